"""Many records as tables: coverage, widths, standing, refusals, causes of misses."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from bench.coverage.bound import NAMES
from bench.coverage.effect_tables import effect_tables
from motorid.estimate.results.status import Status

Row = dict[str, Any]
DECADES = ((0.0, 5.0), (5.0, 50.0), (50.0, math.inf))
DECADE_NAMES = ("0.5 to 5 W", "5 to 50 W", "50 to 500 W")
COLD = "R_25"  # R at 25 °C
TITLES = {
    "fit": "The six parameters",
    "headline": "The six parameters as a report states them, beside a better model or without one",
    "better": "What the report recommends: the better model where one is offered",
    "naive": "The same fit without the chain",
}
NORMAL_95 = 1.959963984540054
UNKNOWABLE = 0.30  # relative: a bound beyond it excuses "not identifiable"


def interval_of_share(held: int, count: int) -> tuple[float, float]:
    """Wilson's 95 % interval of a share that was ``held`` of ``count`` times."""
    if not count:
        return 0.0, 1.0
    p, z = held / count, NORMAL_95
    middle = (p + z**2 / (2 * count)) / (1 + z**2 / count)
    reach = z / (1 + z**2 / count) * math.sqrt(p * (1 - p) / count + z**2 / (4 * count**2))
    return middle - reach, middle + reach


def given(rows: Sequence[Row], which: str, name: str) -> Iterator[tuple[Row, Row]]:
    """(record, parameter) wherever that fit gave an interval of ``name``."""
    for row in rows:
        p = row.get(which, {}).get("parameters", {}).get(name)
        if p is not None and "interval" in p:
            yield row, p


def coverage(rows: Sequence[Row], which: str, name: str) -> tuple[int, int]:
    """How many intervals hold the truth, of how many."""
    held = [p["holds"] for _, p in given(rows, which, name)]
    return sum(held), len(held)


def width_ratio(rows: Sequence[Row], which: str, name: str) -> float:
    """Median of the total standard uncertainty over the bound."""
    ratios = [
        p["total"] / row["bound"][name] for row, p in given(rows, which, name) if "bound" in row
    ]
    return float(np.median(ratios)) if ratios else math.nan


def standing(rows: Sequence[Row], which: str, name: str) -> tuple[int, int]:
    """How often ``name`` was called not identifiable, and how often of these the bound agrees."""
    unknown = [
        row.get("bound", {}).get(name, math.nan)
        for row in rows
        if row.get(which, {}).get("parameters", {}).get(name, {}).get("status")
        == Status.NOT_IDENTIFIABLE
    ]
    return len(unknown), sum(bound > UNKNOWABLE for bound in unknown)


def summary(rows: Sequence[Row]) -> str:
    """All tables."""
    parts = []
    for which, title in TITLES.items():
        if any(which in row for row in rows):
            parts.append(f"{title}\n\n{_coverage_table(rows, which)}")
    if any("headline" in row for row in rows):
        parts.append(effect_tables(rows))
    parts.append(_refusals(rows))
    return "\n\n".join(parts)


def _coverage_table(rows: Sequence[Row], which: str) -> str:
    head = ("", "95 % holds", "of", *DECADE_NAMES, "width/bound", "median u", "not identifiable")
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    for name in (*NAMES, COLD):
        held, count = coverage(rows, which, name)
        if not count:
            continue
        low, high = interval_of_share(held, count)
        cells = [name, f"{_share(held, count)} ({low:.1%} to {high:.1%})", str(count)]
        for lower, upper in DECADES:
            part = [row for row in rows if lower <= row.get("power_w", -1.0) < upper]
            cells.append(_share(*coverage(part, which, name)))
        if name in NAMES:
            unknown, excused = standing(rows, which, name)
            totals = [p["total"] for _, p in given(rows, which, name)]
            cells += [
                f"{width_ratio(rows, which, name):.2f}",
                f"{np.median(totals):.2%}",
                f"{unknown}, the bound above 30 % in {excused}" if unknown else "0",
            ]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _share(held: int, count: int) -> str:
    return f"{held / count:.1%}" if count else ""


def _refusals(rows: Sequence[Row]) -> str:
    """How many rigs gave no fit, by what was said."""
    said: Counter[str] = Counter()
    for row in rows:
        fitted = row.get("fit", row.get("headline", {}))
        for place, kind in ((row, "refused"), (row, "crashed"), (fitted, "refused"),
                            (fitted, "crashed")):  # fmt: skip
            if kind in place:
                text = place[kind].strip().splitlines()[-1]
                said["fit " * (place is fitted) + kind + ": " + text[:110]] += 1
    lines = [f"{len(rows)} rigs; without a fit: {sum(said.values())}"]
    return "\n".join(lines + [f"  {count:4d}  {text}" for text, count in said.most_common(15)])


def causes(rows: Sequence[Row], name: str, top: int = 6) -> list[tuple[str, float, float]]:
    """What drives the standardised error of ``name``: (feature, correlation, with its square).

    Spearman's rank correlation of each drawn figure with the standardised error, and with its size.
    """
    pairs = [
        (row, p["off"] / p["total"])
        for row, p in given(rows, "fit", name)
        if p["off"] is not None and p["total"]
    ]
    if len(pairs) < 20:
        return []
    z = np.array([z for _, z in pairs])
    found = []
    for feature in pairs[0][0]["feature"]:
        x = _ranks(np.array([row["feature"][feature] for row, _ in pairs]))
        if np.ptp(x) > 0:
            found.append((feature, _correlation(x, _ranks(z)), _correlation(x, _ranks(np.abs(z)))))
    found.sort(key=lambda item: -max(abs(item[1]), abs(item[2])))
    return found[:top]


def by_kind(rows: Sequence[Row], name: str, key: str) -> dict[str, tuple[int, int]]:
    """Coverage of ``name`` by a drawn word: its sense point, its decay."""
    kinds = sorted({str(row[key]) for row in rows if key in row})
    return {
        kind: coverage([row for row in rows if str(row.get(key)) == kind], "fit", name)
        for kind in kinds
    }


def cause_tables(rows: Sequence[Row]) -> str:
    """For each parameter its features by weight, its size of misses, and coverage by kinds."""
    lines = []
    for name in NAMES:
        z = np.array([p["off"] / p["total"] for _, p in given(rows, "fit", name)
                      if p["off"] is not None and p["total"]])  # fmt: skip
        if not len(z):
            continue
        lines.append(
            f"{name}: median z {np.median(z):+.2f}, median |z| {np.median(np.abs(z)):.2f}, "
            f"95th percentile of |z| {np.quantile(np.abs(z), 0.95):.1f}"
        )
        for feature, signed, size in causes(rows, name):
            lines.append(f"    {feature:<26} with z {signed:+.2f}   with |z| {size:+.2f}")
        for key in ("sense", "decay", "by_duty", "window"):
            shares = by_kind(rows, name, key)
            said = "  ".join(f"{kind} {_share(*share)}" for kind, share in shares.items())
            lines.append(f"    by {key}: {said}")
    return "\n".join(lines)


def _ranks(values: Any) -> Any:
    return np.argsort(np.argsort(values)).astype(float)


def _correlation(a: Any, b: Any) -> float:
    return float(np.corrcoef(a, b)[0, 1])
