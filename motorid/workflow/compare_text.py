"""Comparisons as text: CSV, Markdown (docs/review.md), a table for a terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

from motorid import csv_text
from motorid.estimate.results.estimate import PARAMETERS, UNITS
from motorid.search.review.experiment import Experiment
from motorid.search.review.run import Quartiles
from motorid.workflow.compare import Comparison
from motorid.workflow.compare_tables import Block, Line, TableResult

HEADER = (
    "table", "experiment", "noise", "row", "method", "quantity", "review_value",
    "review_error_of_nominal_pct", "review_error_of_estimate_pct",
    "of_nominal_median_pct", "of_nominal_q1_pct", "of_nominal_q3_pct",
    "of_estimate_median_pct", "of_estimate_q1_pct", "of_estimate_q3_pct",
    "rms_of_nominal_pct", "cost_median", "evaluations", "seconds", "seeds", "failed",
)  # fmt: skip

Figures = tuple[float | None, float | None, float | None]  # value, % of nominal, % of estimate


def review_figures(experiment: Experiment, line: Line, name: str) -> Figures:
    """What the review prints for one quantity of a row, in both conventions where it can be."""
    figure, nominal = line.row.printed.get(name), experiment.truth.get(name)
    if figure is None or nominal is None:
        return None, None, None
    if line.row.percent:
        return None, None, figure  # a magnitude: its sign, and so the value, is not printed
    miss = 100.0 * abs(figure - nominal)
    return figure, miss / abs(nominal), miss / abs(figure)


def as_csv(result: TableResult) -> str:
    """Every figure of the table, one quantity of one row a line."""
    return csv_text.table(HEADER, map(_short, _table_rows(result)), end="\n")


def _table_rows(result: TableResult) -> Iterator[list[Any]]:
    for block in result.blocks:
        for line in block.lines:
            s = line.summary
            for name, nominal in s.to_nominal.items():
                review = review_figures(block.experiment, line, name)
                estimate = s.to_estimate[name]
                cost = s.cost.median if s.cost else None
                yield [
                    result.number, block.experiment.key, block.noise, s.label, s.method, name,
                    *review, nominal.median, nominal.low, nominal.high,
                    estimate.median, estimate.low, estimate.high,
                    s.rms[name], cost, s.evaluations, s.seconds, s.seeds, s.failed,
                ]  # fmt: skip


def _short(cells: Iterable[Any]) -> list[Any]:
    """Numbers with six digits; nothing for None."""
    return ["" if c is None else f"{c:.6g}" if isinstance(c, float) else c for c in cells]


def percent(value: float) -> str:
    """Two significant digits: enough for a percent error, and small ones by their power."""
    if value == 0:
        return "0"
    if value < 1e-3:
        return f"{value:.0e}".replace("e-0", "e-")
    return f"{value:.2g}" if value < 100 else f"{value:.0f}"


def quartiles(q: Quartiles) -> str:
    """median (first to third quartile)"""
    return f"{percent(q.median)} ({percent(q.low)} to {percent(q.high)})"


def rows_of(block: Block) -> Iterator[tuple[str, str, list[str]]]:
    """(label, kind of figure, cells): ours in both conventions, then the review's."""
    names = columns_of(block)
    for line in block.lines:
        s = line.summary
        head = f"{s.label} ({s.evaluations:.0f} evaluations, {s.seconds * 1e3:.0f} ms)"
        if s.failed:
            head += f", {s.failed} of {s.seeds} runs without an answer"
        yield head, "of nominal", [_cell(s.to_nominal, n) for n in names]
        yield "", "of estimate", [_cell(s.to_estimate, n) for n in names]
        figures = {n: review_figures(block.experiment, line, n) for n in names}
        if any(any(f is not None for f in figure) for figure in figures.values()):
            yield "", "review", [_review_cell(figures[n]) for n in names]


def columns_of(block: Block) -> list[str]:
    """Quantities of the block, in the model's order."""
    return list(block.experiment.figures(block.experiment.truth))


def _cell(errors: Mapping[str, Quartiles], name: str) -> str:
    return quartiles(errors[name]) if name in errors else "–"


def _review_cell(figures: Figures) -> str:
    _, nominal, estimate = figures
    if nominal is not None and estimate is not None:
        return f"{percent(nominal)} / {percent(estimate)}"
    return "–" if estimate is None else f"– / {percent(estimate)}"


def as_markdown(result: TableResult) -> str:
    """The table's section of docs/review.md."""
    parts = [f"## Table {result.number}\n"]
    parts += [f"- {remark}\n" for remark in result.remarks]
    for block in result.blocks:
        noise = f"{100 * block.noise:g} % noise" if block.noise else "no noise"
        parts.append(f"\n### {block.experiment.key}, {noise}\n\n{block.experiment.title}.")
        if block.experiment.note:
            parts.append(f" {block.experiment.note}")
        names = columns_of(block)
        parts.append("\n\n| method | error, % | " + " | ".join(names) + " |\n")
        parts.append("|---|---|" + "---|" * len(names) + "\n")
        for label, kind, cells in rows_of(block):
            parts.append(f"| {label} | {kind} | " + " | ".join(cells) + " |\n")
    return "".join(parts)


INTRODUCTION = """# The review's tables, rebuilt

Source: "Parameters Identification of a Permanent Magnet DC Motor: A Review", Electronics 2023,
12(12), 2559. This page is written by `motorid compare --table 2 … --page docs/review.md -o OUT`
(one `--table` for each of 2 to 9); do not edit it.

Each cell is the median percent error over {seeds} seeds with its quartiles, first relative to the
nominal value, then to the estimate. The review's figure stands below as "of nominal / of estimate".
Tables 8 and 9 print magnitudes relative to the estimate only. Every search works on the same
objective, one batch of candidates at a time, and counts its budget in evaluations. [P] marks a
set-up that the review does not print and we propose; [D] one that follows from its numbers.

The model that is searched also makes the records, in finer steps where it takes steps. So the
tables compare searches, and not models. The row "motorid (default)" is `motorid fit` with the
record as a capture. In Tables 4 and 5 it is the same likelihood on the searches' response, from
the middle of the bounds. It counts every response that it simulates.
"NLS (ours)" is a trust-region least squares on the same residuals from the middle of the bounds,
started again until two starts agree. The review has no such rows. [review-best.md](review-best.md)
compares the default with the best row of each table with noise.
"""


def page(results: Sequence[TableResult]) -> str:
    """docs/review.md."""
    seeds = max((result.seeds for result in results), default=0)
    sections = "\n".join(as_markdown(result) for result in results)
    return INTRODUCTION.format(seeds=seeds) + "\n" + sections


COMPARISON_HEADER = (
    "method", "quantity", "median", "q1", "q3", "truth", "error_median_pct", "error_q1_pct",
    "error_q3_pct", "evaluations", "seconds", "seeds", "failure",
)  # fmt: skip


def comparison_csv(result: Comparison) -> str:
    """One quantity of one method a line; the cost is a quantity too."""
    return csv_text.table(COMPARISON_HEADER, map(_short, _comparison_rows(result)), end="\n")


def _comparison_rows(result: Comparison) -> Iterator[list[Any]]:
    for line in result.lines:
        tail = [line.evaluations, line.seconds, line.seeds, line.failure]
        if line.cost is None:
            yield [line.method, "cost", *[""] * 7, *tail]
            continue
        for name, q in {"cost": line.cost, **line.values}.items():
            error = line.errors.get(name)
            errors = [error.median, error.low, error.high] if error else ["", "", ""]
            truth = result.truth.get(name, "")
            yield [line.method, name, q.median, q.low, q.high, truth, *errors, *tail]


def comparison_rows(result: Comparison) -> tuple[list[str], list[list[str]]]:
    """Head and rows of the table for people: errors where the truth is known, else values."""
    known = bool(result.truth)
    names = list(result.truth) if known else list(PARAMETERS)
    unit = {name: " %" if known else f" {UNITS[name]}" for name in names}
    head = ["method", "cost", *(name + unit[name] for name in names), "evaluations", "seconds"]
    rows = []
    for line in result.lines:
        if line.cost is None:
            rows.append([line.method, line.failure, *[""] * (len(head) - 2)])
            continue
        cells = line.errors if known else line.values
        form = percent if known else _value
        rows.append(
            [
                line.method,
                _spread(line.cost, _value, line.seeds),
                *(_spread(cells[name], form, line.seeds) for name in names),
                f"{line.evaluations:.0f}",
                f"{line.seconds:.2g}",
            ]
        )
    return head, rows


def _value(value: float) -> str:
    return f"{value:.4g}"


def _spread(q: Quartiles, form: Callable[[float], str], seeds: int) -> str:
    if seeds == 1:
        return form(q.median)
    return f"{form(q.median)} ({form(q.low)} to {form(q.high)})"


def comparison_text(result: Comparison) -> str:
    """The table for a terminal."""
    head, rows = comparison_rows(result)
    widths = [max(len(row[k]) for row in [head, *rows] if len(row) > k) for k in range(len(head))]
    failures = {line.method for line in result.lines if line.cost is None}
    widths[1] = max(
        len(row[1]) for row in [head, *rows] if row[0] not in failures
    )  # a sentence may run on
    lines = [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in [head, *rows]
    ]
    return "\n".join(lines)
