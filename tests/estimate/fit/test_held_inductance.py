"""When an inductance that readings hardly tell is taken from ripple or pulses, and what is kept."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, SUPPLY, Capture, Channel
from motorid.estimate.fit import subsample_inductance as subsample
from motorid.estimate.solver.problem import Solution, Unknown

START = {"R": 2.0, "L": 4e-5, "K": 0.05}


def solution(objective: float = 0.0, bound: bool = False, **values: float) -> Solution:
    found = {**START, **values}
    return Solution(
        tuple(Unknown(n, v, log=n != "K") for n, v in found.items()),
        np.array(list(found.values())), (np.zeros(1),), (), np.diag([1.0, 4.0, 1.0]),
        np.array([False, bound, False]), tuple, objective, 1, True,
    )  # fmt: skip


def record(ripples: bool = True) -> Any:
    capture = Capture(np.arange(4), 1e3, {CURRENT: Channel(CURRENT, "A", np.zeros(4))})
    return SimpleNamespace(
        ripples=ripples, simulated=0, capture=capture, rivals=(), foretold=None, shape="joined",
        timeline=SimpleNamespace(period_s=1e-4), unknowns=(Unknown("offset", 0.5),),
    )  # fmt: skip


class Told:
    """Searches whose answers are given."""

    def __init__(
        self, monkeypatch: pytest.MonkeyPatch, unsure: float, pulses: float | None = None,
        ripple: float | None = None, ripples: bool = True,
    ) -> None:  # fmt: skip
        self.ended = list[tuple[float, str]]()
        monkeypatch.setattr(subsample, "_unsure", lambda *_: unsure)
        monkeypatch.setattr(
            subsample.discontinuous_current_inductance, "inductance", lambda *_: pulses
        )
        monkeypatch.setattr(subsample._Search, "by_ripple", lambda _: ripple)
        monkeypatch.setattr(subsample._Search, "ended", lambda _, henry, by: self.end(henry, by))
        monkeypatch.setattr(subsample._Search, "spent", lambda _, but=(): 40 if but else 70)
        self.records, self.other = [record(ripples)], record()
        self.found = subsample.told(self.records, ("R", "L", "K"), {}, START, solution())

    def end(self, henry: float, by: str) -> Any:
        self.ended.append((henry, by))
        return [self.other], solution()


def test_what_readings_tell_well_is_left_to_them(monkeypatch: pytest.MonkeyPatch) -> None:
    assert Told(monkeypatch, 0.049, 4e-5).found is None
    assert Told(monkeypatch, 0.051, 4e-5).ended == [(4e-5, "pulses")]


def test_pulses_come_before_ripple_and_what_was_spent_is_counted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    told = Told(monkeypatch, 1.0, 4e-5, 5e-5)
    assert told.ended == [(4e-5, "pulses")]
    assert (told.records[0].simulated, told.other.simulated) == (70, 40)  # it counts its own
    assert Told(monkeypatch, 1.0, None, 5e-5).ended == [(5e-5, "ripple")]
    none = Told(monkeypatch, 1.0, None, 5e-5, ripples=False)
    assert none.ended == []
    assert none.found is None
    assert none.records[0].simulated == 70


@pytest.mark.parametrize(
    ("ratio", "by", "unsure", "contradicted"),
    [
        (1.5, "ripple", 0.1, True), (1.4, "ripple", 0.1, False), (1 / 1.5, "ripple", 0.1, True),
        (1.4, "pulses", 0.1, True), (9.0, "ripple", 0.16, False),
    ],
)  # fmt: skip
def test_readings_of_some_authority_contradict_what_is_far_from_theirs(
    ratio: float, by: str, unsure: float, contradicted: bool
) -> None:
    """Three standard deviations: of 0.1 and .08 or .04."""
    assert subsample._contradicted(ratio, by, unsure) is contradicted


def test_a_contradicted_one_is_not_held(monkeypatch: pytest.MonkeyPatch) -> None:
    assert Told(monkeypatch, 0.1, 8e-5).ended == []
    assert Told(monkeypatch, 0.2, 8e-5).ended == [(8e-5, "pulses")]


def test_the_chains_own_gains_count() -> None:
    current = Channel(CURRENT, "A", np.zeros(4), gain_uncertainty=0.04)
    supply = Channel(SUPPLY, "V", np.zeros(4), gain_uncertainty=0.02)
    alone = Capture(np.arange(4), 1e3, {CURRENT: current})
    assert subsample._of_chain(alone) == pytest.approx(math.hypot(0.03, 0.04))
    both = replace(alone, channels={CURRENT: current, SUPPLY: supply})
    assert subsample._of_chain(both) == pytest.approx(math.hypot(0.02, 0.04))
    assert subsample._of_chain(replace(alone, channels={SUPPLY: supply})) == pytest.approx(0.02)


def test_how_unsure_an_inductance_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(subsample, "_deviation", lambda *_: 0.7)
    monkeypatch.setattr(subsample, "vanished", lambda *_: False)
    one = solution()
    held = replace(one, unknowns=one.unknowns[::2], values=one.values[::2])
    assert subsample._unsure(held, []) == 0.0
    assert subsample._unsure(solution(bound=True), []) == math.inf
    assert subsample._unsure(one, []) == 0.7  # by white noise half
    surely = replace(one, information=np.diag([1.0, 1.0 / 0.0049**2, 1.0]))
    assert subsample._unsure(surely, []) == pytest.approx(0.0049)
    hardly = replace(one, information=np.diag([1.0, 1.0 / 0.0051**2, 1.0]))
    assert subsample._unsure(hardly, []) == 0.7
    monkeypatch.setattr(subsample, "vanished", lambda *_: True)
    assert subsample._unsure(one, []) == math.inf


def ended(
    monkeypatch: pytest.MonkeyPatch, would_tell: float, alone: float, moved: float = 0.0
) -> tuple[Any, list[float], Any]:
    """What a search ends with; the inductances that it held; the records."""
    held: list[float] = []
    records = [record()]

    def hold(_: Any, henry: float) -> Any:
        held.append(henry)
        return records, solution(L=henry, R=2.0 + len(held))

    deviations = [would_tell, alone]
    search: Any = subsample._Search([record()], (), {}, START, solution())
    monkeypatch.setattr(subsample._Search, "held", hold)
    factors = np.exp([0.0, moved, 0.0])
    monkeypatch.setattr(
        subsample._Search, "finished",
        lambda _, __, one: replace(one, values=one.values * factors, objective=9.0),
    )  # fmt: skip
    monkeypatch.setattr(subsample, "_deviation", lambda *_: deviations.pop(0))
    monkeypatch.setattr(subsample, "_of_chain", lambda _: 0.06)
    return search.ended(4e-5, "ripple"), held, records


def test_what_readings_tell_better_from_there_is_theirs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ripple tells it to 0.1: hypot(.08, .06)."""
    found, held, records = ended(monkeypatch, 0.2, 0.09)
    assert held == [4e-5]
    assert found is not None
    assert found[1].objective == 9.0
    assert records[0].foretold is None


def test_else_it_is_foretold_with_what_a_larger_one_shifts(monkeypatch: pytest.MonkeyPatch) -> None:
    found, held, records = ended(monkeypatch, 0.2, 0.11)
    unsure = math.hypot(0.1, 0.15)  # iron may have .15 of it
    assert held == pytest.approx([4e-5, 4e-5 * math.exp(unsure), 4e-5])
    assert found is not None
    told = records[0].foretold
    assert (told.inductance_h, told.by) == (4e-5, "ripple")
    assert told.shift["L"] == pytest.approx(unsure)
    assert told.shift["R"] == pytest.approx(math.log(4.0 / 5.0))
    assert told.shift["K"] == 0.0
    wandered, _, _ = ended(monkeypatch, 0.2, 0.01, moved=0.31)
    assert wandered is not None
    _, held, _ = ended(monkeypatch, 0.2, 0.01, moved=-0.29)
    assert held == [4e-5]


def test_where_readings_would_have_told_it_far_better_they_contradict_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert ended(monkeypatch, 0.049, 0.11)[0] is None
    assert ended(monkeypatch, 0.051, 0.11)[0] is not None


def test_an_inductance_at_its_bound_does_not_stay() -> None:
    assert subsample._stays(solution(), solution(), 0.1, 0.2)
    assert not subsample._stays(solution(bound=True), solution(), 0.1, 0.2)
    assert not subsample._stays(solution(), solution(), 0.2, 0.2)


def test_neighbours_are_a_coarse_step_away() -> None:
    worse = {0: 50.0, subsample.COARSE: 80.0, -subsample.COARSE: 79.0}
    assert subsample._clear(0, worse.__getitem__, 30.0) == [False, True]


def test_how_a_valley_jumps_about_is_no_part_of_its_bend() -> None:
    valley = {place: 3.0 * place**2 - place for place in range(100, 107)}
    assert subsample._roughness(valley) == pytest.approx(0.0, abs=1e-6)
    jumping = {place: value + 10.0 * (-1) ** place for place, value in valley.items()}
    assert 8.0 < subsample._roughness(jumping) < 20.0


def test_own_unknowns_are_taken_over_by_name() -> None:
    before = record()
    before.sizes = lambda own: {"offset": 7.0, "promoted": 3.0}
    other = record()
    other.unknowns = (Unknown("new", 0.25), Unknown("offset", 0.5))
    found = subsample._as_of([other], [before], solution())
    assert found.own[0].tolist() == [0.25, 7.0]
