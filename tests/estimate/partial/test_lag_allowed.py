"""By which of some lags a motion is taken earlier, and what the answer then is, step by step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import POSITION, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.partial import unstated_lag as module
from motorid.estimate.partial.block_bootstrap_regression import Regression
from motorid.estimate.partial.mechanical_signals import COMMAND

PERIOD_S = 2e-3
FREE = np.array([True, True, False, True])


def capture(delay: str = "", motion: str = SPEED) -> Capture:
    """``delay``: of which channel nobody states it."""
    channels = {
        name: Channel(name, "", np.arange(20.0), delay_s=1e-4,
                      undeclared=("delay",) if name in delay.split() else ())
        for name in (motion, VOLTAGE)
    }  # fmt: skip
    return Capture(2000 * np.arange(20), 1e6, channels)


def regression(left: float, coefficients: float = 0.0) -> Regression:
    each = coefficients * np.array([1.0, 2.0, 3.0, 4.0])
    residual = left * np.array([1.0, -1.0, 1.0, -1.0])
    nothing: Any = None
    return Regression(each, np.diag([4.0] * 4), FREE, ~FREE, residual, 9, 0.1, nothing)


BEST = regression(9.0, 1.0)


class Tried:
    """A balance that leaves so much by the samples that a motion is taken earlier."""

    def __init__(self, patch: pytest.MonkeyPatch, left: dict[float, float | None]) -> None:
        self.left, self.lags = left, []
        patch.setattr(module, "of_capture", self.of_capture)
        patch.setattr(module, "lacks_fit", lambda motions, one: np.abs(one.residual).max() > 2.0)

    def of_capture(self, one: Capture, drive: str) -> Any:
        assert drive == VOLTAGE
        late = one.channels[SPEED].delay_s - 1e-4
        return SimpleNamespace(samples=round(late / PERIOD_S, 3), period_s=PERIOD_S)

    def regress(self, motions: Sequence[Any]) -> Regression | None:
        (samples,) = {motion.samples for motion in motions}
        self.lags.append(samples)
        left = self.left.get(samples, 9.0)
        return None if left is None else regression(left, 1.0 + samples)

    def allowed(self, *captures: Capture, best: Regression = BEST) -> Any:
        motions: Any = [SimpleNamespace(period_s=PERIOD_S), SimpleNamespace(period_s=3 * PERIOD_S)]
        return module.allowed_for(captures, VOLTAGE, motions, best, self.regress)


def test_the_lag_that_leaves_least_is_taken_and_its_change_is_in_the_covariance(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tried = Tried(monkeypatch, {0.5: None, 1.0: 1.5, 1.5: -0.5, 2.0: 1.0})
    wider, said = tried.allowed(capture(SPEED), capture("terminal_voltage"))
    assert tried.lags == [0.5, 1.0, 1.5, 2.0, 3.0]
    shift = np.where(FREE, 1.5 * np.array([1.0, 2.0, 3.0, 4.0]), 0.0)
    assert wider.covariance == pytest.approx(np.diag([4.0] * 4) + np.outer(shift, shift))
    assert wider.coefficients is BEST.coefficients
    assert (said.code, said.severity) == ("unstated_lag", "info")
    assert "comes about 9 ms (1.5 samples) after the terminal voltage" in said.message


def test_where_no_lag_explains_it_none_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    tried = Tried(monkeypatch, {1.0: None})
    assert tried.allowed(capture(SPEED)) is None
    assert len(tried.lags) == 5


@pytest.mark.parametrize(
    ("captures", "best"),
    [
        ([capture(SPEED)], regression(1.0)),  # it fits as it is
        ([capture()], BEST),  # both delays are stated
        ([capture(SPEED), capture()], BEST),  # of one capture
        ([capture()], regression(1.0)),
    ],
)
def test_what_fits_or_is_stated_is_left_alone(
    captures: list[Capture], best: Regression, monkeypatch: pytest.MonkeyPatch
) -> None:
    tried = Tried(monkeypatch, {1.0: 0.1})
    assert tried.allowed(*captures, best=best) is None
    assert tried.lags == []


def test_delays_are_stated_of_the_motion_and_the_drive() -> None:
    assert module._stated(capture(), VOLTAGE)
    assert not module._stated(capture(SPEED), VOLTAGE)
    assert not module._stated(capture(VOLTAGE), VOLTAGE)
    assert not module._stated(capture(), COMMAND)  # there is none
    both = capture()
    place = replace(both.channels[SPEED], name=POSITION, undeclared=("delay",))
    beside = replace(both, channels={**both.channels, POSITION: place})
    assert module._stated(beside, VOLTAGE)  # the speed is what is taken


@pytest.mark.parametrize("motion", [SPEED, POSITION])
def test_a_motion_is_taken_earlier_and_no_drive(motion: str) -> None:
    one = capture(motion=motion)
    early = module._earlier(one, 1.5)
    assert early.channels[motion].delay_s == pytest.approx(1e-4 + 1.5 * PERIOD_S)
    assert early.channels[VOLTAGE] is one.channels[VOLTAGE]
