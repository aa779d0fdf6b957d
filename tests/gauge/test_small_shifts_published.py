"""EWMA and CUSUM against published examples and published run lengths."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.cli.main import run
from motorid.errors import DataError, UsageError
from motorid.quality.small_shifts import cusum, ewma

Floats = NDArray[np.float64]
# Montgomery, Introduction to Statistical Quality Control, table 9.1: the first 20 of mean 10, the
# last 10 of mean 11, sigma 1.
SHIFTED = np.array([
    9.45, 7.99, 9.29, 11.66, 12.16, 10.18, 8.04, 11.46, 9.20, 10.34,
    9.03, 11.47, 10.51, 9.40, 10.08, 9.37, 10.62, 10.31, 8.52, 10.84,
    10.90, 9.33, 12.29, 11.50, 10.60, 11.08, 10.38, 11.62, 11.31, 10.52,
])  # fmt: skip
# Montgomery and Runger, Applied Statistics and Probability for Engineers, table 16-8: target 99,
# K = 1, H = 10.
CONCENTRATION = np.array([
    102.0, 94.8, 98.3, 98.4, 102.0, 98.5, 99.0, 97.7, 100.0, 98.1,
    101.3, 98.7, 101.1, 98.4, 97.0, 96.7, 100.3, 101.4, 97.2, 101.0,
])  # fmt: skip
ABOVE = [2.0, 0, 0, 0, 2.0, 0.5, 0, 0, 0, 0, 1.3, 0, 1.1, 0, 0, 0, 0.3, 1.7, 0, 1.0]
BELOW = [0, 3.2, 2.9, 2.5, 0, 0, 0, 0.3, 0, 0, 0, 0, 0, 0, 1.0, 2.3, 0, 0, 0.8, 0]


def test_cusum_of_the_concentrations() -> None:
    above, below = cusum(CONCENTRATION, 99.0, 2.0, slack=0.5, decision=5.0)
    assert above.points == pytest.approx(ABOVE, abs=1e-9)
    assert -below.points == pytest.approx(BELOW, abs=1e-9)
    assert (above.upper, below.lower) == (10.0, -10.0)
    assert above.alarms == below.alarms == ()


def test_cusum_of_the_shifted_process() -> None:
    """Table 9.2 with K = 1/2, H = 5: C+ is 5.28 at reading 29, and left zero at 23."""
    above, below = cusum(SHIFTED, 10.0, 1.0, slack=0.5, decision=5.0)
    assert above.points[28] == pytest.approx(5.28, abs=1e-9)
    first = above.alarms[0]
    assert (first.index + 1, first.first + 1) == (29, 23)
    assert below.alarms == ()


def test_ewma_of_the_shifted_process() -> None:
    """Example 9.2 with weight 0.1, L = 2.7: limits 9.38 and 10.62; the mean moved at reading 21."""
    chart = ewma(SHIFTED, 10.0, 1.0, weight=0.1, width=2.7)
    assert chart.points[:2] == pytest.approx((9.945, 9.7495), abs=1e-9)
    assert (round(chart.lower, 2), round(chart.upper, 2)) == (9.38, 10.62)
    shown = [alarm.index + 1 for alarm in chart.alarms]
    assert shown == [29, 30]


@pytest.mark.parametrize(("reading", "half"), [(0, 0.27), (1, 0.36)])
def test_the_first_limits_are_narrower(reading: int, half: float) -> None:
    """The same example: 9.73 and 10.27 at the first reading, 9.64 and 10.36 at the second."""
    for off, out in ((half - 0.005, False), (half + 0.005, True)):
        values = np.full(reading + 1, 10.0)
        values[reading] += off / 0.1
        chart = ewma(np.append(values, 10.0), 10.0, 1.0, weight=0.1, width=2.7)
        assert (reading in [alarm.index for alarm in chart.alarms]) is out


def run_length(out: Callable[[Floats], NDArray[np.int64]], seed: int) -> float:
    """Mean readings until the first alarm after a shift of one sigma, of 600 series."""
    rng = np.random.default_rng(seed)
    found = [out(rng.normal(1.0, 1.0, 60)) for _ in range(600)]
    return float(np.mean([one.min(initial=59) + 1 for one in found]))


@pytest.mark.slow
def test_run_lengths_after_a_shift_of_one_sigma() -> None:
    """Montgomery, tables 9.3 and 9.11: 10.4 for K = 1/2, H = 5; 10.5 for weight 0.2, L = 2.962.

    The length varies by about half of itself, so that 600 series know the mean to 0.27.
    """

    def of_cusum(values: Floats) -> NDArray[np.int64]:
        charts = cusum(values, 0.0, 1.0, decision=5.0)
        return np.array([alarm.index for chart in charts for alarm in chart.alarms], np.int64)

    def of_ewma(values: Floats) -> NDArray[np.int64]:  # the table is for the long run's limits
        chart = ewma(values, 0.0, 1.0)
        return np.flatnonzero(np.abs(chart.points) > chart.upper)

    assert run_length(of_cusum, 1) == pytest.approx(10.4, abs=1.1)
    assert run_length(of_ewma, 2) == pytest.approx(10.5, abs=1.1)


def test_what_makes_no_sense_is_refused() -> None:
    with pytest.raises(UsageError):
        ewma(SHIFTED, 10.0, 1.0, weight=0.0)
    with pytest.raises(UsageError):
        cusum(SHIFTED, 10.0, 1.0, decision=0.0)
    with pytest.raises(DataError):
        cusum(SHIFTED[:1], 10.0, 1.0)
    with pytest.raises(DataError):
        ewma(SHIFTED, 10.0, 0.0)


def test_the_command_shows_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    place = tmp_path / "readings.csv"
    rows = "\n".join(f"{x}" for x in (*SHIFTED, *(SHIFTED[:20] + 1.5)))
    place.write_text(f"R\n{rows}\n")
    call = ["trend", str(place), "--quantity", "R", "--rules", "limits", "--baseline", "20"]
    assert run([*call, "--small-shifts"]) == 1
    said = capsys.readouterr().out
    assert "CUSUM above" in said
    assert "has shifted above its target" in said
