"""From covariance and budget to values with intervals, each with its standing."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.results.estimate import PARAMETERS, UNITS, Parameter
from motorid.estimate.results.status import Status
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.budget import Carried
from motorid.estimate.uncertainty.covariance import Statistical
from motorid.estimate.uncertainty.errors_in_variables import Hidden
from motorid.estimate.uncertainty.undetected import Undetected
from motorid.motor.brushes import Brushes, figure, figure_uncertainty
from motorid.motor.parameters import FIGURES, Motor

Floats = NDArray[np.float64]

NORMAL_95 = 1.959963984540054
LARGE_FREEDOM = 1e6
SERIES_FROM = 6.0  # degrees of freedom
FREEDOMS = (1.0, 1.25, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0)
STUDENT_95 = (12.7062, 8.02795, 6.01666, 4.30265, 3.18245, 2.77645, 2.57058, 2.44691)  # of them
POSITIVE = ("R", "L", "K", "J")
UNKNOWN = 0.5  # relative standard uncertainty beyond which R, L, K and J are not given
UNKNOWN_FRICTION = 1.0  # the same of B and T0, which may be nothing
KNOWN_TOGETHER = 0.3  # relative standard uncertainty below which a ratio is worth printing
RATIOS: dict[str, tuple[str, dict[str, float]]] = {
    "L/R": ("s", {"L": 1, "R": -1}),
    "J/K": ("kg·m²·A/(N·m)", {"J": 1, "K": -1}),
    "B/K": ("A·s/rad", {"B": 1, "K": -1}),
    "T0/K": ("A", {"T0": 1, "K": -1}),
    "B/J": ("1/s", {"B": 1, "J": -1}),
    "T0/J": ("rad/s²", {"T0": 1, "J": -1}),
    "K/J": ("rad/(s²·A)", {"K": 1, "J": -1}),
    "J R/K²": ("s", {"J": 1, "R": 1, "K": -2}),
}
REMEDY = {
    "R": "a run whose current changes a lot: a start from rest, or several levels",
    "L": "a run sampled at several times R/L, with a step of the voltage",
    "K": "a run at speed with the voltage measured",
    "B": "runs at two or more speeds, or a coast-down from full speed",
    "J": "a run that accelerates, or coasts down, sampled finely",
    "T0": "runs at two or more speeds, or a coast-down to standstill",
}


def student(freedom: float) -> float:
    """Two-sided 95 % factor, to 5e-3 of itself; to 1e-3 from 6 degrees of freedom on.

    Importing scipy for one quantile takes longer than a fit: a table up to 6 degrees, its logarithm
    taken between them on 1/n, above by the Cornish-Fisher series in 1/n.
    """
    n = max(freedom, 1.0)
    if n > LARGE_FREEDOM:
        return NORMAL_95
    if n < SERIES_FROM:
        inverse = -1.0 / np.array(FREEDOMS)
        return float(np.exp(np.interp(-1.0 / n, inverse, np.log(STUDENT_95))))
    z = NORMAL_95
    terms = (
        z,
        (z**3 + z) / 4,
        (5 * z**5 + 16 * z**3 + 3 * z) / 96,
        (3 * z**7 + 19 * z**5 + 17 * z**3 - 15 * z) / 384,
        (79 * z**9 + 776 * z**7 + 1482 * z**5 - 1920 * z**3 - 945 * z) / 92160,
    )
    return float(sum(term / n**k for k, term in enumerate(terms)))


@dataclass(frozen=True)
class Findings:
    """The uncertain answer in search coordinates, with what turns it into numbers for people."""

    solution: Solution
    statistical: Statistical
    causes: Mapping[str, Floats]
    fixed: Mapping[str, float]
    without: Sequence[str]
    profiles: Mapping[str, tuple[float, float]] = field(default_factory=dict)  # of the likelihood
    undetected: Sequence[Undetected] = ()  # effects that were not modelled
    hidden: Sequence[Hidden] = ()  # errors of what drove the motor, in the statistical part
    carried: Carried = field(
        default_factory=lambda: Carried({}, {})
    )  # of instruments, to all that was found
    simulated: int = 0  # responses of a capture, at most, of the search alone

    @property
    def names(self) -> tuple[str, ...]:
        """The free parameters."""
        return tuple(u.name for u in self.solution.unknowns)

    def motor(self, search: Floats | None = None) -> Motor:
        """The motor at the solution, or at other search coordinates."""
        unknowns = self.solution.unknowns
        values = self.solution.values
        if search is not None:
            pairs = zip(unknowns, search, strict=True)
            values = np.array([np.exp(x) if u.log else x for u, x in pairs])
        free = dict(zip(self.names, (float(v) for v in values), strict=True))
        return Motor.of({**dict.fromkeys(PARAMETERS, 0.0), **self.fixed, **free})

    @property
    def search(self) -> Floats:
        """The solution in search coordinates."""
        pairs = zip(self.solution.unknowns, self.solution.values, strict=True)
        return np.array([np.log(v) if u.log else v for u, v in pairs])

    def propagate(self, gradient: Floats) -> tuple[float, float, float]:
        """(statistical, instrument, freedom of both together) of a quantity with gradient (p,).

        Welch-Satterthwaite (GUM G.4.1): the instruments' share is as good as known, so that few
        runs widen an interval by no more than their spread's part in it.
        """
        C = self.statistical.covariance
        variance = float(gradient @ C @ gradient)
        instrument = float(np.sqrt(sum(float(gradient @ d) ** 2 for d in self.causes.values())))
        share = gradient**2 * np.diag(C)
        known = np.isfinite(self.statistical.freedom) & (share > 0)
        weight = float((share[known] ** 2 / self.statistical.freedom[known]).sum())
        freedom = float(share.sum()) ** 2 / weight if weight > 0 else np.inf
        if variance > 0:
            freedom *= (1.0 + instrument**2 / variance) ** 2
        return float(np.sqrt(max(variance, 0.0))), instrument, freedom


def torque_is_lost(solution: Solution, statistical: Statistical) -> bool:
    """K is so uncertain that no torque has a scale: friction can have any value."""
    deviations = zip(solution.unknowns, statistical.deviations, strict=True)
    return any(u.name == "K" and deviation > UNKNOWN for u, deviation in deviations)


def parameters(found: Findings) -> dict[str, Parameter]:
    """R, L, K, B, J, T0, in that order."""
    out = {}
    for name in PARAMETERS:
        if name in found.without:
            out[name] = _given(name, 0.0, "left out of the model")
        elif name in found.fixed:
            out[name] = _given(name, float(found.fixed[name]), "given, not measured")
        else:
            out[name] = _free(found, name)
    return out


def _given(name: str, value: float, note: str) -> Parameter:
    return Parameter(name, UNITS[name], value, 0.0, 0.0, 0.0, (value, value), Status.FIXED, note)


def _free(found: Findings, name: str) -> Parameter:
    k = found.names.index(name)
    value = float(found.solution.values[k])
    gradient = np.eye(len(found.names))[k]
    deviation, instrument, freedom = found.propagate(gradient)
    unit = UNITS[name]
    if name in POSITIVE:
        relative, factor = float(np.hypot(deviation, instrument)), student(freedom)
        low = high = factor * relative
        if name in found.profiles:
            ends = (abs(float(np.log(end / value))) for end in found.profiles[name])
            low, high = (float(np.hypot(end, factor * instrument)) for end in ends)
        wide = max(relative, (low + high) / (2.0 * factor)) > UNKNOWN
        if wide or found.solution.at_bound[k]:
            return unknown(name, unit, f"these data do not determine it; {REMEDY[name]} would")
        return Parameter(
            name, unit, value, value * deviation, value * instrument, value * relative,
            (value * float(np.exp(-low)), value * float(np.exp(high))), Status.ESTIMATED,
        )  # fmt: skip
    if torque_is_lost(found.solution, found.statistical):
        return unknown(
            name, unit, f"no torque is known without K; {REMEDY['K']} would determine it"
        )
    total = float(np.hypot(deviation, instrument))
    reach = below = student(freedom) * total
    if name in found.profiles:
        ends = (abs(end - value) for end in found.profiles[name])
        below, reach = (float(np.hypot(end, student(freedom) * instrument)) for end in ends)
    if found.solution.at_bound[k]:
        return Parameter(
            name, unit, value, deviation, instrument, total, (0.0, reach), Status.AT_BOUND,
            "the best fit would be negative; set to 0",
        )  # fmt: skip
    if total > UNKNOWN_FRICTION * value:
        note = f"these data say only that it is below {value + reach:.2g} {unit}; {REMEDY[name]}"
        return unknown(name, unit, f"{note} would determine it")
    return Parameter(
        name, unit, value, deviation, instrument, total,
        (max(0.0, value - below), value + reach), Status.ESTIMATED,
    )  # fmt: skip


def unknown(name: str, unit: str, note: str) -> Parameter:
    """A quantity that these data do not tell."""
    return Parameter(name, unit, None, None, None, None, None, Status.NOT_IDENTIFIABLE, note)


def of_ratio(
    name: str, unit: str, value: float, deviation: float, instrument: float, freedom: float
) -> Parameter:
    """A positive quantity whose errors are factors."""
    total = float(np.hypot(deviation, instrument))
    reach = float(np.exp(student(freedom) * total / value))
    interval = value / reach, value * reach
    return Parameter(name, unit, value, deviation, instrument, total, interval, Status.ESTIMATED)


def positive(
    found: Findings,
    name: str,
    unit: str,
    of: Callable[[Motor], float],
    note: str,
    limit: float,
    besides: float = 0.0,
) -> Parameter:
    """A positive function of the motor, by linear propagation on the logarithmic scale.

    ``besides``: standard uncertainty (its unit) by what is no parameter of the motor.
    """
    value = of(found.motor())
    if not np.isfinite(value) or value <= 0:
        return unknown(name, unit, "it does not exist for this motor")
    x, scale = found.search, found.solution.slopes
    gradient = np.empty(len(x))
    for k, unknown_k in enumerate(found.solution.unknowns):
        step = 1e-6 if unknown_k.log else 1e-6 * unknown_k.scale
        moved = x.copy()
        moved[k] += step
        gradient[k] = (of(found.motor(moved)) - value) / step
    assert len(scale) == len(gradient)
    deviation, instrument, freedom = found.propagate(gradient)
    deviation = float(np.hypot(deviation, besides))
    total = float(np.hypot(deviation, instrument))
    if total > limit * value:
        return unknown(name, unit, "the parameters it follows from are not known well enough")
    reach = float(np.exp(student(freedom) * total / value))
    return Parameter(
        name, unit, value, deviation, instrument, total, (value / reach, value * reach),
        Status.ESTIMATED, note,
    )  # fmt: skip


def derived(
    found: Findings, voltage_v: float, brushes: Brushes | None = None
) -> dict[str, Parameter]:
    """Figures of the motor at ``voltage_v``, of which ``brushes`` drop some.

    Those that need a parameter left out are left out.
    """
    out = {}
    for name, about in FIGURES.items():
        if name == "electrical_time_constant" and found.motor().L == 0:
            continue
        at = "" if name in ("Kv",) or name.endswith("constant") else f" at {voltage_v:.3g} V"
        out[name] = positive(
            found, name, about.unit, partial(_figure, name, voltage_v, brushes),
            about.meaning + at, UNKNOWN,
            figure_uncertainty(name, found.motor(), voltage_v, brushes),
        )  # fmt: skip
    return out


def _figure(name: str, voltage_v: float, brushes: Brushes | None, motor: Motor) -> float:
    return figure(name, motor, voltage_v, brushes)


def combinations(found: Findings, given: Mapping[str, Parameter]) -> dict[str, Parameter]:
    """Ratios that are known although a parameter in them is not."""
    out = {}
    missing = {n for n, p in given.items() if p.status.unknown}
    for name, (unit, powers) in RATIOS.items():
        if not missing & powers.keys():
            continue

        def ratio(motor: Motor, powers: Mapping[str, float] = powers) -> float:
            logs = sum(p * np.log(max(getattr(motor, n), 1e-300)) for n, p in powers.items())
            return float(np.exp(logs))

        p = positive(found, name, unit, ratio, "", KNOWN_TOGETHER)
        if p.value is not None:
            out[name] = p
    return out


def budget_shares(found: Findings) -> dict[str, dict[str, float]]:
    """Standard uncertainty (SI) of every free parameter by cause: their squares sum to its own."""
    slopes = found.solution.slopes
    shares: dict[str, dict[str, float]] = {}
    for k, name in enumerate(found.names):
        known = {cause: float(v[k]) ** 0.5 for cause, v in found.statistical.lines.items()}
        known |= {cause: abs(float(shift[k])) for cause, shift in found.causes.items()}
        shares[name] = {c: u * float(slopes[k]) for c, u in known.items() if u > 0.0}
    return shares
