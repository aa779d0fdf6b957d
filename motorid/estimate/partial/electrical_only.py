"""Captures with voltage and current but no motion: what is left is the motor on its K's own scale.

With K -> c K, J -> c² J, B -> c² B, T0 -> c T0 a motor turns at 1/c of the speed and draws the same
current from the same voltage. So R, L, J/K², B/K² and T0/K are known, and one of K, J, B and T0
tells the others. The whole likelihood is used, with K held at 1.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from motorid.capture.model import CURRENT, POSITION, SPEED, SUPPLY, VOLTAGE, Capture
from motorid.errors import DataError, UsageError
from motorid.estimate.assembly.assemble import (
    UNCHANGED,
    accused,
    judged,
    renamed,
    uncertain,
    unjudged,
)
from motorid.estimate.assembly.doubt import settled
from motorid.estimate.diagnosis import identifiability
from motorid.estimate.diagnosis.remarks import budget
from motorid.estimate.effects.state.initial_speed import INITIAL_SPEED
from motorid.estimate.fit import joint_fit, multistart
from motorid.estimate.fit.parameter_bounds import held_values, merged, searched
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.partial import locked_rotor as rotor
from motorid.estimate.results.estimate import UNITS, Diagnostic, Estimate, Parameter
from motorid.estimate.results.status import Status
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.intervals import Findings, unknown

Better = Callable[
    [Estimate, Sequence[MotorRecord], Findings, Mapping[str, float], Sequence[str],
     Mapping[str, str]], Sequence[Diagnostic]]  # fmt: skip
POWERS = {"K": 1, "B": 2, "J": 2, "T0": 1}  # of K's scale in each parameter
RATIOS = {"J": ("J/K²", "A·s/V"), "B": ("B/K²", "A/V"), "T0": ("T0/K", "A")}  # with V = N·m/A·rad/s
COMBINED = {name: ratio for name, (ratio, _) in RATIOS.items()}
SCALELESS = ("stall_current", "electrical_time_constant", "mechanical_time_constant",
             "peak_efficiency")  # fmt: skip
UNSEEN = "the speed is seen through v - R i, and these data do not determine R"
REMEDY = "add the speed or the position, or give one of K, J, B and T0 by --fix"


def suits(captures: Sequence[Capture]) -> bool:
    """Every capture has a current and a voltage, and none a motion."""
    return all(_lacks_motion(capture) for capture in captures)


def _lacks_motion(capture: Capture) -> bool:
    names = set(capture.channels)
    return CURRENT in names and bool(names & {VOLTAGE, SUPPLY}) and not names & {SPEED, POSITION}


def fit(
    captures: Sequence[Capture],
    fix: Mapping[str, float],
    without: Sequence[str],
    better: Better | None = None,
) -> Estimate:
    """R, L and the combinations; all six where ``fix`` holds one of K, J, B and T0.

    ``better``: what better models say of the values, where no channel is accused.
    Raises UsageError where it holds more of these, DataError as ``motor_fit.fit``.
    """
    given = [name for name in POWERS if name in fix]
    if len(given) > 1:
        raise UsageError(
            f"cannot fix {' and '.join(given)} together: without a motion one of K, J, B and T0 "
            "determines the others"
        )
    _insist_on_current(captures)
    held = {**{n: v for n, v in fix.items() if n not in POWERS}, "K": fix.get("K", 1.0)}
    if not given and not without:
        still = rotor.still_motor(captures, held)
        if rotor.leaves_noise(captures, still):
            known = joint_fit.solved(captures, still, ())
            return rotor.estimate(captures, *known, still, fix)
    records, solution = joint_fit.solved(captures, held, without)
    if given and given != ["K"]:
        values = merged(held_values(held, without), solution)
        held = dict(fix)
        records, solution = _on_scale(records, solution, held, without, given[0], values)
    doubts = uncertain(records, solution, held, without)
    scaled = unjudged(captures, records, doubts, held, without)
    found = scaled if given else _open(scaled)
    found = replace(found, options={**found.options, "fix": dict(fix)})
    said = accused(found, records, solution)
    names = UNCHANGED if given else COMBINED
    found = judged(found, records, solution, said, names)
    if better is None or said.worst is not None or _accuses(found):
        return found
    more = better(scaled, records, doubts, held, without, names)
    more = [
        replace(renamed(one, names), sides={names.get(n, n): s for n, s in one.sides.items()})
        for one in more
    ]
    return replace(settled(found, more), diagnostics=(*more, *found.diagnostics))


def _accuses(found: Estimate) -> bool:
    """Some channel is named, and the fit does not allow for it."""
    return any(one.strength == "named" and not one.allowed for one in found.suspects)


def _insist_on_current(captures: Sequence[Capture]) -> None:
    for capture in captures:
        current = capture.channels[CURRENT]
        known = current.values[np.isfinite(current.values)]
        if not len(known) or float(np.ptp(known)) <= 1.5 * current.resolution:
            where = f" in {capture.path}" if capture.path else ""
            raise DataError(
                f"the current never changes{where}, and no motion was measured: check its sensor, "
                "and that the motor is driven"
            )


def _on_scale(
    before: Sequence[MotorRecord],
    solution: Solution,
    fix: Mapping[str, float],
    without: Sequence[str],
    name: str,
    values: Mapping[str, float],
) -> tuple[list[MotorRecord], Solution]:
    """The fit with K free, from the ``values`` of K = 1, on the scale that ``fix[name]`` sets.

    ``before``: the records of that fit, and its ``solution``.
    """
    if not values[name] > 0.0:
        raise DataError(f"--fix {name} sets no scale: these data show no {name}; hold K or J")
    scale = (fix[name] / values[name]) ** (1.0 / POWERS[name])
    start = {n: v * scale ** POWERS.get(n, 0) for n, v in values.items()}
    fixed = held_values(fix, without)
    free = searched(fixed)
    records = [MotorRecord(record.capture, free, fixed, record.shape) for record in before]
    for record, last, own in zip(records, before, solution.own, strict=True):
        _begin(record, last.sizes(own), scale)
    return records, multistart.solve(records, free, {**start, **fixed})


def _begin(record: MotorRecord, sizes: Mapping[str, float], scale: float) -> None:
    """As fast as a record of K = 1 began, whose own unknowns have these ``sizes``."""
    name = INITIAL_SPEED.name
    record.unknowns = tuple(
        replace(u, start=sizes[name] / scale) if u.name == name and name in sizes else u
        for u in record.unknowns
    )


def _in_volts(nuisance: Mapping[str, Parameter]) -> dict[str, Parameter]:
    """A speed of K = 1 as what it is: a back-EMF."""
    out = {}
    for name, p in nuisance.items():
        if name.startswith(INITIAL_SPEED.name):
            shown = name.replace(INITIAL_SPEED.name, "initial back-EMF")
            out[shown] = replace(p, name=shown, unit="V")
        else:
            out[name] = p
    return out


def _open(found: Estimate) -> Estimate:
    """The estimate of K = 1 as what it is: combinations."""
    parameters, combinations = dict(found.parameters), {}
    for name, (ratio, unit) in RATIOS.items():
        told = found.parameters[name]
        if told.status is Status.FIXED:
            continue  # left out of the model
        resistance = found.parameters["R"].status
        seen = resistance.measured or resistance is Status.FIXED
        combinations[ratio] = (
            replace(told, name=ratio, unit=unit) if seen else unknown(ratio, unit, UNSEEN)
        )
        why = f"voltage and current alone determine only {ratio}: {REMEDY}"
        parameters[name] = unknown(name, UNITS[name], why)
    parameters["K"] = unknown("K", UNITS["K"], f"no motion was measured: {REMEDY}")
    shares = {COMBINED.get(name, name): each for name, each in found.budget.items()}
    moves = {
        gain: {COMBINED.get(name, name): move for name, move in each.items()}
        for gain, each in found.not_stated.items()
    }
    known = {n for n, p in {**parameters, **combinations}.items() if p.value is not None}
    remarks_on = [d for d in found.diagnostics if d.code != "budget"]
    return replace(
        found,
        parameters=parameters,
        combinations=combinations,
        nuisance=_in_volts(found.nuisance),
        derived={name: found.derived[name] for name in SCALELESS if name in found.derived},
        free=tuple(COMBINED.get(name, name) for name in found.free),
        budget=shares,
        not_stated=moves,
        diagnostics=(
            _said(),
            *remarks_on,
            *budget({n: s for n, s in shares.items() if n in known}),
        ),
        segments=(),  # nobody saw it move: none could be told
    )


def _said() -> Diagnostic:
    run = identifiability.Excitation(frozenset((CURRENT, VOLTAGE)))
    return Diagnostic(
        "no_motion", "info",
        "neither speed nor position was measured, so the fit takes the speed, in volts, from what "
        "R i leaves of the voltage: that determines R, L, J/K², B/K² and T0/K, but not K. "
        f"{identifiability.advice(run)}",
    )  # fmt: skip
