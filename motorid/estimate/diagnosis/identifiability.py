"""Before any fit: which parameters, or combinations of them, a run's channels can tell.

The model's own sensitivities decide. The response of a typical motor to the excitation is computed
exactly (matrix exponentials), once for each parameter moved a little. What the channels show of
that is a matrix whose null space holds the changes of the parameters that nobody could see; a
quantity is known when it does not change along the null space. This is what would be possible
without any noise; how well, the fit says.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED, SUPPLY, TORQUE, VOLTAGE, Capture
from motorid.estimate.results.estimate import PARAMETERS
from motorid.program import Program, StepKind

Floats = NDArray[np.float64]
Motor = Mapping[str, float]

# Faulhaber 2338S006S by its data sheet (R, L, K, J), with friction that gives its no-load current.
TYPICAL = {"R": 2.6, "L": 180e-6, "K": 7.68e-3, "B": 2e-7, "J": 3.9e-7, "T0": 4e-4}
COMBINATIONS: Mapping[str, Callable[[Motor], float]] = {
    "J/K": lambda m: m["J"] / m["K"],
    "B/K": lambda m: m["B"] / m["K"],
    "T0/K": lambda m: m["T0"] / m["K"],
    "T0·R/K": lambda m: m["T0"] * m["R"] / m["K"],
    "B/J": lambda m: m["B"] / m["J"],
    "T0/J": lambda m: m["T0"] / m["J"],
    "J/K²": lambda m: m["J"] / m["K"] ** 2,
    "B/K²": lambda m: m["B"] / m["K"] ** 2,
    "K/(JL)": lambda m: m["K"] / (m["J"] * m["L"]),
    "R/L+B/J": lambda m: m["R"] / m["L"] + m["B"] / m["J"],
    "(RB+K²)/(JL)": lambda m: (m["R"] * m["B"] + m["K"] ** 2) / (m["J"] * m["L"]),
    "K/(K²+RB)": lambda m: m["K"] / (m["K"] ** 2 + m["R"] * m["B"]),
    "K+RB/K": lambda m: m["K"] + m["R"] * m["B"] / m["K"],
}
LEVELS_V = (3.0, 6.0, 4.5)
STEP = 1e-4  # relative change of a parameter
NULL = 1e-7  # a singular value below this share of the largest is none
SEEN = 1e-5  # a quantity that moves less than this along the null space is known
TIMES_S = np.r_[0.0, np.geomspace(1e-5, 0.4, 24)]  # from below L/R to above the coast-down
MOTION, LEVELS, TRANSIENT, COAST = "motion", "levels", "transient", "coast"
ADDITIONS = {  # the dearest last
    TRANSIENT: "a start or a step that is sampled finely",
    LEVELS: "three or more steady levels of drive",
    VOLTAGE: "the terminal voltage measured",
    CURRENT: "the current measured",
    MOTION: "the speed or the position measured",
    COAST: "a coast-down with the bridge open",
}

# Runs that tell them: level as a share of the highest voltage (None: the bridge is open), and
# duration in mechanical time constants. Plans begin their search with these.
Shape = tuple[tuple[float | None, float], ...]
STEP_DOWN: Shape = ((1.0, 3.0), (0.4, 3.0))  # currents that change much: R and L
CLIMB: Shape = ((0.5, 3.0), (1.0, 4.0), (None, 3.0))  # speeds, and a coast: K, B, J, T0


@dataclass(frozen=True)
class Excitation:
    """What a run shows: its channels, and what the motor does in it."""

    channels: frozenset[str]
    levels: int = 3  # steady levels of drive; 0: it is never driven
    transient: bool = True  # starts and steps are sampled finely enough
    coast: bool = True  # it coasts with the bridge open

    @property
    def sees_motion(self) -> bool:
        """Whether speed or position is measured."""
        return bool(self.channels & {SPEED, POSITION})

    @property
    def sees_voltage(self) -> bool:
        """Whether the drive's voltage is known."""
        return bool(self.channels & {VOLTAGE, SUPPLY})


@dataclass(frozen=True)
class Knowledge:
    """What a run can tell at best."""

    parameters: tuple[str, ...]
    combinations: tuple[str, ...]  # further ones, independent of each other and of the parameters
    null_directions: int  # changes of the six parameters that leave every channel as it is

    @property
    def missing(self) -> tuple[str, ...]:
        """Parameters that the run cannot tell."""
        return tuple(name for name in PARAMETERS if name not in self.parameters)


def assess(run: Excitation, motor: Motor | None = None) -> Knowledge:
    """What ``run`` can tell of a motor like ``motor`` (SI values of the six parameters)."""
    return _assess(run, tuple((motor or TYPICAL).items()))


@cache
def _assess(run: Excitation, motor: tuple[tuple[str, float], ...]) -> Knowledge:
    at = dict(motor)
    scale = np.array([at[name] or TYPICAL[name] for name in PARAMETERS])
    values, rows = np.linalg.svd(_sensitivities(run, at, scale))[1:]
    values = np.pad(values, (0, len(PARAMETERS) - len(values)))
    null = rows[values <= NULL * values[0]] if values[0] else np.eye(len(PARAMETERS))
    moves = np.abs(null).max(axis=0, initial=0.0)
    known = [name for name, move in zip(PARAMETERS, moves, strict=True) if move < SEEN]
    shown = np.eye(len(PARAMETERS))[[PARAMETERS.index(name) for name in known]]
    found = []
    for name, combination in COMBINATIONS.items():
        slope = _slope(combination, at, scale)
        wider = np.vstack([shown, slope])
        new = np.linalg.matrix_rank(wider, tol=1e-3) > len(shown)
        if new and np.linalg.norm(null @ slope) < SEEN:
            shown = wider
            found.append(name)
    return Knowledge(tuple(known), tuple(found), len(null))


def advice(run: Excitation, motor: Motor | None = None) -> str:
    """The least that must be added to ``run`` to tell every parameter, as a sentence; or ""."""
    missing = assess(run, motor).missing
    if not missing:
        return ""
    needed = tuple(ADDITIONS)
    if assess(_with(run, needed), motor).missing:
        return f"No run of this kind determines {_list(missing)}."
    for name in reversed(ADDITIONS):  # what can be spared, the dearest first
        fewer = tuple(other for other in needed if other != name)
        if not assess(_with(run, fewer), motor).missing:
            needed = fewer
    what = _list([ADDITIONS[name] for name in needed])
    return f"To determine {_list(missing)} as well, add a run with {what}."


def run_to_add(names: Sequence[str], volts: float, tau_s: float) -> str:
    """A concrete run that tells ``names`` of a motor of this time constant, as a sentence."""
    shape = STEP_DOWN if set(names) <= {"R", "L"} else CLIMB
    stages = [
        f"{_time(turns * tau_s)} of coasting"
        if share is None
        else f"{_time(turns * tau_s)} at {share * volts:.3g} V"
        for share, turns in shape
    ]
    return (
        f"A run such as {', '.join(stages)} from rest would determine {_list(tuple(names))}; "
        "`motorid plan --rig RIG --capture THIS` finds the shortest."
    )


def _time(seconds: float) -> str:
    return f"{seconds:.2g} s" if seconds >= 1 else f"{seconds * 1e3:.2g} ms"


def _with(run: Excitation, added: tuple[str, ...]) -> Excitation:
    """The run with those additions."""
    channels = {SPEED if name == MOTION else name for name in added} - {LEVELS, TRANSIENT, COAST}
    return replace(
        run,
        channels=run.channels | channels,
        levels=max(run.levels, 3) if LEVELS in added else run.levels,
        transient=run.transient or TRANSIENT in added,
        coast=run.coast or COAST in added,
    )


def _list(names: tuple[str, ...] | list[str]) -> str:
    return " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))


def of_capture(capture: Capture) -> Excitation:
    """What a capture shows, from its signals."""
    from motorid.segment import SegmentKind, segment

    pieces = segment(capture)
    kinds = {piece.kind for piece in pieces}
    driven = kinds & {SegmentKind.ACCELERATION, SegmentKind.STEADY, SegmentKind.BRAKE}
    motion = capture.get(SPEED) or capture.get(CURRENT)
    levels: list[float] = []
    for piece in pieces:
        if piece.kind == SegmentKind.STEADY and motion is not None:
            level = float(np.nanmean(motion.values[piece.slice]))
            if all(abs(level - other) > 0.05 * abs(level) for other in levels):
                levels.append(level)
    return Excitation(
        channels=frozenset(capture.channels),
        levels=max(len(levels), 1) if driven else 0,
        transient=SegmentKind.ACCELERATION in kinds,
        coast=SegmentKind.COAST in kinds,
    )


def of_program(program: Program, channels: Sequence[str], *, fine: bool = True) -> Excitation:
    """What a program will show through ``channels``, before it has run.

    One that never drives is a coast-down of a motor that something else has turned.
    ``fine``: the samples are dense enough to show starts and steps.
    """
    drives = [step for step in program.steps if step.level]
    first = next((k for k, step in enumerate(program.steps) if step.level), 0)
    return Excitation(
        channels=frozenset(channels),
        levels=len({(step.kind, step.level) for step in drives}),
        transient=fine and bool(drives),
        coast=any(step.kind == StepKind.COAST for step in program.steps[first:]),
    )


def _slope(combination: Callable[[Motor], float], at: Motor, scale: Floats) -> Floats:
    """Unit gradient of a combination over scaled parameters; 0 where it does not change."""
    slope = np.zeros(len(PARAMETERS))
    for column, (name, size) in enumerate(zip(PARAMETERS, scale, strict=True)):
        up = combination({**at, name: at[name] + STEP * size})
        down = combination({**at, name: at[name] - STEP * size})
        slope[column] = up - down
    length = float(np.linalg.norm(slope))
    return slope / length if length else slope


def _sensitivities(run: Excitation, at: Motor, scale: Floats) -> Floats:
    """Change of every reading with each scaled parameter, readings in units of their peak."""
    columns = []
    for name, size in zip(PARAMETERS, scale, strict=True):
        up = _readings(run, at, {**at, name: at[name] + STEP * size}, 1.0)
        down = _readings(run, at, {**at, name: at[name] - STEP * size}, 1.0)
        columns.append((up - down) / (2 * STEP))
    matrix = np.stack(columns, axis=1)
    if not run.coast:
        return matrix
    # the speed at which a coast-down begins is a nuisance, projected out whatever its length
    start = _readings(run, at, at, 1 + STEP) - _readings(run, at, at, 1 - STEP)
    length = float(start @ start)
    return matrix - np.outer(start, start @ matrix) / length if length else matrix


def _readings(run: Excitation, true: Motor, moved: Motor, coast_start: float) -> Floats:
    """What the channels of ``run`` read from a motor ``moved``, driven as the ``true`` one is.

    Quantities that are measured and drive the part that is modelled (the voltage, or without it
    the current or the torque) stay those of the true motor.
    """
    readings = [np.zeros(1)]
    state = _breakaway(run, true, moved)
    for volts in LEVELS_V[: run.levels]:
        steady, path = _driven(run, true, moved, volts, state)
        state = path[-1]
        readings += _shown(run, true, path if run.transient else steady[None, :])
    if run.coast:
        start = 0.8 * LEVELS_V[1] / true["K"]
        speed = _coasting(moved, start * coast_start) / start
        if run.sees_motion:
            readings.append(speed)
        if VOLTAGE in run.channels:
            readings.append(speed * moved["K"] / true["K"])
    return np.concatenate(readings)


def _breakaway(run: Excitation, true: Motor, moved: Motor) -> Floats:
    """The state at which the motor begins to turn: the current just overcomes friction."""
    if run.sees_voltage:
        return np.array([moved["T0"] / moved["K"], 0.0])
    return np.array([true["T0"] / true["K"], 0.0, 0.0])


def _driven(
    run: Excitation, true: Motor, moved: Motor, volts: float, start: Floats
) -> tuple[Floats, Floats]:
    """Steady state, and path (n, states) from ``start``, at TIMES_S; the motor turns one way.

    States are (i, ω) of the moved motor; where the voltage is not measured, (i, ω) of the true one
    and the speed of the moved one, which is driven by the measured current or torque.
    """
    motor = moved if run.sees_voltage else true
    A = np.array(
        [
            [-motor["R"] / motor["L"], -motor["K"] / motor["L"]],
            [motor["K"] / motor["J"], -motor["B"] / motor["J"]],
        ]
    )
    b = np.array([volts / motor["L"], -motor["T0"] / motor["J"]])
    if not run.sees_voltage:
        torque_per_ampere = true["K"] if TORQUE in run.channels else moved["K"]
        A, b = np.pad(A, (0, 1)), np.append(b, -moved["T0"] / moved["J"])
        A[2, 0], A[2, 2] = torque_per_ampere / moved["J"], -moved["B"] / moved["J"]
    steady = np.linalg.solve(A, -b)
    rates, modes = np.linalg.eig(A)
    weights = np.linalg.solve(modes, (start - steady).astype(np.complex128))
    path = steady + ((np.exp(TIMES_S[:, None] * rates) * weights) @ modes.T).real
    return steady, path


def _shown(run: Excitation, true: Motor, part: Floats) -> list[Floats]:
    """Readings of the channels that the model predicts, in units of about their peaks."""
    shown = []
    if CURRENT in run.channels and run.sees_voltage:
        shown.append(part[:, 0] * true["R"] / LEVELS_V[1])
    if run.sees_motion and (run.sees_voltage or run.channels & {CURRENT, TORQUE}):
        shown.append(part[:, -1] * true["K"] / LEVELS_V[1])
    return shown


def _coasting(motor: Motor, start: float) -> Floats:
    """Speed at TIMES_S while nothing drives the motor, until it stops."""
    rate, drop = motor["B"] / motor["J"], motor["T0"] / motor["B"]
    return np.asarray(np.maximum((start + drop) * np.exp(-rate * TIMES_S) - drop, 0.0))
