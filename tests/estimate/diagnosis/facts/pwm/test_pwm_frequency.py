"""A PWM frequency that the board states wrongly: found by what it leaves of the current."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bench.mistakes.capture_cases import of_pwm, with_supply
from bench.mistakes.captures import Rigged, answer, preset
from motorid.capture.model import CURRENT
from motorid.errors import DataError
from motorid.estimate.diagnosis.facts.pwm import frequency
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.results.status import Status
from tests.exact_capture import FAULHABER, Plan, clean_capture

NOISE = np.random.default_rng(3).standard_normal(400)
SLOW = np.sin(np.arange(400) / 30.0)


@dataclass(frozen=True, eq=False)
class Told:
    """What is read of an estimate."""

    curves: tuple[Any, ...]
    parameters: Any
    suspects: tuple[Any, ...] = ()
    alternative: Any = None


def left(slow: float, status: Status = Status.ESTIMATED) -> Any:
    """An estimate whose current is left noise of 1 and so much of a slow misfit."""
    curve = SimpleNamespace(
        channel=CURRENT, measured=NOISE + slow * SLOW, fitted=np.zeros(len(NOISE))
    )
    parameters = {"R": SimpleNamespace(value=2.0, status=status)}
    return Told((curve,), parameters)


def capture(pwm_hz: float) -> Any:
    plain = clean_capture(FAULHABER, Plan())
    return replace(plain, wiring=replace(plain.wiring, pwm_hz=pwm_hz))


def fits(right_hz: float) -> Any:
    def fit(captures: Any) -> Any:
        hertz = captures[0].wiring.pwm_hz
        if hertz > 100e3:
            raise DataError("no fit")
        return left(0.0 if hertz == right_hz else 12.0)

    return fit


def no_glance(captures: Any, values: Any) -> Any:
    raise AssertionError("not every parameter has a value")


@pytest.mark.slow
def test_the_frequency_that_explains_the_current_is_taken() -> None:
    found, estimate = frequency.corrected([capture(80e3)], left(12.0), fits(20e3), no_glance)
    assert found[0].wiring.pwm_hz == 20e3
    (said,) = estimate.suspects
    assert said.allowed
    assert "80 kHz" in said.evidence
    assert "20 kHz" in said.evidence
    assert said.without == {"R": 2.0}


@pytest.mark.parametrize(("pwm_hz", "slow"), [(80e3, 12.0), (80e3, 1.0), (0.0, 12.0)])
def test_none_is_taken_that_explains_no_more(pwm_hz: float, slow: float) -> None:
    """No factor of two leads to the right one; the current is left its noise; there is no PWM."""
    given, before = [capture(pwm_hz)], left(slow)
    found = frequency.corrected(given, before, fits(33e3), no_glance)
    assert found[0] is given
    assert found[1] is before


def test_none_is_looked_for_where_no_motor_explains_the_readings() -> None:
    given = [capture(80e3)]
    refused = left(12.0, Status.NOT_SUPPORTED)
    assert frequency.corrected(given, refused, fits(20e3), no_glance) == (given, refused)


@pytest.mark.parametrize(("chi_square", "looked_for"), [(1.2, False), (2.0, True)])
def test_none_is_looked_for_where_a_wider_model_explains_the_readings(
    chi_square: float, looked_for: bool
) -> None:
    wider = SimpleNamespace(chi_square=400 * chi_square, degrees_of_freedom=400)
    before = replace(left(12.0), alternative=wider)
    found, _ = frequency.corrected([capture(80e3)], before, fits(20e3), no_glance)
    assert (found[0].wiring.pwm_hz == 20e3) == looked_for


KNOWN = {"R": 2.0, "K": 2.0, "J": 2.0}


def known(slow: float) -> Any:
    """``left`` of an estimate that gives these values."""
    values = {
        name: SimpleNamespace(value=KNOWN.get(name), status=Status.ESTIMATED) for name in PARAMETERS
    }
    return replace(left(slow), parameters=values)


@pytest.mark.parametrize("shown", [20e3, 40e3])
def test_one_fit_is_made_where_a_glance_tells_the_likeliest(shown: float) -> None:
    """And that fit, not the glance, decides."""
    seen = []

    def glance(captures: Any, values: Any) -> Any:
        assert values == KNOWN
        hertz = captures[0].wiring.pwm_hz
        if hertz > 100e3:
            raise DataError("no fit")
        return [NOISE + (9.0 if hertz == shown else 12.0) * SLOW]

    def fit(captures: Any) -> Any:
        seen.append(captures[0].wiring.pwm_hz)
        return fits(20e3)(captures)

    found, estimate = frequency.corrected([capture(80e3)], known(12.0), fit, glance)
    assert seen == [shown]
    assert found[0].wiring.pwm_hz == (20e3 if shown == 20e3 else 80e3)
    assert bool(estimate.suspects) == (shown == 20e3)


def test_every_fit_is_made_where_a_glance_cannot_be_taken() -> None:
    def glance(captures: Any, values: Any) -> Any:
        raise DataError("no start values")

    found, _ = frequency.corrected([capture(80e3)], known(12.0), fits(20e3), glance)
    assert found[0].wiring.pwm_hz == 20e3


def test_no_fit_is_made_where_a_glance_shows_nothing() -> None:
    given, before = [capture(80e3)], known(12.0)
    found = frequency.corrected(
        given, before, fits(20e3), lambda captures, values: [NOISE + 12.0 * SLOW]
    )
    assert found == (given, before)


@pytest.mark.study
def test_a_board_that_states_four_times_its_pwm(tmp_path: Path) -> None:
    """L was 5 % off, 11 standard uncertainties, and friction was blamed."""
    wrong = Rigged(hidden=lambda m: {"pwm": 20_000}, edit=with_supply, alter=of_pwm(80_000.0))
    told = answer(wrong, "small", tmp_path)
    assert any(said.startswith("pwm_contradicted") for said in told.accusations)
    found = told.parameters["L"]
    low, high = found["interval_95"]
    assert low < preset("small").inductance_h < high
    assert high - low < 0.1 * found["value"]


def test_a_gain_is_of_the_size_of_what_is_left_each_reading_alike() -> None:
    """ln 2 of three readings and ln 1/4 of one; of none there is none."""
    before = [np.array([2.0, -2.0, 2.0]), np.array([1.0])]
    after = [np.array([1.0, 1.0, -1.0]), np.array([4.0])]
    expected = (3.0 * np.log(2.0) - np.log(4.0)) / 4.0
    assert frequency._gain(before, after) == pytest.approx(expected)
    assert frequency._gain(before, []) == 0.0
