"""A log's voltage behind a low-pass about as slow as the winding, of which nobody says anything."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.mistakes.log_cases import filtered
from bench.mistakes.logs import STATIONS, Log, answer
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.unstated.voltage_smoothing import VOLTAGE_SMOOTHING
from motorid.estimate.fit import smoothed_voltage
from motorid.estimate.fit.multistart import settled
from motorid.estimate.fit.parameter_bounds import merged
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.intersample_voltage import JOINED
from tests.estimate.fit.test_log_fit import MOTOR, PERIOD_S, logged
from tests.estimate.fit.test_log_fit import smoothed as low_pass

FREE = ("R", "L", "K", "B", "J", "T0")


def joined(folder: Path, **spoilt: Any) -> MotorRecord:
    """A record of the log, its voltage joined by straight lines."""
    return MotorRecord(logged(folder, **spoilt), FREE, {}, JOINED)


@pytest.mark.parametrize("samples", [0.7, 2.0, 6.0])
def test_readings_go_on_after_a_jump_as_an_exponential_does(samples: float, tmp_path: Path) -> None:
    record = joined(tmp_path, v=low_pass(samples))
    found = smoothed_voltage._goes_on(record)
    assert found == pytest.approx(np.exp(-1.0 / samples), abs=0.08)


def test_where_it_jumps_at_once_nothing_is_tried(tmp_path: Path) -> None:
    record = joined(tmp_path)
    assert abs(smoothed_voltage._goes_on(record)) < 0.02
    assert smoothed_voltage.begun([record], None, FREE, {}, {}) == []  # type: ignore[arg-type]


@pytest.mark.slow
def test_the_likeliest_start_ends_at_the_low_pass_and_the_motor(tmp_path: Path) -> None:
    record = joined(tmp_path, v=low_pass(2.0))
    start = {name: 0.9 * getattr(MOTOR, name) for name in FREE}
    solution = settled([record], FREE, start)
    found = smoothed_voltage.begun([record], solution, FREE, merged(start, solution), {})
    (best,), ended = min(found, key=lambda fit: fit[1].objective)
    size_s = ended.own[0][best.instances.index(Instance(VOLTAGE_SMOOTHING))]
    assert size_s == pytest.approx(2.0 * PERIOD_S, rel=0.1)
    for name in ("R", "K", "J"):
        assert merged(start, ended)[name] == pytest.approx(getattr(MOTOR, name), rel=0.01), name


@pytest.mark.slow
def test_a_voltage_as_slow_as_the_winding(tmp_path: Path) -> None:
    """Two low-passes of 1 ms beside L/R of 4 ms: R was .8 %, 3 half-widths, and L 7 % off."""
    station = STATIONS[2]
    found = answer(Log(chain={"v": filtered(1, 2)}), station, tmp_path, 1).parameters
    for name in ("R", "L", "K", "J"):
        low, high = found[name]["interval_95"]
        middle, wide = (low + high) / 2, high - low  # twice the half-width
        assert abs(getattr(station.motor, name) - middle) < wide, name
    assert abs(found["R"]["value"] / station.motor.R - 1.0) < 5e-3


def test_an_inductance_that_is_given_begins_no_search_for_it(tmp_path: Path) -> None:
    record, held = joined(tmp_path, v=low_pass(2.0)), tuple(n for n in FREE if n != "L")
    assert smoothed_voltage.begun([record], None, held, {}, {"L": 1e-3}) == []  # type: ignore[arg-type]
