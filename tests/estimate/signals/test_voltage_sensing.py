"""What the fit takes for the source of the motor's voltage."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import CURRENT, SUPPLY, VOLTAGE, Capture, Channel, Phase, Wiring
from motorid.estimate.signals.source.dead_time import dead_time_loss
from motorid.estimate.signals.source.pwm_bridge import clamp_voltage, pwm_shape, switched_late
from motorid.estimate.signals.source.smoothing import ALWAYS
from motorid.estimate.signals.source.thevenin_source import source_resistance, sources
from motorid.estimate.signals.time_grid import Part, lay
from motorid.estimate.signals.voltage_sensing import Sense, sense
from motorid.program import Decay, Program, Step, StepKind

N, CLOCK_HZ, PERIOD = 600, 1e6, 1e-4
PWM = Wiring(pwm_hz=20e3)
CURRENT_A = 0.1 + 1.9 * np.exp(-np.arange(N) / 120)


def capture(
    volts: np.ndarray | None,
    *,
    decay: Decay = Decay.SYNCHRONOUS_SLOW,
    kind: StepKind = StepKind.DRIVE_DUTY,
    level: float = 0.5,
    supply: float | None = None,
    sense_at: str = "terminals",
    delay_s: float = 0.0,
    wiring: Wiring = PWM,
    current: np.ndarray = CURRENT_A,
) -> Capture:
    """One driven part after a rest of 100 samples that reads nothing."""
    rest = np.zeros(100)
    channels = {CURRENT: Channel(CURRENT, "A", np.concatenate([rest, current]))}
    if volts is not None:
        channels[VOLTAGE] = Channel(
            VOLTAGE, "V", np.concatenate([rest, volts]), sense=sense_at, kind="mean",
            aperture_s=PERIOD, delay_s=delay_s,
        )  # fmt: skip
    if supply is not None:
        channels[SUPPLY] = Channel(SUPPLY, "V", np.full(N + 100, supply))
    steps = (Step(StepKind.COAST, 99 * PERIOD), Step(kind, N * PERIOD, level, decay))
    return Capture(
        ticks=np.arange(N + 100, dtype=np.int64) * 100,
        clock_hz=CLOCK_HZ,
        channels=channels,
        wiring=wiring,
        program=Program(steps),
        phases=(Phase(0, 0), Phase(1, 99 * 100)),
    )


def heard(one: Capture, ohms: float):
    """(the driven part, its source behind ``ohms``)."""
    line = lay(one)
    sensed = sense(one, line)
    lost = np.zeros(line.count, dtype=bool)
    current = np.concatenate([np.zeros(100), CURRENT_A])
    return line.parts[1], sources(sensed, current, line.parts, lost, ohms)[1]


def test_a_resistive_source_is_a_line_without_the_noise() -> None:
    noise = np.random.default_rng(1).normal(0, 0.01, N)
    part, source = heard(capture(6.0 - 0.2 * CURRENT_A + noise), 0.2)
    assert source is not None
    line = source.volts[ALWAYS:]
    assert np.ptp(line) < 3 * np.ptp(source.tilt)  # a line, as well as its slope is known
    assert np.ptp(source.tilt) < 0.01 / 4  # far below the noise of a reading
    assert line[0] == pytest.approx(6.0, abs=0.002)
    assert source.volts[:ALWAYS] == pytest.approx(6.0 + noise[:ALWAYS], abs=0.002)  # as read
    assert source.noise == pytest.approx(0.01, rel=0.1)
    assert part.stop - part.start == len(source.volts)


def test_a_wandering_source_is_followed_and_its_noise_is_not() -> None:
    wander = 0.1 * np.sin(np.arange(N) / 60)
    noise = np.random.default_rng(2).normal(0, 0.01, N)
    _, source = heard(capture(6.0 - 0.2 * CURRENT_A + wander + noise), 0.2)
    assert source is not None
    error = source.volts - 6.0 - wander
    assert np.std(error[20:]) < 0.006
    assert np.abs(error[ALWAYS:8]).max() < 0.01  # carried back from what follows
    assert source.form.head == ALWAYS


def test_samples_that_stand_out_after_a_step_are_taken_as_read() -> None:
    noise = np.random.default_rng(6).normal(0, 0.01, N)
    late = np.where(np.arange(N) < 5, -0.08, 0.0)
    _, source = heard(capture(6.0 - 0.2 * CURRENT_A + late + noise), 0.2)
    assert source is not None
    assert source.form.head == 5
    np.testing.assert_allclose(source.volts[:5] - 6.0, -0.08 + noise[:5], atol=1e-9)
    assert np.abs(source.volts[5:] - 6.0).max() < 2e-3


def test_readings_that_jump_about_are_used_as_they_are() -> None:
    jumps = np.where(np.arange(N) // 3 % 2, 0.5, -0.5)
    _, source = heard(capture(6.0 + jumps), 0.2)
    assert source is not None
    assert source.as_read
    np.testing.assert_allclose(source.volts[8:], (6.0 + jumps + 0.2 * CURRENT_A)[8:], atol=1e-9)


def test_source_resistance_from_fast_changes_only() -> None:
    sag = 0.5 * np.arange(N) / N
    noise = np.random.default_rng(3).normal(0, 1e-3, N)
    fast = 2.0 * np.exp(-np.arange(N) / 5)
    one = capture(6.0 - 0.2 * fast - sag + noise)
    line = lay(one)
    current = np.concatenate([np.zeros(100), fast])
    lost = np.zeros(line.count, dtype=bool)
    ohms = source_resistance(sense(one, line), current, line.parts, lost, (0.0, np.inf))
    assert ohms == pytest.approx(0.2, abs=0.01)
    sure = source_resistance(sense(one, line), current, line.parts, lost, (0.15, 1e-6))
    assert sure == pytest.approx(0.15, abs=1e-4)


@pytest.mark.parametrize("delay", [PERIOD, 2 * PERIOD])
def test_readings_that_come_late_are_put_back(delay: float) -> None:
    volts = 6.0 + 0.001 * np.arange(N)
    late = round(delay / PERIOD)
    one = capture(np.concatenate([np.zeros(late), volts[:-late]]), delay_s=delay)
    line = lay(one)
    sensed = sense(one, line)
    part = line.parts[1]
    np.testing.assert_allclose(sensed.volts[part.slice][:-late], volts[: N - late])


def test_a_window_that_reaches_over_a_step_tells_nothing_of_the_source() -> None:
    fast = 2.0 * (1 - np.exp(-np.arange(N) / 1.5))
    volts = np.concatenate([np.zeros(2), 6.0 - 0.2 * fast])
    mixed = (volts[2:] + volts[1:-1] + volts[:-2]) / 3  # as a window of three periods reads
    noise = np.random.default_rng(4).normal(0, 1e-4, N)
    one = capture(mixed + noise)
    wide = replace(one.channels[VOLTAGE], aperture_s=3 * PERIOD)
    one = replace(one, channels={**one.channels, VOLTAGE: wide})
    line, current = lay(one), np.concatenate([np.zeros(102), fast])
    seen = (current[2:] + current[1:-1] + current[:-2]) / 3
    sensed = sense(one, line)
    part = line.parts[1]
    assert list(np.flatnonzero(sensed.filled[part.slice])) == [0, 1]
    ohms = source_resistance(sensed, seen, line.parts, sensed.filled, (0.0, np.inf))
    assert ohms == pytest.approx(0.2, abs=2e-3)
    source = sources(sensed, seen, line.parts, sensed.filled, ohms)[1]
    assert source is not None
    assert np.abs(source.volts - 6.0).max() < 2e-3


def test_sense_points_and_what_lies_behind_them() -> None:
    wiring = Wiring(0.1, 0.01, 0.2, 0.02, pwm_hz=20e3)
    volts = np.full(N, 6.0)
    expected = {"terminals": (0.0, 0.0), "bridge": (0.2, 0.02), "supply": (0.3, 0.02236)}
    for where, series in expected.items():
        one = capture(volts, sense_at=where, wiring=wiring)
        sensed = sense(one, lay(one))
        assert (sensed.series_ohm, sensed.series_uncertainty_ohm) == pytest.approx(series, rel=1e-3)
        assert sensed.shows_emf == (where != "supply")


def test_duty_times_supply_and_commanded_volts() -> None:
    one = capture(None, supply=8.0, level=-0.25)
    assert sense(one, lay(one)).volts[200] == pytest.approx(-2.0)
    one = capture(None, kind=StepKind.DRIVE_VOLTS, level=3.0)
    assert sense(one, lay(one)).volts[200] == 3.0
    one = capture(None, level=0.5)
    assert sense(one, lay(one)) is None


def test_dead_time_takes_its_share_unless_ripple_turns_the_current() -> None:
    wiring = Wiring(pwm_hz=20e3, dead_time_s=200e-9)
    one = capture(None, supply=8.0, wiring=wiring)
    line = lay(one)
    current = np.full(line.count, 1.0)
    current[-100:] = 0.01
    lost, _ = dead_time_loss(one, line.parts, current, 1e-3)
    assert lost[150] == pytest.approx(200e-9 * 20e3 * (8.0 + 1.4))
    assert lost[-1] == pytest.approx(0.0, abs=1e-12)
    assert lost[10] == 0.0  # the bridge is open there


def test_the_supply_is_known_from_the_best_there_is() -> None:
    volts = np.full(N, 4.0)
    assert capture(volts, supply=8.0, wiring=Wiring(supply_voltage_v=9.0)).supply_v == 8.0
    assert capture(volts, wiring=Wiring(supply_voltage_v=9.0)).supply_v == 9.0
    checked = replace(capture(volts), provenance={"check": {"duty": 0.1, "volts": 0.7}})
    assert checked.supply_v == pytest.approx(7.0)
    assert capture(volts).supply_v is None
    assert clamp_voltage(capture(volts), 4.0) == pytest.approx(5.4)


def test_pwm_shape_of_each_decay() -> None:
    part = Part(0, 10, StepKind.DRIVE_DUTY, -0.25, Decay.SYNCHRONOUS_SLOW)
    assert pwm_shape(part, -2.0, None) == (0.25, -8.0)
    volts = Part(0, 10, StepKind.DRIVE_VOLTS, 2.0, Decay.SYNCHRONOUS_SLOW)
    assert pwm_shape(volts, 2.0, 8.0) == (0.25, 8.0)
    assert pwm_shape(volts, 2.0, None) == (0.0, 0.0)
    assert pwm_shape(replace(part, decay=Decay.FAST), -2.0, 8.0) == (0.375, 16.0)  # forward first
    assert pwm_shape(replace(part, decay=Decay.DIODE), -2.0, 8.0) == (0.25, -17.4)


def test_the_slope_of_a_source_is_stated_with_its_noise() -> None:
    """A slope that the resistance does not explain is found, and scatters as it says."""
    found, said = [], []
    for seed in range(60):
        noise = np.random.default_rng(seed).normal(0, 0.01, N)
        _, source = heard(capture(6.0 - 0.2 * CURRENT_A + noise), 0.15)
        assert source is not None
        flow = CURRENT_A[8:] - CURRENT_A[8:].mean()
        slope = np.polyfit(flow, source.volts[8:], 1)[0]
        found.append(slope)
        said.append(np.ptp(source.tilt[8:]) / np.ptp(flow))
    assert np.mean(found) == pytest.approx(-0.05, abs=4 * np.mean(said) / np.sqrt(60))
    assert np.std(found) == pytest.approx(np.mean(said), rel=0.3)


def test_dead_time_delays_the_on_part_until_ripple_turns_the_current() -> None:
    late = Wiring(pwm_hz=20e3, dead_time_s=1e-6)
    one = capture(None, supply=12.0, wiring=late)
    part = lay(one).parts[1]
    current = np.concatenate([np.zeros(100), CURRENT_A])
    # half the ripple: 12 V * 0.5 * 0.5 / (2 L 20 kHz) = 0.5 A at L = 150 uH
    edge = switched_late(one, part, current, 150e-6)
    assert abs(current[edge - 1]) >= 0.5 > abs(current[edge])
    assert switched_late(one, part, current, 1.0) == part.stop
    assert switched_late(one, part, 0.0 * current, 150e-6) == part.start


def test_commanded_volts_come_with_the_sag_that_the_next_duty_takes_out() -> None:
    """A board divides by what the supply showed at the sample before."""
    one = capture(None, kind=StepKind.DRIVE_VOLTS, level=4.0, supply=8.0)
    rail = one.channels[SUPPLY].values.copy()
    rail[300:] = 7.6
    sags = replace(one, channels={**one.channels, SUPPLY: Channel(SUPPLY, "V", rail)})
    heard = sense(sags, lay(sags))
    assert heard is not None
    assert heard.volts[[299, 301]] == pytest.approx(4.0)
    assert heard.volts[300] == pytest.approx(4.0 * 7.6 / 8.0)


def test_the_offset_of_a_supply_is_unknown_of_every_voltage() -> None:
    one = capture(None, supply=8.0)
    unsure = replace(one.channels[SUPPLY], gain_uncertainty=3e-3, offset_uncertainty=32e-3)
    heard = sense(replace(one, channels={**one.channels, SUPPLY: unsure}), lay(one))
    assert heard is not None
    assert heard.gain_uncertainty == pytest.approx(5e-3)
    seen = capture(np.full(N, 4.0))
    stated = replace(seen.channels[VOLTAGE], gain_uncertainty=3e-3, offset_uncertainty=32e-3)
    heard = sense(replace(seen, channels={**seen.channels, VOLTAGE: stated}), lay(seen))
    assert heard is not None
    assert heard.gain_uncertainty == 3e-3  # rest shows the offset of the terminals


def test_a_level_is_as_uncertain_as_half_a_step_of_its_converter() -> None:
    """But what is made of a supply shares the supply's error."""
    seen, made = capture(np.full(N, 4.0)), capture(None, supply=8.0, level=-0.25)
    for one, name, expected in ((seen, VOLTAGE, 0.01), (made, SUPPLY, 0.0)):
        stepped = replace(one.channels[name], resolution=0.02)
        heard = sense(replace(one, channels={**one.channels, name: stepped}), lay(one))
        assert heard is not None
        assert heard.level_uncertainty == pytest.approx(expected)


def test_what_dead_time_took_of_the_readings_is_no_resistance() -> None:
    """v0 - r i - lost: what is lost is put back before the slope is taken."""
    fast = 2.0 * np.exp(-np.arange(N) / 5)
    one = capture(6.0 - 0.2 * fast - 0.1 * fast)
    line = lay(one)
    current = np.concatenate([np.zeros(100), fast])
    none = np.zeros(line.count, dtype=bool)
    bare = sense(one, line)
    assert bare is not None
    lossy = replace(bare, lost_shown=np.concatenate([np.zeros(100), 0.1 * fast]))
    assert source_resistance(lossy, current, line.parts, none, (0.0, np.inf)) == pytest.approx(0.2)
    assert source_resistance(bare, current, line.parts, none, (0.0, np.inf)) == pytest.approx(0.3)


def test_a_resistance_is_the_prior_where_no_part_is_drawn_and_never_negative() -> None:
    fast = 2.0 * np.exp(-np.arange(N) / 5)
    one = capture(6.0 + 0.2 * fast)
    line = lay(one)
    current, none = np.concatenate([np.zeros(100), fast]), np.zeros(line.count, dtype=bool)
    read = sense(one, line)
    assert read is not None
    assert source_resistance(read, current, line.parts, none, (0.0, np.inf)) == 0.0
    stopped = [replace(part, discontinuous=True) for part in line.parts]
    assert source_resistance(read, current, stopped, none, (0.7, 0.1)) == 0.7
    assert source_resistance(read, current, line.parts, ~none, (0.7, 0.1)) == 0.7


@pytest.mark.parametrize("ohms", [-0.2, 0.0, 0.3])
def test_a_source_that_gives_way_to_the_current_does_so_from_the_start(ohms: float) -> None:
    """A supply of another resistance than was stated: the line holds in its first samples too."""
    count = 400
    current = 0.5 + 3.0 * np.exp(-np.arange(count) / 40.0)
    noise = np.random.default_rng(5).normal(0, 1e-4, count)
    volts = 6.0 - ohms * current + noise
    sensed = Sense(volts, np.zeros(count, dtype=bool), 0.0, 0.0, True, None)
    part = Part(0, count, StepKind.DRIVE_VOLTS, 6.0, Decay.SYNCHRONOUS_SLOW)
    (source,) = sources(sensed, current, [part], np.zeros(count, dtype=bool), 0.1)
    assert source is not None
    assert source.volts - 0.1 * current == pytest.approx(6.0 - ohms * current, abs=1e-3)
