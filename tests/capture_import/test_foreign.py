"""Logs with one awkward habit each, of a motor that is known: what the fit makes of them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bench.bench_foreign import estimate, truths
from bench.foreign.cases import CASES, LENGTH_S, Case, prbs, regular, steps
from motorid.capture.model import VOLTAGE, Capture, Channel
from motorid.errors import UsageError
from motorid.estimate.results.estimate import Estimate
from motorid.estimate.signals.intersample_voltage import Waveform
from motorid.estimate.signals.log_sections import pieces
from motorid.estimate.signals.time_grid import lay
from motorid.estimate.signals.voltage_jumps import scatter
from tests.estimate.signals.quieted import quiet

UNTOLD = "no motion, stamps at random"
QUICK = (  # one for each set of columns
    "steps, regular stamps",
    "no voltage",
    "no current",
    "no motion, steps",
    "a coast-down, speed alone",
    "a coast-down, voltage as tachometer",
)
(LATE,) = (case.name for case in CASES if case.late_s)
SLOW = [case.name for case in CASES if case.name not in (*QUICK, UNTOLD, LATE)]
UNEVEN = "stamps off by up to a fifth of a period"
DEAR = {
    "stamps at random, as of a busy PC",
    "stamps off by up to 0.9 periods",
    UNEVEN,  # with steps, below
    "no motion, PRBS",  # "PRBS" and "no motion, steps" are of its kinds
}
# s; fits of whole logs cost ten times as much and say the same; bench_foreign fits those
ENOUGH = {"stamps off by up to 0.9 periods": 0.7}
# bounds on errors, relative: what the log can tell at all is wider for friction and inductance
WITHIN = {"R": 0.01, "K": 0.01, "J": 0.015}


def case_of(name: str, begin: float = 0.0, end: float = LENGTH_S) -> Case:
    """A case, with as much of its log as its assertions need."""
    case = next(case for case in CASES if case.name == name)
    end = min(ENOUGH.get(name, LENGTH_S), end)

    def stamps(rng: np.random.Generator) -> np.ndarray:
        whole = case.stamps(rng)
        return whole[(whole >= begin) & (whole < end)]

    return replace(case, stamps=stamps)


def check(case: Case, folder: Path) -> Estimate:
    """The fit of a log, which gives the motor."""
    found, true = estimate(case, folder), truths()
    for name in case.told:
        p = {**found.parameters, **found.combinations}[name]
        if p.interval_95 is None:
            assert name in ("B", "T0", "L"), name
            continue
        low, high = p.interval_95
        half = (high - low) / 2
        assert abs(p.value - true[name]) < 2 * half, name  # 95 %: one seed may be a little outside
        if name in WITHIN:
            assert abs(p.value / true[name] - 1) < WITHIN[name], name
    return found


@pytest.mark.slow
@pytest.mark.parametrize("name", QUICK)
def test_a_log_gives_the_motor(name: str, tmp_path: Path) -> None:
    check(case_of(name), tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=[pytest.mark.study] if n in DEAR else []) for n in SLOW],
)
def test_an_awkward_log_gives_the_motor(name: str, tmp_path: Path) -> None:
    check(case_of(name), tmp_path)


def covered(found: Estimate, case: Case) -> None:
    """What is told has the truth in its interval, or within another half of it."""
    told, true = {**found.parameters, **found.combinations}, truths()
    for name in case.told:
        if (ends := told[name].interval_95) is not None:
            middle, half = sum(ends) / 2.0, (ends[1] - ends[0]) / 2.0
            assert abs(true[name] - middle) < 1.5 * half, name


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "begin", "end"),
    [
        ("no motion, steps", 0.32, 1.0),  # it turns when the log begins
        (UNTOLD, 0.0, 0.75),  # waiting times are no pauses
    ],
)
def test_a_log_without_a_motion_begins_anywhere(
    name: str, begin: float, end: float, tmp_path: Path
) -> None:
    case = case_of(name, begin, end)
    found = estimate(case, tmp_path)
    covered(found, case)
    for name, within in {"R": 0.005, "L": 0.1, "J/K²": 0.01}.items():
        p = {**found.parameters, **found.combinations}[name]
        assert p.value == pytest.approx(truths()[name], rel=within), name
    assert not any(d.severity == "error" for d in found.diagnostics)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "seed", "end"),
    [("no motion, steps", 1, 0.35), ("no motion, closed loop", 0, 0.4)],
)
def test_one_step_hardly_separates_two_kinds_of_friction(
    name: str, seed: int, end: float, tmp_path: Path
) -> None:
    """Noise of the voltage at rest makes a narrow valley about a T0 of nothing."""
    case = case_of(name, end=end)
    covered(estimate(case, tmp_path, seed), case)


@pytest.mark.slow
def test_each_file_has_an_onset_delay_of_its_own(tmp_path: Path) -> None:
    case = case_of(LATE)
    found = check(case, tmp_path)
    late = [found.nuisance[f"voltage late of run {k}"] for k in (1, 2, 3)]
    for p, true in zip(late, (0.0, case.late_s, 2 * case.late_s), strict=True):
        assert p.value == pytest.approx(true, abs=1e-4)


@pytest.mark.slow
def test_a_coast_down_by_voltage_needs_its_constant_beside_an_inertia(tmp_path: Path) -> None:
    case = case_of("a coast-down, voltage as tachometer")
    with pytest.raises(UsageError, match="--fix K"):
        estimate(replace(case, fix={"J": 5e-5}), tmp_path)
    both = estimate(replace(case, fix={"J": 5e-5, "K": 0.05}), tmp_path)
    assert both.parameters["T0"].value == pytest.approx(truths()["T0"], rel=0.02)


@pytest.mark.slow
def test_irregular_stamps_are_said_and_kept(tmp_path: Path) -> None:
    found = check(replace(case_of(UNEVEN), drive=steps), tmp_path)
    assert any(d.code == "irregular_stamps" for d in found.diagnostics)
    assert not any(d.code == "lost_samples" for d in found.diagnostics)
    current = next(c for c in found.curves if c.channel == "current")
    gaps = np.diff(current.time_s)
    assert gaps.min() < 0.8e-3
    assert gaps.max() > 1.2e-3


STAMPS = np.array([0.0, 0.9e-3, 2.1e-3, 3.0e-3])
VOLTS = np.array([1.0, 3.0, -1.0, 2.0])


def log(stamps: np.ndarray, volts: np.ndarray) -> Capture:
    ticks = np.rint(stamps * 1e9).astype(np.int64)
    return Capture(ticks, 1e9, {VOLTAGE: Channel(VOLTAGE, "V", volts, sense="terminals")})


@pytest.mark.parametrize("shape", ["held", "joined", "curved"])
@pytest.mark.parametrize("late_s", [0.0, 4e-4, -7e-4])
def test_a_waveforms_means_are_its_integral(shape: str, late_s: float) -> None:
    from scipy.interpolate import CubicSpline

    waveform = Waveform(STAMPS, VOLTS, shape, 1e-3)  # type: ignore[arg-type]
    stamps = np.concatenate([STAMPS, 4e-3 + np.arange(16) * 1e-3])
    line = lay(log(stamps, np.zeros(len(stamps))))
    means = waveform.means(line, late_s)
    fine = (np.arange(200) + 0.5) / 200 - 1
    for tick in range(line.count):
        at = np.clip((tick + fine) * line.period_s - late_s, STAMPS[0], STAMPS[-1])
        if shape == "held":
            v = VOLTS[np.searchsorted(STAMPS, at, side="right") - 1]
        elif shape == "joined":
            v = np.interp(at, STAMPS, VOLTS)
        else:
            v = CubicSpline(STAMPS, VOLTS)(at)
        assert means[tick] == pytest.approx(v.mean(), abs=0.02)


def test_a_jump_may_come_before_its_reading() -> None:
    stamps = np.array([0.0, 1.0, 2.0, 3.4, 4.4, 5.4, 6.4, 7.4])
    volts = np.array([0.0, 0.0, 0.0, 5.0, 5.0, 5.0, 5.0, 5.0])
    waveform = Waveform(stamps, volts, "held", 1.0)
    assert waveform.jumps.tolist() == [3]
    assert Waveform(np.arange(8.0), volts, "held", 1.0).jumps.tolist() == []
    line = replace(lay(log(np.arange(20.0), np.zeros(20))), period_s=1.0, count=8)
    total = [waveform.means(line, early=[share]).sum() for share in (0.0, 0.5, 1.0)]
    assert total == pytest.approx([5.0 * 3.6, 5.0 * 4.3, 5.0 * 5.0])


@pytest.mark.slow
def test_noise_of_a_voltage_is_averaged_and_its_jumps_stay() -> None:
    rng = np.random.default_rng(5)
    true = np.repeat([0.0, 6.0, -4.0, 6.0], 100)
    read = true + 0.05 * rng.standard_normal(400)
    calm = quiet(read)
    assert scatter(read) == pytest.approx(0.05, rel=0.3)
    left = (calm - true).reshape(4, 100)
    assert np.std(left[:, 40:60]) < 1.6 * 0.05 * np.sqrt(9 / 4 / 33)  # parabolas through 33
    beside = np.r_[96:104, 196:204, 296:304]  # and none over a jump
    assert np.std((calm - true)[beside]) < 0.8 * np.std((read - true)[beside])
    assert np.std(left) < 0.05
    exact = quiet(true)
    assert np.array_equal(exact, true)
    time = np.arange(2000) * 1e-3
    wave = 5.0 * np.sin(2 * np.pi * (0.5 + 15.0 * time) * time)  # to 60 Hz
    clean = np.mean([quiet(wave + 0.01 * rng.standard_normal(2000)) for _ in range(40)], axis=0)
    assert abs(clean @ wave / (wave @ wave) - 1) < 2e-4  # no smaller than it was


@pytest.mark.parametrize("bits", [9, 10, 12])
def test_of_a_voltage_in_coarse_steps_most_noise_is_taken(bits: int) -> None:
    """A slow sine, 2500 readings a period: the wider the window, the less is left."""
    rng = np.random.default_rng(bits)
    true = 9.0 * np.sin(2.0 * np.pi * np.arange(5000) / 2500.0)
    step = 27.0 / 2**bits
    read = step * np.round((true + 0.3 * step * rng.standard_normal(5000)) / step)
    left = float(np.std(quiet(read) - true)) / float(np.std(read - true))
    assert left < 0.35
    few = read[:40]  # less than a window: as it was read
    assert np.array_equal(quiet(few), few)
    some = read[:130]
    assert np.isfinite(quiet(some)).all()


def test_a_pause_parts_a_log_and_a_slower_rate_does_not() -> None:
    grid = regular(1e-3)
    paused = np.delete(grid, slice(600, 640))
    slower = np.concatenate([grid[:900], grid[900::6]])
    cut = pieces([log(paused, np.zeros(len(paused)))])
    assert [len(piece) for piece in cut] == [600, len(grid) - 640]
    assert len(pieces([log(slower, np.zeros(len(slower)))])) == 1
    assert grid[-1] < LENGTH_S
    assert prbs()(0.0, 0.0) in (6.0, -4.0)
