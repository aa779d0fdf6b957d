"""The momentum balance against motors whose parameters are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binom

from motorid.capture.model import Capture, Channel
from motorid.errors import DataError, UsageError
from motorid.estimate.partial import mechanical_fit
from motorid.estimate.results.estimate import Estimate
from tests.estimate.partial.truth import Plant, capture, closed_loop, steps, sweep

MOTOR = Plant()
RATIOS = {"J/K": MOTOR.J / MOTOR.K, "B/K": MOTOR.B / MOTOR.K, "T0/K": MOTOR.T0 / MOTOR.K}


def run(
    seed: int = 0, noise_a: float = 0.01, noise_w: float = 0.2, length_s: float = 8.0
) -> Capture:
    """A closed-loop run with reversals, noise on the current and on the speed."""
    t, i, w = closed_loop(MOTOR, sweep(120.0, 0.7), 0.02, length_s)
    rng = np.random.default_rng(seed)
    return capture(
        t,
        current=("A", i + noise_a * rng.standard_normal(len(t))),
        speed=("rad/s", w + noise_w * rng.standard_normal(len(t))),
    )


@pytest.fixture(scope="module")
def clean() -> Capture:
    return run(noise_a=0.0, noise_w=0.0)


def errors_in_sigmas(estimate: Estimate, truth: dict[str, float]) -> dict[str, float]:
    found = {**estimate.parameters, **estimate.combinations}
    return {
        name: abs(found[name].value - value) / found[name].total for name, value in truth.items()
    }


def inside(estimate: Estimate, truth: dict[str, float]) -> bool:
    found = {**estimate.parameters, **estimate.combinations}
    return all(
        found[name].interval_95[0] <= value <= found[name].interval_95[1]
        for name, value in truth.items()
    )


@pytest.mark.slow
def test_without_noise_the_ratios_come_back(clean: Capture) -> None:
    estimate = mechanical_fit.fit([clean])
    for name, value in RATIOS.items():
        assert estimate.combinations[name].value == pytest.approx(value, rel=5e-3)
    for name in ("R", "L", "K", "J", "B", "T0"):
        assert estimate.parameters[name].status == "not_identifiable"
        assert estimate.parameters[name].value is None
        assert "voltage" in estimate.parameters[name].note
    assert any("terminal voltage" in d.message for d in estimate.diagnostics)


@pytest.mark.slow
def test_fixed_torque_constant_gives_parameters() -> None:
    truth = {"B": MOTOR.B, "J": MOTOR.J, "T0": MOTOR.T0}
    estimate = mechanical_fit.fit([run(1)], fix={"K": MOTOR.K})
    for name, value in truth.items():
        assert estimate.parameters[name].status == "estimated"
        assert estimate.parameters[name].value == pytest.approx(value, rel=0.05)
    assert estimate.parameters["K"].status == "fixed"


@pytest.mark.slow
def test_fixed_inertia_gives_the_torque_constant() -> None:
    estimate = mechanical_fit.fit([run(2)], fix={"J": MOTOR.J})
    assert estimate.parameters["K"].value == pytest.approx(MOTOR.K, rel=0.03)
    assert estimate.parameters["T0"].value == pytest.approx(MOTOR.T0, rel=0.05)


@pytest.mark.slow
def test_position_serves_as_well_as_speed() -> None:
    t, i, w = closed_loop(MOTOR, sweep(120.0, 0.7), 0.02, 8.0)
    angle = np.r_[0.0, np.cumsum((w[1:] + w[:-1]) / 2 * np.diff(t))]
    quantum = 2 * np.pi / 4096
    channel = Channel("position", "rad", np.round(angle / quantum), quantum, resolution=quantum)
    rng = np.random.default_rng(0)
    noisy = i + 0.01 * rng.standard_normal(len(t))
    estimate = mechanical_fit.fit([capture(t, current=("A", noisy), position=channel)])
    for name, value in RATIOS.items():
        assert estimate.combinations[name].value == pytest.approx(value, rel=0.03)


@pytest.mark.slow
def test_linear_axis_reports_mass_and_offset() -> None:
    axis = Plant(K=1.0, B=200.0, J=95.0, T0=20.0, load=-3.0)
    t, force, v = closed_loop(axis, sweep(0.1, 0.5), 3000.0, 8.0)
    position = np.r_[0.0, np.cumsum((v[1:] + v[:-1]) / 2 * np.diff(t))]
    rng = np.random.default_rng(0)
    noisy = force + 0.2 * rng.standard_normal(len(t))
    estimate = mechanical_fit.fit([capture(t, torque=("N", noisy), position=("m", position))])
    assert [estimate.parameters[n].unit for n in ("J", "B", "T0")] == ["kg", "N·s/m", "N"]
    assert estimate.parameters["J"].value == pytest.approx(95.0, rel=0.01)
    assert estimate.parameters["B"].value == pytest.approx(200.0, rel=0.02)
    assert estimate.parameters["T0"].value == pytest.approx(20.0, rel=0.02)
    assert estimate.nuisance["torque_offset"].value == pytest.approx(-3.0, abs=0.1)


def test_torque_beside_metres_is_refused() -> None:
    t = np.arange(100) * 1e-3
    with pytest.raises(DataError, match="map both linear or both not"):
        mechanical_fit.fit([capture(t, torque=("N·m", t), position=("m", t))])


@pytest.mark.slow
def test_averaged_current_is_matched(clean: Capture) -> None:
    """A current averaged over 64 samples biases the inertia unless its aperture is declared."""
    t, i, w = (clean.time_s, clean.channels["current"].values, clean.channels["speed"].values)
    kernel = np.ones(64) / 64
    mean = np.convolve(i, kernel)[: len(i)]
    plain = Channel("current", "A", mean)
    declared = replace(plain, kind="mean", aperture_s=0.064)
    wrong = mechanical_fit.fit([capture(t, current=plain, speed=("rad/s", w))])
    right = mechanical_fit.fit([capture(t, current=declared, speed=("rad/s", w))])
    error = {
        label: abs(e.combinations["J/K"].value / RATIOS["J/K"] - 1)
        for label, e in (("wrong", wrong), ("right", right))
    }
    assert error["right"] < 0.02
    assert error["wrong"] > 3 * error["right"]


@pytest.mark.slow
def test_magnitude_of_the_current_gets_its_sign_back() -> None:
    t, i, w = closed_loop(
        MOTOR, steps(1.0, 40.0, 0.0, -40.0, 0.0, 120.0, 0.0, -120.0, 0.0), 0.02, 16.0
    )
    rng = np.random.default_rng(4)
    read = np.abs(i + 0.01 * rng.standard_normal(len(t)))
    current = Channel("current", "A", np.round(read / 0.02), 0.02, resolution=0.02, unsigned=True)
    speed = w + 0.3 * rng.standard_normal(len(t))
    estimate = mechanical_fit.fit([capture(t, current=current, speed=("rad/s", speed))])
    assert estimate.combinations["B/K"].value == pytest.approx(RATIOS["B/K"], rel=0.1)
    assert estimate.combinations["T0/K"].value == pytest.approx(RATIOS["T0/K"], rel=0.03)
    assert estimate.combinations["J/K"].value == pytest.approx(RATIOS["J/K"], rel=0.1)
    assert any(d.code == "unsigned_drive" for d in estimate.diagnostics)


@pytest.mark.slow
def test_one_direction_knows_no_offset() -> None:
    t, i, w = closed_loop(MOTOR, steps(0.5, 40.0, 120.0, 80.0), 0.02, 8.0)
    rng = np.random.default_rng(0)
    noisy = i + 0.01 * rng.standard_normal(len(t))
    estimate = mechanical_fit.fit([capture(t, current=("A", noisy), speed=("rad/s", w))])
    assert not estimate.nuisance
    assert "offset" not in estimate.free
    assert inside(estimate, RATIOS)


@pytest.mark.slow
def test_volts_without_current_give_time_constant_and_gain() -> None:
    R, K, J, B, T0 = 2.0, 0.05, 5e-5, 2e-5, 4e-3
    equivalent = Plant(K=K / R, B=B + K**2 / R, J=J, T0=T0)  # L neglected: i = (v − Kω)/R
    t, volts, w = closed_loop(equivalent, sweep(100.0, 0.8), 0.3, 8.0)
    rng = np.random.default_rng(0)
    estimate = mechanical_fit.fit(
        [
            capture(
                t,
                terminal_voltage=("V", volts),
                speed=("rad/s", w + 0.2 * rng.standard_normal(len(t))),
            )
        ]
    )
    both = K**2 + R * B
    assert estimate.combinations["JR/(K²+RB)"].value == pytest.approx(J * R / both, rel=0.02)
    assert estimate.combinations["K/(K²+RB)"].value == pytest.approx(K / both, rel=0.02)
    assert estimate.combinations["T0·R/K"].value == pytest.approx(T0 * R / K, rel=0.05)
    known = mechanical_fit.fit(
        [capture(t, terminal_voltage=("V", volts), speed=("rad/s", w))], fix={"R": R, "K": K}
    )
    assert known.parameters["J"].value == pytest.approx(J, rel=0.02)


@pytest.mark.slow
def test_volts_with_resistance_and_constant_give_each_parameter_its_value_and_its_doubt() -> None:
    R, K, J, B, T0 = 2.0, 0.05, 5e-5, 2e-4, 4e-3
    equivalent = Plant(K=K / R, B=B + K**2 / R, J=J, T0=T0)
    t, volts, w = closed_loop(equivalent, sweep(100.0, 0.8), 0.3, 3.0, fine=4)
    noise = 0.2 * np.random.default_rng(0).standard_normal(len(t))
    channels = {"terminal_voltage": ("V", volts), "speed": ("rad/s", w + noise)}
    found = mechanical_fit.fit([capture(t, **channels)], fix={"R": R, "K": K}).parameters
    for name, value in (("J", J), ("B", B), ("T0", T0)):
        assert found[name].value == pytest.approx(value, rel=0.1), name
        assert 0.0 < found[name].total < 0.1 * value, name


@pytest.mark.slow
def test_friction_that_the_model_lacks_is_said() -> None:
    t, _, w = closed_loop(MOTOR, sweep(120.0, 0.7), 0.02, 8.0)
    pushed = (
        np.gradient(w, t) * MOTOR.J + MOTOR.B * w + MOTOR.T0 * np.sign(w) + 4e-7 * w * np.abs(w)
    )
    rng = np.random.default_rng(0)
    current = pushed / MOTOR.K + 0.005 * rng.standard_normal(len(t))
    estimate = mechanical_fit.fit([capture(t, current=("A", current), speed=("rad/s", w))])
    message = next(d.message for d in estimate.diagnostics if d.code == "lack_of_fit")
    assert "square of speed" in message
    assert not any(d.code == "lack_of_fit" for d in mechanical_fit.fit([run(5)]).diagnostics)


@pytest.mark.slow
def test_slow_sampling_is_said() -> None:
    t, i, w = closed_loop(MOTOR, steps(1.0, 100.0, 0.0, -100.0, 0.0), 0.2, 16.0)
    thin = slice(None, None, 60)
    rng = np.random.default_rng(0)
    noisy = i[thin] + 0.02 * rng.standard_normal(len(t[thin]))
    estimate = mechanical_fit.fit(
        [capture(t[thin], current=("A", noisy), speed=("rad/s", w[thin]))]
    )
    assert any(d.code == "slow_sampling" for d in estimate.diagnostics)


@pytest.mark.slow
def test_negative_friction_is_held_at_zero() -> None:
    plant = Plant(B=0.0)
    t, i, w = closed_loop(plant, sweep(100.0, 0.7), 0.02, 6.0)
    rng = np.random.default_rng(0)
    helped = i - 2e-5 * w + 0.01 * rng.standard_normal(len(t))
    estimate = mechanical_fit.fit([capture(t, current=("A", helped), speed=("rad/s", w))])
    viscous = estimate.combinations["B/K"]
    assert (viscous.value, viscous.status) == (0.0, "at_bound")
    assert viscous.interval_95[0] == 0.0


@pytest.mark.slow
def test_bad_requests_and_bad_captures_are_one_sentence(clean: Capture) -> None:
    t = np.arange(200) * 1e-3
    still = capture(t, current=("A", t), speed=("rad/s", np.zeros(200)))
    for bad in ([], [still], [capture(t, speed=("rad/s", t))], [capture(t, current=("A", t))]):
        with pytest.raises(DataError) as caught:
            mechanical_fit.fit(bad)
        assert "\n" not in str(caught.value)
    for fix, without in (({"Q": 1.0}, ()), ({"K": -1.0}, ()), ({}, ("K",)), ({"K": np.nan}, ())):
        with pytest.raises(UsageError):
            mechanical_fit.fit([clean], fix=fix, without=without)


@pytest.mark.study
def test_intervals_hold_what_they_promise() -> None:
    """60 noisy runs: the 95 % intervals hold each ratio about that often, and bias is small."""
    t, i, w = closed_loop(MOTOR, sweep(120.0, 0.7), 0.02, 4.0)
    runs, hits, shifts = 60, dict.fromkeys(RATIOS, 0), {name: [] for name in RATIOS}
    for seed in range(runs):
        rng = np.random.default_rng(seed)
        wander = np.convolve(rng.standard_normal(len(t) + 49), np.ones(50) / 50, "valid")
        noise = 0.01 * rng.standard_normal(len(t)) + 0.02 * wander  # correlated over 50 samples
        speed = w + 0.5 * rng.standard_normal(len(t))
        estimate = mechanical_fit.fit(
            [capture(t, current=("A", i + noise), speed=("rad/s", speed))]
        )
        for name, value in RATIOS.items():
            ratio = estimate.combinations[name]
            low, high = ratio.interval_95
            hits[name] += low <= value <= high
            shifts[name].append((ratio.value - value) / ratio.total)
    fewest = int(binom.ppf(0.005, runs, 0.93))
    assert all(count >= fewest for count in hits.values()), hits
    assert all(abs(np.mean(shift)) < 0.6 for shift in shifts.values()), {
        name: float(np.mean(shift)) for name, shift in shifts.items()
    }


@pytest.mark.slow
def test_coast_down_alone_gives_two_ratios() -> None:
    t = np.arange(0, 1.2, 1e-3)
    b, c = MOTOR.B / MOTOR.J, MOTOR.T0 / MOTOR.J
    w = np.maximum((200 + c / b) * np.exp(-b * t) - c / b, 0.0)
    rng = np.random.default_rng(0)
    estimate = mechanical_fit.fit(
        [capture(t, speed=("rad/s", w + 0.2 * rng.standard_normal(len(t))))]
    )
    assert inside(estimate, {"B/J": b, "T0/J": c})
    assert estimate.combinations["T0/J"].value == pytest.approx(c, rel=0.02)
    known = mechanical_fit.fit([capture(t, speed=("rad/s", w))], fix={"J": MOTOR.J})
    assert known.parameters["T0"].value == pytest.approx(MOTOR.T0, rel=0.02)
    with pytest.raises(DataError, match="gets faster"):
        mechanical_fit.fit([capture(t, speed=("rad/s", w[::-1].copy()))])


def test_steady_points_of_a_measured_table() -> None:
    """Several volts and loads: R and K from the volts, K from the torque, too few rows refused."""
    R, K, T0 = 1.2, 0.03, 5e-3
    volts, load = (x.ravel() for x in np.meshgrid([6.0, 12.0, 18.0], np.linspace(0, 0.2, 9)))
    current = (load + T0) / K
    speed = (volts - R * current) / K
    rng = np.random.default_rng(0)
    measured = {
        "terminal_voltage": ("V", volts + 0.02 * rng.standard_normal(27)),
        "current": ("A", current),
        "speed": ("rad/s", speed),
        "torque": ("N·m", load + 1e-3 * rng.standard_normal(27)),
    }
    table = replace(capture(np.arange(27.0), **measured), provenance={"static": True})
    estimate = mechanical_fit.fit([table])
    assert inside(estimate, {"R": R, "K": K, "T0": T0})
    assert [d.code for d in estimate.diagnostics] == ["no_instrument_uncertainty"]
    few = replace(
        capture(np.arange(3.0), current=("A", np.arange(3.0))), provenance={"static": True}
    )
    with pytest.raises(DataError, match="at least 8 rows"):
        mechanical_fit.fit([few])
