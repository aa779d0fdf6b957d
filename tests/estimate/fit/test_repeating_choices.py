"""Which orders of a rotor are taken, and when not to look at all: on records that are given."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.diagnosis import repeating_remarks
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.rotor.cogging import COGGING
from motorid.estimate.effects.rotor.encoder_error import ENCODER_ERROR
from motorid.estimate.effects.rotor.friction_ripple import FRICTION_RIPPLE
from motorid.estimate.effects.rotor.k_ripple import K_RIPPLE
from motorid.estimate.effects.rotor.r_ripple import R_RIPPLE
from motorid.estimate.effects.rotor.repeating import of_order, order
from motorid.estimate.fit import repeating
from motorid.estimate.model.angle_spectrum import TURN

Slopes = dict[Instance, Any]


def slopes(quantity: Any, periods: int) -> Slopes:
    return {one: {} for one in of_order(quantity, periods)}


OF_MOTOR = (K_RIPPLE, R_RIPPLE, COGGING, FRICTION_RIPPLE)


class Rotor:
    """A record about a solution, whose counts and courses are given."""

    def __init__(self, counts: list[list[int]], turns: float = 20.0, gear: float = 1.0) -> None:
        self.counts, self.turns, self.record = counts, turns, SimpleNamespace(gear=gear)
        self.slopes: Slopes = {}
        self.coasts: list[bool] = []
        self.left = "left"
        self.lines = SimpleNamespace(fitted=lambda known: (None, known), line="line")
        self.response = SimpleNamespace(
            slopes=lambda n: {one: c for q in OF_MOTOR for one, c in slopes(q, n).items()},
            encoder_error=lambda n: slopes(ENCODER_ERROR, n),
        )

    def counted(self) -> Any:
        return self.counts.pop(0) if self.counts else []

    def sights(self, period: float, coasts: bool) -> Any:
        self.coasts.append(coasts)
        return period

    def take(self, more: Slopes) -> None:
        self.slopes |= more


class Given:
    """By how much F falls with each kind and order, of 1000 readings."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, **falls: float) -> None:
        self.falls = falls
        self.periods = list[float]()
        self.peaks = list[float]()
        monkeypatch.setattr(repeating, "fall", self.fall)
        monkeypatch.setattr(repeating, "periods_a_turn", self.counts)

    def counts(self, channels: Any, peak: float) -> list[int]:
        self.peaks.append(peak)
        return list(channels[0])

    def fall(self, _line: Any, _before: Any, after: Slopes, sights: float) -> tuple[float, float]:
        self.periods.append(sights)
        new = list(after)[-1]
        names = {
            K_RIPPLE: "ripple",
            R_RIPPLE: "both",
            COGGING: "cogging",
            FRICTION_RIPPLE: "friction",
            ENCODER_ERROR: "encoder",
        }
        return self.falls.get(f"{names.get(new.quantity, 'ripple')}_{order(new)}", 0.0), 1000.0


def taken(rotor: Rotor) -> set[tuple[str, int]]:
    repeating._take([rotor])  # type: ignore[list-item]
    return {(one.quantity.name, order(one)) for one in rotor.slopes}


RIPPLE_COST = 10.0 + 4 * np.log(1000.0)  # K and R, each with a phase
K_COST = 10.0 + 2 * np.log(1000.0)
COGGING_COST = 10.0 + 2 * np.log(1000.0)


@pytest.mark.parametrize(("more", "found"), [(-0.1, False), (0.1, True)])
def test_an_order_must_pay_for_its_unknowns_and_a_margin(
    more: float, found: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    Given(monkeypatch, ripple_10=K_COST + more)
    assert bool(taken(Rotor([[10]]))) is found
    Given(monkeypatch, both_10=RIPPLE_COST + more)
    assert bool(taken(Rotor([[10]]))) is found
    Given(monkeypatch, cogging_10=COGGING_COST + more)
    assert bool(taken(Rotor([[10]]))) is found


def test_it_is_a_ripple_or_cogging_whichever_pays_more(monkeypatch: pytest.MonkeyPatch) -> None:
    Given(monkeypatch, both_10=RIPPLE_COST + 30.0, cogging_10=COGGING_COST + 29.0)
    assert {name for name, _ in taken(Rotor([[10]]))} == {K_RIPPLE.name, R_RIPPLE.name}
    Given(monkeypatch, both_10=RIPPLE_COST + 30.0, cogging_10=COGGING_COST + 31.0)
    assert {name for name, _ in taken(Rotor([[10]]))} == {COGGING.name}
    both_ways = {"cogging_10": COGGING_COST + 9.0, "friction_10": COGGING_COST + 10.0}
    Given(monkeypatch, **both_ways)
    assert {name for name, _ in taken(Rotor([[10]]))} == {FRICTION_RIPPLE.name}
    Given(monkeypatch, **dict.fromkeys(both_ways, COGGING_COST + 9.0))  # one way they are alike
    assert {name for name, _ in taken(Rotor([[10]]))} == {COGGING.name}


def test_a_ripple_of_k_need_not_pay_for_one_of_r(monkeypatch: pytest.MonkeyPatch) -> None:
    """A coast tells K alone. What R does at a start does not repeat, and is there all the same."""
    Given(monkeypatch, both_10=RIPPLE_COST - 5.0, ripple_10=K_COST + 5.0)
    assert {name for name, _ in taken(Rotor([[10]]))} == {K_RIPPLE.name, R_RIPPLE.name}
    Given(monkeypatch, both_10=RIPPLE_COST - 5.0, ripple_10=K_COST + 5.0, cogging_10=K_COST + 6.0)
    assert {name for name, _ in taken(Rotor([[10]]))} == {COGGING.name}
    Given(monkeypatch, both_10=RIPPLE_COST + 9.0, ripple_10=K_COST + 5.0)
    rotor = Rotor([[10]])
    assert {name for name, _ in taken(rotor)} == {K_RIPPLE.name, R_RIPPLE.name}
    # cogging, friction, and an encoder's errors
    assert rotor.coasts == [True, True, False, False, False, False]


def test_orders_are_taken_one_after_the_other_the_strongest_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    given = Given(monkeypatch, ripple_10=200.0, cogging_20=300.0, cogging_5=90.0, ripple_7=500.0)
    rotor = Rotor([[10, 20, 5, 7], [10, 20, 5], [5, 20], [30]])
    assert {n for _, n in taken(rotor)} == {20, 10, 5}
    assert min(given.periods) == pytest.approx(TURN / 30)
    assert TURN / 7 not in given.periods  # the three strongest of a round are looked at


def test_no_more_than_four_orders_of_a_motor(monkeypatch: pytest.MonkeyPatch) -> None:
    given = Given(monkeypatch, **{f"cogging_{n}": 500.0 for n in (10, 11, 12, 13, 14, 15)})
    rotor = Rotor([[n] for n in (10, 11, 12, 13, 14, 15)])
    assert len({n for _, n in taken(rotor)}) == repeating.ORDERS
    assert len(given.peaks) == repeating.ORDERS


def test_a_count_that_was_taken_is_not_tried_again(monkeypatch: pytest.MonkeyPatch) -> None:
    given = Given(monkeypatch, cogging_10=500.0)
    taken(Rotor([[10], [10]]))
    assert len([p for p in given.periods if p == pytest.approx(TURN / 10)]) == 4  # of every kind


@pytest.mark.parametrize(("turns", "peak"), [(5.1, repeating.PEAK), (4.9, repeating.NO_PEAK)])
def test_in_few_turns_a_count_leaks_into_its_neighbours(
    turns: float, peak: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    given = Given(monkeypatch)
    taken(Rotor([[10]], turns))
    assert given.peaks == [peak]


def test_an_encoder_errs_once_or_twice_in_its_own_turn(monkeypatch: pytest.MonkeyPatch) -> None:
    cost = 10.0 + 2 * np.log(1000.0)
    given = Given(monkeypatch, encoder_1=cost + 0.1, encoder_2=cost - 0.1)
    assert taken(Rotor([], gear=3.0)) == {(ENCODER_ERROR.name, 1)}
    assert given.periods == pytest.approx([3.0 * TURN, 3.0 * TURN / 2])


def looked(
    monkeypatch: pytest.MonkeyPatch, turns: float = 20.0, tells: bool = True, taken: bool = True,
    bent: bool = True,
) -> Any:  # fmt: skip
    class Turning:
        def __init__(self, record: Any, *_: Any) -> None:
            self.record, self.turns = record, turns
            self.slopes = {"one": {}} if taken else {}
            self.sizes = np.array([0.25])
            self.lines = SimpleNamespace(rows=lambda _: np.ones((1, 3)))

        def bend(self) -> Any:
            return {"current": 1.0} if bent else None

        def course(self) -> str:
            return "course"

    record = SimpleNamespace(asked=None)
    record.estimate = lambda *names: setattr(record, "asked", names)
    monkeypatch.setattr(repeating, "_Turning", Turning)
    monkeypatch.setattr(repeating, "_take", lambda _: None)
    monkeypatch.setattr(repeating, "replace", lambda solution, **new: (record, new))
    monkeypatch.setattr(repeating, "covariance_of", lambda _: None)
    block = SimpleNamespace(floor=1.0)
    line = SimpleNamespace(blocks=[block], sigmas=np.array([1.1 if tells else 1.0]))
    solution: Any = SimpleNamespace(
        records=[line], information=None, values=None, own=[np.array([9.0])], derivatives=None
    )
    records: Any = [record]
    return repeating.with_repeating(records, solution)


def test_what_was_taken_becomes_unknowns_at_their_sizes(monkeypatch: pytest.MonkeyPatch) -> None:
    record, new = looked(monkeypatch)
    assert record.asked == ("one",)
    assert new["own"][0].tolist() == [9.0, 0.25]
    assert (record.repeating.slopes, record.repeating.bend) == ({"one": {}}, {"current": 1.0})
    assert record.repeating.course == "course"


def test_nothing_is_taken_where_nothing_can_be_told(monkeypatch: pytest.MonkeyPatch) -> None:
    assert looked(monkeypatch, tells=False) is None
    assert looked(monkeypatch, turns=0.99) is None
    assert looked(monkeypatch, turns=1.01) is not None
    assert looked(monkeypatch, taken=False) is None
    assert looked(monkeypatch, bent=False) is None


def test_a_ripple_is_heavy_beyond_what_straight_lines_describe() -> None:
    ripple = list(of_order(K_RIPPLE, 10))
    other = list(of_order(COGGING, 10))
    record: Any = SimpleNamespace(instances=[*ripple, *other])
    for a, b, heavy in ((0.03, 0.0399, False), (0.03, 0.0401, True), (0.0, 0.049, False)):
        solution: Any = SimpleNamespace(own=[np.array([a, b, 9.0, 9.0])])
        assert repeating.is_heavy([record], solution) is heavy
    none: Any = SimpleNamespace(own=[np.array([9.0, 9.0])])
    assert not repeating.is_heavy([SimpleNamespace(instances=other)], none)  # type: ignore[list-item]


def test_what_repeats_in_one_record_becomes_an_unknown_of_the_other() -> None:
    class Record:
        def __init__(self, repeating: Any) -> None:
            self.repeating, self.asked = repeating, list[Any]()

        def estimate(self, *instances: Any) -> None:
            self.asked += instances

    found = SimpleNamespace(slopes={"first": 1, "second": 2})
    mine: list[Any] = [Record(None), Record(None)]
    theirs: list[Any] = [Record(found), Record(SimpleNamespace(slopes={}))]
    repeating.repeat_as(mine, theirs)
    assert [one.repeating for one in mine] == [one.repeating for one in theirs]
    assert [one.asked for one in mine] == [["first", "second"], []]
    assert [one.asked for one in theirs] == [[], []]


def test_an_amplitude_is_the_rms_of_the_runs_and_said_where_it_stands_out() -> None:
    ripple, cogs = of_order(K_RIPPLE, 7), of_order(COGGING, 14)
    instances = [*ripple, *cogs]
    records: Any = [
        SimpleNamespace(
            instances=instances, repeating=SimpleNamespace(slopes=dict.fromkeys(instances))
        )
        for _ in range(2)
    ]
    own = (np.array([0.03, 0.04, 1e-4, 0.0]), np.array([0.0, 0.05, 0.0, 1e-4]))
    noise = np.diag([1e-4, 1e-4, 4e-8, 4e-8])
    solution: Any = SimpleNamespace(own=own, own_covariance=(noise, noise))
    one, other = repeating_remarks.repeating(records, solution)
    assert (one.per_turn, one.quantity, one.unit) == (7, K_RIPPLE.name, "1")
    assert (one.amplitude, one.uncertainty) == pytest.approx((0.05, 0.01))
    assert (other.per_turn, other.amplitude) == (14, pytest.approx(1e-4))
    (said,) = repeating_remarks.allowed_for(records, solution)
    assert f"7 a turn ({K_RIPPLE.name} 5 %)" in said.message
    assert "14 a turn (each size within its noise)" in said.message
    clear: Any = SimpleNamespace(own=own, own_covariance=(noise / 1e4, noise / 1e4))
    (said,) = repeating_remarks.allowed_for(records, clear)
    assert f"14 a turn ({COGGING.name} 0.0001 N·m)" in said.message


def test_what_repeats_is_the_bend_and_each_size_times_its_course() -> None:
    course = np.arange(4.0)
    known: Any = SimpleNamespace(
        bend={"current": np.full(4, 0.5)},
        slopes={"a": {"current": course, "speed": 2.0 * course}, "b": {"speed": np.ones(4)}},
    )  # fmt: skip
    found = repeating._total(known, {"a": 3.0, "b": -1.0})  # type: ignore[dict-item]
    assert set(found) == {"current", "speed"}
    assert found["current"] == pytest.approx(0.5 + 3.0 * course)
    assert found["speed"] == pytest.approx(6.0 * course - 1.0)
    assert known.bend["current"] == pytest.approx(0.5)  # which is left as it is


@pytest.mark.parametrize(
    ("length", "shift", "anew"),
    [(2.9, 0.09, False), (3.1, 0.0, True), (0.0, 0.11, True), (0.0, 0.0, False)],
)
def test_courses_are_taken_anew_until_they_show_what_they_showed(
    length: float, shift: float, anew: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By three deviations of all readings together, or a tenth of one of a parameter."""
    monkeypatch.setattr(repeating, "covariance_of", lambda _: "inverse")
    monkeypatch.setattr(repeating, "RepeatingResponse", lambda *_: "response")
    monkeypatch.setattr(repeating, "_anew", lambda *_: "new")
    monkeypatch.setattr(repeating, "_total", lambda known, _: {"current": float(known == "new")})
    asked: list[Any] = []

    def lines(*_: Any) -> Any:
        return SimpleNamespace(
            length=lambda change: asked.append(change) or length, shift=lambda _: shift
        )

    monkeypatch.setattr(repeating, "StraightLines", lines)
    monkeypatch.setattr(repeating, "replace", lambda solution, **_: solution)
    run: Any = SimpleNamespace(instances=(), repeating="old")
    solution: Any = SimpleNamespace(
        information=None, own=[np.zeros(0)], records=[None], values=None
    )
    found = repeating.taken_again([run], solution)
    assert (found is not None) is anew
    assert asked == [{"current": 1.0}]
    assert run.repeating == ("new" if anew else "old")
