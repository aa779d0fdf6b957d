"""Logs of motors that cog: the order is found, and the budget has what none shows."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.estimate.diagnosis.refit import plain
from motorid.estimate.effects.rotor.cogging import COGGING
from motorid.estimate.fit.joint_fit import solved
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty import cogging_of_logs
from motorid.estimate.uncertainty.findings import findings
from tests.estimate.logs_with_effects import TRUTH, logged
from tests.exact_capture import FAULHABER, clean_capture, noisy

Fit = tuple[list[MotorRecord], Solution]
COGS = (("cogging", 0.7 * TRUTH["T0"]), ("cogging_per_turn", 20.0))


@pytest.fixture(scope="module")
def cogged() -> Fit:
    return solved([logged(*COGS)], {}, ())


@pytest.fixture(scope="module")
def smooth() -> Fit:
    return solved([logged()], {}, ())


def _inertia(fit: Fit) -> tuple[float, float, float]:
    """Error of J, its u without the line, and the line's part of that: all of J."""
    found = findings(*fit, {}, ())
    k = [u.name for u in fit[1].unknowns].index("J")
    line = float(np.sqrt(found.statistical.lines[COGGING.name][k]))
    total = found.statistical.deviations[k]
    return fit[1].values[k] / TRUTH["J"] - 1.0, float(np.sqrt(total**2 - line**2)), line


@pytest.mark.slow
def test_the_order_that_explains_most_is_the_true_one(cogged: Fit) -> None:
    records, solution = cogged
    white = plain(records, solution)
    at = [(solution.values, own) for own in solution.own]
    assert cogging_of_logs.strongest(records, at, white)[0] == 20


@pytest.mark.slow
def test_an_inertia_that_cogging_moves_is_covered(cogged: Fit, smooth: Fit) -> None:
    error, rest, line = _inertia(cogged)
    assert abs(error) < 3.0 * np.hypot(rest, line)
    assert line > 2.0 * _inertia(smooth)[2]  # by what the readings say of it


@pytest.mark.slow
def test_a_log_that_tells_of_none_is_hardly_wider(smooth: Fit) -> None:
    error, rest, line = _inertia(smooth)
    assert abs(error) < 3.0 * np.hypot(rest, line)
    assert 0.0 < line < 1.5 * rest


def test_captures_with_a_program_have_no_such_line() -> None:
    capture = noisy(clean_capture(FAULHABER), 1, 1e-3, 1e-4)
    record = MotorRecord(capture, ("R",), FAULHABER)
    assert not cogging_of_logs._are_logs([record])
