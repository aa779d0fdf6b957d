"""Tables of the analysis of variance of gauge studies: crossed, and with nested parts."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class AnovaRow:
    """A line of the analysis of variance; ``f`` and ``p`` None where nothing is tested."""

    source: str
    degrees: int
    squares: float
    mean: float
    f: float | None = None
    p: float | None = None


def tested(row: AnovaRow, against: AnovaRow) -> AnovaRow:
    """``row`` with its F and p against another mean square; without them where that is zero."""
    from scipy.stats import f as fisher

    if against.mean == 0:
        return AnovaRow(row.source, row.degrees, row.squares, row.mean)
    ratio = row.mean / against.mean
    p = float(fisher.sf(ratio, row.degrees, against.degrees))
    return AnovaRow(row.source, row.degrees, row.squares, row.mean, ratio, p)


def anova_table(values: Floats) -> dict[str, AnovaRow]:
    """The full two-way table of readings (parts, operators, repeats); one-way for one operator."""
    p, o, r = values.shape
    grand = values.mean()
    cells, parts, operators = (
        values.mean(axis=2),
        values.mean(axis=(1, 2)),
        values.mean(axis=(0, 2)),
    )
    deviation = cells - parts[:, None] - operators[None, :] + grand
    squares = {
        "part": o * r * float(np.sum((parts - grand) ** 2)),
        "operator": p * r * float(np.sum((operators - grand) ** 2)),
        "operator × part": r * float(np.sum(deviation**2)),
        "repeatability": float(np.sum((values - cells[:, :, None]) ** 2)),
        "total": float(np.sum((values - grand) ** 2)),
    }
    degrees = {
        "part": p - 1,
        "operator": o - 1,
        "operator × part": (p - 1) * (o - 1),
        "repeatability": p * o * (r - 1),
        "total": p * o * r - 1,
    }
    rows = _rows(squares, degrees)
    both, error = rows.get("operator × part"), rows["repeatability"]
    if both is None:
        return rows | {"part": tested(rows["part"], error)}
    main = {name: tested(rows[name], both) for name in ("part", "operator")}
    return rows | main | {"operator × part": tested(both, error)}


def nested_table(values: Floats) -> dict[str, AnovaRow]:
    """The table of readings (parts, operators, repeats), parts within operators."""
    p, o, r = values.shape
    grand, operators, cells = values.mean(), values.mean(axis=(0, 2)), values.mean(axis=2)
    squares = {
        "operator": p * r * float(np.sum((operators - grand) ** 2)),
        "part (operator)": r * float(np.sum((cells - operators[None, :]) ** 2)),
        "repeatability": float(np.sum((values - cells[:, :, None]) ** 2)),
        "total": float(np.sum((values - grand) ** 2)),
    }
    degrees = {
        "operator": o - 1,
        "part (operator)": o * (p - 1),
        "repeatability": p * o * (r - 1),
        "total": p * o * r - 1,
    }
    rows = _rows(squares, degrees)
    part, error = rows["part (operator)"], rows["repeatability"]
    if "operator" in rows:
        rows["operator"] = tested(rows["operator"], part)
    return rows | {"part (operator)": tested(part, error)}


def _rows(squares: dict[str, float], degrees: dict[str, int]) -> dict[str, AnovaRow]:
    """Those lines that have degrees of freedom."""
    return {
        name: AnovaRow(name, degrees[name], squares[name], squares[name] / degrees[name])
        for name in squares
        if degrees[name]
    }


def nested_sigmas(rows: dict[str, AnovaRow], parts: int, repeats: int) -> dict[str, float]:
    """EV, AV and PV of a nested table; a negative variance counts as none."""
    part, error = rows["part (operator)"], rows["repeatability"]
    found = {
        "EV": math.sqrt(error.mean),
        "PV": math.sqrt(max(0.0, (part.mean - error.mean) / repeats)),
    }
    if "operator" in rows:
        between = (rows["operator"].mean - part.mean) / (parts * repeats)
        found["AV"] = math.sqrt(max(0.0, between))
    return found
