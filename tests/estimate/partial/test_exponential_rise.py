"""A rise of exponentials, against integrals, scipy's fits and noise that was drawn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import integrate, optimize, signal

from motorid.estimate.partial import exponential_fit as module
from motorid.estimate.partial.exponential_fit import Record, Rise, columns, rise, shape, variances

Floats = NDArray[np.float64]

TAU_S, LAG_S, ONSET_S = 0.08, 0.02, 0.1037
BEFORE, AFTER = 5.0, 120.0  # rad/s
TIME = np.arange(0.0, 0.7, 4e-3)
ONE, TWO = np.array([TAU_S]), np.array([LAG_S, TAU_S])


def after_step(lags: Floats, t: Floats) -> Floats:
    """scipy's step response of 1/((1 + s a)(1 + s b))."""
    denominator = np.array([1.0])
    for lag in lags:
        denominator = np.polymul(denominator, [lag, 1.0])
    fine = np.linspace(0.0, max(t.max(), 1e-3), 4001)
    known = signal.step(([1.0], denominator), T=fine)[1]
    return np.where(t > 0.0, np.interp(t, fine, known), 0.0)


def speed(t: Floats, lags: Floats = ONE, onset_s: float = ONSET_S) -> Floats:
    return BEFORE + (AFTER - BEFORE) * shape(t - onset_s, lags)[0]


def angle(t: Floats, lags: Floats = ONE, start: float = 2.0) -> Floats:
    moved = [integrate.quad(lambda x: float(speed(np.array([x]), lags)[0]), 0.0, one,
                            points=[ONSET_S], limit=200)[0] for one in t]  # fmt: skip
    return start + np.array(moved)


@pytest.mark.parametrize("lags", [ONE, TWO, TWO[::-1]])
def test_the_shape_is_the_step_response_of_its_lags_and_its_integral(lags: Floats) -> None:
    t = np.linspace(-0.1, 0.5, 61)
    risen, area = shape(t, lags)
    np.testing.assert_allclose(risen, after_step(lags, t), atol=1e-5)
    by_parts = integrate.cumulative_simpson(
        shape(np.linspace(0.0, 0.5, 4001), lags)[0], x=np.linspace(0.0, 0.5, 4001), initial=0.0
    )
    np.testing.assert_allclose(area, np.interp(t, np.linspace(0.0, 0.5, 4001), by_parts), atol=1e-6)
    assert not risen[t <= 0.0].any()
    assert not area[t <= 0.0].any()


def test_two_lags_that_are_alike_and_one_that_vanishes_have_a_shape() -> None:
    t = np.linspace(0.0, 0.5, 60)
    alike = 1.0 - (1.0 + t / TAU_S) * np.exp(-t / TAU_S)
    np.testing.assert_allclose(shape(t, np.array([TAU_S, TAU_S]))[0], alike, atol=1e-3)
    np.testing.assert_array_equal(shape(t, np.array([TAU_S, 0.0]))[0], shape(t, ONE)[0])


@pytest.mark.slow
@pytest.mark.parametrize("lags", [ONE, TWO])
def test_columns_are_what_a_unit_of_each_level_is_read_as(lags: Floats) -> None:
    t = TIME[5:] + 1e-4
    instants = Record(t, np.zeros(len(t)))
    read = columns(instants, lags, ONSET_S) @ [BEFORE, AFTER]
    np.testing.assert_allclose(read, speed(t, lags), rtol=1e-12)
    turned = columns(replace(instants, is_position=True), lags, ONSET_S) @ [BEFORE, AFTER, 2.0]
    np.testing.assert_allclose(turned - 2.0, angle(t, lags) - angle(t[:1], lags), atol=1e-6)
    window = 3e-3
    means = columns(replace(instants, aperture_s=window), lags, ONSET_S) @ [BEFORE, AFTER]
    travelled = (angle(t, lags) - angle(t - window, lags)) / window
    np.testing.assert_allclose(means, travelled, atol=1e-5)


def test_stamps_show_to_what_they_were_rounded() -> None:
    steps = np.tile([1.0, 1.0, 2.0], 30) * 1e-3
    stamps = np.cumsum(steps)
    assert Record(stamps, stamps).stamp_quantum_s == pytest.approx(1e-3)
    assert Record(TIME, TIME).stamp_quantum_s == 0.0
    four = np.cumsum(np.tile([1.0, 1.5, 3.0, 4.0], 30))
    assert Record(four, four).stamp_quantum_s == pytest.approx(0.5)
    five = np.cumsum(np.tile([1.0, 1.5, 3.0, 4.0, 6.0], 30))
    assert Record(five, five).stamp_quantum_s == 0.0
    uneven = Record(np.array([0.5, 1.0, 2.0, 3.0, 7.0]), np.zeros(5))
    assert (uneven.period_s, uneven.length_s) == (1.0, 6.5)


@pytest.mark.slow
@pytest.mark.parametrize("is_position", [False, True])
def test_an_exact_rise_is_found(is_position: bool) -> None:
    values = angle(TIME) if is_position else speed(TIME)
    found = rise([Record(TIME, values, is_position)])
    assert found.lags == pytest.approx(ONE, rel=1e-5)
    assert found.onsets == (pytest.approx(ONSET_S, abs=1e-6),)
    assert found.before == pytest.approx([BEFORE], rel=1e-4)
    assert found.after == pytest.approx([AFTER], rel=1e-5)
    assert found.fitted[0] == pytest.approx(values, abs=1e-4)
    assert found.constant_s == pytest.approx(TAU_S, rel=1e-5)


@pytest.mark.slow
def test_a_second_lag_is_found_where_the_readings_ask_for_it() -> None:
    rng = np.random.default_rng(1)
    found = rise([Record(TIME, speed(TIME, TWO) + 0.05 * rng.standard_normal(len(TIME)))])
    assert np.sort(found.lags) == pytest.approx([LAG_S, TAU_S], rel=0.02)
    assert found.constant_s == pytest.approx(TAU_S + LAG_S, rel=5e-3)
    plain = rise([Record(TIME, speed(TIME) + 0.05 * rng.standard_normal(len(TIME)))])
    assert len(plain.lags) == 1


@pytest.mark.slow
def test_an_interval_holds_whether_a_second_lag_is_told_or_not() -> None:
    """One of an eighth of the other: too small for the readings, it hides in the onset."""
    lags, held, told = np.array([0.01, TAU_S]), 0, 0
    for seed in range(20):
        left = 2.0 * np.random.default_rng(seed).standard_normal(len(TIME))
        found = rise([Record(TIME, speed(TIME, lags) + left)])
        held += abs(found.constant_s - lags.sum()) < 1.96 * found.constant_variance**0.5
        told += len(found.lags) == 2
    assert (held >= 16, told) == (True, 0)


@pytest.mark.slow
def test_a_record_that_begins_after_the_onset_shows_none() -> None:
    late = TIME[TIME > ONSET_S + 0.01]
    found = rise([Record(late, speed(late))])
    assert found.lags == pytest.approx(ONE, rel=1e-4)
    assert found.after == pytest.approx([AFTER], rel=1e-4)


def by_scipy(values: Floats, sigma: float) -> tuple[Floats, Floats]:
    """Time constant, onset, levels and their covariance by curve_fit."""

    def model(t: Floats, tau: float, onset: float, before: float, after: float) -> Floats:
        rest = np.exp(-np.maximum(t - onset, 0.0) / tau)
        return before * rest + after * (1.0 - rest)

    start = [TAU_S, ONSET_S, BEFORE, AFTER]
    found = optimize.curve_fit(
        model, TIME, values, start, np.full(len(TIME), sigma), absolute_sigma=True
    )
    return np.asarray(found[0]), np.asarray(found[1])


def noisy(seed: int, sigma: float = 1.0) -> Floats:
    return speed(TIME) + sigma * np.random.default_rng(seed).standard_normal(len(TIME))


def test_values_and_covariance_are_those_of_another_fit() -> None:
    found = rise([Record(TIME, noisy(3))])
    assert found.wander == 1.0
    assert found.freedom == pytest.approx(len(TIME) - 3, abs=1)
    left = noisy(3) - found.fitted[0]
    sigma = float(np.sqrt(left @ left / (len(TIME) - 4)))
    values, covariance = by_scipy(noisy(3), sigma)
    assert found.deviations == pytest.approx([np.sqrt(np.mean(left**2))])
    mine = [found.constant_s, found.onsets[0], found.before[0], found.after[0]]
    assert mine == pytest.approx(values, rel=1e-5)
    np.testing.assert_allclose(found.covariance, covariance, rtol=0.02, atol=1e-9)
    told = found.constant_variance - found.hidden_s**2
    assert told == pytest.approx(covariance[0, 0], rel=0.02)
    assert found.onset_variance(0) == pytest.approx(covariance[1, 1], rel=0.02)
    assert found.place(0) == 3


@pytest.mark.slow
def test_two_records_share_their_time_constant_alone() -> None:
    other = 40.0 + 0.5 * speed(TIME, onset_s=0.2)
    found = rise([Record(TIME, noisy(3)), Record(TIME, other + noisy(4) - speed(TIME))])
    alone = rise([Record(TIME, noisy(3))])
    assert found.onsets == pytest.approx((ONSET_S, 0.2), abs=6e-3)
    assert found.before == pytest.approx([BEFORE, 42.5], abs=1.0)
    assert found.after == pytest.approx([AFTER, 100.0], abs=1.0)
    assert 0.0 < found.constant_variance < alone.constant_variance
    assert (found.place(0), found.place(1)) == (5, 6)
    for record, level in enumerate(found.after):
        u = float(np.sqrt(found.covariance[found.place(record), found.place(record)]))
        assert 0.03 < u < 0.3
        assert abs(level - (AFTER, 100.0)[record]) < 4.0 * u
    onsets = [found.onset_variance(k) ** 0.5 for k in (0, 1)]
    assert onsets[1] > 1.5 * onsets[0]  # half the step in the same noise


@pytest.mark.slow
def test_intervals_hold_in_noise_that_was_drawn() -> None:
    held = 0
    for seed in range(40):
        found = rise([Record(TIME, noisy(100 + seed, 2.0))])
        held += abs(found.constant_s - TAU_S) < 1.96 * np.sqrt(found.constant_variance)
    assert 33 <= held <= 40


def made(lags: list[float], covariance: Floats, onsets: tuple[float | None, ...]) -> Rise:
    count = len(onsets)
    return Rise(np.array(lags), onsets, np.zeros(count), np.zeros(count), covariance, 9,
                np.ones(count), 1.0, (), 1)  # fmt: skip


def test_figures_of_a_rise_are_taken_from_their_places() -> None:
    root = np.random.default_rng(2).standard_normal((8, 8))
    spread = root @ root.T
    found = made([0.02, 0.1], spread, (None, 0.3))
    assert found.constant_s == pytest.approx(0.12)
    assert found.constant_variance == pytest.approx(spread[:2, :2].sum())
    both = max(spread[0, 0], spread[1, 1], spread[:2, :2].sum())
    assert found.lag_variance == pytest.approx(both)
    assert found.onset_variance(1) == spread[2, 2]
    alike = np.diag([4.0, 9.0, 1.0, 1.0, 1.0])
    alike[0, 1] = alike[1, 0] = -6.0
    assert made([1.0, 1.0], alike, (None,)).lag_variance == 9.0


def test_readings_without_a_quantum_have_the_variance_of_their_residuals() -> None:
    left = np.array([1.0, -2.0, 2.0, 1.0, 0.0])
    np.testing.assert_allclose(variances(left, np.arange(5.0), 0.0, 3), np.full(5, 10.0 / 2.0))
    np.testing.assert_allclose(variances(left[:2], np.arange(2.0), 0.0, 3), [5.0, 5.0])
    exact = variances(np.zeros(4), np.array([0.0, 1.0, 2.0, 50.0]), 0.0, 2)
    np.testing.assert_allclose(exact, np.full(4, (1e-7 * 50.0) ** 2))


def test_readings_with_one_rounding_share_its_error() -> None:
    """Without noise, as many as lie within a quantum are worth one."""
    fitted = np.array([0.0, 0.1, 0.2, 1.0, 2.0, 2.1])
    found = variances(np.zeros(6), fitted, 1.0, 2)
    np.testing.assert_allclose(found, np.array([3, 3, 3, 1, 2, 2]) / 12.0)


def test_noise_makes_roundings_independent() -> None:
    fitted, quantum = np.zeros(400), 0.5
    rng = np.random.default_rng(6)
    left = 0.15 * rng.standard_normal(400)
    total = float(left @ left) / 398.0
    noise = total - quantum**2 / 12.0
    common = quantum**2 / 12.0 * np.exp(-4.0 * np.pi**2 * noise / quantum**2)
    found = variances(left, fitted, quantum, 2)
    np.testing.assert_allclose(found, 400.0 * common + (total - common))
    assert 0.05 < common / (quantum**2 / 12.0) < 0.95


def test_weights_are_worth_their_sum_over_the_largest() -> None:
    assert module._worth(np.array([1.0, 1.0, 1.0])) == 3.0
    assert module._worth(np.array([2.0, 1.0])) == pytest.approx(1.25)


@pytest.mark.slow
def test_rounded_readings_and_stamps_are_worth_less() -> None:
    exact = rise([Record(TIME, noisy(8, 0.3))])
    rounded = Record(TIME, 8.0 * np.rint(noisy(8, 0.3) / 8.0), quantum=8.0)
    coarse = rise([rounded])
    assert coarse.constant_s == pytest.approx(TAU_S, abs=4.0 * coarse.constant_variance**0.5)
    assert coarse.constant_variance > 4.0 * exact.constant_variance
    assert coarse.freedom < exact.freedom
    stamps = 0.01 * np.rint(TIME / 0.01)
    late = Record(stamps + 1e-6 * np.arange(len(TIME)) * 0.0, noisy(8, 0.3))
    kept = np.diff(late.time_s, prepend=-1.0) > 0.0
    sparse = Record(late.time_s[kept], late.values[kept])
    blurred = rise([sparse])
    assert blurred.constant_s == pytest.approx(TAU_S, abs=5.0 * blurred.constant_variance**0.5)


@pytest.mark.parametrize("ratio", [0.015, 0.03])
def test_a_winding_that_no_reading_asks_for_is_within_the_interval(ratio: float) -> None:
    """The onset takes it for a delay, and the rise is the quicker by it."""
    off = []
    for seed in range(8):
        noise = 0.6 * np.random.default_rng(seed).standard_normal(len(TIME))
        found = rise([Record(TIME, speed(TIME, np.array([TAU_S, ratio * TAU_S])) + noise)])
        assert len(found.lags) == 1
        off.append((found.constant_s / TAU_S - 1.0 - ratio) * TAU_S / found.constant_variance**0.5)
    assert max(map(abs, off)) < 3.0


def test_a_lag_that_readings_exclude_leaves_nothing_open() -> None:
    """A hundredth of the noise: a hundredth of what is usual of a winding would show."""
    noise = 0.01 * np.random.default_rng(3).standard_normal(len(TIME))
    found = rise([Record(TIME, speed(TIME) + noise)])
    assert len(found.lags) == 1
    assert found.hidden_s < 0.003 * TAU_S
