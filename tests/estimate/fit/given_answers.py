"""Answers of searches, and records, of which what passes and starts look at is given."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.solver.problem import Solution, Unknown
from motorid.estimate.uncertainty import added_noise

START = {"R": 2.0, "L": 4e-3, "K": 0.05, "B": 4e-5, "J": 2e-5, "T0": 6e-3}


def solution(objective: float, converged: bool = True, **values: float) -> Solution:
    found = {**START, **values}
    n = len(found)
    return Solution(
        tuple(Unknown(name, value) for name, value in found.items()),
        np.array(list(found.values())), (np.zeros(0),), (), np.eye(n), np.zeros(n, dtype=bool),
        tuple, objective, 1, converged,
    )  # fmt: skip


def record(simulated: int = 10, period_s: float = 1e-4) -> Any:
    return SimpleNamespace(
        simulated=simulated, untried=0, timeline=SimpleNamespace(period_s=period_s), shape="joined",
        capture="capture", driving=SimpleNamespace(decided=True), measured=(),
        departures=lambda *_: (),
    )  # fmt: skip


def without_noise(monkeypatch: pytest.MonkeyPatch) -> None:
    """No answer is judged by noise of the voltage: records that are given have none."""
    monkeypatch.setattr(added_noise, "judged", lambda _, found: found)


def note(
    monkeypatch: pytest.MonkeyPatch, module: Any, name: str, seen: list[Any], *answers: Any
) -> None:
    """A stage that notes what it is handed, and gives these answers in turn, the last for ever."""
    left = list(answers)

    def stage(*asked: Any, **how: Any) -> Any:
        seen.append((name, *asked, *how.items()))
        return left.pop(0) if len(left) > 1 else left[0]

    monkeypatch.setattr(module, name, stage)
