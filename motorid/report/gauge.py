"""A gauge study for a terminal and for a script."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from motorid.quality.anova import AnovaRow
from motorid.quality.gauge import NAMES, GaugeResult
from motorid.quality.reference import CAPABLE, GoldenResult, LinearityResult
from motorid.report.json_ import plain
from motorid.report.numbers import scaled_unit, significant

GAUGE_SCHEMA = "motorid-gauge-1"
ACCEPTED, CONDITIONAL = 10.0, 30.0  # percent GRR (AIAG)
LEAST_CATEGORIES = 5
METHODS = {
    "anova": "analysis of variance",
    "range": "average and range",
    "nested": "analysis of variance, parts nested in operators",
}


def standing(percent: float) -> str:
    """What the AIAG says of such a %GRR."""
    if not math.isfinite(percent):
        return "cannot be judged"
    if percent < ACCEPTED:
        return "acceptable"
    return "may be acceptable" if percent <= CONDITIONAL else "not acceptable"


def judged_percent(result: GaugeResult) -> tuple[float, str]:
    """The %GRR that decides, and of what: of the tolerance where one is known."""
    of_tolerance = result.grr.percent_tolerance
    if of_tolerance is not None:
        return of_tolerance, "of the tolerance"
    return result.grr.percent_study, "of the study variation"


def headline(result: GaugeResult) -> str:
    """The answer in a sentence."""
    percent, whole = judged_percent(result)
    ndc = "no" if result.categories is None else str(result.categories)
    few = "" if result.categories is None or result.categories >= LEAST_CATEGORIES else ", too few"
    return (
        f"{result.study.quantity}: GRR {significant(percent, 3)} % {whole}, {standing(percent)}; "
        f"{ndc} distinct categories{few}"
    )


def claim(result: GaugeResult) -> str:
    """Whether the readings' own uncertainties foretold the repeatability; "" without them."""
    stated = result.stated_sigma
    interval = result.components["EV"].interval_95
    if stated is None or interval is None:
        return ""
    unit, factor = scaled_unit(result.study.unit, result.components["EV"].sigma)
    low, high = interval
    word = "agrees with" if low <= stated <= high else "lies outside"
    return (
        f"The fits' own uncertainties foretell a repeatability of "
        f"{significant(stated * factor, 3)} {unit}, which {word} the study's 95 % interval "
        f"{significant(low * factor, 3)} to {significant(high * factor, 3)} {unit}."
    )


def component_rows(result: GaugeResult) -> tuple[list[str], list[list[str]]]:
    """Head and rows of the table of components."""
    unit, factor = scaled_unit(result.study.unit, result.components["TV"].sigma)
    head = ["", "source", f"sigma, {unit}" if unit else "sigma", "% study", "% contribution"]
    tolerance = result.tolerance is not None
    head += ["% tolerance"] if tolerance else []
    rows = []
    for symbol, c in result.components.items():
        row = [symbol, NAMES[symbol], significant(c.sigma * factor, 4)]
        row += [f"{c.percent_study:.2f}", f"{c.percent_contribution:.2f}"]
        row += [f"{c.percent_tolerance:.2f}"] if c.percent_tolerance is not None else []
        rows.append(row)
    return head, rows


def anova_rows(table: Sequence[AnovaRow]) -> tuple[list[str], list[list[str]]]:
    """Head and rows of the analysis of variance."""
    head = ["source", "df", "sum of squares", "mean square", "F", "p"]
    return head, [
        [
            row.source,
            str(row.degrees),
            significant(row.squares, 5),
            significant(row.mean, 5) if row.source != "total" else "",
            "" if row.f is None else f"{row.f:.3f}",
            "" if row.p is None else f"{row.p:.3f}",
        ]
        for row in table
    ]


def text(results: Sequence[GaugeResult]) -> str:
    """Every result as tables for a terminal."""
    return "\n\n".join(_text(result) for result in results)


def design_of(result: GaugeResult) -> str:
    """How many parts, operators and repeats."""
    s = result.study
    crossed = "parts of each of" if result.method == "nested" else "parts ×"
    return f"{len(s.parts)} {crossed} {len(s.operators)} operators × {s.repeats} repeats"


def _text(result: GaugeResult) -> str:
    design = f"{design_of(result)}, {METHODS[result.method]}"
    lines = [headline(result), design + (", interaction pooled" if result.pooled else "")]
    lines += columns(*component_rows(result))
    if result.table:
        lines += ["", *columns(*anova_rows(result.table))]
    lines += [word for word in [claim(result)] if word]
    lines += [f"range above its control limit: part {p} by {o}" for p, o in result.ranges_outside]
    return "\n".join(lines)


def columns(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Rows under their head: words to the left, numbers to the right."""
    every = [head, *rows]
    widths = [max(len(row[k]) for row in every) for k in range(len(head))]
    left = [all(not _numeric(row[k]) for row in rows) for k in range(len(head))]
    return [
        "  ".join(
            cell.ljust(width) if to_left else cell.rjust(width)
            for cell, width, to_left in zip(row, widths, left, strict=True)
        ).rstrip()
        for row in every
    ]


def _numeric(cell: str) -> bool:
    return bool(cell) and cell.lstrip("−-")[:1].isdigit()


def to_dict(results: Sequence[GaugeResult]) -> dict[str, Any]:
    """Plain data of the studies."""
    return {"schema": GAUGE_SCHEMA, "studies": [_study(result) for result in results]}


def _study(result: GaugeResult) -> dict[str, Any]:
    percent, whole = judged_percent(result)
    s = result.study
    return {
        "quantity": s.quantity,
        "unit": s.unit,
        "method": result.method,
        "parts": list(s.parts),
        "operators": list(s.operators),
        "repeats": s.repeats,
        "tolerance": result.tolerance,
        "interaction_pooled": result.pooled,
        "grr_percent": plain(percent),
        "grr_percent_of": whole,
        "standing": standing(percent),
        "ndc": plain(result.ndc),
        "distinct_categories": result.categories,
        "stated_sigma": plain(result.stated_sigma),
        "components": {name: plain(vars(c)) for name, c in result.components.items()},
        "anova": [plain(vars(row)) for row in result.table],
        "ranges_outside": [list(cell) for cell in result.ranges_outside],
    }


def golden_text(result: GoldenResult, quantity: str, unit: str) -> str:
    """A golden motor's study for a terminal."""
    shown, f = scaled_unit(unit, result.reference)

    def number(value: float, digits: int = 4) -> str:
        return significant(value * f, digits)

    low, high = result.interval_95
    lines = [
        f"{quantity}: {result.count} readings of a motor of {number(result.reference, 6)} {shown}",
        f"mean {number(result.mean, 6)}, standard deviation {number(result.sigma)} {shown}",
        f"bias {number(result.bias)} {shown}, 95 % interval {number(low)} to {number(high)}, "
        f"t = {result.t:.2f}, p = {result.p:.3f}: "
        + ("the gauge is biased" if result.biased else "no bias shown"),
    ]
    if result.cg is not None and result.cgk is not None:
        word = "capable" if min(result.cg, result.cgk) >= CAPABLE else "not capable"
        lines.append(f"Cg = {result.cg:.2f}, Cgk = {result.cgk:.2f} (asked: {CAPABLE}): {word}")
    return "\n".join(lines)


def linearity_text(result: LinearityResult, quantity: str) -> str:
    """A linearity study for a terminal."""
    slope, intercept = result.slope, result.intercept
    design = f"linearity over {len(result.biases)} motors, {result.count} readings"
    word = "acceptable: no bias at any motor" if result.acceptable else "not acceptable"
    line = f"{significant(intercept.value, 4)} + {significant(slope.value, 4)} × reference"
    named = (("slope", slope), ("intercept", intercept))
    tests = [f"{name} t = {c.t:.3f}, p = {c.p:.3g}" for name, c in named]
    rows = [[significant(x, 5), significant(bias, 4)] for x, bias in result.biases]
    return "\n".join(
        [
            f"{quantity}: {design}, {word}",
            *columns(["reference", "bias"], rows),
            f"bias = {line}, R² = {100 * result.r_squared:.1f} %",
            "; ".join(tests),
        ]
    )
