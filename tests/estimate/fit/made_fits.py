"""Fits of logs of which all that a choice looks at is given."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.unstated.current_lag import CURRENT_LAG
from motorid.estimate.effects.unstated.current_smoothing import CURRENT_SMOOTHING
from motorid.estimate.effects.unstated.speed_smoothing import SPEED_SMOOTHING
from motorid.estimate.solver.problem import Solution, Unknown

Floats = NDArray[np.float64]
NAMES = ("R", "L", "K")
PERIOD_S = 1e-3
LAG, SMOOTHING = Instance(CURRENT_LAG), Instance(CURRENT_SMOOTHING)
SPEED_SMOOTH = Instance(SPEED_SMOOTHING)


def solution(
    objective: float, information: Floats | None = None, *own: Sequence[float]
) -> Solution:
    table = np.eye(3) if information is None else information
    return Solution(
        tuple(Unknown(n, 1.0) for n in NAMES), np.array([objective, 2.0, 3.0]),
        tuple(np.array(one, dtype=float) for one in own or ((),)), (), table,
        np.zeros(3, dtype=bool), tuple, objective, 1, True,
    )  # fmt: skip


def record(shape: str = "joined", simulated: int = 10, **facts: Any) -> Any:
    """As much of a log's record as a choice looks at."""
    waveform = SimpleNamespace(
        shape=shape, volts=np.zeros(99), window_s=0.0, ohms=0.0, wanders=False, period_s=PERIOD_S
    )
    return SimpleNamespace(**{
        "shape": shape, "simulated": simulated, "rivals": (), "left_open": (), "untried": 0,
        "found": {}, "instances": (), "unknowns": (), "measured": [],
        "sensed": SimpleNamespace(waveform=waveform), **facts,
    })  # fmt: skip


def fit(objective: float, shape: str = "joined", simulated: int = 10, **facts: Any) -> Any:
    return [record(shape, simulated, **facts)], solution(objective)


def known(*sizes: tuple[Instance, float, float], found: Sequence[Instance] = ()) -> Any:
    """A record with quantities of (size, standard deviation of the prior), and its own values."""
    one = record(
        instances=tuple(i for i, _, _ in sizes),
        unknowns=tuple(Unknown(i.name, 0.0, prior_sd=sd) for i, _, sd in sizes),
        found=dict.fromkeys(found),
    )
    one.find = one.found.update
    return one, np.array([size for _, size, _ in sizes])


class Found:
    """A record that notes what it is asked to estimate and to find."""

    def __init__(self, capture: object, free: object, fixed: object, shape: str) -> None:
        self.capture, self.shape, self.sizes = capture, shape, dict[object, object]()
        self.found, self.instances, self.unknowns = dict[object, object](), (), ()
        self.measured = [SimpleNamespace(values=np.zeros(1000))]
        self.rivals = ()

    def estimate(self, *instances: object) -> None:
        self.asked = instances

    def find(self, sizes: dict[object, object]) -> None:
        self.sizes |= sizes
