"""What a fit on the scale R = 1, B = 0 says of any motor: JR/(K²+RB), K/(K²+RB), T0·R/K, L/R."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from motorid.capture.model import Capture
from motorid.capture.store import describe
from motorid.estimate.effects.source.voltage_gain import VOLTAGE_GAIN
from motorid.estimate.partial.mechanical_remarks import of_captures
from motorid.estimate.partial.mechanical_results import (
    CONSTANT,
    FRICTION,
    GAIN,
    RUN_FOR_ALL,
    WINDING,
    Judge,
    Quantity,
    fixed,
    unknown,
)
from motorid.estimate.partial.mechanical_signals import COMMAND, drive_of
from motorid.estimate.partial.without_current import wording
from motorid.estimate.partial.without_current.likelihood import Whole
from motorid.estimate.results.estimate import (
    PARAMETERS,
    UNITS,
    Diagnostic,
    Estimate,
    Parameter,
    Suspect,
)
from motorid.estimate.results.status import Status
from motorid.estimate.uncertainty import intervals
from motorid.estimate.uncertainty.unstated_gains import LEAST
from motorid.motor.parameters import Motor, mechanical_time_constant

SHOWN = {"K": GAIN, "J": CONSTANT, "T0": FRICTION}  # what the parameters of that scale show as
TIME = "mechanical time constant"
DROPS = "with what a bridge drops, if the volts are not the motor's own"
EITHER = "L/R counts in it if it is the winding's, not if it is a filter's"
MODEL = "v = JR/K dω/dt + (K + RB/K) ω + T0 R/K sign(ω), and L/R"
OF_PARAMETERS = ("budget", "voltage_readings", "coarse_readings")  # remarks of all six
NO_CURRENT = f"no current was measured; {RUN_FOR_ALL} would determine it"
Finding = TypeVar("Finding", Suspect, Diagnostic)
SMALLEST = 0.1  # of a lower end that a doubt leaves: nearer to nothing it has no reciprocal
ANY = 1.0  # relative standard uncertainty, beyond which a value is not given


@dataclass(frozen=True)
class Combination:
    """A ``name`` in ``unit`` that ``of`` gives, with ``powers`` in it of what may be doubtful."""

    name: str
    unit: str
    note: str
    of: Callable[[Motor], float]
    powers: Mapping[str, float]


def combinations(whole: Whole, volt: str) -> dict[str, Parameter]:
    """Of a fit whose drive is in ``volt``."""
    told = whole.estimate.parameters["L"].status.measured
    constant = Combination(CONSTANT, "s", TIME, mechanical_time_constant, {"J": 1.0, "K": -2.0})
    more = whole.beside
    if told and whole.filterable:
        motor = whole.found.motor()
        constant = replace(constant, note=f"{TIME}; {EITHER}", of=_between)
        more = math.hypot(more, motor.L / np.sqrt(12.0) / _between(motor))
    known = (
        constant,
        Combination(GAIN, f"rad/s/{volt}", "gain, speed for drive", _gain, {"K": -1.0}),
        Combination(FRICTION, volt, DROPS, _friction, {"T0": 1.0, "K": -1.0}),
    )
    out = {one.name: _told(whole, one, more if one is constant else 0.0) for one in known}
    if told:
        rise = Combination(WINDING, "s", "of the winding, or of a filter", _rise, {"L": 1.0})
        out[WINDING] = _told(whole, rise, 0.0)
    return out


def _between(motor: Motor) -> float:
    """Half-way between that and what it is if L/R is the lag of a filter of the speed."""
    return mechanical_time_constant(motor) - motor.L / 2.0


def _gain(motor: Motor) -> float:
    return 1.0 / motor.K


def _rise(motor: Motor) -> float:
    return motor.L


def _friction(motor: Motor) -> float:
    return motor.T0 / motor.K


def _told(whole: Whole, one: Combination, more: float) -> Parameter:
    parts = [whole.estimate.parameters[name] for name in one.powers]
    T0 = whole.estimate.parameters["T0"]
    if one.name == FRICTION and not T0.status.measured:
        return _as_friction(T0, one, _gain(whole.found.motor()))
    plain = intervals.positive(whole.found, one.name, one.unit, one.of, one.note, ANY)
    if plain.value is None or plain.interval_95 is None or plain.total is None:
        return plain
    found = _widened(plain, plain.value * more)
    doubtful = [p for p in parts if p.status is Status.DOUBTFUL]
    if not doubtful:
        return found
    first = intervals.parameters(whole.found)
    low, high = found.interval_95 or plain.interval_95
    for p in doubtful:
        below, above = _grown(p, first[p.name], one.powers[p.name])
        low, high = low * below, high * above
    added = ((high - low) / (plain.interval_95[1] - plain.interval_95[0])) * plain.total
    added = math.sqrt(max(added**2 - plain.total**2, 0.0))
    return replace(
        found,
        interval_95=(low, high),
        instrument=math.hypot(plain.instrument or 0.0, added),
        total=math.hypot(plain.total, added),
        status=Status.DOUBTFUL,
        note="; ".join(filter(None, (one.note, *(p.note for p in doubtful)))),
    )


def _as_friction(T0: Parameter, one: Combination, gain: float) -> Parameter:
    """Friction that is at its bound, left out, or not told."""
    if T0.value is None:
        return unknown(one.name, one.unit, T0.note)
    low, high = T0.interval_95 or (0.0, 0.0)
    return replace(
        T0,
        name=one.name,
        unit=one.unit,
        value=gain * T0.value,
        statistical=gain * (T0.statistical or 0.0),
        instrument=gain * (T0.instrument or 0.0),
        total=gain * (T0.total or 0.0),
        interval_95=(gain * low, gain * high),
    )


def _widened(p: Parameter, more: float) -> Parameter:
    """With a further standard uncertainty."""
    if not more or p.total is None or p.value is None or p.interval_95 is None:
        return p
    total = math.hypot(p.total, more)
    low, high = (p.value * (end / p.value) ** (total / p.total) for end in p.interval_95)
    instrument = math.hypot(p.instrument or 0.0, more)
    return replace(p, total=total, instrument=instrument, interval_95=(low, high))


def _grown(now: Parameter, first: Parameter, power: float) -> tuple[float, float]:
    """Factors of the ends of a combination's interval, by those of a part that is doubtful."""
    if now.interval_95 is None or first.interval_95 is None:
        return 1.0, 1.0
    pairs = zip(now.interval_95, first.interval_95, strict=True)
    low, high = (end / before if before > 0.0 else 1.0 for end, before in pairs)
    low, high = min(low, 1.0), max(high, 1.0)
    if power < 0.0:
        return high**power, max(low, SMALLEST) ** power
    return low**power, high**power


def shares(parameters: Mapping[str, Parameter]) -> str:
    """What the parameters of another model on that scale come to, for a sentence."""
    K, J, T0 = (parameters[name].value for name in SHOWN)
    if not K:
        return f"no {GAIN}"
    motor = Motor(R=1.0, L=0.0, K=K, B=0.0, J=J or 0.0, T0=T0 or 0.0)
    told = {
        GAIN: _gain(motor),
        CONSTANT: mechanical_time_constant(motor) if J else 0.0,
        FRICTION: _friction(motor),
    }
    return ", ".join(
        f"{name} {value:.4g}" if value else f"no {name}" for name, value in told.items()
    )


def opened(
    whole: Whole, captures: Sequence[Capture], fix: Mapping[str, float], without: Sequence[str]
) -> Estimate:
    """The estimate of that scale as what it is: combinations of ``captures`` as they were."""
    found, command = whole.estimate, drive_of(captures[0].channels) == COMMAND
    known = combinations(whole, "1" if command else "V")
    parameters = {name: unknown(name, UNITS[name], NO_CURRENT) for name in PARAMETERS}
    if {"K", "R"} <= fix.keys() and not command:
        parameters |= _by_constants(whole, known, fix)
    parameters |= {name: fixed(name, UNITS[name], value) for name, value in fix.items()}
    said = [
        replace(_shown(one), message=wording.shown(one.message, command))
        for one in found.diagnostics
        if one.code not in OF_PARAMETERS
    ]
    suspects = [
        replace(_shown(one), evidence=wording.shown(one.evidence, command))
        for one in found.suspects
    ]
    lags = [one for one in suspects if one.allowed and one.code.endswith("_lag")]
    return replace(
        found,
        model=MODEL,
        parameters=parameters,
        combinations=known,
        derived={n: found.derived[n] for n in ("no_load_speed",) if n in found.derived},
        free=tuple(SHOWN.get(name, WINDING) for name in found.free),
        diagnostics=(*said, *map(_unstated, lags), *of_captures(captures)),
        suspects=tuple(one for one in suspects if one not in lags),
        inputs=tuple(describe(capture) for capture in captures),
        options={**found.options, "fix": dict(fix), "without": list(without)},
        budget={},
        not_stated=_not_stated(found, command),
        at_25={},
        levels=(),
        steady=(),
        brushes=None,
    )


def _by_constants(
    whole: Whole, known: Mapping[str, Parameter], fix: Mapping[str, float]
) -> dict[str, Parameter]:
    """B, J and T0 where K and R are given."""
    share = fix["K"] / fix["R"]
    inertia = Combination("J", UNITS["J"], "", lambda m: share * m.J / m.K, {"J": 1.0, "K": -1.0})
    slope, friction = whole.estimate.parameters["K"], known[FRICTION]
    viscous = Quantity(
        share * ((slope.value or 0.0) - fix["K"]),
        (share * (slope.statistical or 0.0)) ** 2,
        share * (slope.instrument or 0.0),
    )
    dry = _as_friction(replace(friction, name="T0"), replace(inertia, name="T0"), share)
    return {
        "J": _told(whole, inertia, whole.beside),
        "B": Judge(max(whole.estimate.degrees_of_freedom, 1)).parameter("B", UNITS["B"], viscous),
        "T0": dry if friction.value is not None else unknown("T0", UNITS["T0"], friction.note),
    }


def _shown(one: Finding) -> Finding:
    """With its moves of the combinations that the parameters show as; they are settled already."""
    return replace(one, moves={SHOWN.get(n, n): move for n, move in one.moves.items()})


def _unstated(lag: Suspect) -> Diagnostic:
    """A delay of a log of which nobody stated one is no fault."""
    return Diagnostic(
        "unstated_lag", "info",
        f"{lag.evidence}: nobody stated the delays of this log, and the fit has this one as an "
        "unknown. To fix it, state --delay, or --aperture for what averages",
    )  # fmt: skip


def _not_stated(found: Estimate, command: bool) -> dict[str, dict[str, float]]:
    """What 1 % too much in a channel does to the combinations, by what it does to parameters."""
    value = {n: found.parameters[n].value or math.inf for n in SHOWN}
    out = {}
    for gain, moves in found.not_stated.items():
        if command and gain == VOLTAGE_GAIN.name:
            continue  # its scale is that of the answer
        share = {n: moves.get(n, 0.0) / value[n] for n in SHOWN}
        both = {
            CONSTANT: (share["J"] - 2.0 * share["K"], value["J"] / value["K"] ** 2),
            GAIN: (-share["K"], 1.0 / value["K"]),
            FRICTION: (share["T0"] - share["K"], value["T0"] / value["K"]),
        }
        out[gain] = {
            name: part * whole
            for name, (part, whole) in both.items()
            if math.isfinite(whole) and abs(part) > LEAST
        }
    return out
