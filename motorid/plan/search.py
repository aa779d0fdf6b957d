"""Coordinate search for the program that reaches the wants in the shortest time.

The price of a program is its length, times the runs that it would take until the worst motor's
worst want is met. Both sides of that trade are in one number, and it needs no penalty.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from motorid.motor.parameters import Motor
from motorid.plan.predict import Prediction, foresee
from motorid.plan.shape import (
    DRIVE_SAMPLES,
    Frame,
    Stage,
    holding_s,
    neighbours,
    seeds,
    shake,
    steady_both_ways,
)
from motorid.plan.skeleton import Bench
from motorid.plan.wants import Demand
from motorid.program import Program

MOVES = ((2.0, 0.3), (1.4, 0.15), (1.15, 0.07))  # factor on durations, shift of levels
PROGRAMS = 400  # tried at most from one beginning
SHAKES = 60
NOISE_LEAST = 0.5  # of a want that instruments alone exceed: what noise may take of it
MARGIN = 1.5  # on the statistical part: residuals of a real rig are not white

Stages = tuple[Stage, ...]
Allowed = Callable[[Program], bool]


@dataclass
class Search:
    """One bench, one demand, the motors it must hold for, and what the rig allows."""

    bench: Bench
    frame: Frame
    motors: Sequence[Motor]
    demand: Demand
    allowed: Allowed
    tried: int = 0
    _worst: list[int] = field(default_factory=list)  # motors that decided, the latest first

    def runs(self, predictions: Sequence[Prediction | None]) -> float:
        """Runs until every motor of ``predictions`` meets every want."""
        needed = [0.0]
        for p in predictions:
            if p is None:
                return math.inf
            for want in self.demand.wants:
                needed.append(MARGIN**2 * p.runs_for(want.name, want.reach, NOISE_LEAST))
        return max(needed)

    def price(self, stages: Stages, below: float = math.inf) -> float:
        """Seconds until the wants are met; infinite where the rig forbids the program.

        Motors that decided before are tried first. Once ``below`` is passed nothing more is asked,
        and the price is at least what is returned.
        """
        program = self.frame.program(stages)
        if not self.allowed(program):
            return math.inf
        turns = self.demand.turns
        if turns and not steady_both_ways(stages, self.motors, self.frame.top_v, turns):
            return math.inf
        self.tried += 1
        price = program.duration_s
        order = [*self._worst, *(k for k in range(len(self.motors)) if k not in self._worst)]
        for k in order:
            found = foresee(self.bench, program, self.motors[k])
            if found is None:
                self._decided(k)
                return math.inf
            for foreseen in (found.bare, found.whole):  # the cheap one may be dear enough
                price = max(price, program.duration_s * self.runs([foreseen()]))
                if price >= below:
                    self._decided(k)
                    return price
        return price

    def in_one_run(self, stages: Stages) -> bool:
        """Whether one run of an allowed program is enough: one motor that needs more settles it."""
        just = self.frame.program(stages).duration_s
        return self.price(stages, just * (1.0 + 1e-9)) <= just

    def _decided(self, k: int) -> None:
        self._worst = [k, *(other for other in self._worst if other != k)]

    def from_shape(self, stages: Stages) -> tuple[Stages, float]:
        """The nearest program that no move makes cheaper, and its price."""
        best, price = stages, self.price(stages)
        until = self.tried + PROGRAMS
        least = DRIVE_SAMPLES * self.frame.period_s
        for stretch, shift in MOVES:
            moved = True
            while moved and self.tried < until:
                moved = False
                for other in neighbours(best, stretch, shift, least):
                    cost = self.price(other, price)
                    if cost < price * (1 - 1e-3):
                        best, price, moved = other, cost, True
                        break
        return best, price

    def best(self) -> tuple[Stages, float]:
        """The cheapest of all beginnings' ends."""
        turns, hold_s = self.demand.turns, 0.0
        if turns:
            hold_s = 1.05 * max(holding_s(m, self.frame.top_v, turns) for m in self.motors)
        found = [self.from_shape(stages) for stages in seeds(self.motors[0], hold_s)]
        return self.shaken(*min(found, key=lambda pair: pair[1]))

    def shaken(self, best: Stages, price: float) -> tuple[Stages, float]:
        """Programs in which everything differs a little from the best: what no one move reaches."""
        chance = np.random.default_rng(0)
        least = DRIVE_SAMPLES * self.frame.period_s
        for _ in range(SHAKES):
            other = tuple(shake(stage, chance, least) for stage in best)
            cost = self.price(other, price)
            if cost < price * (1 - 1e-3):
                best, price = other, cost
        return self.from_shape(best)
