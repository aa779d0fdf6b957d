"""Speed and current of a steady level, as measured and as the fit foretells them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import CURRENT, Capture
from motorid.estimate.diagnosis.facts.steady_levels import Level, Reached, findings
from motorid.estimate.results.estimate import Estimate
from motorid.motor.parameters import Motor
from tests.exact_capture import FAULHABER, Plan, clean_capture, noisy
from tests.six_parameters import fit

MOTOR = Motor.of(FAULHABER)
LONG = Plan(volts=(6.0, 3.0), count=3000)


def level(measured: float, foretold: float, u: float) -> Level:
    speed = Reached("speed", "rad/s", 700.0, 700.0, 1.0)
    return Level(0, 0.1, 0.2, speed, Reached("current", "A", measured, foretold, u))


def codes(estimate: Estimate) -> list[str]:
    return [d.code for d in estimate.diagnostics if d.code.startswith("steady_")]


def with_current(capture: Capture, later: float) -> Capture:
    """The same, whose current reads so much more while the second level is steady."""
    channel = capture.channels[CURRENT]
    n = len(capture)
    raw = np.array(channel.values)
    raw[int(0.55 * n) : int(0.63 * n)] += later
    return replace(capture, channels={**capture.channels, CURRENT: replace(channel, raw=raw)})


def test_a_difference_beyond_three_uncertainties_is_said_with_its_size() -> None:
    (said,) = findings([level(0.110, 0.100, 0.002)], MOTOR)
    assert said.code == "steady_current"
    assert "0.11 A" in said.message
    assert "5 standard uncertainties" in said.message
    assert said.moves["T0"] == pytest.approx(FAULHABER["K"] * 0.010)
    assert said.moves["B"] == pytest.approx(FAULHABER["K"] * 0.010 / 700.0)


@pytest.mark.parametrize(("measured", "u"), [(0.105, 0.002), (0.1005, 1e-5)])
def test_within_them_or_too_small_to_matter_it_is_not(measured: float, u: float) -> None:
    assert list(findings([level(measured, 0.100, u)], MOTOR)) == []


@pytest.mark.slow
def test_a_good_run_reports_the_foretold_speed_and_no_difference() -> None:
    estimate = fit([noisy(clean_capture(FAULHABER, LONG), 1, 1e-3, 1e-4)])
    told = [r for r in estimate.steady if r.foretold_speed_rad_s is not None]
    assert told
    for row in told:
        assert row.foretold_speed_rad_s == pytest.approx(row.speed_rad_s, rel=2e-3)
    assert codes(estimate) == []


@pytest.mark.slow
def test_a_level_whose_current_reads_too_much_is_named() -> None:
    good = noisy(clean_capture(FAULHABER, LONG), 1, 1e-3, 1e-4)
    assert codes(fit([with_current(good, 0.02)])) == ["steady_current"]
