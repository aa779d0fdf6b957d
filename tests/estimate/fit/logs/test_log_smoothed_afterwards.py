"""Logs whose readings were smoothed afterwards: named, and the motor right or doubtful."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from scipy.ndimage import uniform_filter1d
from scipy.signal import butter, filtfilt, savgol_filter

from bench.mistakes.logs import MAPS, STATIONS, Floats, Log, Station, table, text
from motorid.capture.table import read_table
from motorid.estimate.results.estimate import PARAMETERS, Estimate
from motorid.estimate.results.status import Status
from tests.six_parameters import fit

MEDIUM = STATIONS[1]
Smoothing = Callable[[Floats], Floats]
BUTTERWORTH = butter(2, 0.2)
NORMAL_95 = 1.96


def estimate(folder: Path, column: str, smoothing: Smoothing, station: Station) -> Estimate:
    """What a fit says of a log of which one column was smoothed."""
    columns = table(Log(), station, seed=0)
    columns[column] = smoothing(columns[column])
    path = folder / "log.csv"
    path.write_text(text(columns), encoding="utf-8")
    return fit([read_table(path, [f"{q}={name}" for q, name in MAPS.items()])])


def off(found: Estimate, station: Station) -> dict[str, float]:
    """Errors in standard uncertainties."""
    errors = {}
    for name in PARAMETERS:
        p = found.parameters[name]
        if p.value is not None and p.interval_95 is not None:
            half = (p.interval_95[1] - p.interval_95[0]) / 2.0
            errors[name] = NORMAL_95 * (p.value - getattr(station.motor, name)) / half
    return errors


@pytest.mark.slow
@pytest.mark.parametrize("window", [5, pytest.param(15, marks=pytest.mark.study)])
def test_a_savitzky_golay_filter_is_repaired(tmp_path: Path, window: int) -> None:
    found = estimate(tmp_path, "i", partial(savgol_filter, window_length=window, polyorder=3),
                     MEDIUM)  # fmt: skip
    named = next(one for one in found.suspects if one.strength == "named")
    assert named.code == "current_smoothed"
    assert named.allowed
    assert f"({window} readings wide)" in named.evidence
    assert "Savitzky-Golay" in named.evidence
    assert max(map(abs, off(found, MEDIUM).values())) < 3.0
    inductance = found.parameters["L"]
    assert inductance.status is Status.ESTIMATED
    assert inductance.value == pytest.approx(MEDIUM.motor.L, rel=0.02)
    assert not any(one.severity == "warning" for one in found.diagnostics)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("column", "smoothing"),
    [
        pytest.param("i", lambda y: filtfilt(*BUTTERWORTH, y), marks=pytest.mark.study),
        ("w", lambda y: filtfilt(*BUTTERWORTH, y)),
        pytest.param(
            "w", lambda y: uniform_filter1d(y, 15, mode="nearest"), marks=pytest.mark.study
        ),
    ],
)
def test_none_is_wrong_in_silence(tmp_path: Path, column: str, smoothing: Smoothing) -> None:
    found = estimate(tmp_path, column, smoothing, MEDIUM)
    assert max(map(abs, off(found, MEDIUM).values())) < 4.0


@pytest.mark.slow
@pytest.mark.parametrize(
    "station", [pytest.param(STATIONS[0], marks=pytest.mark.study), MEDIUM], ids=lambda s: s.name
)
def test_a_log_as_recorded_is_not_said_to_be_smoothed(tmp_path: Path, station: Station) -> None:
    found = estimate(tmp_path, "i", np.asarray, station)
    assert not [one for one in found.suspects if one.strength == "named"]
    assert not [one for one in found.diagnostics if one.code == "lack_of_fit"]
