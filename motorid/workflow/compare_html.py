"""Comparisons as one HTML file: tables, sentences and convergence plots."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape

import numpy as np

from motorid.report.page import figure, page, paragraph, section, table
from motorid.report.plot import WIDE, Plot, axis, legend, style
from motorid.workflow.compare import Comparison
from motorid.workflow.compare_tables import Block, TableResult
from motorid.workflow.compare_text import columns_of, comparison_rows, rows_of

TINIEST = 1e-16  # a cost below this is drawn as this
Curve = tuple[str, Sequence[tuple[float, float]]]  # label, (evaluations, cost)


def convergence(curves: Sequence[Curve]) -> str:
    """Best cost against evaluations, both as powers of ten; nothing where nothing converges."""
    drawn = [(label, np.array(points)) for label, points in curves if len(points) > 1]
    if not drawn:
        return ""
    logs = [(label, np.log10(np.maximum(points, TINIEST))) for label, points in drawn]
    x = axis([p[:, 0] for _, p in logs], "evaluations, powers of ten")
    y = axis([p[:, 1] for _, p in logs], "cost, powers of ten")
    plot = Plot(x, y, "Median of the best cost so far against evaluations", height=22.0)
    for k, (_, points) in enumerate(logs):
        plot.line(points[:, 0], points[:, 1], f"c{k}")
    keys = legend([(f"c{k}", label) for k, (label, _) in enumerate(logs)])
    caption = "Convergence: median over the seeds of the best cost so far"
    return figure(caption, style(len(logs)), keys, plot.render())


def comparison_page(result: Comparison) -> str:
    """The whole page of a comparison on captures."""
    title = f"{len(result.lines)} methods on {', '.join(result.captures)}"
    head, rows = comparison_rows(result)
    judged = "error, percent of the truth" if result.truth else "value in SI"
    said = (
        f"Each search has {result.budget} evaluations and {result.seeds} seeds. A cell is the "
        f"median {judged}, with quartiles over the seeds. The cost is the root mean square of all "
        "residuals in units of each channel's peak, by the searches' response model. nls and "
        "pattern-search begin at the closed form's values, the populations anywhere in the bounds."
    )
    curves = [(line.method, line.convergence) for line in result.lines]
    body = section("Methods", paragraph(said), table(head, rows), convergence(curves))
    return page(title, [WIDE, f"<h1>{escape(title)}</h1>", body])


def table_page(result: TableResult) -> str:
    """The whole page of one rebuilt table."""
    title = f"Table {result.number} of the review, rebuilt over {result.seeds} seeds"
    said = "".join(paragraph(sentence) for sentence in result.remarks)
    blocks = "".join(_block(block) for block in result.blocks)
    return page(title, [WIDE, f"<h1>{title}</h1>", section("On the printed figures", said), blocks])


def _block(block: Block) -> str:
    noise = f"{100 * block.noise:g} % noise" if block.noise else "no noise"
    experiment = block.experiment
    rows = [[label, kind, *cells] for label, kind, cells in rows_of(block)]
    return section(
        f"{experiment.key}, {noise}",
        paragraph(f"{experiment.title}. {experiment.note}"),
        table(["method", "error, %", *columns_of(block)], rows),
        convergence(list(_curves(block))),
    )


def _curves(block: Block) -> Iterator[Curve]:
    for line in block.lines:
        yield line.row.label, line.convergence
