"""What a rise is made of, quickly: columns by closed forms, weights, covariance, a second lag."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import optimize
from scipy.signal import lfilter

from motorid.estimate.partial import exponential_fit as module
from motorid.estimate.partial.exponential_fit import Record, Rise, Start, columns, variances

Floats = NDArray[np.float64]
TAU_S, ONSET_S, BEFORE, AFTER = 0.08, 0.13, 5.0, 120.0
TIME = 0.02 + 4e-3 * np.arange(150)
ONE = np.array([TAU_S])


def risen(t: Floats, tau: float = TAU_S, onset: float = ONSET_S) -> Floats:
    return -np.expm1(-np.maximum(t - onset, 0.0) / tau)


def area(t: Floats) -> Floats:
    """Of ``risen``, from the onset."""
    since = np.maximum(t - ONSET_S, 0.0)
    return np.asarray(since - TAU_S * risen(t))


def speed(t: Floats = TIME, tau: float = TAU_S, onset: float = ONSET_S) -> Floats:
    return BEFORE + (AFTER - BEFORE) * risen(t, tau, onset)


def test_a_reading_is_a_speed_its_mean_or_the_angle_since_the_first() -> None:
    one = Record(TIME, np.zeros(150))
    assert one.quantum == 0.0
    levels = np.array([BEFORE, AFTER])
    assert columns(one, ONE, ONSET_S) @ levels == pytest.approx(speed())
    turned = BEFORE * (TIME - TIME[0]) + (AFTER - BEFORE) * area(TIME)
    angle = columns(replace(one, is_position=True), ONE, ONSET_S) @ [BEFORE, AFTER, 2.0]
    assert angle == pytest.approx(2.0 + turned)
    window = 6e-3
    mean = BEFORE + (AFTER - BEFORE) * (area(TIME) - area(TIME - window)) / window
    assert columns(replace(one, aperture_s=window), ONE, ONSET_S) @ levels == pytest.approx(mean)


@pytest.mark.parametrize(("tau", "onset"), [(2.0, 0.0), (0.01, 0.3), (0.08, 0.13)])
def test_a_search_begins_near_the_rise_however_long_it_is(tau: float, onset: float) -> None:
    """Of constants from a third of a period to five lengths, a grid of which is 1.6 apart."""
    found = module._start(Record(TIME, speed(tau=tau, onset=onset)))
    assert tau / 2.0 < found.constant_s < 2.0 * tau
    assert found.shown is bool(onset > TIME[0])
    if found.shown:
        assert found.onset_s == pytest.approx(onset, abs=0.04)


def problem(*records: Record, shown: bool = True) -> module._Problem:
    return module._Problem(records, [Start(TAU_S, ONSET_S, shown) for _ in records])


TIMES = np.array([np.log(TAU_S), ONSET_S])


def test_weights_are_of_the_readings_and_of_stamps_that_were_rounded() -> None:
    """A stamp that is off by up to half a quantum moves a reading by the slope times that."""
    rng = np.random.default_rng(3)
    stamps = 0.02 + np.cumsum(np.where(np.arange(150) % 3, 4e-3, 6e-3))
    left = 0.5 * rng.standard_normal(150)
    one = problem(Record(stamps, speed(stamps) + left))
    assert one.records[0].stamp_quantum_s == pytest.approx(2e-3)
    ((X, c),) = list(one._levels(TIMES, 1))
    fitted = X @ c
    one._weigh(TIMES, 1)
    own = variances(one.records[0].values - fitted, fitted, 0.0, 4)  # two levels, two times
    more = 1.0 / one.roots[0] ** 2 - own
    slope = np.gradient(fitted, stamps)
    assert more == pytest.approx(slope**2 * 2e-3**2 / 12.0, rel=1e-6, abs=1e-9)
    assert slope.max() > 300.0
    even = problem(Record(TIME, speed() + left))
    even._weigh(TIMES, 1)
    assert np.ptp(even.roots[0]) == 0.0


def made(lags: list[float], fitted: Floats, wander: float = 1.0) -> Rise:
    none = np.zeros(1)
    return Rise(np.array(lags), (None,), none, none, np.eye(4), 9, none, wander, (fitted,), 1)


def test_one_rise_is_better_by_the_weighed_squares_of_what_they_leave() -> None:
    one = problem(Record(TIME, np.full(150, 3.0)))
    one.roots = [np.full(150, 2.0)]
    assert one.evaluations == 0
    found = one.misfit(made([0.1], np.zeros(150)), made([0.1], np.full(150, 4.0)))
    assert found == pytest.approx(150 * 4.0 * (9.0 - 1.0))
    one._left(TIMES, 1)
    one._left(TIMES, 1)
    assert one.evaluations == 2


@pytest.mark.parametrize(
    ("second", "misfit", "told"),
    [(0.2, 41.0, True), (0.2, 39.0, False), (0.0101, 41.0, True), (0.0099, 41.0, False)],
)
def test_a_second_lag_must_be_long_and_better(
    second: float, misfit: float, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By twenty times the wandering of what it leaves, and a hundredth of the other."""
    single, double = made([0.9], np.zeros(1)), made([1.0, second], np.zeros(1), wander=2.0)

    class Told:
        evaluations = 7

        def __init__(self, records: object, starts: object) -> None: ...

        def solved(self, lags: int, near: Rise | None = None) -> Rise:
            assert (near is None) is (lags == 1)
            return single if lags == 1 else double

        def misfit(self, one: Rise, other: Rise) -> float:
            assert (one, other) == (single, double)
            return misfit

        def hidden_s(self, one: Rise) -> float:
            assert one is single
            return 0.06

    monkeypatch.setattr(module, "_Problem", Told)
    found = module.rise([Record(TIME, speed())])
    if told:
        assert found is double
    else:
        assert found.lags is single.lags
        assert found.hidden_s == pytest.approx(max(1.0 + second - 0.9, 0.06))
        assert found.evaluations == Told.evaluations


@pytest.mark.parametrize(("share", "counts"), [(0.0, True), (0.9, True), (1.1, False)])
def test_neighbours_that_follow_each_other_widen_unless_rounding_makes_them(
    share: float, counts: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Residuals of .5 rms and a quantum of so much of it."""
    monkeypatch.setattr(module, "excess", lambda *_: 1.0)
    red = lfilter([1.0], [1.0, -0.8], np.random.default_rng(4).standard_normal(150))
    one = problem(Record(TIME, speed() + 0.5 * red / red.std()))
    ((X, c),) = list(one._levels(TIMES, 1))
    left = one.records[0].values - X @ c
    quantum = share * float(np.sqrt(np.mean(left**2)))
    one.records = [replace(one.records[0], quantum=quantum)]
    found = one._rise(TIMES, 1)
    rho = float(left[1:] @ left[:-1] / (left @ left))
    assert found.wander == pytest.approx((1.0 + rho) / (1.0 - rho) if counts else 1.0)
    assert rho > 0.5
    plain = np.linalg.inv(
        one._jacobian(TIMES, 1, [(X, c)]).T[[0, 1, 2, 3]]
        @ one._jacobian(TIMES, 1, [(X, c)])[:, [0, 1, 2, 3]]
    )
    assert found.covariance[3, 3] == pytest.approx(found.wander * plain[3, 3], rel=1e-6)
    assert found.covariance[0, 0] == pytest.approx(found.wander * plain[0, 0] * TAU_S**2, rel=1e-6)


def test_levels_of_two_records_have_the_covariance_of_another_fit() -> None:
    """One time constant, and an onset and two levels of each."""

    def model(t: Floats, tau: float, *own: float) -> Floats:
        return np.concatenate([
            own[0] + (own[2] - own[0]) * risen(TIME, tau, own[1]),
            own[3] + (own[5] - own[3]) * risen(TIME, tau, own[4]),
        ])  # fmt: skip

    rng = np.random.default_rng(5)
    start = [TAU_S, BEFORE, ONSET_S, AFTER, 40.0, 0.2, 70.0]
    true = model(TIME, *start) + rng.standard_normal(300)
    both = module._Problem(
        [Record(TIME, true[:150]), Record(TIME, true[150:])],
        [Start(TAU_S, ONSET_S, True), Start(TAU_S, 0.2, True)],
    )
    found = both._rise(np.array([np.log(TAU_S), ONSET_S, 0.2]), 1)
    exact = optimize.curve_fit(
        model, np.tile(TIME, 2), true, start, np.ones(300), absolute_sigma=True
    )[1]
    order = [0, 2, 5, 1, 4, 3, 6]  # times, levels before, levels after
    wanted = np.sqrt(np.diag(exact))[order]
    assert np.sqrt(np.diag(found.covariance) / found.wander) == pytest.approx(wanted, rel=0.1)
    assert found.freedom == 300 - 3 - 4


def test_cells_of_a_quantum_are_about_its_multiples() -> None:
    """Of half a unit: .2 and -.2 round alike, .3 does not."""
    fitted = np.array([-0.2, 0.0, 0.2, 0.3, 0.7, 0.8])
    found = variances(np.zeros(6), fitted, 0.5, 2)
    assert found == pytest.approx(0.25 / 12.0 * np.array([3, 3, 3, 2, 2, 1]))
