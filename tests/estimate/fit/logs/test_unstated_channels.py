"""What derivatives say of lags and low-passes that nobody stated, before a fit has them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from motorid.estimate.fit import multistart, start_values
from motorid.estimate.fit.logs import log_fit
from motorid.estimate.fit.logs.unstated_channels import Told, told
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.rebuilt_response import rebuilt
from motorid.estimate.results.estimate import PARAMETERS
from tests.estimate.fit.logs.test_log_fit import late, logged


def plain(folder: Path, lag: int) -> tuple[list[MotorRecord], Told]:
    """A log whose speed is late, fitted with all channels as stamped; and what is told of it."""
    capture = logged(folder, **({"w": late(lag)} if lag else {}))
    records = [MotorRecord(capture, PARAMETERS, {}, "held")]
    start = start_values.start_values(records, {})
    solution = multistart.settled(records, PARAMETERS, start)
    (heard,) = told(records, solution)
    return records, heard


@pytest.mark.slow
def test_a_late_speed_is_asked_for_and_a_sound_log_is_not(tmp_path: Path) -> None:
    _, sound = plain(tmp_path, 0)
    assert not sound.asked_for
    _, spoilt = plain(tmp_path, 3)
    assert spoilt.asked_for
    assert spoilt.gain > 10.0 * spoilt.needed
    assert spoilt.unknowns == 4


def test_what_is_left_open_is_no_more_than_the_priors(tmp_path: Path) -> None:
    _, heard = plain(tmp_path, 0)
    assert len(heard.shifts) == heard.unknowns
    assert all(np.isfinite(shift).all() for shift in heard.shifts)
    assert any(shift.any() for shift in heard.shifts)


def test_more_unknowns_need_more_gain() -> None:
    none = np.zeros(6)
    assert Told(30.0, 4, 2.0, 2000, (), none).needed == pytest.approx(4 * np.log(2000))
    assert not Told(30.0, 4, 2.0, 2000, (), none).asked_for
    assert Told(31.0, 4, 2.0, 2000, (), none).asked_for
    assert not Told(31.0, 4, 0.1, 2000, (), none).asked_for


@pytest.mark.slow
def test_the_likeliest_shape_of_a_held_voltage_is_held(tmp_path: Path) -> None:
    capture = logged(tmp_path)
    records = [MotorRecord(capture, PARAMETERS, {})]
    start = start_values.start_values(records, {})
    solution = multistart.settled(records, PARAMETERS, start)
    found, best = log_fit.best(records, solution, PARAMETERS, start, {})
    assert found[0].shape == "held"
    assert best.objective < solution.objective
    assert len(found[0].rivals) == 5  # three shapes; a speed and a current of means
    assert not found[0].found


def test_a_response_of_its_own_gives_the_same_run(tmp_path: Path) -> None:
    record = MotorRecord(logged(tmp_path), PARAMETERS, {}, "held")
    own = np.array([unknown.start for unknown in record.unknowns])
    values = np.array([2.0, 2e-3, 0.05, 2e-5, 5e-5, 4e-3])
    setup = record.setup(own)
    usual = record.readings(values, own)
    other = rebuilt(record, setup, record.respond)(values, setup.initial)
    assert np.abs(other - usual).max() < 1e-9 * np.abs(usual).max()
