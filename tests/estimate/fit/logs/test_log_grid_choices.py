"""When a log's fit goes on upon a finer grid, and when it stays: on fits that are given."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import Capture
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.timing.voltage_late import VOLTAGE_LATE
from motorid.estimate.fit.logs import log_grid
from motorid.estimate.signals.time_grid import FINER_GRID, IRREGULAR
from tests.estimate.fit.given_answers import without_noise
from tests.estimate.fit.made_fits import NAMES, record, solution

KNOWN = {"R": 2.0, "L": 4e-3, "K": 3.0}
OWN = np.zeros(0)
TAU = KNOWN["L"] / KNOWN["R"]


def line(period_s: float, jitter: float = 1.0, past: Any = "shares") -> Any:
    return SimpleNamespace(period_s=period_s, jitter=jitter, past=past)


def smooth(**facts: Any) -> Any:
    """A record whose voltage does not jump."""
    one = record(**facts)
    one.sensed.waveform.shape, one.sensed.waveform.steps_off = "held", np.zeros(0, dtype=int)
    return one


@pytest.mark.parametrize(
    ("facts", "coarse"),
    [
        ({}, True), ({"period_s": TAU / 33.0}, False), ({"period_s": TAU / 31.0}, True),
        ({"jitter": IRREGULAR}, False), ({"jitter": 1.01 * IRREGULAR}, True),
        ({"past": None}, False),
    ],
)  # fmt: skip
def test_irregular_stamps_beside_a_quick_winding_ask_for_a_finer_grid(
    facts: dict[str, Any], coarse: bool
) -> None:
    one = smooth(timeline=line(**{"period_s": TAU, **facts}))
    assert log_grid._coarse(one, OWN, KNOWN) is coarse
    one.sensed.waveform = None  # a program knows when its voltage jumps
    assert not log_grid._coarse(one, OWN, KNOWN)


@pytest.mark.parametrize(
    ("late", "own_moments", "coarse"),
    [
        (0.0, False, False), (-8.04, False, False), (-8.06, False, True), (-7.5, False, True),
        (0.0, True, True),
    ],
)  # fmt: skip
def test_a_jump_between_two_ticks_asks_for_one_too(
    late: float, own_moments: bool, coarse: bool
) -> None:
    """Whether all come by so many ticks after their stamps, or each at a moment of its own."""
    one = smooth(timeline=line(TAU, jitter=0.0), instances=(Instance(VOLTAGE_LATE),))
    own = np.array([late * TAU])
    assert not log_grid._coarse(one, own, KNOWN)
    one.sensed.waveform.steps_off = np.array([3, 9])
    one.sensed.waveform.jumps = np.array([3] if own_moments else [])
    assert log_grid._coarse(one, own, KNOWN) is coarse
    one.sensed.waveform.shape = "curved"
    assert not log_grid._coarse(one, own, KNOWN)  # then it does not jump there


def test_a_grid_gets_four_times_finer_each_time() -> None:
    capture = Capture(np.arange(9), 1e3, {}, provenance={"by": "hand"})
    once = log_grid._on_finer_grid(capture)
    twice = log_grid._on_finer_grid(once)
    assert once.provenance == {"by": "hand", FINER_GRID: 4}
    assert twice.provenance[FINER_GRID] == 16


@pytest.mark.parametrize(("period_s", "same"), [(0.76, True), (0.75, False), (0.25, False)])
def test_a_grid_that_hardly_gets_finer_is_none(period_s: float, same: bool) -> None:
    fine, last = record(timeline=line(period_s)), record(timeline=line(1.0))
    assert log_grid._as_fine(fine, last) is same


class Grids:
    """Finer records whose searches end at given objectives."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, *objectives: float, fine: bool = False):
        self.left, self.began = list(objectives), list[float]()
        monkeypatch.setattr(log_grid, "_finer", lambda one, *_: self.finer())
        monkeypatch.setattr(log_grid, "_as_fine", lambda *_: fine)
        monkeypatch.setattr(log_grid, "with_sources", self.search)
        monkeypatch.setattr(log_grid.default, "period_s", lambda _: 1e-3)
        monkeypatch.setattr(log_grid, "readings", lambda _: 100)
        without_noise(monkeypatch)

    def finer(self) -> Any:
        one = record("finer")
        one.go_on = lambda last, own: vars(one).update(from_=(last, own))
        return one

    def search(self, records: Any, _free: Any, start: Any) -> Any:
        self.began.append(start["L"])
        return solution(self.left.pop(0))

    def found(self, free: Any = NAMES) -> Any:
        before = [record("coarse")], solution(50.0, None, (1.5,))
        found = log_grid._gone_on(before, free, KNOWN, {})
        if found is not None:
            last, own = found[0][0].from_
            assert (last.shape, own.tolist()) == ("coarse", [1.5])
        return found


@pytest.mark.parametrize(("objective", "better"), [(54.6, True), (54.61, False)])
def test_a_search_may_rise_by_what_is_chance(
    objective: float, better: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By ln 100 of as many readings."""
    grids = Grids(monkeypatch, objective, 90.0, 90.0)
    assert (grids.found() is not None) is better
    others = [rise * 1e-3 * KNOWN["R"] for rise in log_grid.RISES]
    assert grids.began == pytest.approx([KNOWN["L"], *([] if better else others)])


def test_another_inductance_may_end_as_well(monkeypatch: pytest.MonkeyPatch) -> None:
    found = Grids(monkeypatch, 90.0, 40.0).found()
    assert found[1].objective == 40.0
    held = Grids(monkeypatch, 90.0)
    assert held.found(("R", "K")) is None  # of one that is held there is no other
    assert len(held.began) == 1
    assert Grids(monkeypatch, fine=True).found() is None


def settled(
    monkeypatch: pytest.MonkeyPatch, *steps: tuple[float, float], coarse: bool = True
) -> tuple[Any, list[Any]]:
    """What is settled on where finer fits gain so much and change by so many deviations."""
    left, shares = list(steps), list[Any]()
    before = [record("0")], solution(100.0)

    def gone_on(fit: Any, *_: Any) -> Any:
        if not left:
            return None
        gain, _ = left[0]
        return [record(str(len(shares) + 1))], solution(fit[1].objective - gain)

    def change(_before: Any, _after: Any) -> Any:
        shares.append(None)
        return SimpleNamespace(size=left.pop(0)[1], shift=np.array([3.0]))

    monkeypatch.setattr(log_grid, "_coarse", lambda *_: coarse)
    monkeypatch.setattr(log_grid, "_gone_on", gone_on)
    monkeypatch.setattr(log_grid, "Change", SimpleNamespace(of=change))
    monkeypatch.setattr(log_grid, "readings", lambda _: np.e**7)
    return log_grid.settled(before, NAMES, {}, {}), shares


@pytest.mark.parametrize(
    ("steps", "ends", "left_to_come"),
    [
        ([(6.9, 9.0)], "0", 3.0),  # no reading tells the grids apart: the first one stays
        ([(7.1, 0.89), (9.0, 9.0)], "1", 1.0),  # a third of .89 is left to come
        ([(7.1, 0.91), (0.0, 0.1)], "2", 1.0),
        ([(7.1, 9.0), (9.0, 9.0), (9.0, 9.0)], "2", 1.0),  # twice at most
        ([(7.1, 9.0)], "1", 1.0),  # there is no finer one
    ],
)
def test_a_fit_goes_on_until_its_parameters_stay(
    steps: list[tuple[float, float]], ends: str, left_to_come: float,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    (records, _), _ = settled(monkeypatch, *steps)
    assert records[0].shape == ends
    assert records[0].between_ticks == pytest.approx([left_to_come])


def test_a_grid_that_is_fine_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    (records, _), asked = settled(monkeypatch, (9.0, 9.0), coarse=False)
    assert records[0].shape == "0"
    assert not hasattr(records[0], "between_ticks")
    assert asked == []
