"""Steiglitz-McBride: exact on exact data, whatever the damping, and honest where it cannot be."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import cont2discrete

from motorid.errors import DataError
from motorid.estimate.fit.steiglitz_mcbride import _pass, _stable, motor_of, steiglitz_mcbride
from motorid.motor.batch import LINEAR, Record, blank

UNDERDAMPED = {"R": 3.1363, "L": 0.01307, "K": 0.048774, "B": 1.69e-4, "J": 9e-6}
OVERDAMPED = {"R": 2.8, "L": 0.003, "K": 0.2305, "B": 0.00019, "J": 0.00015}


def step(motor: dict[str, float], period: float, count: int, volts: float = 8.0) -> Record:
    drive = np.full(count, volts)
    silent = Record(period, drive, blank(drive, ("current", "speed")))
    current, speed = LINEAR.outputs(np.array([list(motor.values())]), silent)[0]
    return Record(period, drive, {"current": current, "speed": speed})


@pytest.mark.parametrize("motor", [UNDERDAMPED, OVERDAMPED])
@pytest.mark.parametrize("period", [1e-4, 5e-4])
def test_exact_data_give_the_exact_motor(motor, period):
    found = steiglitz_mcbride(step(motor, period, 2000))
    assert found.settled
    assert found.values == pytest.approx(motor, rel=1e-5)


@pytest.mark.slow
@settings(max_examples=30)
@given(scales=st.lists(st.floats(0.5, 2.0), min_size=5, max_size=5))
def test_any_motor_near_is_found(scales):
    pairs = zip(UNDERDAMPED.items(), scales, strict=True)
    motor = {name: value * scale for (name, value), scale in pairs}
    assert steiglitz_mcbride(step(motor, 1e-4, 1500)).values == pytest.approx(motor, rel=1e-4)


@pytest.mark.slow
def test_noise_costs_percents_and_no_more():
    clean = step(UNDERDAMPED, 1e-4, 5000)
    misses = []
    for seed in range(10):
        rng = np.random.default_rng(seed)
        noisy = {
            name: y + 0.02 * np.abs(y).max() * rng.standard_normal(len(y))
            for name, y in clean.measured.items()
        }
        values = steiglitz_mcbride(Record(1e-4, clean.input, noisy)).values
        misses.append([100 * abs(values[n] / UNDERDAMPED[n] - 1) for n in UNDERDAMPED])
    medians = dict(zip(UNDERDAMPED, np.median(misses, axis=0), strict=True))
    # one trial, made before this code was: R .24, L .31, K .06, J 1.1, B 4.5 %
    for name, one in {"R": 0.24, "L": 0.31, "K": 0.06, "J": 1.1, "B": 4.5}.items():
        assert medians[name] < 3 * one, name


def test_what_cannot_be_is_refused_in_a_sentence():
    record = step(UNDERDAMPED, 1e-4, 500)
    only_speed = Record(1e-4, record.input, {"speed": record.measured["speed"]})
    with pytest.raises(DataError, match="a current and a speed"):
        steiglitz_mcbride(only_speed)
    holes = {name: y.copy() for name, y in record.measured.items()}
    holes["current"][7] = np.nan
    with pytest.raises(DataError, match="every reading"):
        steiglitz_mcbride(Record(1e-4, record.input, holes))
    reversed_encoder = {**record.measured, "speed": -record.measured["speed"]}
    with pytest.raises(DataError, match="no motor"):
        steiglitz_mcbride(Record(1e-4, record.input, reversed_encoder))
    nothing = {"current": np.zeros(500), "speed": np.zeros(500)}
    with pytest.raises(DataError):
        steiglitz_mcbride(Record(1e-4, record.input, nothing))


def test_a_system_without_a_real_logarithm_is_no_motor():
    # a pole on the negative real axis: sampled motors have none
    with pytest.raises(DataError, match="Steiglitz-McBride"):
        motor_of(np.array([1.0, 0.2, -0.35]), np.array([[0.1, 0.0], [0.0, 0.2]]), 1e-4)


@pytest.mark.parametrize(
    "roots",
    [(1.25, 0.5), (1.25, 2.0), (0.9, 0.3), (1.1 + 0.6j, 1.1 - 0.6j), (0.9 + 0.1j, 0.9 - 0.1j)],
)
def test_a_stable_denominator_has_the_same_spectrum(roots):
    """A root mirrored at the unit circle leaves the spectrum, but for a constant."""
    given = np.real(np.poly(roots))
    found = _stable(given)
    assert found[0] == pytest.approx(1.0)
    assert np.abs(np.roots(found)).max() < 1.0
    frequencies = np.exp(-1j * np.linspace(0.0, np.pi, 40))
    ratio = np.abs(np.polyval(given[::-1], frequencies) / np.polyval(found[::-1], frequencies))
    assert ratio == pytest.approx(ratio[0])
    if max(abs(r) for r in roots) < 1.0:
        assert found == pytest.approx(given)


@pytest.mark.parametrize("motor", [UNDERDAMPED, OVERDAMPED])
@pytest.mark.parametrize("period", [1e-4, 1e-3])
def test_a_discrete_system_is_taken_back_to_its_motor(motor, period):
    """The system by scipy: a voltage that is held between samples."""
    R, L, K, B, J = motor.values()
    continuous = np.array([[-R / L, -K / L], [K / J, -B / J]]), np.array([[1.0 / L], [0.0]])
    Ad, Bd, *_ = cont2discrete((*continuous, np.eye(2), np.zeros((2, 1))), period)
    a = np.poly(Ad)
    h1, h2 = Bd[:, 0], Ad @ Bd[:, 0]
    b = np.column_stack([h1, h2 + a[1] * h1])  # of y = h1 v[-1] + h2 v[-2] ..
    assert motor_of(a, b, period) == pytest.approx(motor)


def test_passes_are_counted_until_they_settle():
    record = step(UNDERDAMPED, 5e-4, 400)
    one = steiglitz_mcbride(record, 1)
    assert (one.passes, one.settled) == (1, False)
    assert one.denominator[0] == pytest.approx(1.0)
    whole = steiglitz_mcbride(record)
    assert whole.settled
    assert 1 < whole.passes < 20
    again = steiglitz_mcbride(record, whole.passes)
    assert again.settled
    assert again.denominator == pytest.approx(whole.denominator)
    assert not steiglitz_mcbride(record, whole.passes - 1).settled


def test_each_output_counts_by_its_own_spread():
    """A channel in other units is the same channel: milliamperes move nothing but K, R and L."""
    record = step(UNDERDAMPED, 5e-4, 400)
    rng = np.random.default_rng(3)
    noisy = {
        name: y + 0.01 * np.std(y) * rng.standard_normal(len(y))
        for name, y in record.measured.items()
    }
    first = _pass(record.input, np.array([*noisy.values()]), np.array([1.0, 0.0, 0.0]))
    scaled = np.array([1e3 * noisy["current"], noisy["speed"]])
    other = _pass(record.input, scaled, np.array([1.0, 0.0, 0.0]))
    assert other[0] == pytest.approx(first[0])
    assert other[1][0] == pytest.approx(1e3 * first[1][0])
    assert other[1][1] == pytest.approx(first[1][1])
