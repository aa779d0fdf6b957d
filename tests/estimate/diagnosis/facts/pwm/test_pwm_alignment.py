"""Pulses in the middle or at the end of their PWM periods: found by what the current leaves."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid import api
from motorid.capture.model import CURRENT, POSITION, Capture
from motorid.errors import DataError
from motorid.estimate.diagnosis.facts.pwm import alignment
from motorid.estimate.results.estimate import Estimate
from motorid.estimate.results.status import Status
from motorid.estimate.signals.source.pwm_bridge import stretch_of
from motorid.estimate.signals.time_grid import lay
from tests.centred_pulses import LENGTH, MOTOR, PWM_HZ, SUPPLY_V, capture_of

NOISE = np.random.default_rng(5).standard_normal(2000)


def fitted(capture: Capture) -> Estimate:
    return api.fit(capture, model="six")


def named(estimate: Estimate) -> list[str]:
    return [one.code for one in estimate.suspects if one.strength == "named"]


def told(estimate: Estimate) -> list[str]:
    return [one.message for one in estimate.diagnostics if one.code == "pwm_alignment"]


def off(estimate: Estimate, name: str) -> float:
    """The error in standard uncertainties."""
    found = estimate.parameters[name]
    assert found.value is not None
    assert found.total
    return abs(found.value - MOTOR[name]) / found.total


@pytest.mark.slow
@pytest.mark.parametrize("place", [0.0, 0.5, pytest.param(1.0, marks=pytest.mark.study)])
def test_pulses_are_found_where_they_lie(place: float) -> None:
    """Taken at the beginning of their period, centred ones moved L by 7 u without a word."""
    estimate = fitted(capture_of(place))
    assert named(estimate) == []
    assert all(off(estimate, name) < 4.0 for name in MOTOR)
    assert [f"pwm_alignment = {place:g}" in said for said in told(estimate)] == [True] * bool(place)


@pytest.mark.slow
def test_a_stated_place_is_taken_at_its_word() -> None:
    found = fitted(capture_of(0.5, stated=0.5))
    assert named(found) == told(found) == []
    assert off(found, "L") < 4.0


@pytest.mark.parametrize("place", [0.0, 0.5, 1.0])
def test_a_pulse_begins_after_its_share_of_the_off_part(place: float) -> None:
    capture = capture_of(0.0, stated=place)
    part = next(p for p in lay(capture).parts if p.level == 0.6)
    volts = np.full(LENGTH, 0.6 * SUPPLY_V)
    made = stretch_of(capture.wiring, SUPPLY_V, 13.4, part, 1, 0.0, volts)
    assert made.late_s == pytest.approx(place * 0.4 / PWM_HZ)
    assert made.duty == pytest.approx(0.6)


def estimate(current: float, position: float = 1.0, status: Status = Status.ESTIMATED) -> Any:
    """Found with so much noise left of each channel."""
    curves = tuple(
        SimpleNamespace(channel=name, measured=size * NOISE, fitted=np.zeros(len(NOISE)))
        for name, size in ((CURRENT, current), (POSITION, position))
    )
    parameters = {name: SimpleNamespace(value=1.0, status=status) for name in ("R", "L", "K", "J")}
    return SimpleNamespace(curves=curves, parameters=parameters, alternative=None, diagnostics=())


def run(stated: float | None = None) -> Capture:
    return capture_of(0.0, stated=stated)


def glancing(left: dict[float, float]) -> Any:
    """A glance that leaves the current so much with pulses at each place."""

    def glance(captures: Any, values: Any, channels: Any) -> Any:
        assert channels == (CURRENT,)
        place = captures[0].wiring.pwm_alignment or 0.0
        if place not in left:
            raise DataError("no fit")
        return [left[place] * NOISE]

    return glance


def showing(more: float) -> Any:
    """With pulses at the end of their periods the current would show so much more."""

    def moves(captures: Any, others: Any, values: Any, channel: str) -> Any:
        assert (captures[0].wiring.pwm_alignment, others[0].wiring.pwm_alignment) == (None, 1.0)
        assert channel == CURRENT
        return [more * NOISE]

    return moves


def taken(
    before: Any, glance: Any, after: Any, capture: Capture | None = None, more: float = 0.1
) -> Any:
    """The place that is taken, and what is answered."""
    given = [capture or run()]
    found, answer = alignment.aligned(given, before, lambda _: after, glance, showing(more))
    return found[0].wiring.pwm_alignment, answer


@pytest.fixture
def replaced(monkeypatch: pytest.MonkeyPatch) -> None:
    """``replace`` of what stands in for an estimate."""

    def of(one: Any, **changed: Any) -> Any:
        if isinstance(one, SimpleNamespace):
            return SimpleNamespace(**{**vars(one), **changed})
        return replace(one, **changed)

    monkeypatch.setattr(alignment, "replace", of)


@pytest.mark.usefixtures("replaced")
@pytest.mark.parametrize(
    ("left", "after", "place"),
    [
        ({0.0: 1.1, 0.5: 1.0, 1.0: 1.2}, estimate(1.0), 0.5),
        ({0.0: 1.1, 0.5: 1.05, 1.0: 1.0}, estimate(1.0), 1.0),
        ({0.0: 1.1, 1.0: 1.0}, estimate(1.0), 1.0),  # with the other there is no fit
        ({0.5: 1.0}, estimate(1.0), None),  # nothing to compare with
        ({0.0: 1.01, 0.5: 1.0}, estimate(1.0), None),  # 40 of twice a log likelihood
        ({0.0: 1.1, 0.5: 1.0}, estimate(1.1, 0.5), None),  # the fit says otherwise
        ({0.0: 1.1, 0.5: 1.0}, estimate(1.0, 1.0, Status.NOT_SUPPORTED), None),
    ],
)
def test_the_likeliest_place_of_the_current_is_taken(
    left: dict[float, float], after: Any, place: float | None
) -> None:
    before = estimate(1.1)
    where, answer = taken(before, glancing(left), after)
    assert where == place
    assert (answer is before) == (place is None)


@pytest.mark.parametrize(
    "capture",
    [
        run(stated=0.0),
        replace(run(), wiring=replace(run().wiring, pwm_hz=0.0)),
        replace(run(), program=None, phases=()),
        replace(run(), channels={POSITION: run().channels[POSITION]}),
    ],
)
def test_none_is_looked_for_where_it_is_stated_or_nothing_switches(capture: Capture) -> None:
    before = estimate(1.1)
    assert taken(before, None, None, capture)[1] is before


def test_none_is_looked_for_without_values() -> None:
    before = estimate(1.1)
    before.parameters["K"].value = None
    assert taken(before, None, None) == (None, before)


@pytest.mark.usefixtures("replaced")
@pytest.mark.parametrize(("more", "looked"), [(0.014, False), (0.016, True), (-0.1, False)])
def test_no_search_is_made_where_residuals_show_nothing_of_it(more: float, looked: bool) -> None:
    """2,000 readings that show 1.5 % of what is left of them foresee 30 of twice a likelihood."""
    asked: list[Any] = []

    def glance(*given: Any, **_: Any) -> Any:
        asked.append(given)
        raise DataError("no fit")

    before = estimate(1.0)
    assert taken(before, glance, None, more=more) == (None, before)
    assert bool(asked) is looked


@pytest.mark.usefixtures("replaced")
def test_captures_that_no_fit_begins_from_stay_as_they_are() -> None:
    """A reversed encoder, which the fit put right by itself."""

    def moves(*_: Any, **__: Any) -> Any:
        raise DataError("the motor turns against its voltage")

    before, given = estimate(1.0), [run()]
    found = alignment.aligned(given, before, lambda _: before, glancing({}), moves)
    assert found == (given, before)
