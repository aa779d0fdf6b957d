"""The six-parameter fit on captures that obey its model exactly, and on ones that do not."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from bench.coverage.rigs import draw_bench
from bench.coverage.runs import record
from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture, Channel
from motorid.errors import DataError, UsageError
from motorid.estimate.results.estimate import PARAMETERS, Estimate
from tests.exact_capture import FAULHABER, Plan, clean_capture, noisy
from tests.six_parameters import fit

PLAN = Plan(count=3000)
SD = (0.004, 3e-3, 6e-3)  # A, rad, V


@cache
def clean() -> Capture:
    return clean_capture(FAULHABER, PLAN)


@cache
def run(seed: int = 3) -> Capture:
    return noisy(clean(), seed, *SD)


def changed(capture: Capture, **channels: Channel | None) -> Capture:
    kept = {**capture.channels, **channels}
    return replace(capture, channels={n: c for n, c in kept.items() if c is not None})


def with_raw(capture: Capture, name: str, raw: np.ndarray) -> Capture:
    return changed(capture, **{name: replace(capture.channels[name], raw=raw)})


def pulls(estimate: Estimate) -> np.ndarray:
    """Errors of what was estimated, in standard uncertainties."""
    return np.array(
        [
            (p.value - FAULHABER[n]) / p.total
            for n, p in estimate.parameters.items()
            if p.status == "estimated"
        ]
    )


@pytest.mark.slow
def test_six_parameters_from_one_noisy_capture() -> None:
    estimate = fit([run()])
    assert tuple(estimate.parameters) == PARAMETERS
    assert {p.status for p in estimate.parameters.values()} == {"estimated"}
    assert np.abs(pulls(estimate)).max() < 3.5
    for name in ("R", "K", "J"):
        assert estimate.parameters[name].value == pytest.approx(FAULHABER[name], rel=1e-3)
    assert estimate.chi_square == pytest.approx(estimate.degrees_of_freedom, rel=0.05)
    assert estimate.correlation.shape == (6, 6)
    assert {c.channel for c in estimate.curves} == {CURRENT, POSITION, "back_emf"}
    assert len(estimate.steady) >= 2
    for row in estimate.steady:
        assert row.fitted_current_a == pytest.approx(
            row.current_a, abs=0.05
        )  # a hundredth of the start's current may remain


@pytest.mark.slow
def test_no_start_value_is_asked_however_the_motor_is_scaled() -> None:
    """The same motor in other units: 1000 times the voltage and the inertia's square root."""
    big = {"R": 0.03, "L": 6e-5, "K": 0.6, "B": 2e-3, "J": 0.09, "T0": 0.4}
    plan = Plan(volts=(48.0, 24.0), count=3000, period_s=5e-4, aperture_s=5e-4, delay_s=1e-4)
    estimate = fit([noisy(clean_capture(big, plan), 1, 0.5, 1e-3, 0.05)])
    for name in ("R", "K", "J"):
        assert estimate.parameters[name].value == pytest.approx(big[name], rel=0.02)


@pytest.mark.slow
def test_runs_together_are_known_better_than_one() -> None:
    one, three = fit([run(1)]), fit([run(1), run(2), run(3)])
    assert three.parameters["R"].statistical < 0.9 * one.parameters["R"].statistical
    assert np.abs(pulls(three)).max() < 4
    assert any("this run only" in d.message for d in one.diagnostics)
    assert not any("this run only" in d.message for d in three.diagnostics)


@pytest.mark.slow
def test_spread_between_runs_enters_the_interval() -> None:
    """Runs whose position is scaled differently disagree beyond their noise."""
    runs = []
    for seed, scale in ((1, 0.99), (2, 1.0), (3, 1.01)):
        capture = run(seed)
        runs.append(with_raw(capture, POSITION, scale * capture.channels[POSITION].raw))
    estimate = fit(runs)
    K = estimate.parameters["K"]
    assert K.statistical / K.value == pytest.approx(0.01 / np.sqrt(3), rel=0.3)
    low, high = K.interval_95
    assert high - low > 3.5 * 2 * K.statistical  # Student with two degrees of freedom


def test_fixed_and_left_out_parameters_stay_so() -> None:
    estimate = fit([run()], fix={"K": 7.68e-3}, without=["L"])
    K, L = estimate.parameters["K"], estimate.parameters["L"]
    assert (K.value, K.status) == (7.68e-3, "fixed")
    assert (L.value, L.status, L.note) == (0.0, "fixed", "left out of the model")
    assert estimate.free == ("R", "B", "J", "T0")
    assert estimate.parameters["R"].value == pytest.approx(2.6, rel=0.01)


@pytest.mark.slow
def test_lost_samples_leave_their_place() -> None:
    keep = np.ones(len(run()), dtype=bool)
    keep[[700, 701, 702, 1500]] = False
    broken = replace(
        run(),
        ticks=run().ticks[keep],
        channels={n: replace(c, raw=c.raw[keep]) for n, c in run().channels.items()},
    )
    estimate = fit([broken])
    assert np.abs(pulls(estimate)).max() < 3.5
    assert "lost_samples" in {d.code for d in estimate.diagnostics}


def test_a_speed_will_do_for_a_position() -> None:
    h = PLAN.period_s
    speed = np.diff(clean().channels[POSITION].raw, prepend=0.0) / h
    speed = speed + np.random.default_rng(5).normal(0, 1.0, len(speed))
    channel = Channel(SPEED, "rad/s", speed, kind="mean", aperture_s=h)
    estimate = fit([changed(run(), position=None, speed=channel)])
    assert np.abs(pulls(estimate)).max() < 3.5


@pytest.mark.slow
def test_a_long_aperture_is_modelled() -> None:
    """The mean over 16 samples, declared as such, biases nothing."""
    width = 16
    fine = clean_capture(FAULHABER, replace(PLAN, aperture_s=PLAN.period_s, delay_s=0.0))
    raw = fine.channels[CURRENT].raw
    total = np.concatenate([np.zeros(width), np.cumsum(raw)])
    slow = (total[width:] - total[:-width]) / width
    channel = replace(fine.channels[CURRENT], raw=slow, aperture_s=width * PLAN.period_s)
    capture = noisy(changed(fine, current=channel), 4, *SD)
    estimate = fit([capture])
    assert estimate.parameters["R"].value == pytest.approx(2.6, rel=2e-3)
    assert np.abs(pulls(estimate)).max() < 3.5
    # the test can fail: readings without that mean differ from these by far more than their noise
    assert np.abs(raw[: len(slow)] - slow).max() > 20 * SD[0]


@pytest.mark.slow
def test_a_record_that_begins_in_motion() -> None:
    cut = replace(
        run(),
        ticks=run().ticks[900:],
        channels={n: replace(c, raw=c.raw[900:]) for n, c in run().channels.items()},
    )
    estimate = fit([cut])
    assert np.abs(pulls(estimate)).max() < 3.5
    assert "initial speed" in estimate.nuisance


@pytest.mark.slow
def test_friction_that_is_not_there_is_not_given() -> None:
    motor = {**FAULHABER, "B": 1e-12, "T0": 1e-6}
    estimate = fit([noisy(clean_capture(motor, PLAN), 3, *SD)])
    for name in ("B", "T0"):
        p = estimate.parameters[name]
        assert p.status in ("not_identifiable", "at_bound")
        assert p.interval_95 is None or p.interval_95[0] >= 0
    assert estimate.parameters["R"].value == pytest.approx(2.6, rel=1e-2)


@pytest.mark.slow
def test_inductance_far_below_the_sampling_is_not_given() -> None:
    plan = Plan(count=300, period_s=2e-3, aperture_s=2e-3, delay_s=0.0)
    estimate = fit([noisy(clean_capture(FAULHABER, plan), 3, 0.1, 0.06, 0.1)])
    L = estimate.parameters["L"]
    assert (L.status, L.value, L.interval_95) == ("not_identifiable", None, None)
    assert "sampled" in L.note
    assert estimate.parameters["K"].value == pytest.approx(7.68e-3, rel=5e-3)


@pytest.mark.slow
def test_instrument_uncertainty_follows_the_declared_gains() -> None:
    gain = 0.01
    plain = fit([run()])
    capture = changed(run(), current=replace(run().channels[CURRENT], gain_uncertainty=gain))
    estimate = fit([capture])
    R, K = estimate.parameters["R"], estimate.parameters["K"]
    # i too large by 1 %: R too small by 1 %; K, from volts and speed, hardly moves
    assert R.instrument / R.value == pytest.approx(gain, rel=0.15)
    assert K.instrument / K.value < 0.1 * gain
    stated = plain.budget["R"].keys() & {"current gain", "voltage gain", "clock"}
    assert not stated
    # effects that were not detected stand beside it
    others = plain.parameters["R"].instrument
    assert estimate.budget["R"]["current gain"] == pytest.approx(
        np.sqrt(R.instrument**2 - others**2), rel=1e-3
    )
    assert R.total == pytest.approx(np.hypot(R.statistical, R.instrument))


@pytest.mark.slow
def test_a_current_gain_error_moves_the_values_as_the_budget_says() -> None:
    error = 1.004
    true = fit([run()])
    wrong = fit([with_raw(run(), CURRENT, error * run().channels[CURRENT].raw)])
    declared = fit(
        [changed(run(), current=replace(run().channels[CURRENT], gain_uncertainty=error - 1))]
    )
    for name in ("R", "J", "B", "T0"):
        moved = abs(wrong.parameters[name].value - true.parameters[name].value)
        assert moved == pytest.approx(declared.budget[name]["current gain"], rel=0.15)


@pytest.mark.slow
def test_a_voltage_gain_error_moves_the_values_as_the_budget_says() -> None:
    error = 1.004
    volts = run().channels[VOLTAGE]
    true = fit([run()])
    wrong = fit([with_raw(run(), VOLTAGE, error * volts.raw)])
    declared = fit([changed(run(), terminal_voltage=replace(volts, gain_uncertainty=error - 1))])
    for name in ("R", "K"):
        moved = abs(wrong.parameters[name].value - true.parameters[name].value)
        assert moved == pytest.approx(declared.budget[name]["voltage gain"], rel=0.15)


@pytest.mark.slow
def test_derived_figures_follow_from_the_motor() -> None:
    estimate = fit([run()])
    assert estimate.derived["stall_current"].value == pytest.approx(6.0 / 2.6, rel=1e-3)
    assert estimate.derived["no_load_speed"].value == pytest.approx(758.0, rel=1e-3)
    assert estimate.derived["electrical_time_constant"].value == pytest.approx(
        180e-6 / 2.6, rel=0.02
    )
    assert estimate.derived["Kv"].value == pytest.approx(30 / np.pi / 7.68e-3, rel=1e-3)
    low, high = estimate.derived["peak_efficiency"].interval_95
    assert 0 < low < high < 1


@pytest.mark.parametrize(
    ("break_it", "says"),
    [
        (lambda c: with_raw(c, CURRENT, np.zeros(len(c))), "current never changes"),
        (lambda c: with_raw(c, CURRENT, np.full(len(c), np.nan)), "no usable reading"),
        (lambda c: with_raw(c, POSITION, np.zeros(len(c))), "position never changes"),
        (lambda c: with_raw(c, VOLTAGE, np.zeros(len(c))), "never driven"),
        (
            lambda c: with_raw(changed(c, position=None), CURRENT, np.zeros(len(c))),
            "never changes, and no motion",
        ),
        (
            lambda c: with_raw(changed(c, position=None), VOLTAGE, np.zeros(len(c))),
            "never driven",
        ),
        (
            lambda c: replace(
                c,
                ticks=c.ticks[:9],
                channels={n: replace(v, raw=v.raw[:9]) for n, v in c.channels.items()},
            ),
            "too few",
        ),
        (
            lambda c: replace(
                c, ticks=np.sort(c.ticks + np.random.default_rng(1).integers(-45, 45, len(c)))
            ),
            "uniform grid",
        ),
    ],
)
def test_bad_captures_are_refused_in_a_sentence(break_it, says: str) -> None:
    with pytest.raises(DataError, match=says):
        fit([break_it(run())])


@pytest.mark.parametrize(
    "options",
    [{"method": "guess"}, {"fix": {"Q": 1.0}}, {"fix": {"R": -1.0}}, {"without": ["K"]},
     {"fix": {"L": 1e-4}, "without": ["L"]}],
)  # fmt: skip
def test_wrong_options_are_usage_errors(options) -> None:
    with pytest.raises(UsageError):
        fit([run()], **options)


def test_no_captures() -> None:
    with pytest.raises(DataError, match="no capture"):
        fit([])


def test_import_is_cheap_and_knows_no_serial_port() -> None:
    script = (
        "import sys, motorid.identify; "
        "heavy = {'serial', 'scipy', 'pandas', 'h5py', 'numpy', 'motorid.acquire'}; "
        "bad = heavy & set(sys.modules); "
        "sys.exit(str(bad) if bad else 0)"
    )
    subprocess.run([sys.executable, "-c", script], check=True)


@pytest.mark.slow
def test_the_report_says_which_cause_to_improve_first() -> None:
    current = run().channels[CURRENT]
    doubtful = changed(run(), **{CURRENT: replace(current, gain_uncertainty=0.02)})
    (said,) = (d.message for d in fit([doubtful]).diagnostics if d.code == "budget")
    assert "current gain for R (" in said
    assert "calibrate the current's gain" in said
    (said,) = (d.message for d in fit([run()]).diagnostics if d.code == "budget")
    assert "commutation resistance for R (" in said  # and of what rises with the speed
    assert "quadratic load for B (" in said  # two levels tell little of windage


@pytest.mark.slow
def test_correlated_residuals_are_said_once_however_many_runs_show_them() -> None:
    rng = np.random.default_rng(5)
    runs = []
    for seed in (1, 2, 3):
        one = run(seed)
        raw = one.channels[CURRENT].raw
        walk = np.convolve(rng.normal(0, 0.01, len(raw) + 4), np.ones(5) / 5, "valid")
        runs.append(with_raw(one, CURRENT, raw + walk))
    said = [d.message for d in fit(runs).diagnostics if d.code == "coloured_residuals"]
    assert len(said) == len(set(said)) <= 3
    assert sum("residuals of the current" in text for text in said) == 1
    assert any("in 3 runs" in text for text in said)


@pytest.mark.slow
def test_a_current_that_hovers_where_the_dead_time_turns_it_settles(tmp_path: Path) -> None:
    """A simulated rig without a sensed voltage: 1.6 % of dead time, no load below the ripple.

    A loss that swings from step to step makes R and T0 1.6 % wrong, and B 3 %.
    """
    bench = draw_bench(277)
    runs = record(replace(bench, rigs=bench.rigs[:1]), tmp_path)
    found = fit(runs.captures, model="six").parameters
    for name, most in {"R": 0.01, "L": 0.01, "B": 0.01, "T0": 0.01}.items():
        assert found[name].value == pytest.approx(runs.truth[name], rel=most)
        assert found[name].interval_95[0] < runs.truth[name] < found[name].interval_95[1]
