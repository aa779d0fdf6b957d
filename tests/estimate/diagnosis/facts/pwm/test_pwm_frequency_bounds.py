"""How much better another PWM frequency must explain the readings, by made residuals."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, SPEED
from motorid.errors import DataError
from motorid.estimate.diagnosis.facts.pwm import frequency
from motorid.estimate.results.status import Status
from tests.estimate.diagnosis.facts.pwm.test_pwm_frequency import Told

ONES = np.ones(64)
NOISE = np.random.default_rng(6).standard_normal(6000)


@dataclass(frozen=True)
class Wired:
    """A capture, as far as its PWM frequency goes."""

    wiring: Any


@dataclass(frozen=True)
class Wiring:
    """Its board's statement."""

    pwm_hz: float


def curve(left: Any, channel: str = CURRENT) -> Any:
    """Readings that a fit leaves so much."""
    fitted = np.linspace(5.0, 7.0, len(left))
    return SimpleNamespace(channel=channel, measured=fitted + left, fitted=fitted)


def told(*left: Any, names: str = "R", **changes: Any) -> Told:
    known = {n: SimpleNamespace(value=2.0, status=Status.ESTIMATED) for n in names}
    return replace(Told(tuple(map(curve, left)), known), **changes)


def wired(*hertz: float) -> Any:
    return [Wired(Wiring(hz)) for hz in hertz]


def glance_of(sizes: dict[float, Any]) -> Any:
    """What is left of readings of 1 at each frequency."""

    def glance(captures: Any, values: Any) -> Any:
        size = sizes[captures[0].wiring.pwm_hz]
        if size is None:
            raise DataError("nothing to begin with")
        return [size * ONES]

    return glance


@pytest.mark.parametrize(
    ("offset", "misfits"), [(1.35, False), (1.65, True)]
)  # root mean squares of 1.68 and 1.93
def test_a_current_is_left_nearly_twice_its_noise(offset: float, misfits: bool) -> None:
    assert frequency._misfits(curve(NOISE + offset)) is misfits
    assert frequency._misfits(curve(NOISE + offset, SPEED)) is False


def test_sixteen_readings_make_a_curve() -> None:
    assert frequency._misfits(curve(ONES[:16])) is True
    assert frequency._misfits(curve(ONES[:15])) is False
    gone = np.concatenate([ONES[:15], [np.nan] * 9])
    assert frequency._misfits(curve(gone)) is False


@pytest.mark.parametrize(("fall", "taken"), [(0.9, False), (1.1, True)])
def test_it_leaves_little_more_than_a_third_of_the_readings(fall: float, taken: bool) -> None:
    before = told(ONES, NOISE)  # one current of two misfits
    after = told(np.exp(-fall) * ONES, np.exp(-fall) * NOISE)
    given = wired(80e3)
    found, estimate = frequency.corrected(
        given, before, lambda c: after if c[0].wiring.pwm_hz == 160e3 else before, glance_of({})
    )
    assert (found is given) is not taken
    if taken:
        assert [c.wiring.pwm_hz for c in found] == [160e3]
        assert estimate.curves is after.curves
        (said,) = estimate.suspects
        assert (said.code, said.strength, said.allowed) == ("pwm_contradicted", "named", True)
        assert "frequency of 80 kHz" in said.evidence
        assert "at 160 kHz the fit leaves the readings 33% of what it leaves" in said.evidence


def test_the_best_of_those_that_have_a_fit_is_taken() -> None:
    """The first has none; the second is better than the third; what was said stays."""
    sizes = {40e3: 0.05, 160e3: 0.2, 320e3: 0.04}

    def fit(captures: Any) -> Any:
        hertz = captures[0].wiring.pwm_hz
        if hertz == 20e3:
            raise DataError("no fit")
        return told(sizes[hertz] * ONES, suspects=("before",))

    assert len(wired(80e3, 80e3)) == 2
    found, estimate = frequency.corrected(wired(80e3, 80e3), told(ONES), fit, glance_of({}))
    assert [c.wiring.pwm_hz for c in found] == [320e3, 320e3]
    assert estimate.suspects[1:] == ("before",)


@pytest.mark.parametrize("hertz", [(80e3, 40e3), (80e3, 0.0), (0.0, 0.0)])
def test_boards_that_state_different_frequencies_or_none_are_left(
    hertz: tuple[float, ...],
) -> None:
    def fit(captures: Any) -> Any:
        raise AssertionError("no fit is asked for")

    given, before = wired(*hertz), told(ONES)
    assert frequency.corrected(given, before, fit, glance_of({})) == (given, before)


@pytest.mark.parametrize(("chi_square", "explained"), [(600.0, True), (600.1, False)])
def test_a_wider_model_explains_up_to_one_and_a_half(chi_square: float, explained: bool) -> None:
    wider: Any = SimpleNamespace(chi_square=chi_square, degrees_of_freedom=400)
    assert frequency._explained(wider) is explained
    assert frequency._explained(None) is False


FOUR = [wired(hz) for hz in (20e3, 40e3, 160e3, 320e3)]


@pytest.mark.parametrize(
    ("sizes", "worth"),
    [
        ((0.9, 0.85, 0.95, 1.0), None),  # ln .85 is -.16
        ((0.9, 0.8, 0.95, 1.0), 1),  # and ln .8 is -.22
        ((0.7, 0.8, 0.5, 0.6), 2),
        ((None, 0.8, 0.5, 0.6), 2),
        ((0.7, 0.8, 0.9, None), 0),
    ],
)
def test_the_likeliest_at_a_glance_is_worth_a_fit(
    sizes: tuple[float | None, ...], worth: int | None
) -> None:
    """One from whose start nothing follows is not."""
    of = dict(zip((20e3, 40e3, 160e3, 320e3), sizes, strict=True))
    found = frequency._worth_a_fit(
        FOUR,
        wired(80e3),
        told(ONES, names="RKJ"),
        glance_of({80e3: 1.0, **of}),  # type: ignore[arg-type]
    )
    assert found == ([] if worth is None else [FOUR[worth]])


@pytest.mark.parametrize("names", ["R", "RK", "KJL", "RJ"])
def test_all_are_worth_a_fit_where_a_motor_is_not_known(names: str) -> None:
    before: Any = told(ONES, names=names)
    assert frequency._worth_a_fit(FOUR, wired(80e3), before, glance_of({})) is FOUR
    known: Any = told(ONES, names="RKJ")
    assert frequency._worth_a_fit(FOUR, wired(80e3), known, glance_of({80e3: None})) is FOUR


def test_readings_that_are_left_nothing_have_a_size() -> None:
    assert frequency.size_of(np.zeros(0)) == frequency.size_of(np.zeros(3)) < -300.0
    assert frequency.size_of(np.array([3.0, -4.0])) == pytest.approx(np.log(12.5) / 2.0)
