"""Turns the coefficients of a momentum balance into an Estimate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED, TORQUE, VOLTAGE, Capture
from motorid.capture.store import describe
from motorid.estimate.partial.block_bootstrap_regression import OFFSET, Regression
from motorid.estimate.partial.mechanical_signals import COASTING, COMMAND, Motion
from motorid.estimate.results.estimate import (
    PARAMETERS,
    UNITS,
    Curve,
    Diagnostic,
    Estimate,
    Parameter,
)
from motorid.estimate.results.status import Status
from motorid.estimate.uncertainty.unstated_gains import PART, gains_of, moved
from motorid.version import __version__

Floats = NDArray[np.float64]

LINEAR_UNITS = {"K": "N/A", "B": "N·s/m", "J": "kg", "T0": "N"}
LINEAR_NAMES = {"J": "mass", "T0": "Coulomb force"}  # where the usual names mislead
CONSTANT, GAIN, FRICTION, WINDING = "JR/(K²+RB)", "K/(K²+RB)", "T0·R/K", "L/R"
COLUMNS = {"J": 0, "B": 1, "T0": 2}
MODELS = {
    TORQUE: "torque = J dω/dt + B ω + T0 sign(ω) + offset",
    CURRENT: "i = J/K dω/dt + B/K ω + T0/K sign(ω) + offset",
    COASTING: "dω/dt = −B/J ω − T0/J sign(ω)",
    VOLTAGE: "v = JR/K dω/dt + (K + RB/K) ω + T0 R/K sign(ω) + offset, L neglected",
}
WEAK = 0.3  # relative standard uncertainty beyond which a note says so
NOTHING = 1.0  # and beyond which the value is not given
RUN_FOR_ALL = (
    "a run with the terminal voltage and the current measured, from rest through several levels "
    "to a coast-down"
)


@dataclass(frozen=True)
class Quantity:
    """A value with its variances, before it is judged."""

    value: float
    variance: float
    instrument: float = 0.0
    at_bound: bool = False


class Judge:
    """Says of each quantity whether these data know it."""

    def __init__(self, freedom: int) -> None:
        from scipy.stats import t

        self.reach = float(t.ppf(0.975, freedom))

    def parameter(
        self, name: str, unit: str, q: Quantity, note: str = "", signed: bool = False
    ) -> Parameter:
        """``signed``: the quantity may be negative, as an offset may."""
        statistical = float(np.sqrt(q.variance))
        total = float(np.hypot(statistical, q.instrument))
        low, high = float(q.value - self.reach * total), float(q.value + self.reach * total)
        if q.at_bound:
            return Parameter(
                name, unit, 0.0, statistical, q.instrument, total, (0.0, max(high, 0.0)),
                Status.AT_BOUND, _joined(note, "the best fit would be negative; set to 0"),
            )  # fmt: skip
        if not signed and (q.value <= 0 or total > NOTHING * q.value):
            limit = f"these data say only that it is below {max(high, 0.0):.2g} {unit}"
            return unknown(name, unit, _joined(note, limit))
        if not signed:
            low = max(low, 0.0)
            if total > WEAK * q.value:
                note = _joined(
                    note, f"weakly known: ± {100 * total / q.value:.0f} % (one standard)"
                )
        return Parameter(
            name, unit, q.value, statistical, q.instrument, total, (low, high),
            Status.ESTIMATED, note,
        )  # fmt: skip


def _joined(first: str, second: str) -> str:
    return f"{first}; {second}" if first else second


def unknown(name: str, unit: str, note: str) -> Parameter:
    """A parameter that these data do not tell."""
    return Parameter(name, unit, None, None, None, None, None, Status.NOT_IDENTIFIABLE, note)


def fixed(name: str, unit: str, value: float) -> Parameter:
    """A parameter that the caller gave."""
    return Parameter(
        name, unit, value, 0.0, 0.0, 0.0, (value, value), Status.FIXED, "given, not measured"
    )


def estimate(
    captures: Sequence[Capture],
    motions: Sequence[Motion],
    best: Regression,
    drive: str,
    fix: Mapping[str, float],
    without: Sequence[str],
    findings: Sequence[Diagnostic],
) -> Estimate:
    """The Estimate of a mechanical fit."""
    judge = Judge(best.freedom)
    gains, linear = _gain_uncertainties(captures, drive), motions[0].linear
    parameters, combinations = _answer(judge, best, gains, drive, fix, linear)
    known = parameters | combinations
    not_stated = {}
    for gain, channel in gains_of(captures, (drive, SPEED, POSITION)).items():
        if channel == COMMAND:
            continue  # its scale is that of the answer
        true = replace(best, coefficients=_true_coefficients(best, drive, channel))
        others = _answer(judge, true, gains, drive, fix, linear)
        not_stated[gain] = moved(known, others[0] | others[1])
    free = [name for name, column in {**COLUMNS, "offset": OFFSET}.items() if best.free[column]]
    return Estimate(
        model=MODELS.get(drive, MODELS[VOLTAGE]),
        method="momentum balance over smooth bumps, jackknife over stretches of motion",
        parameters={name: parameters[name] for name in PARAMETERS},
        combinations=combinations,
        derived={},
        nuisance=_offset(judge, best, motions[0]),
        free=tuple(free),
        correlation=_correlation(best),
        chi_square=_chi_square(motions, best),
        degrees_of_freedom=len(best.rows) - int(best.free.sum()),
        evaluations=1,
        diagnostics=tuple(findings),
        curves=_curves(motions, best),
        inputs=tuple(describe(capture) for capture in captures),
        options={"fix": dict(fix), "without": list(without), "half_width_s": best.half_width_s},
        versions={"motorid": __version__, "numpy": np.__version__},
        not_stated=not_stated,
    )


def _answer(
    judge: Judge,
    best: Regression,
    gains: Mapping[str, float],
    drive: str,
    fix: Mapping[str, float],
    linear: bool,
) -> tuple[dict[str, Parameter], dict[str, Parameter]]:
    """Parameters and combinations that the coefficients of a balance give."""
    raw = {name: _quantity(best, column, gains[name]) for name, column in COLUMNS.items()}
    units = {**UNITS, **(LINEAR_UNITS if linear else {})}
    if drive == TORQUE:
        return _from_torque(judge, raw, units, fix, linear), {}
    if drive == COASTING:
        return _from_coast(judge, raw, units, fix, linear)
    if drive == CURRENT:
        return _from_current(judge, raw, units, fix, best, linear)
    return _from_volts(judge, best, gains, units, fix, drive)


def _true_coefficients(best: Regression, drive: str, channel: str) -> Floats:
    """Of the balance if a channel reads 1 % too much."""
    factors = np.ones(len(best.coefficients))
    if channel == drive:
        factors -= PART
    elif drive == COASTING:  # what slows the motor is its own drive
        factors[COLUMNS["T0"]] -= PART
    else:
        factors[[COLUMNS["J"], COLUMNS["B"]]] += PART
    return np.asarray(best.coefficients * factors)


def _gain_uncertainties(captures: Sequence[Capture], drive: str) -> dict[str, float]:
    """Relative instrument uncertainty of each coefficient, by parameter name."""
    channels = [capture.channels for capture in captures]
    force = max((c[drive].gain_uncertainty for c in channels if drive in c), default=0.0)
    motion = max(
        c[name].gain_uncertainty for c in channels for name in ("speed", "position") if name in c
    )
    clock = max(capture.clock_uncertainty for capture in captures)
    if drive == COASTING:  # what slows the motor is its own drive, over which nothing else is read
        return {"J": 0.0, "B": clock, "T0": float(np.hypot(motion, 2 * clock))}
    both = float(np.hypot(force, motion))
    return {"J": float(np.hypot(both, 2 * clock)), "B": float(np.hypot(both, clock)), "T0": force}


def _quantity(best: Regression, column: int, gain: float) -> Quantity:
    value = float(best.coefficients[column])
    return Quantity(
        value,
        float(best.covariance[column, column]),
        abs(value) * gain,
        bool(best.at_bound[column]),
    )


def _from_torque(
    judge: Judge,
    raw: Mapping[str, Quantity],
    units: Mapping[str, str],
    fix: Mapping[str, float],
    linear: bool,
) -> dict[str, Parameter]:
    why = "the drive's torque was given, not its current and voltage; "
    why += f"{RUN_FOR_ALL} would determine it"
    found = {name: unknown(name, units[name], why) for name in ("R", "L", "K")}
    for name, quantity in raw.items():
        note = LINEAR_NAMES.get(name, "") if linear else ""
        found[name] = judge.parameter(name, units[name], quantity, note)
    return found | {name: fixed(name, units[name], value) for name, value in fix.items()}


def _from_current(
    judge: Judge,
    raw: Mapping[str, Quantity],
    units: Mapping[str, str],
    fix: Mapping[str, float],
    best: Regression,
    linear: bool,
) -> tuple[dict[str, Parameter], dict[str, Parameter]]:
    turn = "m" if linear else "rad"
    ratio_units = {"J": f"A·s²/{turn}", "B": f"A·s/{turn}", "T0": "A"}
    combinations = {
        f"{name}/K": judge.parameter(f"{name}/K", ratio_units[name], quantity)
        for name, quantity in raw.items()
    }
    found = {name: unknown(name, units[name], _without_voltage(name)) for name in PARAMETERS}
    torque_constant = _torque_constant(raw, best, fix)
    if torque_constant is not None:
        known, constant = torque_constant
        if known not in ("K", ""):
            found["K"] = judge.parameter("K", units["K"], constant)
        for name in COLUMNS:
            found[name] = judge.parameter(name, units[name], _times(raw[name], constant))
    return found | {n: fixed(n, units[n], value) for n, value in fix.items()}, combinations


def _from_coast(
    judge: Judge,
    raw: Mapping[str, Quantity],
    units: Mapping[str, str],
    fix: Mapping[str, float],
    linear: bool,
) -> tuple[dict[str, Parameter], dict[str, Parameter]]:
    """B/J and T0/J of a motor that nothing drives; B and T0 where J is given."""
    ratio_units = {"B": "1/s", "T0": "m/s²" if linear else "rad/s²"}
    combinations = {
        f"{name}/J": judge.parameter(f"{name}/J", unit, raw[name])
        for name, unit in ratio_units.items()
    }
    why = f"a coast-down alone determines only B/J and T0/J; {RUN_FOR_ALL} would determine it"
    found = {name: unknown(name, units[name], why) for name in PARAMETERS}
    if "J" in fix:
        inertia = Quantity(fix["J"], 0.0)
        for name in ratio_units:
            found[name] = judge.parameter(name, units[name], _times(raw[name], inertia))
    return found | {n: fixed(n, units[n], value) for n, value in fix.items()}, combinations


def _without_voltage(name: str) -> str:
    if name in ("R", "L", "K"):
        return f"no voltage was measured; {RUN_FOR_ALL} would determine it"
    return f"only its ratio to K is known: give --fix K=VALUE, or {RUN_FOR_ALL}"


def _torque_constant(
    raw: Mapping[str, Quantity], best: Regression, fix: Mapping[str, float]
) -> tuple[str, Quantity] | None:
    """K as given, or as it follows from one given mechanical parameter and its ratio to K."""
    if "K" in fix:
        return "K", Quantity(fix["K"], 0.0)
    for name in COLUMNS:
        ratio = raw[name]
        if name in fix and fix[name] > 0 and ratio.value > 0:
            value = fix[name] / ratio.value
            relative = value / ratio.value
            return name, Quantity(value, ratio.variance * relative**2, ratio.instrument * relative)
    return None


def _times(ratio: Quantity, constant: Quantity) -> Quantity:
    """ratio × constant. A constant that came from another ratio is nearly independent of it."""
    value = ratio.value * constant.value
    variance = ratio.variance * constant.value**2 + constant.variance * ratio.value**2
    return Quantity(value, variance, ratio.instrument * constant.value, ratio.at_bound)


def _from_volts(
    judge: Judge,
    best: Regression,
    gains: Mapping[str, float],
    units: Mapping[str, str],
    fix: Mapping[str, float],
    drive: str,
) -> tuple[dict[str, Parameter], dict[str, Parameter]]:
    """Time constant JR/(K² + RB), gain K/(K² + RB) and the volts that friction costs, T0 R/K."""
    a, b, c = map(float, best.coefficients[:3])
    cov = best.covariance
    volt = "V" if drive != COMMAND else "1"
    slope = np.array([1 / b, -a / b**2]) if b > 0 else np.zeros(2)
    constant = Quantity(a / b if b > 0 else 0.0, float(slope @ cov[:2, :2] @ slope))
    gain = Quantity(1 / b, float(cov[1, 1] / b**4), gains["B"] / b) if b > 0 else Quantity(0.0, 0.0)
    combinations = {
        CONSTANT: judge.parameter(CONSTANT, "s", constant, "mechanical time constant"),
        GAIN: judge.parameter(GAIN, f"rad/s/{volt}", gain, "gain, speed for drive"),
        FRICTION: judge.parameter(FRICTION, volt, _quantity(best, 2, gains["T0"])),
    }
    why = f"no current was measured; {RUN_FOR_ALL} would determine it"
    found = {name: unknown(name, units[name], why) for name in PARAMETERS}
    if {"K", "R"} <= fix.keys() and drive != COMMAND:
        share = fix["K"] / fix["R"]
        torque = {
            "J": Quantity(a * share, cov[0, 0] * share**2, abs(a) * share * gains["J"]),
            "B": Quantity(
                b * share - fix["K"] * share, cov[1, 1] * share**2, b * share * gains["B"]
            ),
            "T0": Quantity(c * share, cov[2, 2] * share**2, c * share * gains["T0"]),
        }
        found |= {name: judge.parameter(name, units[name], q) for name, q in torque.items()}
    return found | {n: fixed(n, units[n], value) for n, value in fix.items()}, combinations


def _offset(judge: Judge, best: Regression, motion: Motion) -> dict[str, Parameter]:
    if not best.free[OFFSET]:
        return {}
    quantity = _quantity(best, OFFSET, 0.0)
    note = "a constant load, or the sensor's offset"
    name = f"{motion.drive_name}_offset"
    return {name: judge.parameter(name, motion.drive_unit, quantity, note, signed=True)}


def _correlation(best: Regression) -> Floats:
    cov = best.covariance[np.ix_(best.free, best.free)]
    sigma = np.sqrt(np.maximum(np.diag(cov), 1e-300))
    return np.asarray(cov / np.outer(sigma, sigma))


def _chi_square(motions: Sequence[Motion], best: Regression) -> float:
    """Residual power over what the drive's noise gives."""
    from motorid.estimate.partial.mechanical_remarks import expected_rms

    expected = expected_rms(motions, best)
    power = float(best.residual @ best.residual)
    return power / expected**2 if expected else power


def _curves(motions: Sequence[Motion], best: Regression) -> tuple[Curve, ...]:
    """The drive, averaged over each bump, measured and as the model has it."""
    fitted = best.rows.matrix @ best.coefficients / best.rows.weight
    measured = best.rows.drive / best.rows.weight
    curves = []
    for index, motion in enumerate(motions):
        mine = best.rows.capture == index
        if mine.sum() > 2:
            spread = float(np.std(measured[mine] - fitted[mine]))
            curves.append(
                Curve(
                    index, motion.drive_name, motion.drive_unit, best.rows.time_s[mine],
                    measured[mine], fitted[mine], spread,
                )
            )  # fmt: skip
    return tuple(curves)
