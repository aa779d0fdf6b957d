"""Channels whose readings hang on their size, their sign or their past."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import lsim

from motorid import sim
from motorid.capture.model import CURRENT, VOLTAGE, Capture
from motorid.estimate.diagnosis.faults import distorted_readings as distorted
from motorid.estimate.effects.brush_and_heating import DROP
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.results.status import Status
from tests.estimate.diagnosis.faults import inject
from tests.estimate.diagnosis.faults.cases import Runs
from tests.estimate.diagnosis.faults.rigs import DIRECTIONS, Bench
from tests.estimate.effects.benches import POINT, record, start
from tests.six_parameters import fit

Floats = NDArray[np.float64]
WAVE = 3.0 * np.sin(np.linspace(0.01, 9.0, 400))


def behind(values: Floats, play: float) -> Floats:
    """Prandtl's play, by its definition."""
    out = [0.0]
    for value in values:
        low, high = value - play, value + play
        out.append(low if out[-1] < low else high if out[-1] > high else out[-1])
    return np.array(out[1:])


def test_hysteresis_stays_behind_both_ways_and_holds_where_it_turns() -> None:
    shown = distorted.hysteresis(WAVE, (0.4,), 1e-3)
    assert shown == pytest.approx(behind(WAVE, 0.4), abs=1e-15)
    assert np.abs(shown - WAVE).max() == pytest.approx(0.4)
    assert distorted.hysteresis(WAVE, (0.0,), 1e-3) == pytest.approx(WAVE)


def test_gains_of_a_range_and_of_a_sign() -> None:
    low = distorted.low_range(WAVE, (0.05, 1.0), 1e-3) / WAVE - 1.0
    assert low == pytest.approx(np.where(np.abs(WAVE) < 1.0, 0.05, 0.0), nan_ok=True)
    below = distorted.one_sign(WAVE, (0.05,), 1e-3) / WAVE - 1.0
    assert below == pytest.approx(np.where(WAVE < 0.0, 0.05, 0.0), nan_ok=True)
    assert distorted.one_sign(WAVE, (-1.0,), 1e-3) == pytest.approx(np.maximum(WAVE, 0.0))


def test_a_bend_is_stated_at_the_highest_reading() -> None:
    shown = distorted.bent(WAVE, (-0.1,), 1e-3)
    top = np.abs(WAVE).argmax()
    assert shown[top] == pytest.approx(0.9 * WAVE[top])
    small = np.abs(WAVE) < 0.1
    assert shown[small] == pytest.approx(WAVE[small], rel=2e-4)


@pytest.mark.slow
def test_what_settles_and_warms_follows_a_first_order_lag() -> None:
    time = np.linspace(0.0, 2.0, 20_001)
    step = np.ones_like(time)
    _, lag, _ = lsim(([1.0], [0.25, 1.0]), step, time)
    settled = distorted.settling(step, (0.2, 0.25), time[1])
    assert settled == pytest.approx(0.8 + 0.2 * lag, abs=1e-4)
    warmed = distorted.warming(2.0 * step, (0.03, 0.25), time[1])
    assert warmed == pytest.approx(2.0 + 0.06 * lag / lag[-1], abs=1e-4)


def test_a_zero_that_drifts_ends_where_it_is_said() -> None:
    shown = distorted.drifting(WAVE, (0.3,), 1e-3) - WAVE
    assert shown[0] == 0.0
    assert shown[-1] == pytest.approx(0.3)
    assert np.diff(shown) == pytest.approx(0.3 / 399)


def test_every_channel_that_is_read_may_be_distorted() -> None:
    codes = {h.code for h in distorted.hypotheses([record("measured")])}
    assert {"current_hysteresis", "current_bent", "voltage_settling"} <= codes
    assert not any(code.startswith("speed") for code in codes)
    commanded = {h.code for h in distorted.hypotheses([record("commanded")])}
    assert not any(code.startswith("voltage") for code in commanded)
    assert {"speed_bent", "speed_dead_band"} <= {
        h.code for h in distorted.hypotheses([record("moving")])
    }


def test_a_dead_band_leaves_the_gain_as_it_is() -> None:
    found = {h.code: h for h in distorted.hypotheses([record("moving")])}["speed_dead_band"]
    assert found.belongs is not None
    assert set(found.belongs(np.array([3.0])).values()) == {0.0}
    said = found.words(np.array([3.0])).evidence
    assert "it shows 3 rad/s less than there is, of either sign" in said


def test_a_reference_sags_only_where_converters_read_current_and_voltage() -> None:
    for name, offered in (("measured", True), ("diodes", True), ("commanded", False),
                          ("log", False)):  # fmt: skip
        codes = {h.code for h in distorted.hypotheses([record(name)])}
        assert ("reference_sags" in codes) is offered


def test_a_sag_of_the_reference_is_told_at_the_highest_current() -> None:
    subject = record("measured")
    found = {h.code: h for h in distorted.hypotheses([subject])}["reference_sags"]
    current = subject.block(CURRENT)
    assert current is not None
    peak = float(np.abs(current.values).max())
    said = found.words(np.array([0.008 / peak]))
    assert f"at {peak:.3g} A the current and the voltage both read 0.8 % more" in said.evidence
    assert "reference" in said.action
    assert found.lower == (0.0,)  # what rises with the load is no reference that it pulls down


def test_beside_brushes_that_drop_much_no_voltage_is_accused() -> None:
    subject = record("measured").twin()
    for drop, offered in ((0.04, True), (0.06, False)):
        subject.losing = {DROP: drop * float(np.abs(subject.volts).max())}
        codes = {h.code for h in distorted.hypotheses([subject])}
        assert ("voltage_bent" in codes) is offered
        assert "current_bent" in codes


def test_a_share_of_a_gain_is_in_doubt_whichever_gain_is_right() -> None:
    found = {h.code: h for h in distorted.hypotheses([record("measured")])}
    low, late = found["current_low_range"], found["current_hysteresis"]
    assert low.belongs is not None
    assert late.belongs is not None
    assert low.belongs(np.array([-0.02, 1.0])) == dict.fromkeys(("R", "L", "B", "J", "T0"), 0.02)
    assert set(late.belongs(np.array([0.3])).values()) == {0.0}
    said = low.words(np.array([0.04, 0.5]))
    assert said.evidence == (
        "the current is distorted: below 0.5 A it shows 1.04 times as much as above, as another "
        "range"
    )


def test_a_distorted_voltage_drives_the_motor_by_as_much_less() -> None:
    """A bend of 2 % throughout the low voltages is nearly a gain."""
    subject = record("measured")
    found = {h.code: h for h in distorted.hypotheses([subject])}["voltage_settling"]
    change = found.effect(subject, POINT, start(subject), np.array([0.02, 1e-9]))
    for one in change:  # it settles within a sample: nothing is distorted
        assert np.abs(one).max() < 1e-9
    slow = found.effect(subject, POINT, start(subject), np.array([0.02, 0.05]))
    assert max(float(np.abs(one).max()) for one in slow) > 1e-3


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Runs:
    return Runs(Bench("maxon-re35", 3, DIRECTIONS, tmp_path_factory.mktemp("rig")))


def _of(name: str, shown: Callable[..., Floats], *size: float) -> Callable[[Runs], Capture]:
    def capture(r: Runs) -> Capture:
        values, period = r.good.channels[name].values, r.good.period_s
        return inject.changed(r.good, name, shown(values, size, period))

    return capture


def _sagging(r: Runs, share: float = 0.01) -> Capture:
    """Whose current and voltage read so much too high at the highest current."""
    current, volts = (r.good.channels[name].values for name in (CURRENT, VOLTAGE))
    gain = 1.0 + share * np.abs(current) / r.peak_a
    return inject.changed(inject.changed(r.good, CURRENT, gain * current), VOLTAGE, gain * volts)


LONG = {"voltage_settling", "current_low_range"}  # to find
CASES = {
    "current_bent": _of(CURRENT, distorted.bent, -0.05),
    "current_hysteresis": lambda r: inject.changed(
        r.good, CURRENT, behind(r.good.channels[CURRENT].values, 0.01 * r.peak_a)
    ),
    "current_low_range": lambda r: _of(CURRENT, distorted.low_range, 0.04, 0.2 * r.peak_a)(r),
    "current_one_sign": _of(CURRENT, distorted.one_sign, 0.03),
    "current_warming": _of(CURRENT, distorted.warming, 0.04, 0.1),
    "current_settling": _of(CURRENT, distorted.settling, 0.04, 0.05),
    "voltage_settling": _of(VOLTAGE, distorted.settling, 0.03, 0.03),
    "voltage_bent": _of(VOLTAGE, distorted.bent, -0.03),
    "reference_sags": _sagging,
}


@pytest.mark.slow
@pytest.mark.parametrize(
    "code",
    [pytest.param(c, marks=[pytest.mark.study] if c in LONG else []) for c in CASES],
)
def test_a_distorted_channel_is_named_and_what_it_moved_is_covered(code: str, runs: Runs) -> None:
    estimate = fit([CASES[code](runs)])
    assert code in [s.code for s in estimate.suspects if s.strength == "named"]
    truth = sim.truth(f"sim://?motor={runs.bench.motor}")
    for name in PARAMETERS:
        p = estimate.parameters[name]
        assert p.value is not None
        assert p.interval_95 is not None
        half = (p.interval_95[1] - p.interval_95[0]) / 2.0
        assert abs(p.value - truth[name]) < 2.0 * half  # 4 u


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.007, pytest.param(0.01, marks=pytest.mark.study)])
def test_a_reference_that_sags_is_estimated_with_the_motor(share: float, runs: Runs) -> None:
    """Named with its size; no parameter is doubtful by it."""
    estimate = fit([_sagging(runs, share)])
    (said,) = [s for s in estimate.suspects if s.strength == "named"]
    assert (said.code, said.allowed) == ("reference_sags", True)
    told = re.search(r"both read ([\d.]+) % more", said.evidence)
    assert told is not None
    assert float(told[1]) == pytest.approx(100.0 * share, rel=0.2)
    truth = sim.truth(f"sim://?motor={runs.bench.motor}")
    for name in PARAMETERS:
        p = estimate.parameters[name]
        assert p.value is not None
        assert p.total is not None
        assert p.status is Status.ESTIMATED
        assert abs(p.value - truth[name]) < 3.0 * p.total


def _wavy(one: Capture, steps: float) -> Capture:
    """A voltage whose converter leaves a straight line by so many steps, three times its range."""
    volts = one.channels[VOLTAGE]
    turns = 3.0 * (volts.raw - volts.raw_min) / (volts.raw_max - volts.raw_min)
    raw = np.rint(volts.raw + steps * np.sin(2.0 * np.pi * turns)).astype(np.int64)
    return inject.replaced(one, replace(volts, raw=raw))


@pytest.mark.slow
def test_a_voltage_converter_that_is_not_straight_moves_nothing_beyond_its_interval(
    tmp_path: Path,
) -> None:
    """4 steps of 12 bits. The levels are the data's; T0 was 2 u off in twice the interval."""
    bench = Bench("pittman", 5, DIRECTIONS, tmp_path)
    good = bench.capture()
    estimate, usual = fit([_wavy(good, 4.0)]), fit([good])
    assert [s.code for s in usual.suspects if s.strength == "named"] == []
    truth = sim.truth(f"sim://?motor={bench.motor}")
    for name in PARAMETERS:
        p = estimate.parameters[name]
        assert p.value is not None
        assert p.total is not None
        assert abs(p.value - truth[name]) < 2.0 * p.total
        assert p.total < 0.03 * p.value


@pytest.mark.slow
def test_a_good_capture_has_no_distorted_channel(runs: Runs) -> None:
    assert [s.code for s in fit([runs.good]).suspects if s.strength == "named"] == []
