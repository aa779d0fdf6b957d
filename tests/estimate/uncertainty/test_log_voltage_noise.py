"""Noise of a log's voltage, against fits of logs that really had more of it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.fit.multistart import settled
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.signals.voltage_jumps import scatter
from motorid.estimate.solver.levenberg_marquardt import maximise
from motorid.estimate.solver.problem import Block, Linearised, Solution, Unknown
from motorid.estimate.uncertainty import added_noise, log_voltage_noise
from motorid.estimate.uncertainty.covariance import covariance_of
from motorid.estimate.uncertainty.errors_in_variables import hidden, with_errors
from tests.estimate.effects.benches import measured

Floats = NDArray[np.float64]

R, L, K, B, J, T0 = 2.0, 1e-3, 0.02, 1e-6, 1e-5, 1e-3
PERIOD_S, COUNT, FINE = 2e-4, 3000, 20
NOISE_V = 0.1
TRUE = dict(zip(PARAMETERS, (R, L, K, B, J, T0), strict=True))


def turned() -> tuple[Floats, Floats, Floats]:
    """Volts, amperes and rad/s (COUNT,) of a motor under a sine, by small steps of Euler's."""
    h = PERIOD_S / FINE
    volts = 6.0 * np.sin(2.0 * np.pi * 8.0 * h * np.arange(COUNT * FINE))
    out, i, w = np.empty((2, COUNT)), 0.0, 0.0
    for n, v in enumerate(volts.tolist()):
        if n % FINE == 0:
            out[:, n // FINE] = i, w
        torque = K * i
        dry = T0 * np.sign(w) if w else max(-T0, min(T0, torque))
        i, before = i + h * (v - R * i - K * w) / L, w
        w += h * (torque - B * w - dry) / J
        w = 0.0 if w * before < 0.0 and abs(torque) < T0 else w
    return volts[::FINE], out[0], out[1]


@cache
def log(noise_v: float) -> Capture:
    """What a logger keeps of it, the voltage with that much noise."""
    rng = np.random.default_rng(7)
    columns = (VOLTAGE, "V", noise_v), (CURRENT, "A", 0.01), (SPEED, "rad/s", 0.2)
    channels = {
        name: Channel(name, unit, values + sd * rng.standard_normal(COUNT))
        for (name, unit, sd), values in zip(columns, turned(), strict=True)
    }
    return Capture(np.arange(COUNT) * 200, 1e6, channels)


def fitted(capture: Capture) -> tuple[MotorRecord, Solution]:
    record = MotorRecord(capture, PARAMETERS, {})
    return record, settled([record], PARAMETERS, TRUE)


def shaken(capture: Capture, seed: int) -> Capture:
    """With as much noise of the voltage once more."""
    volts = capture.channels[VOLTAGE]
    noise = scatter(volts.values) * np.random.default_rng(seed).standard_normal(len(volts.raw))
    return replace(
        capture, channels={**capture.channels, VOLTAGE: replace(volts, raw=volts.raw + noise)}
    )


def deviations(said: list[log_voltage_noise.Step]) -> Floats:
    return np.asarray(np.sqrt(np.sum([one.shared**2 for one in said], axis=0)))


@pytest.mark.slow
def test_steps_are_as_large_as_those_of_fits_with_more_noise() -> None:
    """Under one sine L and a lag are nearly one: what seems to tell them apart is the noise."""
    capture = log(NOISE_V)
    record, usual = fitted(capture)
    said = deviations(list(log_voltage_noise.steps(0, record, usual)))
    others = [fitted(shaken(capture, seed))[1] for seed in range(8)]
    moved = np.array([(o.values - usual.values) / usual.slopes for o in others])
    found = np.sqrt(np.mean(moved**2, axis=0))
    noise = np.sqrt(np.diag(usual.covariance))
    assert (found / noise)[:2].min() > 5.0  # far beyond what residuals tell of R and L
    ratio = (said / found)[:2]  # of eight draws each, whose searches end in several valleys
    assert ratio.min() > 0.2
    assert ratio.max() < 5.0
    assert (said / noise)[:2].min() > 5.0
    away = (np.array(list(TRUE.values())) / usual.values)[:2]
    assert (np.abs(np.log(away)) < 3.0 * said[:2]).all()  # the truth is within their reach


@pytest.mark.slow
def test_what_they_do_stands_in_the_budget_and_in_the_lags() -> None:
    record, usual = fitted(log(NOISE_V))
    errors = hidden(usual, [record])
    assert len(errors) == added_noise.DRAWS
    place = [one.name for one in record.instances].index("voltage late")
    before, after = (s.own_covariance[0][place, place] for s in (usual, with_errors(usual, errors)))
    assert after == pytest.approx(before + sum(one.own[place] ** 2 for one in errors))
    assert after > 9.0 * before
    assert abs(usual.own[0][place]) < 3.0 * np.sqrt(after)  # it has none


@pytest.mark.slow
def test_a_quiet_voltage_moves_nothing() -> None:
    record, usual = fitted(log(0.0))
    moved = deviations(list(log_voltage_noise.steps(0, record, usual)))
    assert (moved < 0.3 * np.sqrt(np.diag(usual.covariance))).all()


@pytest.mark.slow
def test_a_record_with_a_program_has_none() -> None:
    record = MotorRecord(measured(), PARAMETERS, {})
    solution = settled([record], PARAMETERS, TRUE)
    assert list(log_voltage_noise.steps(0, record, solution)) == []


def linearised(rows: Floats, sigma: float) -> Linearised:
    """A record of one channel with these derivatives (n, p), without nuisances that explain any."""
    n = len(rows)
    return Linearised(
        np.arange(float(n)), rows, np.ones((n, 1)), rows, np.zeros(1), (), (slice(0, n),),
        np.full(1, sigma),
    )  # fmt: skip


@pytest.mark.parametrize("share", [0.2, 0.49, 0.51, 1.0, 100.0])
def test_a_step_is_at_most_three_times_that_under_more_noise(share: float) -> None:
    """Of two directions, one that noise tells nothing of, and one of which it tells a share."""
    rows = np.eye(4)[:, :2] * [2.0, 3.0]
    usual = linearised(rows, 1.0)
    more = np.eye(4)[:, 2:] * [0.0, 3.0 * share**0.5]
    line = log_voltage_noise._in_units_of(usual, linearised((rows + more) / 2.0, 2.0))
    inverse, grown = log_voltage_noise._without_what_noise_tells(
        rows.T @ rows, usual, [line, line], np.arange(2)
    )
    most = 3.0 / (9.0 + 9.0 * share)
    expected = 1.0 / (9.0 - 9.0 * share) if share < 0.5 else most
    assert expected <= most
    np.testing.assert_allclose(inverse, np.diag([1.0 / 4.0, expected]), atol=1e-12)
    growth = min((1.0 + share) / (1.0 - share), 2.0) if share < 1.0 else 2.0  # of a search's
    np.testing.assert_allclose(grown, np.diag([1.0, growth]), atol=1e-12)


def test_an_unknown_that_is_held_has_no_part_in_what_noise_tells() -> None:
    """The first, of which a draw makes much; the other two are told as if it were known."""
    rows = np.eye(6)[:, :3] * [1e-9, 2.0, 3.0] + 0.5 * np.eye(6)[:, [3, 3, 3]] * [0.0, 1.0, 1.0]
    noisy = rows + np.eye(6)[:, [4, 5, 5]] * [1e3, 0.0, 0.1]
    usual, line = linearised(rows, 1.0), linearised(noisy, 1.0)
    information = rows.T @ rows
    inverse, _ = log_voltage_noise._without_what_noise_tells(
        information, usual, [line], np.array([1, 2])
    )
    told = information[1:, 1:] - np.diag([0.0, 0.01])
    np.testing.assert_allclose(inverse, np.linalg.inv(told), rtol=1e-9)


def test_residuals_and_derivatives_are_put_into_the_units_of_another() -> None:
    """Of two channels, of which a draw makes the second three times as noisy."""
    rows = np.random.default_rng(3).standard_normal((5, 2))
    usual = replace(linearised(rows, 1.0), sigmas=np.array([0.5, 2.0]))
    parts = (slice(0, 2), slice(2, 5))
    line = replace(linearised(rows, 1.0), sigmas=np.array([0.5, 6.0]), slices=parts)
    found = log_voltage_noise._in_units_of(usual, line)
    times = np.repeat([1.0, 3.0], [2, 3])
    assert found.residual == pytest.approx(times * line.residual)
    for name in ("shared", "own", "orthogonal"):
        assert getattr(found, name) == pytest.approx(times[:, None] * getattr(line, name))


# steps by themselves: readings that are linear in all that moves them


ROWS = (60, 40)  # readings of two channels
APART_SD = np.repeat([0.5, 4.0], ROWS)  # their noise
WAYS = np.random.default_rng(5).standard_normal((2, 100)) * APART_SD  # of two parameters
ORIGIN = np.r_[np.zeros(ROWS[0]), np.ones(ROWS[1])]


class Linear:
    """A record whose readings are linear in ``size`` (by its logarithm where it has one), in a
    second parameter, and in an origin of its own.
    """

    simulated = 0
    blocks = tuple(Block(n, 1e-9, m, n) for n, m in zip(("current", "position"), ROWS, strict=True))

    def __init__(self, ways: Floats, log: bool, measured: Floats) -> None:
        self.ways, self.log, self.measured = ways, log, measured
        self.unknowns: tuple[Unknown, ...] = (Unknown("origin", 0.0),)

    def residuals(self, shared: Floats, own: Floats) -> list[Floats]:
        size = np.log(shared[0]) if self.log else shared[0]
        left = self.measured - size * self.ways[0] - shared[1] * self.ways[1] - own[0] * ORIGIN
        return np.split(left, [ROWS[0]])

    def foresee(self, points: object) -> None:
        """Nothing is quicker at once."""

    def twin(self) -> Linear:
        return Linear(self.ways, self.log, self.measured)


def stepped(
    monkeypatch: pytest.MonkeyPatch, deviation: float, log: bool = True, loud: float = 1.0
) -> tuple[list[log_voltage_noise.Step], list[Floats], Solution, Floats]:
    """Steps by two draws, their changes (n,) of the readings, the usual solution, the columns
    (n, 3) of what it moves. Its first parameter has that standard deviation. The second channel has
    more noise in a draw than it has else; ``loud``: times as much, of both.
    """
    noise = APART_SD * np.random.default_rng(6).standard_normal(100)
    ways = WAYS.copy()
    for _ in range(2):  # a smaller column leaves more open
        measured = 0.5 * ways[0] + 0.2 * ways[1] + noise
        usual = Linear(ways, log, measured)
        unknowns = [Unknown("size", 1.0, log=log), Unknown("other", 0.0)]
        solution = maximise(unknowns, [usual], enough=1e-9)  # type: ignore[list-item]
        ways[0] *= covariance_of(solution.information)[0, 0] ** 0.5 / deviation
    rng = np.random.default_rng(9)
    noises = np.repeat([0.3 * loud, 9.0 * loud], ROWS)
    changes = [noises * rng.standard_normal(100) for _ in range(2)]
    draws = [Linear(usual.ways, log, measured + change) for change in changes]
    monkeypatch.setattr(log_voltage_noise, "noisier", lambda _: iter(draws))
    steps = list(log_voltage_noise.steps(0, usual, solution))  # type: ignore[arg-type]
    return steps, changes, solution, np.array([*usual.ways, ORIGIN]).T


def refitted(columns: Floats, change: Floats, solution: Solution) -> Floats:
    """How far least squares with the usual weights go with a change (n,) of the readings."""
    sigma = np.repeat(solution.records[0].sigmas, ROWS)
    found = np.linalg.lstsq(columns / sigma[:, None], change / sigma, rcond=None)[0]
    return np.asarray(found)


def test_a_step_is_that_of_a_fit_with_the_usual_weights(monkeypatch: pytest.MonkeyPatch) -> None:
    """By a draw's own the channel that it makes noisy would hardly count."""
    steps, changes, solution, columns = stepped(monkeypatch, 0.1)
    for step, change in zip(steps, changes, strict=True):
        assert np.std(change[ROWS[0] :]) > 2.0 * solution.records[0].sigmas[1]
        expected = refitted(columns, change, solution) / 2.0**0.5
        assert np.r_[step.shared, step.own] == pytest.approx(expected, rel=1e-4)
        weighed = -change / np.repeat(solution.records[0].sigmas, ROWS) / 2.0**0.5
        assert step.change == pytest.approx(weighed, rel=1e-6)


@pytest.mark.parametrize(
    ("share", "log", "moves"), [(0.97, True, True), (1.03, True, False), (1.03, False, True)]
)
def test_a_logarithm_that_is_open_does_not_move(
    share: float, log: bool, moves: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The others move as they do where it is held. Differences tell little of one that is open."""
    deviation = share * log_voltage_noise.OPEN
    steps, changes, solution, columns = stepped(monkeypatch, deviation, log)
    assert covariance_of(solution.information)[0, 0] ** 0.5 == pytest.approx(deviation, rel=0.02)
    for step, change in zip(steps, changes, strict=True):
        if moves:
            expected = refitted(columns, change, solution)
        else:
            expected = np.r_[0.0, refitted(columns[:, 1:], change, solution)]
            assert step.shared[0] == 0.0
        assert np.r_[step.shared, step.own] == pytest.approx(expected / 2.0**0.5, rel=1e-3)


def two_logs() -> tuple[list[Linear], Solution]:
    """Of one group, so that one weight serves both, though the second is ten times as noisy."""
    rng, logs = np.random.default_rng(6), list[Linear]()
    for times in (1.0, 10.0):
        ways = APART_SD * rng.standard_normal((2, 100))
        noise = times * APART_SD * rng.standard_normal(100)
        logs.append(Linear(ways, False, 0.5 * ways[0] + 0.2 * ways[1] + noise))
    unknowns = [Unknown("size", 1.0), Unknown("other", 0.0)]
    return logs, maximise(unknowns, logs, enough=1e-9)  # type: ignore[arg-type]


def test_a_far_step_of_a_lone_log_is_that_of_a_fit_of_its_own(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With the weights that so noisy a log has, to a tenth of its deviations."""
    rng = np.random.default_rng(6)
    usual = Linear(WAYS, False, 0.5 * WAYS[0] + 0.2 * WAYS[1] + APART_SD * rng.standard_normal(100))
    unknowns = [Unknown("size", 1.0), Unknown("other", 0.0)]
    solution = maximise(unknowns, [usual], enough=1e-9)  # type: ignore[list-item]
    change = np.repeat([6.0, 180.0], ROWS) * rng.standard_normal(100)
    by_usual = refitted(np.array([*WAYS, ORIGIN]).T, change, solution)
    assert by_usual[:2] @ solution.information @ by_usual[:2] > log_voltage_noise.FAR**2
    noisy = Linear(WAYS, False, usual.measured + change)
    far = [Unknown("size", -9.0), Unknown("other", 7.0)]
    found = maximise(far, [noisy.twin()], enough=1e-9)  # type: ignore[list-item]
    monkeypatch.setattr(log_voltage_noise, "noisier", lambda _: iter([noisy]))
    (step,) = log_voltage_noise.steps(0, usual, solution)  # type: ignore[arg-type]
    moved = np.r_[found.values - solution.values, found.own[0] - solution.own[0]]
    deviations = np.sqrt(np.r_[np.diag(found.covariance), np.diag(found.own_covariance[0])])
    off = np.abs(np.r_[step.shared, step.own] - moved) / deviations
    assert off.max() < 0.1
    assert (np.abs(by_usual - moved) / deviations).max() > 2.0


@pytest.mark.parametrize("loud", [1.0, 300.0])  # far or not
@pytest.mark.parametrize("k", [0, 1])
def test_a_step_of_one_of_two_logs_is_that_of_a_fit_of_both(
    k: int, loud: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By weights of its own the quiet one would pull seven times as much."""
    logs, solution = two_logs()
    sigma = np.repeat(solution.records[k].sigmas, ROWS)
    assert sigma / APART_SD == pytest.approx(np.full(100, 50.5**0.5), rel=0.2)
    change = loud * APART_SD * np.random.default_rng(9).standard_normal(100)
    draw = Linear(logs[k].ways, False, logs[k].measured + change)
    monkeypatch.setattr(log_voltage_noise, "noisier", lambda _: iter([draw]))
    (step,) = log_voltage_noise.steps(k, logs[k], solution)  # type: ignore[arg-type]
    columns = np.zeros((4, 2, 100))  # two parameters and an origin of each log, by log
    for n, one in enumerate(logs):
        columns[:2, n], columns[2 + n, n] = one.ways, ORIGIN
    changes = np.zeros((2, 100))
    changes[k] = change / sigma
    whole = (columns / sigma).reshape(4, 200).T
    expected = np.linalg.lstsq(whole, changes.reshape(200), rcond=None)[0]
    assert np.r_[step.shared, step.own] == pytest.approx(expected[[0, 1, 2 + k]], rel=1e-4)
    assert step.change == pytest.approx(-change / sigma, rel=1e-6)
