"""Logs with one channel behind a filter: repaired where it is of second order, else doubtful."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from bench.mistakes.plant import Motor
from bench.stranger import chain
from bench.stranger.plant import Source, turn
from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.diagnosis import filter_rest
from motorid.estimate.fit.joint_fit import solved
from motorid.estimate.fit.logs import log_one_filter
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.findings import findings
from tests.six_parameters import fit

RATE, TICKS, CLOCK_HZ = 10_000.0, 8, 1e9
MOTOR = Motor(0.5, 0.5 * 1.5 / RATE, 0.038, 7e-5, 1.5e-5, 14e-3, 12.0)  # L/R of 1.5 samples
COLUMNS = ((VOLTAGE, "v", "V"), (CURRENT, "i", "A"), (SPEED, "w", "rad/s"))
NOT_STATED = frozenset({"delay", "filter", "aperture"})


@cache
def logged(column: str, kind: str, samples: float, stages: int = 1) -> Capture:
    """A log by converters of 16 bits; one column is behind so many filters."""
    rng = np.random.default_rng(8)
    volts = chain.wave("steps", MOTOR.volts, MOTOR.tau_s, RATE, rng)
    dt = 1.0 / RATE / TICKS
    true = turn(MOTOR, np.repeat(volts, TICKS), dt, Source())
    series = {"v": true.terminal, "i": true.current, "w": true.speed}
    for _ in range(stages):
        series[column] = chain.low_pass(series[column], dt, samples / RATE, kind)
    stamps = np.arange(1, len(volts)) / RATE
    spans = {"v": 1.25 * MOTOR.volts, "i": 1.3 * MOTOR.stall_a, "w": 1.3 * MOTOR.top_rad_s}
    channels = {}
    for name, one, unit in COLUMNS:
        read = chain.instants(series[one], dt, stamps, one == "v" != column)
        shown = chain.converted(read, spans[one], 16, 8.0, rng)
        channels[name] = replace(Channel(name, unit, shown), undeclared=NOT_STATED)
    return Capture(np.rint(stamps * CLOCK_HZ).astype(np.int64), CLOCK_HZ, channels)


def errors_in_u(records: list[MotorRecord], solution: Solution) -> dict[str, float]:
    """Of every parameter."""
    covariance = findings(records, solution, {}, ()).statistical.covariance
    u = np.sqrt(np.diag(covariance)) * solution.slopes
    true = np.array([MOTOR.truth[name] for name in PARAMETERS])
    return dict(zip(PARAMETERS, (solution.values - true) / u, strict=True))


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.parametrize(
    ("column", "kind", "samples"),
    [
        pytest.param("i", "2 RC", 2.5, marks=pytest.mark.study),
        pytest.param("w", "Bessel", 6.0, marks=pytest.mark.study),  # a current's: test_log_readings
    ],
)
def test_a_filter_of_second_order_is_repaired(column: str, kind: str, samples: float) -> None:
    records, solution = solved([logged(column, kind, samples)], {}, ())
    assert max(map(abs, errors_in_u(records, solution).values())) < 4.0
    if column == "i":  # one of the speed is seen as another, by a few hundredths of a per cent
        assert not filter_rest.moves(records, solution)


@pytest.mark.study
def test_what_a_filter_of_third_order_may_move_is_doubtful_or_allowed_for() -> None:
    """By filters of lower order, or by one of those and a kernel, which may do as much."""
    estimate = fit([logged("i", "RC", 4.0, stages=3)])
    named = {s.code for s in estimate.suspects if s.strength == "named"}
    assert named & {"current_filtered", "current_smoothed"}
    doubtful = {n for n, p in estimate.parameters.items() if p.status == "doubtful"}
    assert {"R", "L"} <= doubtful or "current_smoothed" in named
    for name, p in estimate.parameters.items():
        assert p.interval_95 is not None
        assert p.interval_95[0] <= MOTOR.truth[name] <= p.interval_95[1], name


@pytest.mark.slow
def test_a_channel_is_later_by_its_lag_and_its_low_pass() -> None:
    record = MotorRecord(logged("i", "RC", 2.0), PARAMETERS, {})
    record.estimate(*(log_one_filter.Instance(q) for q in log_one_filter.UNSTATED))
    sizes = {"current lag": 3e-4, "current smoothing": 1e-4, "voltage late": -2e-4}
    own = [sizes.get(one.name, 0.0) for one in record.instances]
    late = log_one_filter.later(record, own)
    assert late == pytest.approx({CURRENT: 2e-4, SPEED: -2e-4, VOLTAGE: 0.0})
