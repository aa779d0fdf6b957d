"""Attribute studies and comparisons of stations, for a terminal and for a script."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from motorid.quality.agreement import Agreement, Kappa, Share
from motorid.quality.stations import Pair
from motorid.report.gauge import columns
from motorid.report.json_ import plain
from motorid.report.numbers import scaled_unit, significant

AGREEMENT_SCHEMA, STATIONS_SCHEMA = "motorid-agreement-1", "motorid-stations-1"
GOOD, POOR = 0.75, 0.40  # of kappa (AIAG)
RIGHT, MISSED, ALARMED = (0.90, 0.80), (0.02, 0.05), (0.05, 0.10)  # acceptable, marginal (AIAG)


def strength(kappa: float) -> str:
    """What the AIAG says of such a kappa."""
    if not math.isfinite(kappa):
        return "chance alone explains all"
    if kappa >= GOOD:
        return "good"
    return "poor" if kappa < POOR else "between good and poor"


def _standing(value: float, bounds: tuple[float, float]) -> str:
    """Acceptable, marginal or not, for shares that should be large, or small."""
    if not math.isfinite(value):
        return "no such part"
    large = bounds[0] > bounds[1]
    for bound, word in zip(bounds, ("acceptable", "marginal"), strict=True):
        if value >= bound if large else value <= bound:
            return word
    return "not acceptable"


def agreement_text(found: Agreement) -> str:
    """The study as tables for a terminal."""
    r = found.ratings
    parts, appraisers, trials = r.values.shape
    lines = [
        f"{parts} parts × {appraisers} appraisers × {trials} trials: {', '.join(r.categories)}"
    ]
    lines += columns(["appraiser", "share", "found", "of", "%", "95 % interval", ""], _rows(found))
    head = ["kappa", "with", "value", "95 % interval", ""]
    kappas = [*found.pairs, *found.with_reference, *([found.overall] if found.overall else [])]
    return "\n".join([*lines, "", *columns(head, [_kappa(k) for k in kappas])])


def _rows(found: Agreement) -> list[list[str]]:
    rows = []
    for one in found.appraisers:
        shares: list[tuple[str, Share | None, tuple[float, float] | None]] = [
            ("alike in all trials", one.consistent, None),
            ("alike, and right", one.right, RIGHT),
            ("bad ones missed", one.missed, MISSED),
            ("false alarms", one.alarmed, ALARMED),
        ]
        rows += [_row(one.name, *share) for share in shares]
    rows.append(_row("all", "alike in all trials", found.all_agree, None))
    rows.append(_row("all", "alike, and right", found.all_right, RIGHT))
    return [row for row in rows if row]


def _row(who: str, what: str, share: Share | None, bounds: tuple[float, float] | None) -> list[str]:
    if share is None:
        return []
    low, high = share.interval_95
    percent = f"{100 * share.value:.1f}" if share.of else "—"
    word = _standing(share.value, bounds) if bounds else ""
    between = f"{100 * low:.1f} to {100 * high:.1f}"
    return [who, what, str(share.found), str(share.of), percent, between, word]


def _kappa(one: Kappa) -> list[str]:
    between = "—"
    if one.interval_95 is not None:
        between = f"{one.interval_95[0]:.2f} to {one.interval_95[1]:.2f}"
    value = f"{one.value:.3f}" if math.isfinite(one.value) else "—"
    return [one.first, one.second, value, between, strength(one.value)]


def least_kappa(found: Agreement) -> float:
    """The smallest kappa: with the reference where there is one, else of the pairs."""
    judged = found.with_reference or found.pairs
    values = [one.value for one in judged]
    return min(values) if all(math.isfinite(v) for v in values) else math.nan


def agreement_dict(found: Agreement) -> dict[str, Any]:
    """Plain data of the study."""
    r = found.ratings
    return {
        "schema": AGREEMENT_SCHEMA,
        "parts": list(r.parts),
        "trials": r.values.shape[2],
        "categories": list(r.categories),
        "appraisers": [
            {
                "name": one.name,
                "consistent": _share(one.consistent),
                "right": _share(one.right),
                "missed": _share(one.missed),
                "false_alarms": _share(one.alarmed),
            }
            for one in found.appraisers
        ],
        "all_agree": _share(found.all_agree),
        "all_right": _share(found.all_right),
        "kappa": [_kappa_dict(one) for one in found.pairs],
        "kappa_with_reference": [_kappa_dict(one) for one in found.with_reference],
        "kappa_overall": None if found.overall is None else _kappa_dict(found.overall),
    }


def _share(share: Share | None) -> dict[str, Any] | None:
    if share is None:
        return None
    value = plain(share.value)
    return {"found": share.found, "of": share.of, "share": value,
            "interval_95": list(share.interval_95)}  # fmt: skip


def _kappa_dict(one: Kappa) -> dict[str, Any]:
    return {
        "first": one.first,
        "second": one.second,
        "kappa": plain(one.value),
        "interval_95": None if one.interval_95 is None else list(one.interval_95),
        "table": None if one.table is None else one.table.tolist(),
    }


def stations_text(pairs: Sequence[Pair], quantity: str, unit: str) -> str:
    """The comparison as a table for a terminal."""
    largest = max(abs(v) for p in pairs for v in (p.difference, *p.interval_95))
    shown, f = scaled_unit(unit, largest)
    head = ["station", "less", "motors", f"difference, {shown}" if shown else "difference",
            "95 % interval", "limits of agreement", "p", "E_n", ""]  # fmt: skip
    rows = []
    for one in pairs:
        ends = ["—" if b is None else " to ".join(significant(v * f, 3) for v in b)
                for b in (one.interval_95, one.limits)]  # fmt: skip
        rows.append([
            one.first, one.second, str(one.parts), significant(one.difference * f, 3), *ends,
            f"{one.p:.3f}", "—" if one.e_n is None else f"{one.e_n:.2f}", _said(one),
        ])  # fmt: skip
    return "\n".join([f"{quantity}: {len(pairs)} pairs of stations", *columns(head, rows)])


def _said(one: Pair) -> str:
    words = ["differ" if one.differ else "no difference shown"]
    if one.e_n is not None and one.e_n > 1.0:
        words.append("beyond the stated uncertainties")
    if one.slope_p is not None and one.slope_p < 0.05:
        words.append("grows with the value")
    return ", ".join(words)


def stations_dict(pairs: Sequence[Pair], quantity: str, unit: str) -> dict[str, Any]:
    """Plain data of the comparison."""
    return {
        "schema": STATIONS_SCHEMA,
        "quantity": quantity,
        "unit": unit,
        "pairs": [plain(vars(one)) | {"differ": one.differ} for one in pairs],
    }
