"""Captures with voltage and current but no motion: what is left is the motor on its K's own scale.

With K -> c K, J -> c² J, B -> c² B, T0 -> c T0 a motor turns at 1/c of the speed and draws the same
current from the same voltage. So R, L, J/K², B/K² and T0/K are known, and one of K, J, B and T0
tells the others. The whole likelihood is used, with K held at 1.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from motorid.capture.model import CURRENT, POSITION, SPEED, SUPPLY, VOLTAGE, Capture
from motorid.errors import DataError, UsageError
from motorid.estimate import identifiability, motor_fit, passes, settling, unseen_motion
from motorid.estimate.intervals import unknown
from motorid.estimate.likelihood import maximise
from motorid.estimate.motor_results import report
from motorid.estimate.record import MotorRecord
from motorid.estimate.remarks import budget
from motorid.estimate.solution import Solution
from motorid.estimate.suspects.lazy import Suspects
from motorid.estimate.types import PARAMETERS, UNITS, Diagnostic, Estimate
from motorid.estimate.unknowns import held_values, merged, unknowns_of

POWERS = {"K": 1, "B": 2, "J": 2, "T0": 1}  # of K's scale in each parameter
RATIOS = {"J": ("J/K²", "A·s/V"), "B": ("B/K²", "A/V"), "T0": ("T0/K", "A")}  # with V = N·m/A·rad/s
SCALELESS = ("stall_current", "electrical_time_constant", "mechanical_time_constant",
             "peak_efficiency")  # fmt: skip
STILL = SCALELESS[:2]  # of these, what a rotor that is held tells
HOLDS = 2.0  # times the torque of the highest current: friction of a rotor that is held
UNSEEN = "the speed is seen through v - R i, and these data do not tell R"
REMEDY = "add the speed or the position, or give one of K, J, B and T0 by --fix"


def suits(captures: Sequence[Capture]) -> bool:
    """Every capture has a current and a voltage, and none a motion."""
    return all(_lacks_motion(capture) for capture in captures)


def _lacks_motion(capture: Capture) -> bool:
    names = set(capture.channels)
    return CURRENT in names and bool(names & {VOLTAGE, SUPPLY}) and not names & {SPEED, POSITION}


def fit(captures: Sequence[Capture], fix: Mapping[str, float], without: Sequence[str]) -> Estimate:
    """R, L and the combinations; all six where ``fix`` holds one of K, J, B and T0.

    Raises UsageError where it holds more of these, DataError as ``motor_fit.fit``.
    """
    given = [name for name in POWERS if name in fix]
    if len(given) > 1:
        raise UsageError(
            f"cannot fix {' and '.join(given)} together: without a motion one of K, J, B and T0 "
            "tells the others"
        )
    _insist_on_current(captures)
    held = {**{n: v for n, v in fix.items() if n not in POWERS}, "K": fix.get("K", 1.0)}
    stuck = None if given or without else _stuck(captures, held)
    if stuck is not None:
        return stuck
    records, solution = motor_fit.solved(captures, held, without)
    if given and given != ["K"]:
        values = merged(held_values(held, without), solution)
        held = dict(fix)
        records, solution = _on_scale(captures, held, without, given[0], values)
    found = report(captures, records, solution, held, without)
    if not given:
        found = _open(found)
    suspects = Suspects(records, solution, found.parameters)
    return replace(found, suspects=suspects, options={**found.options, "fix": dict(fix)})


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


def _stuck(captures: Sequence[Capture], held: Mapping[str, float]) -> Estimate | None:
    """R and L of a rotor that is held; None where such a rotor leaves a misfit."""
    peak = max(float(np.nanmax(np.abs(c.channels[CURRENT].values))) for c in captures)
    still = {**held, "B": 0.0, "J": 1.0, "T0": HOLDS * peak}  # with K = 1; nothing tells J
    if _moves(captures, still):
        return None
    records, solution = motor_fit.solved(captures, still, ())
    found = report(captures, records, solution, still, ())
    why = f"nothing shows that the rotor turned: its friction holds {peak:.3g} A or more"
    parameters = dict(found.parameters)
    for name in POWERS:
        parameters[name] = unknown(name, UNITS[name], f"{why}; let it turn")
    said = Diagnostic("rotor_held", "warning", f"{why}. R and L are all that such a run tells.")
    return replace(
        found,
        parameters=parameters,
        derived={name: found.derived[name] for name in STILL if name in found.derived},
        diagnostics=(said, *found.diagnostics),
        segments=(),
        suspects=Suspects(records, solution, parameters),
        options={**found.options, "fix": {n: v for n, v in held.items() if n != "K"}},
    )


def _moves(captures: Sequence[Capture], still: Mapping[str, float]) -> bool:
    """A rotor that is held leaves more than noise in these captures, roughly fitted."""
    free = [name for name in PARAMETERS if name not in still]
    records = [MotorRecord(capture, free, still) for capture in captures]
    start = unseen_motion.start_values(records, still)
    rough = maximise(unknowns_of(records, free, start), records, enough=passes.ROUGH)
    return settling.leaves_misfit(rough, records)


def _on_scale(
    captures: Sequence[Capture],
    fix: Mapping[str, float],
    without: Sequence[str],
    name: str,
    values: Mapping[str, float],
) -> tuple[list[MotorRecord], Solution]:
    """The fit with K free, from the ``values`` of K = 1, on the scale that ``fix[name]`` sets."""
    if not values[name] > 0.0:
        raise DataError(f"--fix {name} sets no scale: these data show no {name}; hold K or J")
    scale = (fix[name] / values[name]) ** (1.0 / POWERS[name])
    start = {n: v * scale ** POWERS.get(n, 0) for n, v in values.items()}
    fixed = held_values(fix, without)
    free = [n for n in PARAMETERS if n not in fixed]
    records = [MotorRecord(capture, free, fixed) for capture in captures]
    return records, settling.solve(records, free, {**start, **fixed})


def _open(found: Estimate) -> Estimate:
    """The estimate of K = 1 as what it is: combinations."""
    parameters, combinations = dict(found.parameters), {}
    for name, (ratio, unit) in RATIOS.items():
        told = found.parameters[name]
        if told.status == "fixed":
            continue  # left out of the model
        seen = found.parameters["R"].status in ("estimated", "fixed")
        combinations[ratio] = (
            replace(told, name=ratio, unit=unit) if seen else unknown(ratio, unit, UNSEEN)
        )
        why = f"voltage and current alone tell only {ratio}: {REMEDY}"
        parameters[name] = unknown(name, UNITS[name], why)
    parameters["K"] = unknown("K", UNITS["K"], f"no motion was measured: {REMEDY}")
    names = {name: ratio for name, (ratio, _) in RATIOS.items()}
    shares = {names.get(name, name): each for name, each in found.budget.items()}
    known = {n for n, p in {**parameters, **combinations}.items() if p.value is not None}
    remarks_on = [d for d in found.diagnostics if d.code != "budget"]
    return replace(
        found,
        parameters=parameters,
        combinations=combinations,
        derived={name: found.derived[name] for name in SCALELESS if name in found.derived},
        free=tuple(names.get(name, name) for name in found.free),
        budget=shares,
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
        "neither speed nor position was measured: what R i leaves of the voltage shows the speed "
        "in volts, which tells R, L, J/K², B/K² and T0/K, but not K. "
        f"{identifiability.advice(run)}",
    )  # fmt: skip
