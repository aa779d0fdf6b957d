"""Noise of a log's voltage: what it leaves in the residuals, and makes of a fault's size."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, VOLTAGE
from motorid.estimate.diagnosis import input_noise, misfit, rank, residual_remarks, score_test
from motorid.estimate.diagnosis.input_noise import InputNoise
from motorid.estimate.fit.parameter_bounds import unknowns_of
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.signals.neighbour_noise import neighbour_noise
from motorid.estimate.solver.levenberg_marquardt import maximise
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.added_noise import DRAWS
from tests.estimate.diagnosis.test_score import COURSE, OWN, SHARED, SIGMAS, N, cleared, fault, line
from tests.estimate.effects.benches import BENCHES, FAULHABER

Floats = NDArray[np.float64]

EACH = np.repeat(SIGMAS, N)  # of every reading


def record(departures: Floats, draws: Sequence[Floats] = ()) -> Any:
    """One that is left ``departures`` (2 N,), SI, and those of each draw of noise."""
    return SimpleNamespace(
        departures=lambda values, own: [departures[:N].copy(), departures[N:].copy()],
        weighed=lambda parts, filtered: parts,
        measured=["current", "position"],
        draws=[record(one) for one in draws],
    )


def heard(monkeypatch: pytest.MonkeyPatch, *records: Any) -> InputNoise:
    lines = tuple(line(np.concatenate(one.departures(None, None)) / EACH) for one in records)
    solution: Any = SimpleNamespace(
        records=lines, information=sum(one.orthogonal.T @ one.orthogonal for one in lines),
        values=np.zeros(1), own=[np.zeros(1) for _ in lines],
    )  # fmt: skip
    monkeypatch.setattr(score_test, "plain", lambda *_: solution)
    monkeypatch.setattr(input_noise, "noisier", lambda one: iter(one.draws))
    return InputNoise.of(records, solution)


def drawn(seed: int) -> Floats:
    """A change of the readings, SI, of which parameter and nuisance explain a part."""
    noise = 0.5 * np.random.default_rng(seed).standard_normal(2 * N)
    return np.asarray(EACH * (noise + 3.0 * SHARED[:, 0] - 2.0 * OWN[:, 0]))


USUAL = EACH * np.random.default_rng(1).standard_normal(2 * N)


def test_what_is_left_of_a_draw_is_what_the_fit_does_not_follow(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    one, other = drawn(2), drawn(3)
    found = heard(monkeypatch, record(USUAL, (USUAL + one, USUAL + other)))
    assert len(found.changes) == 2
    for (change,), given in zip(found.changes, (one, other), strict=True):
        assert change == pytest.approx(cleared(given / EACH), abs=1e-9)


def test_a_record_without_noise_follows_what_the_others_make_of_the_motor(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """One parameter for both, an origin for each."""
    moved = drawn(2)
    quiet, noisy = record(USUAL), record(2.0 * USUAL, (2.0 * USUAL + moved,))
    found = heard(monkeypatch, noisy, quiet)
    none = np.zeros((2 * N, 1))
    columns = np.vstack([np.hstack([SHARED, OWN, none]), np.hstack([SHARED, none, OWN])])
    change = np.r_[moved / EACH, np.zeros(2 * N)]
    left = change - columns @ np.linalg.lstsq(columns, change, rcond=None)[0]
    ((one, other),) = found.changes
    assert np.r_[one, other] == pytest.approx(left, abs=1e-9)
    assert np.abs(other).max() > 0.1


def test_a_variance_is_that_of_the_largest_draw_by_channel(monkeypatch: pytest.MonkeyPatch) -> None:
    current, position = (np.where(np.arange(2 * N) < N, *by) for by in ((1.0, 0.1), (0.1, 1.0)))
    draws = [drawn(2) * current, drawn(3) * position]
    found = heard(monkeypatch, record(USUAL), record(USUAL, [USUAL + one for one in draws]))
    lefts = EACH * np.array(found.changes)  # by draw, record and reading
    each = np.mean(lefts.reshape(2, 2, 2, N) ** 2, axis=-1)
    assert each[:, 1].argmax(axis=0).tolist() == [0, 1]
    quiet, noisy = found.variances()
    assert noisy == pytest.approx([each[0, 1, 0], each[1, 1, 1]])
    assert quiet == pytest.approx(each[:, 0].max(axis=0).tolist())


def test_a_share_is_what_draws_make_of_a_size_where_there_is_none(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Draws of -.3 and .4 A of the fault's course, and of what has nothing to do with it."""
    course = np.r_[COURSE, np.zeros(N)]
    others = [drawn(seed) for seed in (2, 3)]
    way = cleared(course / EACH)
    for other in others:
        other -= EACH * way * (way @ (other / EACH)) / (way @ way)
    moved = [size * course + other for size, other in zip((-0.3, 0.4), others, strict=True)]
    found = heard(monkeypatch, record(USUAL, [USUAL + one for one in moved]))
    rms = (0.5 * (0.3**2 + 0.4**2)) ** 0.5
    assert found.share(fault((1.0,)), np.array([2.0])) == pytest.approx(rms / 2.0)
    assert found.share(fault((1.0,)), np.array([0.5])) == pytest.approx(rms / 0.5)


def test_without_noise_there_is_neither(monkeypatch: pytest.MonkeyPatch) -> None:
    found = heard(monkeypatch, record(USUAL), record(USUAL))
    assert found.changes == ()
    assert found.variances() == []
    assert found.share(fault((1.0,)), np.array([2.0])) == 0.0


def test_a_fault_that_does_nothing_is_no_division_by_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found = heard(monkeypatch, record(USUAL, [USUAL + drawn(2)]))
    assert found.share(fault((1.0,)), np.array([0.0])) == 0.0


def log(noise_v: float) -> tuple[list[MotorRecord], Solution]:
    """A log of a simulated motor whose voltage was read with that much noise, and its fit."""
    capture, rng = BENCHES["log"](), np.random.default_rng(7)
    channels = dict(capture.channels)
    for name, sd in ((CURRENT, 2e-3), (POSITION, 2e-4), (VOLTAGE, noise_v)):
        raw = channels[name].raw + sd * rng.standard_normal(len(capture))
        channels[name] = replace(channels[name], raw=raw, resolution=0.0)
    records = [MotorRecord(replace(capture, channels=channels), PARAMETERS, {})]
    return records, maximise(unknowns_of(records, PARAMETERS, FAULHABER), records)


@pytest.mark.slow
def test_a_log_with_a_noisy_voltage_leaves_little_to_explain_and_no_fault() -> None:
    """A tenth of a volt: by neighbours alone its residuals are ten times their noise."""
    records, solution = log(0.1)
    found = InputNoise.of(records, solution)
    assert len(found.changes) == DRAWS
    left = misfit.residuals(records, solution)
    (variances,) = found.variances()
    for variance, residual in zip(variances, left[0], strict=True):
        assert 0.3 < variance / np.mean(residual**2) < 4.0  # the largest of all draws
    whole = misfit.excess(records, left)
    assert whole > 1.0
    assert misfit.excess(records, left, found.variances()) < whole / 5.0
    assert not any(trial.convincing for trial in rank.trials(records, solution, {}))
    # nor is it a lack of fit; nine times as much is
    (driven,) = input_noise.where_lacking(records, solution, left)
    assert driven == found.variances()[0]
    m, current, variance = records[0].measured[0], left[0][0], driven[0]
    assert m.block.name == CURRENT
    assert residual_remarks.lacking(records[0], m, current) > residual_remarks.OF_NEIGHBOURS
    assert residual_remarks.lacking(records[0], m, current, variance) == 0.0
    times = residual_remarks.lacking(records[0], m, 9.0 * current, variance)
    noise = np.hypot(9.0 * neighbour_noise(current, residual_remarks.ORDER), variance**0.5)
    assert times == pytest.approx(9.0 * residual_remarks.rms(m, current) / noise, rel=1e-6)


@pytest.mark.slow
def test_a_log_with_a_quiet_voltage_has_none(monkeypatch: pytest.MonkeyPatch) -> None:
    records, solution = log(0.0)
    assert InputNoise.of(records, solution).changes == ()
    left = misfit.residuals(records, solution)
    monkeypatch.setattr(InputNoise, "of", lambda *_: pytest.fail("nothing lacks anything"))
    assert input_noise.where_lacking(records, solution, left) == [[0.0] * len(left[0])]
