"""What a record keeps of its unknowns, runs and steps; tangents and low-passes by hand."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT
from motorid.estimate.effects.action import Setup
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.unstated.current_lag import CURRENT_LAG
from motorid.estimate.effects.unstated.current_smoothing import CURRENT_SMOOTHING
from motorid.estimate.model import low_passes, tangent
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.rebuilt_response import Planned
from motorid.estimate.model.source_mixing import Mixer
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.solver.problem import Unknown
from motorid.motor.reading import Output, Quantity
from tests.estimate.effects.benches import BENCHES, POINT, start

LAG, SMOOTHING = Instance(CURRENT_LAG), Instance(CURRENT_SMOOTHING)


def log() -> MotorRecord:
    """Of whose channels nobody says anything; a record of its own."""
    return MotorRecord(BENCHES["unstated"](), PARAMETERS, {})


# unknowns


def test_unknowns_come_last_and_go_again() -> None:
    one = log()
    before = one.instances
    one.estimate(LAG, SMOOTHING)
    assert one.instances == (*before, LAG, SMOOTHING)
    assert [u.name for u in one.unknowns[-2:]] == [LAG.name, SMOOTHING.name]
    one.propagate(LAG)
    assert one.instances == (*before, SMOOTHING)
    assert len(one.unknowns) == len(one.instances)


def test_what_was_found_keeps_its_place_and_its_prior() -> None:
    """Others follow what drives the motor; starts and bounds stay."""
    one = log()
    one.estimate(LAG)
    known = replace(one.unknowns[-1], start=2e-4, prior_sd=3e-4)
    added = Unknown(SMOOTHING.name, 1e-4, prior_sd=1e-4)
    before = one.instances
    one.find({LAG: known, SMOOTHING: added})
    assert one.instances == (*before, SMOOTHING)
    assert one.unknowns[-2:] == (known, added)
    assert one.found == {LAG, SMOOTHING}
    usual = log()
    usual.estimate(LAG, SMOOTHING)
    first = replace(usual.unknowns[0], start=0.125, prior_mean=9.0, prior_sd=7.0)
    usual._take(zip(usual.instances, (first, *usual.unknowns[1:]), strict=True))
    usual.renew()
    renewed = usual.unknowns[0]
    fresh = usual.instances[0].unknown(usual)
    assert fresh is not None
    assert (renewed.prior_mean, renewed.prior_sd) == (fresh.prior_mean, fresh.prior_sd)
    assert renewed.start == 0.125
    one.renew()
    assert one.unknowns[-2:] == (known, added)


def test_another_record_of_the_readings_goes_on_where_one_ended() -> None:
    one, other = log(), log()
    one.estimate(LAG)
    one.find({LAG: one.unknowns[-1]})
    kept: dict[str, Any] = {
        "rivals": ("rival",), "untried": 3, "outlying": True, "left_open": (np.ones(1),),
        "as_stamped": {"R": 1.0},
    }  # fmt: skip
    vars(one).update(kept)
    own = np.arange(1.0, len(one.unknowns) + 1.0)
    other.go_on(one, own)
    assert {name: getattr(other, name) for name in kept} == kept
    assert other.found == {LAG}
    assert other.instances == one.instances
    assert [u.start for u in other.unknowns] == own.tolist()
    assert [replace(u, start=0.0) for u in other.unknowns] == [
        replace(u, start=0.0) for u in one.unknowns
    ]
    assert other.sizes(own) == dict(zip((u.name for u in one.unknowns), own, strict=True))


# runs


def test_a_response_that_is_known_is_not_computed_again() -> None:
    """An offset of a reading needs none; three are remembered, the latest used the longest."""
    one = log()
    own = start(one)
    places = [[k * 1e-3 + 1.0, *np.ones(5)] * POINT for k in range(4)]
    first = one.readings(places[0], own)
    counts = [one.simulated]

    def read(k: int) -> None:
        one.readings(places[k], own)
        counts.append(one.simulated)

    assert one.readings(places[0], own) is first
    for k in (1, 2, 0, 3, 0, 2, 1):
        read(k)
    steps = np.sign(np.diff(counts)).tolist()
    assert steps == [1.0, 1.0, 0.0, 1.0, 0.0, 0.0, 1.0]
    (shown,) = (k for k, i in enumerate(one.instances) if i.name == "current offset")
    assert shown not in one._simulated


def test_a_twin_is_driven_alike_and_changes_by_itself() -> None:
    one = log()
    twin = one.twin()
    own = start(one)
    for a, b in zip(one.fitted(POINT, own), twin.fitted(POINT, own), strict=True):
        assert a == pytest.approx(b)
    assert twin.response is not one.response
    twin.estimate(LAG)
    assert LAG not in one.instances


def test_a_run_without_own_actions_begins_at_rest() -> None:
    one = log()
    setup = one.setup(0.0 * start(one))
    assert setup.initial == [0.0, 0.0, 0.0]
    assert setup.count == one.timeline.count


def test_steps_serve_a_motor_that_has_as_much_more_or_less() -> None:
    volts = np.ones(4)
    planned = Planned(np.array([2.0, 0.5]), np.array([1.0]), volts, np.zeros(4, dtype=np.uint8))
    assert planned.serve(np.array([2.0, -0.5]), np.array([1.0]), volts)
    assert not planned.serve(np.array([2.0, 0.6]), np.array([1.0]), volts)
    assert not planned.serve(np.array([2.0, 0.5]), np.array([1.1]), volts)
    assert not planned.serve(np.array([2.0, 0.5]), np.array([1.0]), volts.copy())


# tangents


@pytest.mark.parametrize(
    ("bounds", "low", "high"),
    [
        ((-9.0, 9.0), -0.5, 0.5), ((0.0, 9.0), 0.0, 0.5), ((-9.0, 0.0), -0.5, 0.0),
        ((-0.125, 0.25), -0.125, 0.25),
    ],
)  # fmt: skip
def test_a_tangent_is_a_difference_within_the_bounds(
    bounds: tuple[float, float], low: float, high: float
) -> None:
    """Of a step of .01 of a scale of 50; of what channels show, from nothing to the scale."""
    asked: list[dict[Any, float]] = []

    def fitted(_shared: Any, _own: Any, more: dict[Any, float]) -> list[np.ndarray]:
        asked.append(more)
        size = sum(more.values())
        return [np.array([size + size**2]), np.array([3.0 * size, 0.0])]

    record: Any = SimpleNamespace(fitted=fitted)
    quantity: Any = SimpleNamespace(
        simulated=True, step=0.01, scale=lambda _: 50.0, bounds=lambda _: bounds
    )

    class One(SimpleNamespace):
        __hash__ = object.__hash__

    one: Any = One(quantity=quantity)
    found = tangent.tangent(record, POINT, np.zeros(0), one)
    assert found[0] == pytest.approx([1.0 + low + high])
    assert found[1] == pytest.approx([3.0, 0.0])
    assert asked == [{one: high}, {one: low} if low else {}]
    quantity.simulated = False
    asked.clear()
    assert tangent.tangent(record, POINT, np.zeros(0), one)[1] == pytest.approx([3.0, 0.0])
    assert asked == [{one: 50.0}, {}]


# low-passes


def block(name: str, row: int) -> Any:
    return SimpleNamespace(block=SimpleNamespace(name=name), row=row)


BLOCKS = [block(CURRENT, 1), block("speed", 0)]
OUTPUTS = [Output(Quantity.SPEED, filter_s=3.0), Output(Quantity.CURRENT, filter_s=2.0)]


@pytest.mark.parametrize(
    ("second", "filter_s", "first", "size"),
    [
        (4.0, 1.0, 3.0, 4.0),
        (12.0, 1.0, 0.3 * 12.0, 12.0),  # one that rings more is none
        (1e-9, 1.0, 3.0, 0.02),  # nor is one of much less than a tick
    ],
)
def test_a_second_order_has_what_its_channel_has_of_first(
    second: float, filter_s: float, first: float, size: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(low_passes, "SecondOrder", SimpleNamespace(by_coefficients=lambda *of: of))
    setup = Setup(4, [], filter_s={CURRENT: filter_s}, second_s={CURRENT: second})
    found: Any = low_passes.low_passes(BLOCKS, OUTPUTS, setup, 1.0)
    assert found == {1: pytest.approx((first, size**2, 1.0))}
    # the response that stands has none of first order there, and the other channel's as declared
    assert low_passes.first_orders(BLOCKS, OUTPUTS, setup) == {CURRENT: -2.0, "speed": 0.0}
    plain = Setup(4, [], filter_s={CURRENT: filter_s})
    assert low_passes.low_passes(BLOCKS, OUTPUTS, plain, 1.0) == {}
    assert low_passes.first_orders(BLOCKS, OUTPUTS, plain) == {CURRENT: filter_s, "speed": 0.0}


def test_readings_of_some_rows_are_behind_their_low_pass() -> None:
    readings = np.arange(6.0).reshape(2, 3)
    passes: Any = {1: lambda row: 10.0 * row}
    found = low_passes.behind(passes, readings)
    assert found is readings
    assert found.tolist() == [[0.0, 1.0, 2.0], [30.0, 40.0, 50.0]]


# mixing


class Guess:
    """What drives a motor: volts; notes how it is mixed."""

    def __init__(self, *volts: float) -> None:
        self.excitation = SimpleNamespace(volts=np.array(volts))

    def mixed(self, other: Any, share: float) -> Any:
        return self, other, share


@pytest.mark.parametrize(
    ("first", "second", "share"),
    [
        ((1.0, 0.0), (0.5, 0.0), -1.0),  # half as much is left: as much again is ahead
        ((1.0, 0.0), (0.2, 0.0), -0.25),
        ((1.0, 0.0), (-1.0, 0.0), 0.5),  # it went as far beyond: half of the way back
        ((1.0, 0.0), (-50.0, 0.0), 0.9), ((1.0, 0.0), (1.0, 0.0), 0.0),
        ((1.0, 0.0), (0.0, 1.0), 0.5),
    ],
)  # fmt: skip
def test_a_guess_falls_short_by_what_the_change_before_shows(
    first: tuple[float, float], second: tuple[float, float], share: float
) -> None:
    """Share of the way from what was judged now to what was judged before."""
    mixer = Mixer()
    start, judged, again = Guess(0.0, 0.0), Guess(*first), Guess(3.0 + second[0], 4.0 + second[1])
    found: Any = mixer.next(start, judged)  # type: ignore[arg-type]
    assert found is judged
    found = mixer.next(Guess(3.0, 4.0), again)  # type: ignore[arg-type]
    assert found[:2] == (again, judged)
    assert found[2] == pytest.approx(share)
    assert mixer.judged is again
    assert mixer.change == pytest.approx(np.array(second))
