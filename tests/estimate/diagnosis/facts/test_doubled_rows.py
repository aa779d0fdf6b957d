"""Rows that stand twice are named; readings that repeat for another reason are not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture
from motorid.estimate.diagnosis.facts.doubled_rows import findings
from motorid.estimate.results.estimate import Parameter
from motorid.estimate.results.status import Status
from tests.estimate.diagnosis.facts.made_log import MOTOR, log, rounded, rows

PARAMETERS = {
    n: Parameter(n, "", v, 0.0, 0.0, 0.01 * v, None, Status.ESTIMATED) for n, v in MOTOR.items()
}


def twice(count: int, share: float) -> NDArray[np.intp]:
    """Places of rows of which that share stands twice."""
    chosen = np.random.default_rng(3).random(count) < share
    return np.repeat(np.arange(count), 1 + chosen)


@pytest.mark.parametrize("bits", [0, 12, 14])
def test_rows_that_stand_twice_are_named(bits: int) -> None:
    capture = rounded(log(), bits)
    places = twice(len(capture), 0.05)
    (said,) = findings(rows(capture, places), PARAMETERS)
    assert said.severity == "error"
    assert "rows stand twice" in said.message
    assert said.moves["J"] > 0.05 * MOTOR["J"] * 0.5
    assert said.moves["L"] > 0.0
    assert all(said.moves[name] < MOTOR[name] for name in ("J", "L"))  # a part of a value


@pytest.mark.parametrize("bits", [0, 6, 8, 10, 12])
@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_a_coarse_log_is_not_accused(bits: int, noise: float) -> None:
    assert list(findings(rounded(log(noise), bits), PARAMETERS)) == []


@pytest.mark.parametrize("share", [0.02, 0.3])
def test_readings_that_wait_and_catch_up_are_not_accused(share: float) -> None:
    capture = log()
    waits = np.random.default_rng(5).random(len(capture)) < share
    latest = np.maximum.accumulate(np.where(waits, 0, np.arange(len(capture))))
    assert list(findings(rows(capture, latest), PARAMETERS)) == []


@pytest.mark.parametrize("times", [2, 3])
def test_a_logger_faster_than_its_source_is_not_accused(times: int) -> None:
    capture = log()
    latest = np.arange(len(capture)) // times * times
    assert list(findings(rows(capture, latest), PARAMETERS)) == []


def test_rows_that_stand_twice_under_one_stamp_take_no_time() -> None:
    capture = log()
    places = twice(len(capture), 0.05)
    stamped = replace(rows(capture, places), ticks=capture.ticks[places])
    assert list(findings(stamped, PARAMETERS)) == []


def test_without_parameters_the_size_stays_open() -> None:
    capture = log()
    spoiled: Capture = rows(capture, twice(len(capture), 0.05))
    assert {VOLTAGE, CURRENT, SPEED} <= set(spoiled.channels)
    only_j = {"J": PARAMETERS["J"]}
    (said,) = findings(spoiled, only_j)
    assert said.moves["J"] == np.inf
