"""What residuals say, on series made to say it: noise, colour, a band, a stretch of the run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, SPEED
from motorid.estimate.diagnosis import data_remarks, localise, misfit, refit, residual_remarks
from motorid.estimate.diagnosis.remarks import budget
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS
from motorid.segment.types import Segment, SegmentKind
from tests.estimate.effects.benches import BENCHES, measured, record
from tests.estimate.uncertainty.test_budget import fitted

RNG = np.random.default_rng(6)


def current() -> object:
    found = record("measured").block(CURRENT)
    assert found is not None
    return found


@pytest.mark.parametrize("sd", [1e-3, 0.5])
def test_neighbours_tell_the_noise_whatever_bends(sd: float) -> None:
    series = np.random.default_rng(1).normal(0.0, sd, 5000) + np.linspace(0.0, 50 * sd, 5000)
    assert misfit.noise_variance(current(), series) == pytest.approx(sd**2, rel=0.1)  # type: ignore[arg-type]


def test_noise_leaves_nothing_to_explain_and_a_bow_does() -> None:
    one = record("measured")
    noise = [[RNG.normal(0.0, 1.0, len(m.values)) for m in one.measured]]
    bow = [[r + 5.0 * np.sin(np.linspace(0, np.pi, len(r))) for r in noise[0]]]
    assert misfit.excess([one], noise) == pytest.approx(0.0, abs=0.25)
    # every square is 12.5 more than its noise's 1: ln 13.5 a reading
    assert misfit.excess([one], bow) == pytest.approx(np.log(13.5), abs=0.35)


@pytest.mark.parametrize("hz", [40.0, 600.0])
def test_a_tone_lies_in_a_band_about_it(hz: float) -> None:
    time = np.arange(4000) * 1e-4
    low, high = localise.band(np.sin(2 * np.pi * hz * time), 1e-4)
    assert low <= hz * 1.1
    assert high >= hz * 0.9
    assert high - low < 0.2 * hz + 10.0


def test_a_burst_is_placed_in_the_segment_that_has_it() -> None:
    one, m = record("measured"), current()
    residual = RNG.normal(0.0, 0.01, len(m.keep))  # type: ignore[attr-defined]
    residual[150:190] += np.sin(np.arange(40) * 0.7)
    segments = [
        Segment(SegmentKind.ACCELERATION, a, b) for a, b in ((0, 140), (140, 200), (200, 400))
    ]
    said = localise.place(one, m, residual, segments)  # type: ignore[arg-type]
    assert "0.014 to 0.0199 s" in said
    assert localise.place(one, m, np.zeros(len(residual)), segments) == ""  # type: ignore[arg-type]


def test_a_tone_of_a_log_is_at_its_own_frequency_and_is_called_one() -> None:
    """The fit's grid is finer than the log: its ticks are not the readings."""
    one = record("moving")
    m = one.block(CURRENT)
    assert m is not None
    between_s = one.capture.period_s
    assert one.timeline.period_s < 0.6 * between_s
    n = len(m.values)
    segments = [Segment(SegmentKind.STEADY, 0, len(one.capture))]
    noise = np.random.default_rng(5).normal(0.0, 0.02, n)
    for periods, is_tone in ((20, True), (1, False)):
        hz = periods / (n * between_s)
        wave = np.sin(2.0 * np.pi * hz * between_s * np.arange(n))
        said = localise.place(one, m, wave + noise, segments)
        assert ("a tone as of the mains" in said) == is_tone
        if is_tone:
            frequency = float(said.split(" at ")[1].split(" Hz")[0])
            assert frequency == pytest.approx(hz, rel=0.1)


@pytest.mark.parametrize("rho", [0.5, -0.4])
def test_the_correlation_of_neighbours(rho: float) -> None:
    white = np.random.default_rng(3).normal(size=8000)
    series = white.copy()
    for k in range(1, len(series)):
        series[k] += rho * series[k - 1]
    assert residual_remarks.neighbour_correlation(series) == [pytest.approx(rho, abs=0.05)]
    assert residual_remarks.neighbour_correlation(white) == []
    said = residual_remarks.coloured("current", [rho])
    assert f"{rho:+.2f}" in said.message


def test_a_declared_noise_has_the_quantisation_in_it() -> None:
    m = current()
    channel = replace(m.channel, noise=0.02, resolution=0.01)  # type: ignore[attr-defined]
    assert residual_remarks.declared_noise(replace(m, channel=channel)) == 0.02  # type: ignore[type-var]
    coarse = replace(channel, resolution=0.12)
    assert residual_remarks.declared_noise(replace(m, channel=coarse)) == pytest.approx(  # type: ignore[type-var]
        0.12 / 12**0.5
    )
    none = replace(channel, noise=0.0)
    assert residual_remarks.declared_noise(replace(m, channel=none)) == 0.0  # type: ignore[type-var]


def test_chi_square_is_the_count_where_no_noise_is_declared() -> None:
    records, solution = fitted("measured")
    chi, freedom = residual_remarks.chi_square(solution, records)
    count = sum(m.block.count for m in records[0].measured)
    assert chi == pytest.approx(count)
    assert freedom == round(count) - 6 - len(records[0].unknowns)


def test_a_clipped_reading_is_counted() -> None:
    capture = measured()
    amperes = capture.channels[CURRENT]
    top = float(np.sort(amperes.raw)[-3])
    clipped = replace(
        capture, channels={**capture.channels, CURRENT: replace(amperes, raw_max=top)}
    )
    (said,) = [
        d for d in data_remarks.of_capture(MotorRecord(clipped, PARAMETERS, {}), " in run 2")
        if d.code == "saturated"
    ]  # fmt: skip
    assert said.message.startswith("3 readings of the current")
    assert " in run 2" in said.message
    assert not data_remarks.stopping([record("measured")])
    assert not data_remarks.standing([record("measured")])


def test_the_largest_line_of_each_variance_by_its_share() -> None:
    (said,) = budget({"R": {"noise": 3.0, "current gain": 4.0}, "K": {"noise": 0.0, "clock": 1.0},
                      "J": {"current gain": 2.0}})  # fmt: skip
    assert "current gain for R (64 %), J (100 %)" in said.message
    assert "clock for K (100 %)" in said.message
    assert "calibrate the current's gain" in said.message
    assert budget({"R": {"noise": 0.0}}) == []
    assert budget({}) == []


def test_a_refit_without_a_fault_stays_where_it_was() -> None:
    records, solution = fitted("measured")
    again = refit.refit(records, [solution])
    assert again.values == pytest.approx(solution.values, rel=1e-3)
    assert again.size.shape == (0,)
    plain = refit.plain(records, solution)
    assert plain.values == pytest.approx(solution.values)


def test_a_single_reading_that_is_far_off_is_placed_too() -> None:
    one, m = record("measured"), current()
    residual = RNG.normal(0.0, 0.01, len(m.keep))  # type: ignore[attr-defined]
    residual[150] += 5.0
    at = int(m.keep[150])  # type: ignore[attr-defined]
    segments = [
        Segment(SegmentKind.STEADY, 0, at), Segment(SegmentKind.ACCELERATION, at, at + 1),
        Segment(SegmentKind.REST, at + 1, at + 1), Segment(SegmentKind.STEADY, at + 1, 400),
    ]  # fmt: skip
    said = localise.place(one, m, residual, segments)  # type: ignore[arg-type]
    time = one.capture.time_s[at]
    assert said.startswith("100% of it in the acceleration segment")
    assert said.endswith(f"from {time:.3g} to {time:.3g} s")  # no band of a single reading


def test_a_geared_speed_that_is_only_rounded_lacks_nothing() -> None:
    """A step of the wheel's is ten of the motor's: most neighbours agree, and rounding is all."""
    gear, step = 10.0, 0.05  # rad/s of the wheel
    capture = BENCHES["moving"]()
    speed = capture.channels[SPEED]
    read = step * np.round(speed.raw / gear / step)
    channels = {**capture.channels, SPEED: replace(speed, raw=read, resolution=step)}
    wiring = replace(capture.wiring, gear_ratio=gear)
    one = MotorRecord(replace(capture, channels=channels, wiring=wiring), PARAMETERS, {})
    m = one.block(SPEED)
    assert m is not None
    left = gear * (step * np.round(np.linspace(0.0, 1.0, len(m.values)) / step))
    left -= gear * np.linspace(0.0, 1.0, len(m.values))
    rounding = gear * step / 12.0**0.5
    assert residual_remarks.rms(m, left) == pytest.approx(rounding, rel=0.05)
    assert residual_remarks.lacking(one, m, left) == 0.0
    assert residual_remarks.lacking(one, m, 3.9 * left) == 0.0
    assert residual_remarks.lacking(one, m, 4.3 * left) == pytest.approx(4.3, rel=0.05)


def test_a_log_lacks_what_is_far_more_than_its_neighbours_differ_by() -> None:
    """It declares no noise. What is nothing beside the readings is let be."""
    one = record("moving")
    assert one.sensed.waveform is not None
    m = one.block(CURRENT)
    assert m is not None
    m = replace(m, channel=replace(m.channel, noise=0.0, resolution=0.0))
    n, span = len(m.values), float(np.ptp(m.values))
    noise = np.random.default_rng(4).normal(0.0, 1e-3 * span, n)
    wave = 0.02 * span * np.sin(np.linspace(0.0, 20.0, n))
    assert residual_remarks.lacking(one, m, noise) == 0.0
    times = residual_remarks.lacking(one, m, noise + wave)
    assert times == pytest.approx(float(np.std(wave)) / (1e-3 * span), rel=0.2)
    assert residual_remarks.lacking(one, m, 0.05 * (noise + wave)) == 0.0
    assert residual_remarks.lacking(record("measured"), m, noise + wave) == 0.0  # no log
    said = residual_remarks.lack_of_fit(one, m, noise + wave, (), "")
    assert "times what neighbours differ by" in said[0].message


def test_a_boards_position_lacks_what_is_a_share_of_all_that_it_turned() -> None:
    """It lacked nothing however far off: an encoder that lost counts, by 2,500 steps."""
    one = record("measured")
    m = one.block(POSITION)
    assert one.sensed.waveform is None
    assert m is not None
    step, span = 1e-4 * float(np.ptp(m.values)), float(np.ptp(m.values))
    m = replace(m, channel=replace(m.channel, noise=0.0, resolution=step))
    wave = np.sin(np.linspace(0.0, 20.0, len(m.values)))
    wave /= residual_remarks.rms(m, wave)
    assert residual_remarks.lacking(one, m, 0.004 * span * wave) == 0.0
    times = residual_remarks.lacking(one, m, 0.006 * span * wave)
    assert times == pytest.approx(0.006 * span / (step / 12.0**0.5))
    coarse = replace(m, channel=replace(m.channel, resolution=0.01 * span))
    assert residual_remarks.lacking(one, coarse, 0.02 * span * wave) == 0.0
    assert residual_remarks.lacking(one, coarse, 0.05 * span * wave) > 0.0
    (said,) = residual_remarks.lack_of_fit(one, m, 0.006 * span * wave, [], "")
    assert "times what the encoder's step leaves open" in said.message
