"""The family of programs that a plan is sought in: rest, then stages of drive, coast or brake."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from motorid.estimate.diagnosis.identifiability import CLIMB, STEP_DOWN
from motorid.motor.parameters import Motor, mechanical_time_constant, no_load_speed
from motorid.program import Decay, Program, Step, StepKind

REST_SAMPLES = 32  # at rest before the first drive: offsets show, and that it begins at rest
DRIVE_SAMPLES = 40  # of a stage: fewer would leave the fit no line of the source (source.py)
SETTLED = 3.2  # time constants until the speed is within 5 % of its end
COAST, BRAKE = "coast", "brake"


@dataclass(frozen=True)
class Stage:
    """One stretch: ``level`` is a share (-1 to 1) of the highest voltage, or coast or brake."""

    level: float | str
    seconds: float


@dataclass(frozen=True)
class Frame:
    """What all programs of one search share."""

    top_v: float
    period_s: float
    decay: Decay = Decay.SYNCHRONOUS_SLOW

    @property
    def rest_s(self) -> float:
        """Seconds before the first drive."""
        return REST_SAMPLES * self.period_s

    def program(self, stages: Sequence[Stage], cycles: int = 1) -> Program:
        """The program, in whole samples; the stages as often as ``cycles`` says."""
        steps = [Step(StepKind.COAST, self.rest_s)]
        return Program((*steps, *(self._step(stage) for stage in (*stages,) * cycles)))

    def _step(self, stage: Stage) -> Step:
        samples = max(round(stage.seconds / self.period_s), DRIVE_SAMPLES)
        seconds = round(samples * self.period_s, 9)
        match stage.level:
            case "coast":
                return Step(StepKind.COAST, seconds)
            case "brake":
                return Step(StepKind.BRAKE, seconds)
            case share:
                volts = round(float(share) * self.top_v, 3)
                return Step(StepKind.DRIVE_VOLTS, seconds, volts, self.decay)


def drives(stage: Stage) -> bool:
    """Whether a stage puts a voltage on the motor."""
    return not isinstance(stage.level, str)


def seeds(motor: Motor, hold_s: float = 0.0) -> tuple[tuple[Stage, ...], ...]:
    """Shapes to begin a search with, in mechanical time constants of ``motor``.

    With ``hold_s`` only those that run so long in each direction.
    """
    tau = mechanical_time_constant(motor)
    start, stop, end = Stage(0.5, 3 * tau), Stage(BRAKE, 3 * tau), Stage(COAST, 3 * tau)
    if hold_s:
        up, down = Stage(1.0, hold_s), Stage(-1.0, hold_s)
        return ((up, stop, down), (start, up, stop, down, end), (start, up, end, down, end))
    up, down = Stage(1.0, 3 * tau), Stage(-1.0, 3 * tau)
    climb, steps = (
        tuple(Stage(COAST if level is None else level, turns * tau) for level, turns in shape)
        for shape in (CLIMB, STEP_DOWN)
    )
    return ((up, end), climb, steps, (up, down), (start, up, stop, down, end))


def neighbours(
    stages: tuple[Stage, ...], stretch: float, shift: float, least_s: float
) -> Iterator[tuple[Stage, ...]]:
    """Shapes one move away: all or one stage longer or shorter, one level moved, one left out."""
    for factor in (1 / stretch, stretch):
        yield tuple(replace(s, seconds=max(s.seconds * factor, least_s)) for s in stages)
    for k, stage in enumerate(stages):
        before, after = stages[:k], stages[k + 1 :]
        if any(drives(other) for other in (*before, *after)):
            yield (*before, *after)
        for factor in (1 / stretch, stretch):
            moved = max(stage.seconds * factor, least_s)
            if moved != stage.seconds:
                yield (*before, replace(stage, seconds=moved), *after)
        if not isinstance(stage.level, str):
            for step in (-shift, shift):
                level = min(max(stage.level + step, -1.0), 1.0)
                if level not in (stage.level, 0.0):
                    yield (*before, replace(stage, level=level), *after)


def shake(stage: Stage, chance: np.random.Generator, least_s: float) -> Stage:
    """The stage with its duration and its level a little elsewhere."""
    seconds = max(stage.seconds * float(np.exp(0.3 * chance.standard_normal())), least_s)
    if isinstance(stage.level, str):
        return replace(stage, seconds=seconds)
    level = float(np.clip(stage.level + 0.1 * chance.standard_normal(), -1.0, 1.0))
    return Stage(level or stage.level, seconds)


def holding_s(motor: Motor, volts: float, turns: float) -> float:
    """Seconds until a motor from rest has turned steadily so often; infinite if it does not."""
    speed = no_load_speed(motor, volts)
    if speed <= 0:
        return math.inf
    return SETTLED * mechanical_time_constant(motor) + turns * 2 * math.pi / speed


def steady_both_ways(
    stages: Sequence[Stage], motors: Sequence[Motor], top_v: float, turns: float
) -> bool:
    """Whether every motor runs steadily for so many turns in each direction."""

    def holds(stage: Stage, way: int) -> bool:
        if isinstance(stage.level, str) or stage.level * way <= 0:
            return False
        volts = abs(stage.level) * top_v
        return all(stage.seconds >= holding_s(motor, volts, turns) for motor in motors)

    return all(any(holds(stage, way) for stage in stages) for way in (1, -1))
