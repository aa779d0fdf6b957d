"""Rows between readings: found where a program made them, and nowhere else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture, Channel, Gap
from motorid.estimate.signals.upsampled_rows import Upsampled, _bends, find, own_readings

Floats = NDArray[np.float64]
ROWS = 120  # readings of a log


def readings(noise: float = 1e-3, seed: int = 1) -> dict[str, Floats]:
    """A motor's steps, two mechanical time constants each."""
    rng = np.random.default_rng(seed)
    volts = np.repeat([0.0, 6.0, 2.0, 4.0], ROWS // 4)
    speed, current = np.zeros(ROWS), np.zeros(ROWS)
    for k in range(1, ROWS):
        speed[k] = speed[k - 1] + (100.0 * volts[k] - speed[k - 1]) / 15.0
        current[k] = (volts[k] - 0.01 * speed[k]) / 2.5
    clean = {VOLTAGE: volts, CURRENT: current, SPEED: speed}
    return {n: x + noise * np.abs(x).max() * rng.normal(size=ROWS) for n, x in clean.items()}


def capture(columns: dict[str, Floats], period: int = 100) -> Capture:
    units = {VOLTAGE: "V", CURRENT: "A", SPEED: "rad/s"}
    count = len(next(iter(columns.values())))
    return Capture(
        ticks=np.arange(count, dtype=np.int64) * period,
        clock_hz=1e6,
        channels={n: Channel(n, units[n], x) for n, x in columns.items()},
    )


def straight(factor: int, digits: int = 7) -> Capture:
    """On straight lines, as a text of some digits keeps them."""
    fine = np.arange((ROWS - 1) * factor + 1) / factor
    columns = {n: np.interp(fine, np.arange(ROWS), x) for n, x in readings().items()}
    return capture({n: np.array([float(f"{v:.{digits}g}") for v in x]) for n, x in columns.items()})


def held(factor: int, **slower: int) -> Capture:
    """Each reading ``factor`` times; channels of ``slower`` are read anew that many times less."""
    columns = readings()
    for name, less in slower.items():
        columns[name] = np.repeat(columns[name][::less], less)[:ROWS]
    return capture({n: np.repeat(x, factor) for n, x in columns.items()})


@pytest.mark.parametrize("factor", [2, 3, 10, 64])
def test_straight_lines_between_readings_are_left_out(factor: int) -> None:
    whole = straight(factor)
    thin, said = own_readings(whole)
    assert find(whole) == Upsampled(0, factor, False)
    assert len(thin) == ROWS
    assert thin.period_s == pytest.approx(factor * whole.period_s)
    for name, channel in thin.channels.items():
        assert channel.raw == pytest.approx(readings()[name], rel=1e-6)
    assert said is not None
    assert f"one row of {factor} is a reading" in said.message


@pytest.mark.parametrize("first", [0, 1, 4])
def test_a_log_may_begin_between_two_readings(first: int) -> None:
    whole = straight(5)
    cut = capture({n: c.raw[first:] for n, c in whole.channels.items()})
    assert find(cut) == Upsampled(-first % 5, 5, False)
    thin, _ = own_readings(cut)
    assert thin.channels[SPEED].raw[-1] == whole.channels[SPEED].raw[-1]


def test_repeated_rows_are_left_out() -> None:
    whole = held(4)
    thin, said = own_readings(whole)
    assert find(whole) == Upsampled(0, 4, True)
    assert thin.channels[CURRENT].raw == pytest.approx(readings()[CURRENT])
    assert said is not None
    assert "repeat it" in said.message


def test_a_channel_that_is_read_less_often_costs_the_others_no_reading() -> None:
    """A speed that comes every third reading, and one that comes with every third row."""
    assert find(held(4, speed=3)) == Upsampled(0, 4, True)
    assert find(held(1, speed=3)) is None


def test_a_held_rotor_shows_its_rows_by_the_current() -> None:
    columns = {**readings(), SPEED: np.zeros(ROWS)}
    whole = capture({n: np.repeat(x, 4) for n, x in columns.items()})
    assert find(whole) == Upsampled(0, 4, True)


def test_a_voltage_alone_shows_no_rows() -> None:
    """It is often set every few rows."""
    columns = {**readings(), SPEED: np.zeros(ROWS), CURRENT: np.zeros(ROWS)}
    assert find(capture({n: np.repeat(x, 4) for n, x in columns.items()})) is None


@pytest.mark.parametrize(("rows", "shown"), [(34, False), (37, True)])
def test_enough_of_the_rows_bend(rows: int, shown: bool) -> None:
    """Three tenths of 120 readings."""
    still = np.where(np.arange(ROWS) <= rows, readings()[CURRENT], 9.0)
    columns = {VOLTAGE: np.zeros(ROWS), CURRENT: still}
    found = find(capture({n: np.repeat(x, 4) for n, x in columns.items()}))
    assert found == (Upsampled(0, 4, True) if shown else None)


@pytest.mark.parametrize(("readings_left", "shown"), [(19, False), (20, True)])
def test_enough_readings_are_left(readings_left: int, shown: bool) -> None:
    columns = {n: np.repeat(x[:readings_left], 7) for n, x in readings().items()}
    assert find(capture(columns)) == (Upsampled(0, 7, True) if shown else None)


def test_what_bends_is_more_than_digits_and_rounding() -> None:
    ramp = np.arange(9.0)
    off = np.where(ramp == 4, 1.0, 0.0)
    for size, bent in ((1.9e-6 * 8.0 / 2.0, []), (2.1e-6 * 8.0, [3, 4, 5])):
        assert np.flatnonzero(_bends(ramp + size * off, 0.0, False)).tolist() == bent
    for size, bent in ((0.2, []), (0.21, [4])):  # 2 of it at the row, 1 beside it
        assert np.flatnonzero(_bends(ramp + size * off, 0.2, False)).tolist() == bent
    assert np.flatnonzero(_bends(off, 9.0, True)).tolist() == [4, 5]


def test_a_gap_keeps_its_place_among_the_readings() -> None:
    """Rows 4, 9, 14, ..., 44 are readings 0, 1, 2, ..., 8; a gap lies before the row it names."""
    whole = straight(5)
    cut = capture({n: c.raw[1:] for n, c in whole.channels.items()})
    gaps = tuple(Gap(k, 3, "lost") for k in (2, 4, 11, 44))
    thin, _ = own_readings(replace(cut, gaps=gaps))
    assert [gap.index for gap in thin.gaps] == [0, 0, 2, 8]
    assert find(replace(cut, channels={SPEED: cut.channels[SPEED]})) is None  # one channel


@pytest.mark.parametrize(("off", "shown"), [(1, True), (2, False)])
def test_stamps_of_a_grid_are_off_by_a_tick_at_most(off: int, shown: bool) -> None:
    whole = straight(5)
    ticks = whole.ticks.copy()
    ticks[300] += off
    assert (find(replace(whole, ticks=ticks)) is not None) is shown


@pytest.mark.parametrize("noise", [0.0, 1e-6, 1e-3])
def test_readings_stay(noise: float) -> None:
    """Without noise too, where a voltage that is set every few rows has few bends."""
    whole = capture(readings(noise))
    assert own_readings(whole) == (whole, None)


def test_rows_at_uneven_times_are_readings() -> None:
    whole = straight(5)
    ticks = whole.ticks + np.random.default_rng(2).integers(-9, 9, len(whole)) * 2
    uneven = Capture(ticks=ticks, clock_hz=1e6, channels=whole.channels)
    assert find(uneven) is None


@pytest.mark.parametrize(("rows", "shown"), [(39, False), (40, True)])
def test_forty_rows_are_enough(rows: int, shown: bool) -> None:
    whole = held(2)
    cut = capture({n: c.raw[:rows] for n, c in whole.channels.items()})
    assert find(cut) == (Upsampled(0, 2, True) if shown else None)


def test_a_row_that_was_not_read_tells_that_no_program_made_it() -> None:
    whole = straight(5)
    speed = whole.channels[SPEED]
    raw = speed.raw.copy()
    raw[300] = np.nan
    lost = replace(whole, channels={**whole.channels, SPEED: replace(speed, raw=raw)})
    assert find(lost) is None


@pytest.mark.parametrize(("off", "shown"), [(9, True), (11, False)])
def test_stamps_of_many_ticks_are_off_by_a_thousandth(off: int, shown: bool) -> None:
    whole = straight(5)
    ticks = 100 * whole.ticks
    ticks[300] += off
    assert (find(replace(whole, ticks=ticks)) is not None) is shown


@pytest.mark.parametrize("scale", [0.1, -0.1])
def test_rows_that_were_rounded_to_counts_bend_by_their_rounding_alone(scale: float) -> None:
    """In counts, of which the resolution is one: of no unit."""
    fine = np.arange((ROWS - 1) * 5 + 1) / 5.0
    columns = {}
    for name, read in readings().items():
        counts = np.round(50_000.0 * read / np.abs(read).max())
        raw = np.round(np.interp(fine, np.arange(ROWS), counts))
        columns[name] = Channel(name, "", raw, scale=scale, resolution=0.1)
    whole = replace(straight(5), channels=columns)
    assert find(whole) == Upsampled(0, 5, False)


def test_what_is_said_of_rows_names_the_time_between_readings() -> None:
    _, said = own_readings(straight(10))
    assert said is not None
    assert (said.code, said.severity) == ("rows_interpolated", "warning")
    assert "The fit takes the readings alone, 1 ms apart" in said.message
