"""The other shares of friction between B and T0 that a log's fit tries."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.errors import DataError
from motorid.estimate.effects import scales
from motorid.estimate.fit import joint_fit
from motorid.estimate.fit.lagging_start import Doubt
from motorid.estimate.solver.problem import Solution, Unknown

MOTOR = {"R": 2.0, "L": 4e-3, "K": 0.05, "B": 4e-5, "J": 2e-5, "T0": 6e-3}
TOP = 300.0


def solution(free: tuple[str, ...] = tuple(MOTOR)) -> Solution:
    n = len(free)
    return Solution(
        tuple(Unknown(name, MOTOR[name]) for name in free), np.array([MOTOR[f] for f in free]),
        (), (), np.eye(n), np.zeros(n, dtype=bool), tuple, 100.0, 1, True,
    )  # fmt: skip


class Tried:
    """Instead of a search: what it would begin with; ``better`` falls with every one."""

    def __init__(self, gains: tuple[float, ...]) -> None:
        self.gains, self.seen = list(gains), list[dict[str, float]]()

    def again(self, _records: Any, free: Any, _start: Any, near: Solution) -> Solution:
        self.seen.append(dict(zip(free, near.values.tolist(), strict=True)))
        return replace(near, objective=100.0 - self.gains.pop(0))


def found(
    monkeypatch: pytest.MonkeyPatch, gains: tuple[float, ...], top: float = TOP,
    free: tuple[str, ...] = tuple(MOTOR),
) -> tuple[Solution, Tried]:  # fmt: skip
    tried = Tried(gains)
    monkeypatch.setattr(joint_fit, "again", tried.again)
    monkeypatch.setattr(scales, "speed", lambda record: record.top)
    records: Any = [SimpleNamespace(top=top / 3), SimpleNamespace(top=top)]
    return joint_fit._with_other_friction(records, solution(free), free, MOTOR), tried


def test_the_torque_at_the_highest_speed_is_shared_otherwise(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    _, tried = found(monkeypatch, (0.0, 0.0))
    torque = MOTOR["B"] * TOP + MOTOR["T0"]
    assert [one["T0"] / torque for one in tried.seen] == pytest.approx(list(joint_fit.SHARED))
    for one in tried.seen:
        assert one["B"] * TOP + one["T0"] == pytest.approx(torque)
        assert {n: one[n] for n in ("R", "L", "K", "J")} == {n: MOTOR[n] for n in "RLKJ"}


@pytest.mark.parametrize(
    ("gains", "objective"),
    [((0.0, 0.0), 100.0), ((0.4, 0.4), 100.0), ((3.0, 3.2), 97.0), ((1.0, 9.0), 91.0)],
)
def test_the_likelier_is_taken_where_it_surely_is(
    gains: tuple[float, ...], objective: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert found(monkeypatch, gains)[0].objective == objective


def test_nothing_is_tried_where_one_of_them_is_given(monkeypatch: pytest.MonkeyPatch) -> None:
    free = tuple(n for n in MOTOR if n != "B")
    assert found(monkeypatch, (), free=free)[1].seen == []


def test_without_a_motion_valleys_of_friction_are_compared(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(joint_fit.log_friction, "shared", lambda *given: given)
    (_, before, free, start), tried = found(monkeypatch, (), top=0.0)
    assert (free, start, tried.seen) == (tuple(MOTOR), MOTOR, [])
    assert before.objective == solution().objective


@pytest.mark.parametrize("share", [0.5, 0.7, 1.0, 1.3, 2.0])
def test_a_motion_is_taken_earlier_by_about_its_lag(
    share: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The start values guess a lag; the likelihood says how much of it there is."""
    late_s = 0.02
    monkeypatch.setattr(joint_fit, "taken_earlier", lambda capture, by_s: capture + by_s)
    monkeypatch.setattr(
        joint_fit, "MotorRecord", lambda capture, *_: SimpleNamespace(capture=capture)
    )
    monkeypatch.setattr(
        joint_fit, "settled", lambda records, *_: replace(
            solution(), objective=abs(records[0].capture - share * late_s)
        ),
    )  # fmt: skip
    monkeypatch.setattr(joint_fit, "leaves_misfit", lambda *_: misfit)
    monkeypatch.setattr(joint_fit, "unsupported", lambda *_: None)
    misfit, before = False, replace(solution(), objective=share * late_s)
    records: Any = [SimpleNamespace(capture=0.0, shape="joined")]
    doubt = Doubt(DataError("why"), late_s)
    (found,), best = joint_fit._doubted(records, before, tuple(MOTOR), MOTOR, {}, doubt)
    assert found.capture / (share * late_s) == pytest.approx(1.0, abs=0.1)
    assert best.objective < before.objective
    assert joint_fit._doubted(records, before, (), {}, {}, Doubt(DataError("why")))[0] is records
    misfit = True
    with pytest.raises(DataError, match=r"why.*20 ms earlier"):
        joint_fit._doubted(records, before, (), {}, {}, doubt)
