"""Single steps under one constant drive: time constant, steady speed, dead time, and how sure."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binom

from motorid.capture.model import Capture, Channel
from motorid.errors import DataError
from motorid.estimate.partial import exponential_fit, mechanical_fit, step_response
from motorid.estimate.results.estimate import Estimate

TAU_S, TOP, ONSET_S = 0.08, 200.0, 0.1
TAU, WHOLE = "JR/(K²+RB)", "(K−T0·R/V)/(K²+RB)"


def risen(time: np.ndarray, onset_s: float = ONSET_S, tau_s: float = TAU_S) -> np.ndarray:
    return TOP * (1.0 - np.exp(-np.maximum(time - onset_s, 0.0) / tau_s))


def log(time: np.ndarray, quantum: float = 0.0, **columns: tuple[str, np.ndarray]) -> Capture:
    channels = {
        name: Channel(name, unit, y, resolution=quantum if name in ("speed", "position") else 0.0)
        for name, (unit, y) in columns.items()
    }
    return Capture(np.rint(time * 1e9).astype(np.int64), 1e9, channels)


def holds(found: Estimate, name: str, value: float) -> bool:
    low, high = found.combinations[name].interval_95
    return bool(low <= value <= high)


TIME = np.arange(0.0, 1.0, 2e-3)
NOISE = 0.5 * np.random.default_rng(0).standard_normal(len(TIME))


@pytest.mark.slow
def test_a_speed_alone_shows_its_time_constant_and_where_it_ends() -> None:
    found = mechanical_fit.fit([log(TIME, speed=("rad/s", risen(TIME) + NOISE))])
    assert holds(found, TAU, TAU_S)
    assert holds(found, "steady speed", TOP)
    assert found.combinations[TAU].total < 0.01 * TAU_S
    assert {p.status for p in found.parameters.values()} == {"not_identifiable"}


@pytest.mark.slow
@pytest.mark.parametrize(("drive", "unit"), [("terminal_voltage", "V"), ("command", "1")])
@pytest.mark.parametrize("before", [0, 60])
def test_one_level_gives_gain_and_friction_as_one(drive: str, unit: str, before: int) -> None:
    level = np.where(np.arange(len(TIME)) >= before, 12.0, 0.0)
    speed = risen(TIME, 0.13) + NOISE
    found = mechanical_fit.fit([log(TIME, speed=("rad/s", speed), **{drive: (unit, level)})])
    assert holds(found, TAU, TAU_S)
    assert holds(found, WHOLE, TOP / 12.0)
    for name in ("K/(K²+RB)", "T0·R/K"):
        assert found.combinations[name].status == "not_identifiable"
    assert ("dead time" in found.nuisance) == bool(before)
    if before:
        late = found.nuisance["dead time"]
        assert late.value == pytest.approx(0.13 - 0.119, abs=4.0 * late.total)
        assert "dead_time" in {d.code for d in found.diagnostics}
    without = mechanical_fit.fit(
        [log(TIME, speed=("rad/s", speed), **{drive: (unit, level)})], without=["T0"]
    )
    assert holds(without, "K/(K²+RB)", TOP / 12.0)


@pytest.mark.slow
def test_a_log_that_begins_amid_the_rise_and_a_position_show_the_same() -> None:
    late, volts = TIME[60:], ("V", np.full(len(TIME), 12.0))
    cut = log(
        late, speed=("rad/s", (risen(TIME) + NOISE)[60:]), terminal_voltage=("V", volts[1][60:])
    )
    assert holds(mechanical_fit.fit([cut]), TAU, TAU_S)
    since = np.maximum(TIME - ONSET_S, 0.0)
    angle = TOP * (since - TAU_S * (1.0 - np.exp(-since / TAU_S)))
    turned = log(TIME, position=("rad", angle + 1e-3 * NOISE), terminal_voltage=volts)
    found = mechanical_fit.fit([turned])
    assert holds(found, TAU, TAU_S)
    assert holds(found, WHOLE, TOP / 12.0)


def test_what_is_no_single_step_is_left_to_the_balance() -> None:
    speed = ("rad/s", risen(TIME) + NOISE)
    levels = 12.0 - 6.0 * (TIME > 0.5)
    for drive in (levels, 12.0 * (TIME < 0.5), 0.0 * TIME, 12.0 * np.sin(9.0 * TIME)):
        assert step_response.steps([log(TIME, speed=speed, terminal_voltage=("V", drive))]) is None
    coasting = log(TIME, speed=("rad/s", speed[1][::-1].copy()))
    assert step_response.steps([coasting]) is None
    two = [log(TIME, speed=speed, command=("1", np.full(len(TIME), u))) for u in (0.3, 0.6)]
    assert step_response.steps(two) is None
    same = step_response.steps([two[0], two[0]])
    assert same is not None
    assert [step.level for step in same] == [0.3, 0.3]


def test_few_readings_or_hardly_a_motion_are_no_step() -> None:
    """Either alone: a dozen readings of a fast rise, and many of a motor within its rounding."""
    few = log(TIME[::50], speed=("rad/s", risen(TIME)[::50]))
    still, fine = (log(TIME, quantum, speed=("rad/s", risen(TIME))) for quantum in (100.0, 1.0))
    assert step_response.steps([few]) is None
    assert step_response.steps([still]) is None
    assert step_response.steps([fine]) is not None


@pytest.mark.slow
@pytest.mark.parametrize("lags", [(0.08,), (0.08, 0.01), (0.02, 0.02)])
def test_a_rise_begins_at_nothing_and_ends_at_one_beside_its_integral(
    lags: tuple[float, ...],
) -> None:
    since = np.linspace(-0.01, 2.0, 20_001)
    rise, whole = exponential_fit.shape(since, np.array(lags))
    assert rise[since <= 0.0] == pytest.approx(0.0, abs=1e-12)
    assert rise[-1] == pytest.approx(1.0, abs=1e-6)
    assert np.gradient(whole, since)[200:] == pytest.approx(rise[200:], abs=1e-4)
    assert since[-1] - whole[-1] == pytest.approx(sum(lags), rel=2e-3)  # it lags by all of them


@pytest.mark.slow
def test_a_second_lag_is_found_where_there_is_one() -> None:
    slow, fast = 0.08, 0.01
    t = np.maximum(TIME - ONSET_S, 0.0)
    speed = TOP * (1.0 - (slow * np.exp(-t / slow) - fast * np.exp(-t / fast)) / (slow - fast))
    found = mechanical_fit.fit([log(TIME, speed=("rad/s", speed + 0.2 * NOISE))])
    assert holds(found, TAU, slow + fast)
    assert holds(found, TAU, slow)  # if it is a filter of the speed
    assert holds(found, "second lag", fast)
    single = mechanical_fit.fit([log(TIME, speed=("rad/s", risen(TIME) + NOISE))])
    assert "second lag" not in single.combinations


@pytest.mark.slow
def test_what_a_step_does_not_show_is_said() -> None:
    short = log(TIME[:80], speed=("rad/s", (risen(TIME) + NOISE)[:80]))
    assert "not_settled" in {d.code for d in mechanical_fit.fit([short]).diagnostics}
    sparse = np.arange(0.0, 4.0, 0.05)
    few = log(sparse, speed=("rad/s", risen(sparse)))
    assert "few_samples" in {d.code for d in mechanical_fit.fit([few]).diagnostics}
    with pytest.raises(DataError, match="time constant"):
        mechanical_fit.fit([log(TIME, speed=("rad/s", 200.0 * TIME + NOISE))])


@pytest.mark.slow
def test_intervals_hold_of_exact_and_of_rounded_steps() -> None:
    """24 drawn steps, half of them rounded to some quantum, some of these without any noise."""
    runs, hits = 24, {"constant": 0, "speed": 0}
    for seed in range(runs):
        rng = np.random.default_rng(seed)
        time = np.linspace(0.0, rng.uniform(4.0, 10.0) * TAU_S, int(rng.integers(60, 200)))
        onset = rng.uniform(0.05, 0.2) * time[-1]
        speed = risen(time, onset)
        quantum = TOP / rng.uniform(20.0, 300.0) if seed % 2 else 0.0
        if seed % 4 != 3:
            speed = speed + TOP * 10 ** rng.uniform(-3.0, -1.7) * rng.standard_normal(len(time))
        if quantum:
            speed = np.round(speed / quantum) * quantum
        rise = exponential_fit.rise([exponential_fit.Record(time, speed, quantum=quantum)])
        reach = 1.96 if rise.freedom > 60 else 2.05
        place = rise.place(0)
        hits["constant"] += abs(rise.constant_s - TAU_S) <= reach * rise.constant_variance**0.5
        hits["speed"] += abs(rise.after[0] - TOP) <= reach * rise.covariance[place, place] ** 0.5
    assert all(count >= binom.ppf(0.005, runs, 0.93) for count in hits.values()), hits
