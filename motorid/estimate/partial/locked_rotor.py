"""Captures of a rotor that never turned: R and L are all that they tell.

With the rotor at rest K, B, J and T0 move no reading. A fit that searches them all the same walks
along valleys without an end, and every interval and wider model after it walks them again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED, SUPPLY, VOLTAGE, Capture
from motorid.errors import DataError
from motorid.estimate.assembly.assemble import accused, judged, uncertain, unjudged
from motorid.estimate.fit import alternating_fit, joint_fit, multistart, start_values_without_motion
from motorid.estimate.fit.parameter_bounds import searched, unknowns_of
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import UNITS, Diagnostic, Estimate
from motorid.estimate.signals.log_sections import pieces
from motorid.estimate.solver.dense_products import dot, square
from motorid.estimate.solver.levenberg_marquardt import maximise
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.intervals import REMEDY, unknown
from motorid.estimate.uncertainty.profile_likelihood import LEANS

Floats = NDArray[np.float64]

MECHANICAL = ("K", "B", "J", "T0")
ELECTRICAL = ("R", "L")
STILL = ("stall_current", "electrical_time_constant")  # of the motor, what such a rotor tells
HOLDS = 2.0  # times the torque of the highest current: friction of a rotor that is held
NARROWEST = 4  # readings of a block whose mean is looked at
NOTHING = (
    "these captures determine nothing: nothing shows that the rotor turned, nor that the current "
    "follows the voltage; capture a run whose voltage steps make it turn"
)
FOLLOWS = 4.0  # standard deviations of a correlation with the voltage that noise does not give
RARE = 8.0  # a chi-square is beyond what noise gives once in exp(8) blocks' widths


def without_constant_motion(captures: Sequence[Capture]) -> list[Capture]:
    """Logs without a speed or position that reads one value throughout: it shows no motion, and
    voltage and current say whether there was one.
    """
    return [_without_constant_motion(capture) for capture in captures]


def _without_constant_motion(capture: Capture) -> Capture:
    if capture.program is not None:
        return capture
    dead = [
        n for n in (SPEED, POSITION)
        if n in capture.channels and not float(np.ptp(_known(capture.channels[n].values)))
    ]  # fmt: skip
    left = {n: c for n, c in capture.channels.items() if n not in dead}
    return replace(capture, channels=left) if dead else capture


def _known(values: Floats) -> Floats:
    known = values[np.isfinite(values)]
    return known if len(known) else np.zeros(1)


def without_motion(
    captures: Sequence[Capture], fix: Mapping[str, float], without: Sequence[str]
) -> Estimate | None:
    """R and L of whole logs whose motion was measured and is none; None where there is some.

    None too where T0, which holds the rotor, is given. Raises DataError as ``estimate``.
    """
    if "T0" in fix or "T0" in without or not all(_is_log_at_rest(c) for c in captures):
        return None
    if not any(_draws_current(capture) for capture in captures):
        raise DataError(NOTHING)
    captures = pieces(captures)
    still = still_motor(captures, {**dict.fromkeys(without, 0.0), **fix})
    records, solution = joint_fit.solved(captures, still, ())
    if multistart.leaves_misfit(solution, records):  # such as a back-EMF that the current shows
        return None
    return estimate(captures, records, solution, still, fix, without)


def _is_log_at_rest(capture: Capture) -> bool:
    """A log with a current that says something, whose sensors of motion read noise alone."""
    motions = [capture.channels[n] for n in (SPEED, POSITION) if n in capture.channels]
    current = capture.get(CURRENT)
    if capture.program is not None or not motions or current is None or current.unsigned:
        return False
    known = current.values[np.isfinite(current.values)]
    if not len(known) or float(np.ptp(known)) <= 1.5 * current.resolution:
        return False
    return all(is_noise(m.values, origin=m.name == POSITION) for m in motions)


def _draws_current(capture: Capture) -> bool:
    """The current is more than noise about nothing, or goes with the voltage."""
    current, voltage = capture.channels[CURRENT].values, _volts(capture)
    if not is_noise(current, origin=False):
        return True
    known = np.isfinite(current) & np.isfinite(voltage)
    if not known.any():
        return True  # what is missing is said elsewhere
    swing, drawn = voltage[known] - voltage[known].mean(), current[known]
    return dot(swing, drawn) ** 2 > FOLLOWS**2 * square(swing) * square(drawn) / len(drawn)


def _volts(capture: Capture) -> Floats:
    channel = capture.get(VOLTAGE) or capture.get(SUPPLY)
    return np.full(len(capture), np.nan) if channel is None else channel.values


def is_noise(readings: Floats, *, origin: bool) -> bool:
    """Readings (n,) about nothing, or about any ``origin``, with no more in the means of blocks of
    any width than the scatter between neighbours gives them. A channel that reads one value only
    shows no noise.

    The bound of a chi-square is that of B. Laurent and P. Massart, Adaptive estimation of a
    quadratic functional by model selection, Ann. Statist. 28, 2000, lemma 1.
    """
    known = readings[np.isfinite(readings)]
    if len(known) < 2 * NARROWEST:
        return False
    known = known - known.mean() if origin else known
    variance = square(np.diff(known)) / (2 * (len(known) - 1))
    if not variance > 0.0:
        return False
    width = NARROWEST
    while width <= len(known):
        count = len(known) // width
        means = known[: count * width].reshape(count, width).mean(axis=1)
        if width * square(means) > variance * (count + 2 * np.sqrt(RARE * count) + 2 * RARE):
            return False
        width *= 2
    return True


def still_motor(captures: Sequence[Capture], held: Mapping[str, float]) -> dict[str, float]:
    """What is ``held``, and a friction that no current of these captures overcomes."""
    peak = max(float(np.nanmax(np.abs(c.channels[CURRENT].values))) for c in captures)
    still = {"K": 1.0, "B": 0.0, "J": 1.0, **held}  # nothing tells them
    return {**still, "T0": HOLDS * peak * still["K"]}


def leaves_noise(captures: Sequence[Capture], still: Mapping[str, float]) -> bool:
    """A rotor that is held leaves no more than noise in these captures, roughly fitted."""
    free = searched(still)
    records = [MotorRecord(capture, free, still) for capture in captures]
    start = start_values_without_motion.start_values(records, still)
    rough = maximise(unknowns_of(records, free, start), records, enough=alternating_fit.ROUGH)
    return not multistart.leaves_misfit(rough, records)


def estimate(
    captures: Sequence[Capture],
    records: Sequence[MotorRecord],
    solution: Solution,
    still: Mapping[str, float],
    fix: Mapping[str, float],
    without: Sequence[str] = (),
    held: str = "",
) -> Estimate:
    """R and L by the ``solution`` for a rotor that stood ``still``.

    ``fix`` and ``without``: as a person gave them. ``held``: why it stood, where that was wanted.

    Raises DataError where the captures do not tell these either.
    """
    profiled = all(record.sensed.waveform is None for record in records)
    doubts = uncertain(records, solution, still, (), profiled)
    found = unjudged(captures, records, doubts, still, (), profiled)
    if not profiled:
        found = _without_leaning(found)
    parameters = dict(found.parameters)
    if all(parameters[name].status.unknown for name in ELECTRICAL):
        raise DataError(NOTHING)
    friction = f"its friction holds {_peak(still):.3g} A or more"
    why = held or f"nothing shows that the rotor turned: {friction}"
    for name in MECHANICAL:
        if name not in fix and name not in without:
            parameters[name] = unknown(name, UNITS[name], f"{why}; let it turn")
    text = f"{why}. Such a run determines only R and L."
    said = Diagnostic("rotor_held", "info" if held else "warning", text)
    known = replace(
        found,
        parameters=parameters,
        derived={name: found.derived[name] for name in STILL if name in found.derived},
        diagnostics=(said, *found.diagnostics),
        segments=(),
        options={**found.options, "fix": dict(fix), "without": list(without)},
    )
    return judged(known, records, solution, accused(known, records, solution))


def _without_leaning(found: Estimate) -> Estimate:
    """An L whose interval only the likelihood's profile would tell is not given.

    In a log every value of L would move the moments of all its jumps, and take as long as a fit.
    """
    L = found.parameters["L"]
    if not (L.value and L.statistical and L.statistical > LEANS["L"] * L.value):
        return found
    note = f"these data hardly determine it; {REMEDY['L']} would"
    return replace(
        found,
        parameters={**found.parameters, "L": unknown("L", UNITS["L"], note)},
        combinations={n: p for n, p in found.combinations.items() if "L" not in n.split("/")},
        derived={n: p for n, p in found.derived.items() if n != "electrical_time_constant"},
    )


def _peak(still: Mapping[str, float]) -> float:
    """A, the highest current of the captures that ``still`` is of."""
    return still["T0"] / still["K"] / HOLDS
