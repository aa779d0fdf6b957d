"""A log's search begins once more where it stopped, with lags in whole samples."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bench.mistakes.log_cases import lagging
from bench.mistakes.logs import STATIONS, Log, Station, answer
from bench.mistakes.plant import Drive

SHARES = (0.0, 0.4, 0.7, 0.2, -0.3, -0.6, 0.0)  # of the top speed, one after another


def speed_control(station: Station) -> Drive:
    """A controller of the speed, that holds its output between the plant's steps."""
    top, most = station.motor.top_rad_s, station.motor.volts
    kept = {"sum": 0.0, "at": 0.0}

    def drive(t: float, i: float, w: float) -> float:
        off = top * SHARES[min(int(t / station.level_s), len(SHARES) - 1)] - w
        kept["sum"] += off * max(t - kept["at"], 0.0)
        kept["at"] = t
        wish = 2 * most / top * off + most / top / (2 * station.motor.tau_s) * kept["sum"]
        return float(np.clip(wish, -most, most))

    return drive


@pytest.mark.study
def test_a_controlled_speed_with_a_current_some_samples_late(tmp_path: Path) -> None:
    """Jumps of the voltage then pass readings at once; R ended .5 %, 28 u, beside the truth."""
    station = STATIONS[0]
    log = Log(drive=speed_control, chain={"i": lagging(3)})
    found = answer(log, station, tmp_path, 3).parameters
    for name in ("R", "L", "K", "J"):
        low, high = found[name]["interval_95"]
        middle, wide = (low + high) / 2, high - low  # twice the half-width
        assert abs(getattr(station.motor, name) - middle) < wide, name
