"""Crossed gauge R&R: how much of what a study shows comes from the gauge, in the AIAG's terms.

Every operator (or fixture) measures every part several times. EV is the equipment's variation
(repeatability), AV the appraisers' (reproducibility), INT their interaction with the parts, GRR
the three together, PV the parts' own variation and TV the whole. Two methods: the analysis of
variance (random effects, AIAG MSA 4th edition) and average and range.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from motorid.errors import DataError, UsageError
from motorid.quality.ranges import d2, d2_star, range_limits

Floats = NDArray[np.float64]
Method = Literal["anova", "range"]
ALPHA_TO_POOL = 0.25  # AIAG: an interaction less significant than this is pooled into EV
STUDY_SPREAD = 6.0  # standard deviations: 99.73 %
DISTINCT = 1.41  # AIAG's factor of ndc, sqrt(2) to its printed digits
NAMES = {
    "EV": "repeatability (equipment)",
    "AV": "reproducibility (operators)",
    "INT": "operator by part",
    "GRR": "gauge R&R",
    "PV": "part to part",
    "TV": "total",
}


@dataclass(frozen=True)
class Study:
    """Readings of shape (parts, operators, repeats) of one quantity.

    ``stated``, of the same shape, is the standard uncertainty that each reading's own fit claims
    for its repeatability: the study says whether the claim holds.
    """

    values: Floats
    parts: tuple[str, ...]
    operators: tuple[str, ...]
    quantity: str = "value"
    unit: str = ""
    stated: Floats | None = None

    def __post_init__(self) -> None:
        parts, operators, repeats = self.values.shape
        if (parts, operators) != (len(self.parts), len(self.operators)):
            raise DataError("a study's table and its names of parts and operators disagree")
        if parts < 2 or repeats < 2:
            raise DataError(
                f"a gauge study needs 2 parts or more and 2 repeats or more; {self.quantity} has "
                f"{parts} parts and {repeats} repeats: measure more"
            )
        if not np.isfinite(self.values).all():
            raise DataError(f"a reading of {self.quantity} is missing: a crossed study needs all")

    @property
    def repeats(self) -> int:
        """Readings in each cell of the study."""
        return int(self.values.shape[2])


@dataclass(frozen=True)
class Component:
    """One source of variation. ``sigma`` in the study's unit; ``interval_95`` of sigma."""

    symbol: str
    sigma: float
    percent_study: float  # of TV; these do not add up
    percent_contribution: float  # of TV's variance; these do
    percent_tolerance: float | None  # study spread over the tolerance
    interval_95: tuple[float, float] | None = None


@dataclass(frozen=True)
class AnovaRow:
    """A line of the analysis of variance; ``f`` and ``p`` None where nothing is tested."""

    source: str
    degrees: int
    squares: float
    mean: float
    f: float | None = None
    p: float | None = None


@dataclass(frozen=True)
class GaugeResult:
    """The answer of a study by one method. ``ndc`` before it is cut to a whole number."""

    study: Study
    method: Method
    components: Mapping[str, Component]
    ndc: float
    tolerance: float | None
    spread: float
    table: tuple[AnovaRow, ...] = ()
    pooled: bool = False  # the interaction went into EV
    ranges_outside: tuple[tuple[str, str], ...] = ()  # (part, operator) above the range chart's D4

    @property
    def grr(self) -> Component:
        """The gauge's part of the variation."""
        return self.components["GRR"]

    @property
    def categories(self) -> int | None:
        """Number of distinct categories, cut to a whole number, at least 1 (AIAG).

        None where the readings never differ: the gauge's resolution hides its spread.
        """
        return max(1, math.floor(self.ndc)) if math.isfinite(self.ndc) else None

    @property
    def stated_sigma(self) -> float | None:
        """Repeatability as the readings' own uncertainties predict it (root mean square)."""
        stated = self.study.stated
        return None if stated is None else float(np.sqrt(np.mean(stated**2)))


def analyse(
    study: Study,
    *,
    method: Method = "anova",
    tolerance: float | None = None,
    process_sigma: float | None = None,
    spread: float = STUDY_SPREAD,
    alpha: float = ALPHA_TO_POOL,
) -> GaugeResult:
    """The study's components of variation.

    ``tolerance``: width of the specification, in the study's unit. ``process_sigma``: the known
    standard deviation of the process, which then stands for TV (AIAG) instead of the study's parts.
    Raises UsageError on a tolerance or a sigma that is not positive.
    """
    for name, number in (("tolerance", tolerance), ("process sigma", process_sigma)):
        if number is not None and not number > 0:
            raise UsageError(f"a {name} is a positive width, not {number}")
    found = _by_ranges(study) if method == "range" else _by_anova(study, alpha)
    variances = {name: sigma**2 for name, sigma in found.sigmas.items()}
    grr = sum(variances[name] for name in ("EV", "AV", "INT") if name in variances)
    total = grr + variances["PV"]
    if process_sigma is not None:
        total = process_sigma**2
        variances["PV"] = max(0.0, total - grr)
    variances |= {"GRR": grr, "TV": total}
    components = {
        name: _component(name, variances[name], total, tolerance, spread, found.intervals.get(name))
        for name in NAMES
        if name in variances
    }
    ndc = DISTINCT * math.sqrt(variances["PV"] / grr) if grr > 0 else math.inf
    return GaugeResult(
        study,
        method,
        components,
        ndc,
        tolerance,
        spread,
        table=found.table,
        pooled=found.pooled,
        ranges_outside=found.outside,
    )


def _component(
    symbol: str,
    variance: float,
    total: float,
    tolerance: float | None,
    spread: float,
    interval: tuple[float, float] | None,
) -> Component:
    sigma = math.sqrt(variance)
    share = variance / total if total > 0 else math.nan
    of_tolerance = 100 * spread * sigma / tolerance if tolerance else None
    return Component(symbol, sigma, 100 * math.sqrt(share), 100 * share, of_tolerance, interval)


@dataclass(frozen=True)
class _Found:
    """What a method gives: standard deviations by symbol, and what they rest on."""

    sigmas: dict[str, float]
    intervals: dict[str, tuple[float, float]]
    table: tuple[AnovaRow, ...] = ()
    pooled: bool = False
    outside: tuple[tuple[str, str], ...] = ()


def _by_ranges(study: Study) -> _Found:
    """Average and range: EV from the mean range, AV and PV from ranges of averages."""
    parts, operators, repeats = study.values.shape
    ranges = np.ptp(study.values, axis=2)
    ev = float(ranges.mean()) / d2(repeats)
    sigmas = {"EV": ev, "PV": float(np.ptp(study.values.mean(axis=(1, 2)))) / d2_star(parts, 1)}
    if operators > 1:
        between = float(np.ptp(study.values.mean(axis=(0, 2)))) / d2_star(operators, 1)
        sigmas["AV"] = math.sqrt(max(0.0, between**2 - ev**2 / (parts * repeats)))
    beyond = ranges > range_limits(repeats)[1] * ranges.mean()
    outside = tuple((study.parts[p], study.operators[o]) for p, o in np.argwhere(beyond))
    return _Found(sigmas, {}, outside=outside)


def _by_anova(study: Study, alpha: float) -> _Found:
    """Two-way random effects; an interaction that does not show (p > alpha) is pooled into EV."""
    p, o, r = study.values.shape
    rows = anova_table(study.values)
    part, error = rows["part"], rows["repeatability"]
    if o == 1:
        ev = math.sqrt(error.mean)
        pv = math.sqrt(max(0.0, (part.mean - error.mean) / r))
        intervals = _intervals(error.degrees, ev, {error: 1.0})
        return _Found({"EV": ev, "PV": pv}, intervals, tuple(rows.values()))
    operator, both = rows["operator"], rows["operator × part"]
    pooled = both.p is None or both.p > alpha
    if pooled:
        degrees = error.degrees + both.degrees
        squares = error.squares + both.squares
        noise = AnovaRow("repeatability", degrees, squares, squares / degrees)
        floor, interaction = noise, None
        rows = _pooled(rows, noise)
    else:
        noise, floor = error, both
        interaction = max(0.0, (both.mean - error.mean) / r)
    sigmas = {
        "EV": math.sqrt(noise.mean),
        "AV": math.sqrt(max(0.0, (operator.mean - floor.mean) / (p * r))),
        "PV": math.sqrt(max(0.0, (part.mean - floor.mean) / (o * r))),
    }
    weights = {operator: 1 / (p * r)}
    if interaction is None:
        weights[noise] = 1 - 1 / (p * r)
    else:
        sigmas["INT"] = math.sqrt(interaction)
        weights |= {both: (1 - 1 / p) / r, error: 1 - 1 / r}
    intervals = _intervals(noise.degrees, sigmas["EV"], weights)
    return _Found(sigmas, intervals, tuple(rows.values()), pooled)


def _pooled(rows: dict[str, AnovaRow], noise: AnovaRow) -> dict[str, AnovaRow]:
    """The table of the reduced model, the interaction's test kept for the record."""
    tested = {name: _tested(rows[name], noise) for name in ("part", "operator")}
    return tested | {
        "operator × part": rows["operator × part"],
        "repeatability": noise,
        "total": rows["total"],
    }


def _tested(row: AnovaRow, against: AnovaRow) -> AnovaRow:
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
    rows = {
        name: AnovaRow(name, degrees[name], squares[name], squares[name] / degrees[name])
        for name in squares
        if degrees[name]
    }
    both, error = rows.get("operator × part"), rows["repeatability"]
    if both is None:
        return rows | {"part": _tested(rows["part"], error)}
    tested = {name: _tested(rows[name], both) for name in ("part", "operator")}
    return rows | tested | {"operator × part": _tested(both, error)}


def _intervals(
    degrees: float, ev: float, weights: Mapping[AnovaRow, float]
) -> dict[str, tuple[float, float]]:
    """95 % intervals of EV (chi-square) and GRR (modified large sample: Graybill and Wang 1980).

    GRR² is a sum of mean squares with positive ``weights``, for which the latter holds its level
    even where the operators are two or three.
    """
    from scipy.stats import chi2

    total = below = above = 0.0
    for row, weight in weights.items():
        share = weight * row.mean
        low, high = (float(chi2.ppf(p, row.degrees)) / row.degrees for p in (0.025, 0.975))
        total += share
        below += (share * (1 - 1 / high)) ** 2
        above += (share * (1 / low - 1)) ** 2
    grr = (max(0.0, total - math.sqrt(below)), total + math.sqrt(above))
    return {
        "EV": chi_interval(ev, degrees),
        "GRR": (math.sqrt(grr[0]), math.sqrt(grr[1])),
    }


def chi_interval(sigma: float, degrees: float, level: float = 0.95) -> tuple[float, float]:
    """The interval of a standard deviation estimated with so many degrees of freedom."""
    from scipy.stats import chi2

    low, high = (float(chi2.ppf(p, degrees)) for p in ((1 - level) / 2, (1 + level) / 2))
    return sigma * math.sqrt(degrees / high), sigma * math.sqrt(degrees / low)
