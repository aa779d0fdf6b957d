"""From a bench, a spread of motors and a demand to the program, its rate and its promise."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from motorid.errors import RigError
from motorid.motor.parameters import Motor
from motorid.plan.predict import Prediction, predict
from motorid.plan.search import MARGIN, Search, Stages
from motorid.plan.shape import Frame
from motorid.plan.skeleton import Bench
from motorid.plan.wants import Demand, Want
from motorid.program import Decay, Program

WORTH = 0.9  # of the price: what another rate must save to be taken
CYCLES = 5  # times at most that the number of cycles is raised
STRETCH = 1.04  # steps in which stages are made longer
Predicted = tuple[Program, tuple[Prediction, ...]]
Allowed = Callable[[Program, int], bool]  # program, ticks between samples


@dataclass(frozen=True)
class Promise:
    """One want and what the plan makes of it; reaches as in ``Want``.

    ``reach`` is the worst motor's, ``expected`` that of the middle one, ``instrument`` the part of
    ``reach`` that no longer run would lessen; ``cause`` is the largest of its causes.
    """

    want: Want
    reach: float
    expected: float
    instrument: float
    cause: str

    @property
    def met(self) -> bool:
        """Whether every motor of the spread gets what was asked."""
        return self.reach <= self.want.reach

    @property
    def instrument_limited(self) -> bool:
        """Whether no run, however long, would meet it."""
        return self.instrument > self.want.reach


@dataclass(frozen=True)
class Plan:
    """The program, how often to run it, and what it promises. ``tried``: programs weighed."""

    program: Program
    bench: Bench
    repeats: int
    promises: tuple[Promise, ...]
    predictions: tuple[Prediction, ...]  # of one run, the middle motor's first
    tried: int

    @property
    def seconds(self) -> float:
        """Of driving, all repeats together."""
        return self.repeats * self.program.duration_s

    @property
    def motor(self) -> Motor:
        """The middle of the spread."""
        return self.predictions[0].motor


def propose(
    benches: Sequence[Bench],
    top_v: float,
    decay: Decay,
    motors: Sequence[Motor],
    demand: Demand,
    allowed: Allowed,
) -> Plan:
    """The shortest plan found. ``benches``: one for each rate that may be used, the rig's first.

    Raises RigError where the rig allows no program that tells these motors.
    """

    def search(bench: Bench) -> Search:
        frame = Frame(top_v, bench.period_s, decay)
        return Search(bench, frame, motors, demand, lambda p: allowed(p, bench.period_ticks))

    chosen = search(benches[0])
    stages, price = chosen.best()
    tried = chosen.tried
    for bench in benches[1:]:
        other = search(bench)
        moved, cost = other.from_shape(stages)
        tried += other.tried
        if cost < WORTH * price:
            chosen, stages, price = other, moved, cost
    if math.isinf(price):
        raise RigError(
            "no program within the rig's limits tells these motors apart: raise "
            "limits.current_a, limits.speed_rad_s or limits.run_time_s as far as bench and motor "
            "allow, or narrow the spread with --capture"
        )
    return _whole(chosen, stages, tried)


def _whole(search: Search, stages: Stages, tried: int) -> Plan:
    """A little longer or in whole cycles, as far as one run may go; then in whole repeats."""
    program, predictions = _predicted(search, stages)
    runs = search.runs(predictions)
    if runs > 1.0:
        longer = _longer(search, stages, runs)
        program, predictions = longer or (program, predictions)
    repeats = max(1, math.ceil(search.runs(predictions) - 1e-9))
    promises = tuple(_promise(want, predictions, repeats) for want in search.demand.wants)
    return Plan(program, search.bench, repeats, promises, predictions, tried)


def _longer(search: Search, stages: Stages, runs: float) -> Predicted | None:
    """The shorter of the stretched and the repeated stages that need one run; else what fits."""
    factor, cycles = 1.0, 1
    while factor < math.ceil(runs):
        factor *= STRETCH
        longer = tuple(replace(stage, seconds=factor * stage.seconds) for stage in stages)
        if not search.allowed(search.frame.program(longer)):
            break
        if search.in_one_run(longer):
            return _predicted(search, longer)
    best = None
    for _ in range(CYCLES):
        cycles = math.ceil(cycles * runs)
        found = _predicted(search, stages, cycles)
        if not search.allowed(found[0]):
            break
        best, runs = found, search.runs(found[1])
        if runs <= 1.0:
            break
    return best


def _predicted(search: Search, stages: Stages, cycles: int = 1) -> Predicted:
    program = search.frame.program(stages, cycles)
    found = (predict(search.bench, program, motor) for motor in search.motors)
    return program, tuple(p for p in found if p is not None)


def _promise(want: Want, predictions: Sequence[Prediction], repeats: int) -> Promise:
    runs = repeats / MARGIN**2
    worst = max(predictions, key=lambda p: p.reach(want.name, runs))
    return Promise(
        want,
        worst.reach(want.name, runs),
        predictions[0].reach(want.name, runs),
        worst.reach(want.name, math.inf),
        worst.largest_cause(want.name),
    )
