"""When drives act, as a balance with a delay tells it: what is taken, and what is left open."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.partial import unstated_lag as module
from motorid.estimate.partial.block_bootstrap_regression import Regression, solve
from motorid.estimate.partial.mechanical_signals import COASTING, COMMAND, Motion, of_capture
from motorid.estimate.partial.modulating_functions import LATE, Rows

PERIOD_S = 2e-3
TRUTH = np.array([0.02, 0.05, 0.3, 0.01])
FREE = np.ones(4, dtype=bool)


def capture(delay: str = "", motion: str = SPEED, unsigned: bool = False) -> Capture:
    """``delay``: of which channels nobody states it."""
    wave = 50.0 * np.sin(np.arange(200.0) / 20.0)
    channels = {
        name: Channel(name, "", wave, unsigned=unsigned and name == VOLTAGE,
                      undeclared=("delay",) if name in delay.split() else ())
        for name in (motion, VOLTAGE)
    }  # fmt: skip
    return Capture(2000 * np.arange(200), 1e6, channels)


def balance(late_s: float, noise: float = 0.01, of: float = 1.0, count: int = 96) -> Regression:
    """Solved beside a delay that is there by ``late_s``; ``of``: times the delay's column."""
    rng = np.random.default_rng(4)
    matrix = rng.standard_normal((count, 4))
    late = of * rng.standard_normal(count)
    drive = matrix @ TRUTH + late_s * late + noise * rng.standard_normal(count)
    stretch, ones = np.arange(count) // 8, np.ones(count)
    rows = Rows(
        matrix, drive, ones, ones, stretch, np.zeros(count, dtype=int), np.zeros((count, 3)), late
    )
    return solve(rows.beside(LATE), np.ones(5, bool), np.zeros(5), 0.1)


class Balances:
    """Each is solved with drives by so much later: what they still lack of ``late_s``."""

    def __init__(self, late_s: float, **more: Any) -> None:
        self.late_s, self.more, self.tried = late_s, more, list[float]()

    def __call__(self, motions: Sequence[Motion], terms: Sequence[str]) -> Regression:
        assert tuple(terms) == (LATE,)
        (taken,) = {motion.drive_late_s for motion in motions}
        self.tried.append(taken)
        return balance(self.late_s - taken, **self.more)


def looked_for(regress: Any, *captures: Capture, drive: str = VOLTAGE) -> module.Timing:
    motions = [of_capture(one, VOLTAGE) for one in captures]
    return module.looked_for(captures, drive, motions, balance(0.0).plain(), regress)


UNSTATED = capture(f"{SPEED} {VOLTAGE}")


@pytest.mark.parametrize("samples", [-0.5, 0.5, 2.0])
def test_a_delay_that_rows_tell_is_taken_for_all_drives(samples: float) -> None:
    regress = Balances(samples * PERIOD_S, noise=1e-5)
    timing = looked_for(regress, UNSTATED, capture(SPEED))
    assert timing.terms == (LATE,)
    assert len(timing.motions) == 2
    for motion in timing.motions:
        assert motion.drive_late_s == pytest.approx(samples * PERIOD_S, rel=0.02)
    assert regress.tried[0] == 0.0
    assert len(regress.tried) > 1
    assert timing.said is not None
    assert (timing.said.code, timing.said.severity) == ("unstated_lag", "info")
    assert ("earlier" if samples < 0.0 else "later") in timing.said.message
    assert timing.moves == ()


@pytest.mark.parametrize(
    ("samples", "words"),
    [(0.5, "as if each reading held until the next"),
     (-0.5, "as if each reading had held since the one before"),
     (1.5, "means since the row before"), (-2.0, "filtered")],
)  # fmt: skip
def test_what_a_delay_is_like_is_said(samples: float, words: str) -> None:
    said = module._said(VOLTAGE, samples, samples * PERIOD_S)
    assert words in said.message
    assert f"{1e3 * abs(samples) * PERIOD_S:.2g} ms" in said.message


def test_one_that_rows_do_not_tell_is_left_open_in_the_covariance() -> None:
    timing = looked_for(Balances(0.2 * PERIOD_S, noise=0.05), UNSTATED)
    assert (timing.terms, timing.said, timing.late_s) == ((), None, None)
    assert [motion.drive_late_s for motion in timing.motions] == [0.0]
    by_delay, by_winding = timing.moves
    assert np.abs(by_delay).max() > 0.0
    assert by_winding[0] > 0.0
    assert not by_winding[1:].any()
    plain = balance(0.0).plain()
    wider = timing.of(plain)
    np.testing.assert_allclose(wider.coefficients, plain.coefficients)
    more = np.outer(by_delay, by_delay) + np.outer(by_winding, by_winding)
    np.testing.assert_allclose(wider.covariance, plain.covariance + more)


def test_a_delay_of_a_current_is_no_windings() -> None:
    drive = replace(UNSTATED.channels[VOLTAGE], name=CURRENT)
    one = replace(UNSTATED, channels={SPEED: UNSTATED.channels[SPEED], CURRENT: drive})
    motions = [of_capture(one, CURRENT)]
    best = balance(0.0).plain()
    sure = module.looked_for([one], CURRENT, motions, best, Balances(PERIOD_S, noise=1e-5))
    assert sure.winding_s == (0.0, 0.0)
    unsure = module.looked_for([one], CURRENT, motions, best, Balances(0.0, noise=0.05))
    assert len(unsure.moves) == 1


def test_a_delay_of_volts_may_be_the_windings_in_part() -> None:
    timing = looked_for(Balances(0.5 * PERIOD_S, noise=1e-5), UNSTATED)
    mean, deviation = timing.winding_s
    assert 0.0 < deviation < mean < 1.1 * PERIOD_S
    found = balance(0.0, noise=1e-5)
    moved = timing.of(found)
    assert moved.coefficients[0] - found.coefficients[0] == pytest.approx(
        mean * found.coefficients[1]
    )
    assert moved.sigma[0] >= deviation * found.coefficients[1]


def test_a_winding_is_as_slow_as_it_usually_is_and_no_slower_than_the_delay() -> None:
    one = balance(0.0).plain()
    constant_s = one.coefficients[0] / one.coefficients[1]
    for share in (1e-6, 0.003, 0.03, 0.3, 30.0):
        most_s = share * constant_s
        grid = (np.arange(400_000) + 0.5) / 400_000 * min(most_s, constant_s)
        weight = np.exp(-grid / (module.WINDING * constant_s))
        mean = np.average(grid, weights=weight)
        deviation = np.sqrt(np.average((grid - mean) ** 2, weights=weight))
        assert module._winding(one, most_s) == pytest.approx((mean, deviation), rel=1e-3)
    assert module._winding(one, -1.0) == (0.0, 0.0)
    for slow in (one.coefficients * [1, -1, 1, 1], one.coefficients * [-1, 1, 1, 1]):
        assert module._winding(replace(one, coefficients=slow), 1.0) == (0.0, 0.0)


def test_a_search_that_runs_away_takes_none() -> None:
    timing = looked_for(Balances(20 * PERIOD_S, noise=1e-5), UNSTATED)
    assert (timing.terms, timing.moves, timing.said) == ((), (), None)
    assert looked_for(lambda *_: None, UNSTATED).moves == ()


@pytest.mark.parametrize("captures", [[capture()], [UNSTATED, capture()],
                                      [capture(f"{SPEED} {VOLTAGE}", unsigned=True)]])  # fmt: skip
def test_what_is_stated_or_a_magnitude_is_left_alone(captures: list[Capture]) -> None:
    regress = Balances(PERIOD_S)
    timing = looked_for(regress, *captures)
    assert (timing.terms, timing.moves, timing.said) == ((), (), None)
    assert regress.tried == []


def test_a_motor_that_coasts_has_no_drive_that_could_be_late() -> None:
    regress = Balances(PERIOD_S)
    assert looked_for(regress, UNSTATED, drive=COASTING).moves == ()
    assert regress.tried == []


def test_a_few_jumps_leave_less_than_they_are_off_by() -> None:
    """Rows that a delay follows to the last digit are as uncertain as jumps' moments make them."""
    found = balance(0.0, noise=1e-6)
    steps = np.repeat([5.0, 9.0, 4.0, 8.0, 5.0], 40)
    speed = np.linspace(20.0, 50.0, 200)
    one = replace(UNSTATED, channels={SPEED: Channel(SPEED, "rad/s", speed),
                                      VOLTAGE: Channel(VOLTAGE, "V", steps)})  # fmt: skip
    motions = [of_capture(one, VOLTAGE)]
    wider = module._as_jumps_scatter(motions, found)
    left = float(np.mean(found.residual**2))
    part = found.rows.matrix
    each = np.diag(np.linalg.inv(part.T @ part)) * module.FOLLOWED * left
    assert motions[0].jumps_variance(0.1) > module.FOLLOWED * left
    np.testing.assert_allclose(
        np.diag(wider.covariance), np.maximum(np.diag(found.covariance), each)
    )


def test_delays_are_stated_of_the_motion_and_the_drive() -> None:
    assert module._stated(capture(), VOLTAGE)
    assert not module._stated(capture(SPEED), VOLTAGE)
    assert not module._stated(capture(VOLTAGE), VOLTAGE)
    assert not module._stated(capture(), COMMAND)  # there is none
    both = capture()
    place = replace(both.channels[SPEED], name=POSITION, undeclared=("delay",))
    beside = replace(both, channels={**both.channels, POSITION: place})
    assert module._stated(beside, VOLTAGE)  # the speed is what is taken
