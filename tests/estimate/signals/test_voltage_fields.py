"""What is stated beside a voltage, and what stands where none was read."""

from __future__ import annotations

import math

import numpy as np
import pytest

from motorid.capture.model import CURRENT, SUPPLY, VOLTAGE, Capture, Channel, Phase, Wiring
from motorid.estimate.signals import voltage_sensing as module
from motorid.estimate.signals.intersample_voltage import SOURCED, Waveform
from motorid.estimate.signals.time_grid import Part, lay
from motorid.estimate.signals.voltage_sensing import Sense, sense
from motorid.program import Decay, Program, Step, StepKind

READ = Channel(VOLTAGE, "V", np.zeros(4), resolution=0.4, noise=0.3, gain_uncertainty=0.02)


def heard(channel: Channel | None, commanded: bool = False) -> Sense:
    none = np.zeros(4, dtype=bool)
    return Sense(np.zeros(4), none, 0.0, 0.0, True, channel, commanded=commanded)


def test_noise_is_what_the_channel_declares_and_its_rounding() -> None:
    assert heard(READ).noise == pytest.approx(math.sqrt(0.3**2 + 0.4**2 / 12.0))
    silent = Channel(VOLTAGE, "V", np.zeros(4), resolution=0.4)
    assert heard(silent).noise == 0.0
    assert heard(None).noise == 0.0
    assert heard(READ).resolution == 0.0


def test_a_gain_is_as_unsure_as_its_channel_says() -> None:
    assert heard(None, commanded=True).gain_uncertainty == 0.0
    assert heard(READ).gain_uncertainty == 0.02
    assert heard(READ, commanded=True).gain_uncertainty == 0.02  # a supply of nothing
    rail = Channel(SUPPLY, "V", np.full(4, -8.0), gain_uncertainty=0.03, offset_uncertainty=0.32)
    assert heard(rail, commanded=True).gain_uncertainty == pytest.approx(0.05)


def test_a_source_of_a_log_adds_to_what_lies_between(monkeypatch: pytest.MonkeyPatch) -> None:
    ticks, volts = 100 * np.arange(40), np.full(40, 3.0)
    read = Channel(VOLTAGE, "V", volts, sense="bridge", resolution=0.01)
    wiring = Wiring(0.1, 0.05, 0.2, 0.02)
    log = Capture(ticks, 1e6, {VOLTAGE: read, CURRENT: Channel(CURRENT, "A", volts)}, wiring=wiring)
    wave = Waveform(log.time_s, volts, SOURCED, log.period_s, ohms=0.3)
    monkeypatch.setattr(module, "of_log", lambda *_: wave)
    line = lay(log)
    found = sense(log, line, SOURCED)
    assert found is not None
    assert (found.series_ohm, found.series_uncertainty_ohm) == pytest.approx((0.2 + 0.3, 0.02))
    assert (found.channel, found.resolution, found.waveform) == (read, 0.01, wave)
    assert (found.shows_emf, found.commanded, found.window) == (True, False, None)
    assert not found.filled.any()
    assert found.volts == pytest.approx(np.full(line.count, 3.0))


def commanded(kind: StepKind, level: float, rail: np.ndarray, delay_s: float = 0.0) -> Sense:
    """Of a rest of ten samples and ten that are driven."""
    supply = Channel(SUPPLY, "V", rail, delay_s=delay_s)
    steps = Step(StepKind.COAST, 1e-3), Step(kind, 1e-3, level, Decay.SYNCHRONOUS_SLOW)
    run = Capture(
        100 * np.arange(20), 1e6, {SUPPLY: supply}, program=Program(steps),
        phases=(Phase(0, 0), Phase(1, 900)), wiring=Wiring(0.1, 0.3, 0.2, 0.4),
    )  # fmt: skip
    found = sense(run, lay(run))
    assert found is not None
    return found


def test_a_command_drives_through_leads_and_bridge_and_shows_no_back_emf() -> None:
    found = commanded(StepKind.DRIVE_DUTY, -0.5, np.full(20, 8.0))
    assert found.volts.tolist() == [0.0] * 10 + [-4.0] * 10
    assert (found.series_ohm, found.series_uncertainty_ohm) == pytest.approx((0.3, 0.5))
    assert (found.shows_emf, found.commanded, found.resolution) == (False, True, 0.0)
    assert not found.filled.any()


def test_a_board_divides_by_what_the_supply_showed_not_by_what_it_was() -> None:
    """Readings come two samples late: that of 15 shows the 13th, when the rail fell to 6 V."""
    rail = np.where(np.arange(20) < 15, 8.0, 6.0)
    found = commanded(StepKind.DRIVE_VOLTS, 4.0, rail, delay_s=2e-4)
    assert found.volts[[11, 12]] == pytest.approx(4.0)
    assert found.volts[[13, 14, 15]] == pytest.approx(4.0 * 6.0 / 8.0)
    assert found.volts[16] == pytest.approx(4.0)


def test_a_supply_that_showed_nothing_leaves_the_command() -> None:
    rail = np.full(4, 8.0)
    shown = np.array([np.nan, 0.0, 0.5, -4.0])
    part = Part(0, 4, StepKind.DRIVE_VOLTS, 1.0)
    assert module._given(rail, shown, part) == pytest.approx([1.0, 1.0, 1.0, 16.0])
    later = Part(3, 4, StepKind.DRIVE_VOLTS, 1.0)
    assert module._given(rail, shown, later) == pytest.approx([16.0])
    assert module._given(None, None, part) == 1.0


def test_a_lost_reading_is_its_neighbours_of_the_same_command() -> None:
    grid = np.array([np.nan, 1.0, np.nan, 3.0, np.nan, np.nan, 7.0, np.nan])
    found = module._filled(grid, [Part(0, 5), Part(5, 6), Part(6, 8)])
    assert found.tolist() == [1.0, 1.0, 2.0, 3.0, 3.0, 0.0, 7.0, 7.0]
    assert np.isnan(grid[0])
    whole = np.arange(3.0)
    assert module._filled(whole, [Part(0, 3)]) is whole
