"""The uniform period behind stamps that were rounded, and what stays as it is."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from motorid.capture.model import NOTES
from motorid.capture.stamp_grid import grid_of, regular
from motorid.capture.stamp_period import Grid
from motorid.capture.table import STAMPS, read_table
from motorid.errors import DataError
from motorid.estimate.signals.time_grid import lay
from motorid.motor.reading import Output, Quantity, Stretch
from tests.motor_reference import Reference
from tests.six_parameters import fit

Floats = NDArray[np.float64]

MAPS = ("time=t:s", "voltage=v:V", "current=i:A", "speed=w:rad/s")
MOTOR = {"R": 0.43, "L": 4e-5, "K": 9e-3, "B": 1e-6, "J": 4e-6, "T0": 1e-3}  # L/R: .55 samples
PERIODS = st.floats(2e-5, 2e-1)
COUNTS = st.integers(40, 2000)
SEEDS = st.integers(0, 2**32 - 1)


def rounded(moments: Floats, step: float, share: float) -> Floats:
    """To multiples of ``step``, up from ``share`` of one: .5 rounds, 1 cuts off."""
    return np.asarray(np.floor(moments / step + 1 - share) * step)


def found(stamps: Floats, rows: Floats | None = None) -> Grid:
    grid = grid_of(stamps, np.arange(float(len(stamps))) if rows is None else rows)
    assert grid is not None
    return grid


def assert_places(grid: Grid, places: Floats, period: float, step: float) -> None:
    assert np.array_equal(grid.places, places - places[0])
    # the ends are off by half a step each at most, and by what counts as on the grid
    assert abs(grid.period - period) * (places[-1] - places[0]) <= 1.01 * step + 4e-5 * period


@pytest.mark.slow
@given(PERIODS, st.floats(-6, -0.35), COUNTS, st.floats(0, 0.1), SEEDS)
def test_lost_samples_and_any_decimal_rounding(
    period: float, finer: float, count: int, loss: float, seed: int
) -> None:
    step = 10.0 ** np.floor(np.log10(period) + finer)
    rng = np.random.default_rng(seed)
    places = np.flatnonzero(rng.random(count) >= loss).astype(np.float64)
    stamps = rounded((places + rng.random() * 50) * period, step, float(rng.random()))
    steps = np.rint(np.diff(stamps) / step).astype(np.int64)
    if np.any(steps % steps.min()):  # else its steps are those of a grid as they stand
        assert_places(found(stamps), places, period, step)


@pytest.mark.slow
@given(PERIODS, st.floats(0.01, 0.45), COUNTS, SEEDS)
def test_any_timer(period: float, coarse: float, count: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    places = np.arange(float(count))
    step = coarse * period
    stamps = rounded((places + rng.random() * 50) * period, step, float(rng.random()))
    shorter = int(np.sum(np.diff(stamps) < np.mean([np.diff(stamps).min(), np.diff(stamps).max()])))
    if 3 <= shorter <= count - 4:  # a step that comes less often is one late sample's
        assert_places(found(stamps), places, period, step)


@pytest.mark.slow
@given(st.floats(0.6, 30), COUNTS, SEEDS)
def test_several_samples_of_one_stamp_are_counted(coarse: float, count: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    rows = np.flatnonzero(rng.random(count) > 0.05).astype(np.float64)  # bad rows were left out
    stamps = np.floor((rows + 50 * rng.random()) / coarse) / 1000
    if np.ptp(stamps) >= 0.02 and not regular(np.rint(1000 * np.diff(stamps)).astype(np.int64)):
        assert_places(found(stamps, rows), rows, 1e-3 / coarse, 1e-3)


@pytest.mark.slow
@given(PERIODS, st.integers(5, 9), COUNTS)
def test_significant_digits(period: float, digits: int, count: int) -> None:
    places = np.arange(float(count))
    stamps = np.array([float(f"{t:.{digits}g}") for t in places * period])
    grid = grid_of(stamps, places)
    step = 10.0 ** (1 + np.floor(np.log10(stamps[-1])) - digits)
    if grid is not None:
        assert_places(grid, places, period, step)
    else:
        assert regular(np.rint(np.diff(stamps) / step).astype(np.int64))


@pytest.mark.slow
@given(PERIODS, COUNTS)
def test_single_precision_and_the_time_of_day(period: float, count: int) -> None:
    places = np.arange(float(count))
    single = (places * period).astype(np.float32).astype(np.float64)
    assert_places(found(single), places, period, single[-1] * 2**-23)
    if period > 1e-4:
        assert_places(found(1.7e9 + places * period), places, period, 2.4e-7)


@pytest.mark.slow
@given(PERIODS, st.floats(1e-6, 0.1), st.floats(2.5, 20), st.integers(100, 500), SEEDS)
def test_stamps_beyond_their_rounding_stay(
    period: float, coarse: float, times: float, count: int, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    step = 10.0 ** np.floor(np.log10(coarse * period))
    off = max(times * step, 1e-4 * period) * rng.uniform(-1, 1, count)
    stamps = rounded(np.sort(np.arange(count) * period + off), step, 0.5)
    assert grid_of(stamps, np.arange(float(count))) is None


@pytest.mark.slow
@given(PERIODS, st.floats(-6, -1.5), st.integers(200, 1000), st.booleans(), SEEDS)
def test_late_samples_keep_their_moments_and_the_others_lie_on_the_grid(
    period: float, finer: float, count: int, first: bool, seed: int
) -> None:
    step = 10.0 ** np.floor(np.log10(period) + finer)
    rng = np.random.default_rng(seed)
    places = np.arange(float(count))
    late = rng.random(count) < 0.02
    late[0], late[-1] = first, False
    moments = places + np.where(late, rng.uniform(0.1, 0.4, count), 0.0)
    moments[50:54] = 52.7, 52.8, 52.9, 53.0  # the logger stood still for three periods
    grid = grid_of(rounded(moments * period, step, 0.5), places)
    assert grid is not None
    moments[0] = 0.0  # where time begins
    assert np.abs(grid.places - moments).max() <= 1.1 * step / period + 2e-5
    late[50:54] = True
    assert np.array_equal(grid.places[~late], places[~late])


def test_a_part_that_begins_anew_keeps_its_phase() -> None:
    moments = np.r_[np.arange(300.0), 1000.3 + np.arange(200.0), 5000.8 + np.arange(300.0)] / 5900
    grid = found(rounded(moments, 1e-6, 0.5))
    assert grid.period == pytest.approx(1 / 5900, rel=1e-6)
    assert grid.places == pytest.approx(moments * 5900, abs=0.006)


@cache
def readings() -> tuple[Floats, Floats, Floats]:
    """Volts, amperes and rad/s at 1500 samples of a motor at 5900 Hz under a random sequence."""
    count, period = 1500, 1 / 5900
    rng = np.random.default_rng(5)
    volts = np.repeat(np.where(rng.random(count // 12) < 0.5, 3.0, 5.5), 12)
    volts[:60] = 0.0
    reference = Reference(tuple(MOTOR.values()), rtol=1e-9)
    reference.run(period, np.r_[0.0, volts[:-1]], [Stretch(1, False, 0.0, 1e9)])
    t = np.arange(count) * period
    amperes = reference.read(Output(Quantity.CURRENT), t)
    speed = reference.read(Output(Quantity.SPEED), t)
    noise = rng.standard_normal((2, count))
    return volts, amperes + 5e-3 * noise[0], speed + 0.1 * noise[1]


def log(folder: Path, stamps: list[str]) -> Path:
    path = folder / "log.csv"
    rows = zip(stamps, *(map(repr, map(float, x)) for x in readings()), strict=True)
    path.write_text("\n".join(["t,v,i,w", *map(",".join, rows)]) + "\n", encoding="utf-8")
    return path


@pytest.mark.slow
@pytest.mark.parametrize(
    "form",
    [
        ".3f",
        ".6g",
        pytest.param(".7f", marks=pytest.mark.study),
        pytest.param(".9f", marks=pytest.mark.study),
    ],
)
def test_a_log_of_rounded_stamps_gives_the_motor(form: str, tmp_path: Path) -> None:
    capture = read_table(log(tmp_path, [f"{k / 5900:{form}}" for k in range(1500)]), MAPS)
    assert capture.period_s == pytest.approx(1 / 5900, rel=1e-4 if form == ".3f" else 1e-6)
    assert lay(capture).jitter < 1e-6
    assert capture.provenance[STAMPS]["resolution_s"] >= 10.0 ** -int(form[1])
    said = [note for note in capture.provenance[NOTES] if "rounded to" in note]
    assert bool(said) == (form == ".3f")
    estimate = fit([capture])
    for name in ("R", "L", "K", "J"):
        low, high = estimate.parameters[name].interval_95
        half = (high - low) / 2
        assert abs(estimate.parameters[name].value - MOTOR[name]) < 2 * half, name
        assert half < 0.02 * MOTOR[name]


@pytest.mark.slow
def test_shared_stamps_that_no_period_explains_are_refused(tmp_path: Path) -> None:
    moments = np.r_[np.arange(700.0), 760.0 + np.arange(800.0)] / 5900  # 60 rows are missing
    path = log(tmp_path, [f"{t:.3f}" for t in moments])
    with pytest.raises(DataError, match=r"line 3 repeats .*stamps with more digits: no uniform"):
        read_table(path, MAPS)


def test_rows_written_twice_are_no_samples(tmp_path: Path) -> None:
    path = tmp_path / "twice.csv"
    rows = "".join(f"{k // 2},{k // 2 % 7}\n" for k in range(100))
    path.write_text("t,w\n" + rows, encoding="utf-8")
    maps = ("time=t:ms", "speed=w:rad/s")
    found = read_table(path, maps)
    assert len(found) == 50
    assert "50 rows that copy" in found.provenance[NOTES][0]


@pytest.mark.parametrize(("unit", "scale"), [("s", 1.0), ("ms", 1e-3), ("us", 1e-6)])
def test_what_replaced_the_stamps_is_said_in_seconds(
    unit: str, scale: float, tmp_path: Path
) -> None:
    """A period of 12.5 ms, cut to whole milliseconds."""
    shown = np.floor(np.arange(200) * 12.5) * 1e-3 / scale
    rows = [f"{time:.10g},{10 + k % 7},{k}" for k, time in enumerate(shown)]
    path = tmp_path / "log.csv"
    path.write_text("\n".join(["t,i,w", *rows]) + "\n", encoding="utf-8")
    capture = read_table(path, [f"time=t:{unit}", "current=i:A", "speed=w:rad/s"])
    said = capture.provenance[STAMPS]
    assert said["period_s"] == pytest.approx(12.5e-3, rel=1e-3)
    assert said["resolution_s"] == pytest.approx(1e-3, rel=0.1)
    assert capture.period_s == pytest.approx(said["period_s"], rel=1e-6)
