"""What each fault of the chain would do to readings: exact where it is put in by hand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE
from motorid.estimate.diagnosis.fault import Hypothesis
from motorid.estimate.diagnosis.faults import (
    channel_delay,
    common_mode,
    current_limited_supply,
    encoder_bandwidth,
    model_alternatives,
    motion,
    saturation,
)
from motorid.estimate.diagnosis.faults.filters import high_pass_filter, low_pass_filter
from motorid.estimate.diagnosis.faults.zeros import current_zero
from motorid.estimate.fit import block_regression
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS
from tests.estimate.effects.benches import FAULHABER, POINT, record, start, usual
from tests.exact_capture import Plan, clean_capture


def effect(hypothesis: Hypothesis, size: float, name: str = "measured") -> dict[str, np.ndarray]:
    subject = record(name)
    parts = hypothesis.effect(subject, POINT, start(subject), np.array([size]))
    return {m.block.name: p for m, p in zip(subject.measured, parts, strict=True)}


def by_code(found: list[Hypothesis], code: str) -> Hypothesis:
    return next(h for h in found if h.code == code)


def test_an_amplifiers_share_of_the_voltage_needs_a_voltage_that_is_read() -> None:
    (found,) = common_mode.hypotheses([record("measured")])
    assert found.code == "current_common_mode"
    change = effect(found, found.upper[0])["current"]
    volts = record("measured").capture.channels[VOLTAGE].values
    assert float(np.abs(change).max()) == pytest.approx(found.upper[0] * float(np.abs(volts).max()))
    assert common_mode.hypotheses([record("commanded")]) == []


def test_a_high_pass_of_no_rate_shows_the_current_as_it_is() -> None:
    (found,) = high_pass_filter.hypotheses([record("measured")])
    assert found.code == "current_coupled"
    assert not effect(found, 0.0)["current"].any()
    faster, slower = (
        effect(found, size)["current"] for (size,) in (found.sizes[0], found.sizes[-1])
    )
    assert float(np.abs(faster).max()) > float(np.abs(slower).max()) > 0.0


@pytest.mark.parametrize("samples", [0.0, 1.0, 2.5, 12.0])
def test_late_by_straight_lines(samples: float) -> None:
    values = np.arange(20.0) * 3.0
    found = channel_delay.late(values, samples)
    assert found == pytest.approx(np.maximum(values - 3.0 * samples, 0.0))


def test_one_hypothesis_for_each_channel_that_may_be_late_or_filtered() -> None:
    codes = {h.code for h in channel_delay.hypotheses([record("measured")])}
    assert codes == {"current_lag", "position_lag", "voltage_lag"}
    assert {h.code for h in channel_delay.hypotheses([record("commanded")])} == {
        "current_lag", "position_lag",
    }  # fmt: skip
    assert {h.code for h in low_pass_filter.hypotheses([record("moving")])} == {
        "current_filtered", "speed_filtered", "current_smoothed", "speed_smoothed",
    }  # fmt: skip
    assert {h.code for h in low_pass_filter.hypotheses([record("measured")])} == {
        "current_filtered", "current_smoothed", "voltage_filtered",
    }  # fmt: skip
    assert {h.code for h in low_pass_filter.hypotheses([record("commanded")])} == {
        "current_filtered", "current_smoothed",
    }  # fmt: skip


def test_a_low_pass_of_the_voltage_is_declared_with_its_delay() -> None:
    found = low_pass_filter.hypotheses([record("measured")])
    filtered = by_code(found, "voltage_filtered")
    assert filtered.remedy is not None
    capture = record("measured").capture
    volts = capture.channels[VOLTAGE]
    tried = [one.channels[VOLTAGE] for one in filtered.remedy(capture, 2e-4)]
    assert tried[0].filter_s == 2e-4
    assert len({one.filter_s for one in tried}) == len(low_pass_filter.AROUND)
    for one in tried:
        assert one.delay_s - volts.delay_s == pytest.approx(one.filter_s)


def test_readings_behind_a_low_pass_follow_exponentially() -> None:
    step = np.r_[np.zeros(3), np.ones(9)]
    found = low_pass_filter._behind(step, 0.6)
    assert found == pytest.approx(np.r_[np.zeros(3), 1.0 - 0.6 ** np.arange(1.0, 10.0)])


def test_a_low_pass_of_the_voltage_makes_the_motor_seem_quicker() -> None:
    """The real voltage came before the one that was read, and the back-EMF reads late."""
    filtered = by_code(low_pass_filter.hypotheses([record("measured")]), "voltage_filtered")
    small, large = (effect(filtered, size) for size in (1e-5, 2e-5))
    assert set(small) == set(large)
    for name, moved in small.items():
        assert np.abs(large[name]).max() > np.abs(moved).max() > 0.0


def test_what_shows_an_edge_before_it_comes_is_done_to_logs_alone() -> None:
    def names(which: str) -> list[str]:
        found = low_pass_filter.hypotheses([record(which)])
        return [h.quantity.name for h in found if h.quantity and h.code == "current_smoothed"]

    behind = ["current behind a recursive average", "current behind a mean of the last readings"]
    assert names("measured") == behind
    assert len(names("moving")) == 6
    assert names("moving")[-2:] == behind


def test_the_lag_of_a_log_counts_its_own_samples() -> None:
    run = clean_capture(FAULHABER, Plan(count=400))
    channels = {n: replace(c, kind="instant", aperture_s=0.0) for n, c in run.channels.items()}
    log = replace(run, program=None, phases=(), channels=channels)
    subject = MotorRecord(log, PARAMETERS, {})
    assert subject.timeline.period_s < 0.5 * log.period_s  # the fit's grid is finer
    found = by_code(channel_delay.hypotheses([subject]), "current_lag")
    said = found.words(np.array([3.0 * log.period_s]))
    assert "(3.0 samples)" in said.evidence


def test_a_current_that_stops_is_clipped() -> None:
    (hypothesis,) = saturation.hypotheses([record("measured")])
    now = usual("measured")[CURRENT]
    end = 0.5 * np.abs(now).max()
    change = effect(hypothesis, end)
    inside = np.abs(now) < 0.9 * end
    assert change[CURRENT][inside] == pytest.approx(0.0, abs=1e-12)
    assert np.abs(now + change[CURRENT]).max() <= end * 1.02
    assert not change[POSITION].any()


def test_a_zero_that_is_off_while_driven_only() -> None:
    (hypothesis,) = current_zero.hypotheses([record("measured")])
    subject = record("measured")
    found = subject.block(CURRENT)
    assert found is not None
    change = effect(hypothesis, 0.02)[CURRENT]
    assert change == pytest.approx(0.02 * subject.driven[found.keep])
    assert current_zero.suspects(subject) == []  # its zero is where it is declared


@pytest.mark.parametrize(("code", "sign"), [("brush_drop", -1.0), ("friction_bends", -1.0)])
def test_what_brakes_brakes(code: str, sign: float) -> None:
    hypothesis = by_code(model_alternatives.hypotheses([record("log")]), code)
    change = effect(hypothesis, hypothesis.scale[0], "log")[POSITION]
    assert np.sign(change[-1]) == sign
    assert hypothesis.guard


def test_the_measured_speed_is_the_slope_of_the_angle() -> None:
    for name in ("measured", "moving"):
        speed = motion.measured_speed(record(name), half=2)
        assert speed is not None
        assert len(speed) == record(name).timeline.count
    angle = usual("measured")[POSITION]
    subject = record("measured").block(POSITION)
    assert subject is not None
    speed = motion.measured_speed(record("measured"), half=1)
    assert speed is not None
    inner = slice(30, 300)
    expected = np.gradient(angle, 1e-4)[inner]
    assert speed[subject.keep][inner] == pytest.approx(expected, rel=0.02, abs=0.5)
    shown = record("moving").block(SPEED)
    assert shown is not None


@pytest.mark.slow
def test_the_motors_two_laws_on_blocks_of_an_exact_capture() -> None:
    """Of a motor that is known: R and K by the electrical law, J by the mechanical one."""
    one = MotorRecord(clean_capture(FAULHABER, Plan(count=1500)), PARAMETERS, {})
    b = block_regression.blocks([one])
    assert b is not None
    motor = block_regression.usual(b)
    assert motor is not None
    assert motor == pytest.approx((FAULHABER["R"], FAULHABER["K"]), rel=0.05)
    J = block_regression.mechanical(b, FAULHABER["K"], b.driven)["J"]
    assert pytest.approx(FAULHABER["J"], rel=0.15) == J


def test_squares_are_numpys_least_squares() -> None:
    rng = np.random.default_rng(3)
    columns, target = rng.normal(size=(50, 3)), rng.normal(size=50)
    left, found, over = block_regression.squares(columns, target)
    expected, (rest,), *_ = np.linalg.lstsq(columns, target, rcond=None)
    assert found == pytest.approx(expected)
    assert left == pytest.approx(rest)
    deviations = np.sqrt(np.diag(np.linalg.inv(columns.T @ columns)) * rest / 47)
    assert over == pytest.approx(expected / deviations)


@pytest.mark.parametrize(
    "seen", [saturation.seen, encoder_bandwidth.seen, current_limited_supply.seen]
)
def test_a_chain_without_a_fault_shows_none(seen: Callable[..., object]) -> None:
    assert seen([record("measured")]) is None
    assert seen([record("commanded")]) is None


def test_a_supply_without_a_limit_shows_no_sag() -> None:
    assert current_limited_supply.sag(record("measured")) is None
    assert current_limited_supply.suspects(record("measured")) == []


def test_what_the_model_lacks_is_looked_for_within_what_it_may_be() -> None:
    for name in ("measured", "log"):
        for one in model_alternatives.hypotheses([record(name)]):
            ((size,),) = one.sizes
            assert 0.0 < size < one.upper[0]
            assert one.lower[0] in {0.0, -one.upper[0]}  # or of either sign
            assert one.scale == (size,)
    volts = float(np.abs(record("measured").volts).max())
    drop = by_code(model_alternatives.hypotheses([record("measured")]), "brush_drop")
    assert (drop.sizes[0][0], drop.upper[0]) == pytest.approx((0.02 * volts, 0.1 * volts))
