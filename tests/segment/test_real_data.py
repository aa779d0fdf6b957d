"""Segments of other people's measurements: what anyone sees in their plots."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from motorid.capture.model import Capture, Channel
from motorid.segment import SegmentKind, segment


def _capture(time_s: pd.Series, **columns: pd.Series) -> Capture:
    ticks = np.round(np.asarray(time_s) * 1e6).astype(np.int64)
    channels = {k: Channel(k, "", np.asarray(v, dtype=np.float64)) for k, v in columns.items()}
    return Capture(ticks, 1e6, channels)


def test_speed_bench_is_two_levels_and_a_step_between(shared_data: Path) -> None:
    table = pd.read_csv(shared_data / "speed-bench" / "Feb-09-2022--14-40-31.csv", sep=";")
    capture = _capture(table["Tempo"], current=table["Corrente"], speed=table["Velocidade"])
    found = segment(capture)
    step = int(np.flatnonzero(np.diff(table["Degrau"]))[0])
    assert [s.kind for s in found] == ["steady", "acceleration", "steady"]
    assert abs(found[1].start - step) < 50
    assert found[1].stop - found[1].start < 1000


def test_pwm_rpm_is_rest_then_a_step(shared_data: Path) -> None:
    for file in sorted((shared_data / "pwm-rpm").glob("*.csv"))[:3]:
        table = pd.read_csv(file)
        speed = table["Motor_Speed(RPM)"] * np.pi / 30
        capture = _capture(table["Timestamp(ms)"] * 1e-3, speed=speed)
        commanded = int(np.flatnonzero(np.diff(table["Commanded_PWM"]))[0]) + 1
        found = segment(capture)
        assert [s.kind for s in found] == ["rest", "acceleration", "steady"]
        assert 0 <= found[1].start - commanded < 30  # a 200 Hz loop, and stiction


def test_robotino_rests_between_its_speeds(shared_data: Path) -> None:
    file = shared_data / "robotino" / "data_for_identification_with_integral.csv"
    table = pd.read_csv(file, sep=";", skiprows=[1, 2])
    speed, target = table["1st motor velocity"], np.asarray(table["1st motor set speed"])
    capture = _capture(table["Time"] * 1e-3, speed=speed, current=table["1st motor current"])
    found = segment(capture)
    steady = [s for s in found if s.kind is SegmentKind.STEADY and s.stop - s.start > 60]
    means = [float(np.mean(speed[s.slice])) for s in steady]
    for level in sorted(set(target) - {0}):
        nearest = min(means, key=lambda mean: abs(mean - level))
        assert abs(nearest - level) < 6 + 0.06 * abs(level)
    resting = np.zeros(len(capture), dtype=bool)
    for s in found:
        resting[s.slice] |= s.kind is SegmentKind.REST
    at_zero = np.asarray(speed) == 0
    assert np.mean(resting[at_zero]) > 0.95
    assert np.mean(resting[np.abs(speed) > 20]) < 0.02
