"""Stations that measured the same motors: what each reads beside another, and is it real?

For each pair the differences of the motors' means: their mean with a t interval, and the limits
of agreement between which 95 % of the differences lie (Bland and Altman 1986). With the stated
uncertainties also E_n, the difference over both expanded uncertainties together (ISO 13528).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from motorid.errors import DataError, UsageError

Floats = NDArray[np.float64]
AGREEMENT = 1.959964  # standard deviations: 95 % of the differences
EXPANDED = 2.0  # of E_n
DIFFERENT = 0.05  # of Holm's adjusted p
LEAST_FOR_SLOPE = 5  # motors


@dataclass(frozen=True)
class Reading:
    """One motor on one station; ``uncertainty``: standard, as stated, or None."""

    station: str
    part: str
    value: float
    uncertainty: float | None = None


@dataclass(frozen=True)
class Pair:
    """``difference`` of the ``first`` station less the ``second``, over ``parts`` common motors.

    With one motor it is of all its readings (Welch's t); ``limits`` and ``slope_p`` are then None.
    ``limits``: of agreement; ``limits_95``: the interval of each. ``p`` is Holm's over all pairs.
    ``slope_p``: whether the difference grows with the value. ``e_n``: beyond 1 the stated
    uncertainties do not explain the difference; None without them.
    """

    first: str
    second: str
    parts: int
    difference: float
    interval_95: tuple[float, float]
    sd: float | None
    limits: tuple[float, float] | None
    limits_95: tuple[tuple[float, float], tuple[float, float]] | None
    p: float
    slope_p: float | None
    e_n: float | None

    @property
    def differ(self) -> bool:
        """A difference that chance among these readings does not explain."""
        return self.p < DIFFERENT


def compare(readings: Sequence[Reading], reference: str | None = None) -> list[Pair]:
    """Every pair of stations with common motors; with ``reference`` only those with that one.

    Raises UsageError for an unknown reference, DataError where fewer than two stations, or no
    pair of them, have a motor in common with enough readings.
    """
    table: dict[str, dict[str, list[Reading]]] = {}
    for one in readings:
        table.setdefault(one.station, {}).setdefault(one.part, []).append(one)
    names = sorted(table)
    if reference is not None and reference not in table:
        raise UsageError(f"no readings of station {reference!r}; stations are {', '.join(names)}")
    if len(names) < 2:
        raise DataError(f"a comparison needs two stations or more, not {len(names)}")
    chosen = list(combinations(names, 2))
    if reference is not None:
        chosen = [(name, reference) for name in names if name != reference]
    pairs = [found for a, b in chosen if (found := _pair(a, b, table[a], table[b]))]
    if not pairs:
        raise DataError(
            "no two stations measured the same motors often enough: two motors, or one motor twice "
            "on each"
        )
    return _adjusted(pairs)


def _pair(
    first: str,
    second: str,
    one: Mapping[str, Sequence[Reading]],
    other: Mapping[str, Sequence[Reading]],
) -> Pair | None:
    """The comparison of two stations, or None where too few readings are common."""
    common = [part for part in one if part in other]
    if not common:
        return None
    stated = _stated([r for part in common for r in (*one[part], *other[part])])
    spread = None if not stated else math.hypot(
        *(_root_mean([r for part in common for r in side[part]]) for side in (one, other))
    )  # fmt: skip
    if len(common) == 1:
        return _of_one_motor(first, second, one[common[0]], other[common[0]], spread)
    a, b = (np.array([_mean(side[part]) for part in common]) for side in (one, other))
    return _of_motors(first, second, a, b, spread)


def _of_motors(first: str, second: str, a: Floats, b: Floats, spread: float | None) -> Pair:
    """By the differences of each motor's means ``a`` and ``b`` (n,)."""
    from scipy.stats import linregress
    from scipy.stats import t as student

    n, apart = len(a), a - b
    mean, sd = float(apart.mean()), float(apart.std(ddof=1))
    error = sd / math.sqrt(n)
    half = float(student.ppf(0.975, n - 1)) * error
    limits = (mean - AGREEMENT * sd, mean + AGREEMENT * sd)
    of_limit = float(student.ppf(0.975, n - 1)) * sd * math.sqrt(3.0 / n)
    slope_p = None
    middle = (a + b) / 2.0
    if n >= LEAST_FOR_SLOPE and np.ptp(middle) > 0.0 and sd > 0.0:
        slope_p = float(linregress(middle, apart).pvalue)
    return Pair(
        first, second, n, mean, _about(mean, half), sd, limits,
        (_about(limits[0], of_limit), _about(limits[1], of_limit)),
        _p(mean, error, n - 1), slope_p, _e_n(mean, spread),
    )  # fmt: skip


def _of_one_motor(
    first: str,
    second: str,
    one: Sequence[Reading],
    other: Sequence[Reading],
    spread: float | None,
) -> Pair | None:
    from scipy.stats import t as student

    if len(one) < 2 or len(other) < 2:
        return None
    a, b = (np.array([r.value for r in side]) for side in (one, other))
    va, vb = float(a.var(ddof=1)) / len(a), float(b.var(ddof=1)) / len(b)
    error, mean = math.sqrt(va + vb), float(a.mean() - b.mean())
    degrees = 1.0
    if error > 0.0:
        degrees = (va + vb) ** 2 / (va**2 / (len(a) - 1) + vb**2 / (len(b) - 1))
    half = float(student.ppf(0.975, degrees)) * error
    return Pair(
        first, second, 1, mean, _about(mean, half), None, None, None,
        _p(mean, error, degrees), None, _e_n(mean, spread),
    )  # fmt: skip


def _about(middle: float, half: float) -> tuple[float, float]:
    return middle - half, middle + half


def _p(mean: float, error: float, degrees: float) -> float:
    from scipy.stats import t as student

    if error == 0.0:
        return 1.0 if mean == 0.0 else 0.0
    return float(2.0 * student.sf(abs(mean) / error, degrees))


def _e_n(mean: float, spread: float | None) -> float | None:
    return None if not spread else abs(mean) / (EXPANDED * spread)


def _mean(readings: Sequence[Reading]) -> float:
    return float(np.mean([r.value for r in readings]))


def _stated(readings: Sequence[Reading]) -> bool:
    """Whether every reading states an uncertainty above zero."""
    return all(r.uncertainty is not None and r.uncertainty > 0.0 for r in readings)


def _root_mean(readings: Sequence[Reading]) -> float:
    """Of the stated uncertainties: what stays the same from reading to reading is not averaged."""
    return math.sqrt(float(np.mean([(r.uncertainty or 0.0) ** 2 for r in readings])))


def _adjusted(pairs: Sequence[Pair]) -> list[Pair]:
    """With Holm's (1979) p: several pairs would else find a difference by chance."""
    order = sorted(range(len(pairs)), key=lambda k: pairs[k].p)
    adjusted, least = list(pairs), 0.0
    for rank, k in enumerate(order):
        least = max(least, min(1.0, pairs[k].p * (len(pairs) - rank)))
        adjusted[k] = replace(pairs[k], p=least)
    return adjusted
