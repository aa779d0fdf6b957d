"""Crossed gauge R&R: how much of what a study shows comes from the gauge, in the AIAG's terms.

Every operator (or fixture) measures every part several times. EV is the equipment's variation
(repeatability), AV the appraisers' (reproducibility), INT their interaction with the parts, GRR
the three together, PV the parts' own variation and TV the whole. Methods: the analysis of
variance (random effects, AIAG MSA 4th edition); average and range; and, where operators have
parts of their own, the nested analysis of variance, which sees no interaction.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from motorid.errors import DataError, UsageError
from motorid.quality.anova import (
    AnovaRow,
    anova_table,
    nested_sigmas,
    nested_table,
    tested,
)
from motorid.quality.ranges import d2, d2_star, range_limits

Floats = NDArray[np.float64]
Method = Literal["anova", "range", "nested"]
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
    alpha: float | None = None,
) -> GaugeResult:
    """The study's components of variation.

    ``tolerance``: width of the specification, in the study's unit. ``process_sigma``: the known
    standard deviation of the process, which then stands for TV (AIAG) instead of the study's parts.
    ``alpha``: an interaction with a larger p is pooled into EV; 0 always pools, 1 never does; None
    is the AIAG's. "nested": part k of each operator is another part, and ``alpha`` has no meaning.
    Raises UsageError on a tolerance or a sigma that is not positive.
    """
    for name, number in (("tolerance", tolerance), ("process sigma", process_sigma)):
        if number is not None and not number > 0:
            raise UsageError(f"a {name} is a positive width, not {number}")
    alpha = ALPHA_TO_POOL if alpha is None else alpha
    if not 0.0 <= alpha <= 1.0:
        raise UsageError(f"alpha is a probability from 0 to 1, not {alpha}")
    match method:
        case "range":
            found = _by_ranges(study)
        case "nested":
            found = _by_nested(study)
        case _:
            found = _by_anova(study, alpha)
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


def _by_nested(study: Study) -> _Found:
    """GRR has no interval: it holds a difference of mean squares."""
    rows = nested_table(study.values)
    sigmas = nested_sigmas(rows, len(study.parts), study.repeats)
    intervals = {"EV": chi_interval(sigmas["EV"], rows["repeatability"].degrees)}
    return _Found(sigmas, intervals, tuple(rows.values()))


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
    main = {name: tested(rows[name], noise) for name in ("part", "operator")}
    return main | {
        "operator × part": rows["operator × part"],
        "repeatability": noise,
        "total": rows["total"],
    }


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
