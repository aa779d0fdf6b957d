"""The grid of a log: finer than its samples, which lie between two ticks."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import VOLTAGE, Channel, Gap
from motorid.errors import DataError
from motorid.estimate.signals.time_grid import FINER, FINEST, JUMPED_TICKS, Part, lay
from tests.estimate.signals.test_time_grid import EVEN, capture


def test_the_grid_of_a_log_is_finer_than_its_samples() -> None:
    line = lay(capture(EVEN))
    assert line.period_s == pytest.approx(1e-4 / FINER)
    assert line.index.tolist() == [4 * k for k in range(40)]
    assert line.count == 4 * 39 + 2
    assert line.past == pytest.approx(np.zeros(40), abs=1e-9)
    assert line.parts == (Part(0, line.count),)
    assert line.coarser == pytest.approx(1.0)
    assert line.driven.all()


def test_a_reading_between_two_ticks_says_by_how_much_it_is_past_the_first() -> None:
    ticks = EVEN.copy()
    ticks[5] += 10  # of 25 µs
    line = lay(capture(ticks))
    assert line.past is not None
    scale = line.period_s * 1e6
    assert line.index + line.past == pytest.approx(ticks / scale)
    assert (line.past >= -1e-5).all()
    assert (line.past < 1.0).all()


def test_quick_stamps_of_a_log_make_its_grid_finer_as_far_as_its_work_allows() -> None:
    quick = np.cumsum(np.where(np.arange(200) % 10 == 0, 20, 100))
    line = lay(capture(quick - quick[0]))
    assert line.period_s == pytest.approx(20e-6 / 2)
    very = np.cumsum(np.where(np.arange(200) % 10 == 0, 3, 1000))
    bounded = lay(capture(very - very[0]))
    assert bounded.count <= 100 * 200 + 2
    assert bounded.coarser == pytest.approx(bounded.period_s / 1.5e-6)
    assert bounded.coarser > 5.0


def test_the_gaps_of_a_log_are_lost_samples() -> None:
    one = capture(EVEN)
    gaps = (Gap(3, 5, "pause"), Gap(9, 2, "pause"))
    assert lay(replace(one, gaps=gaps)).lost == 7
    back = EVEN.copy()
    back[7] = back[6] - 10
    with pytest.raises(DataError, match="do not advance"):
        lay(capture(back))


def means(**facts: Any) -> Channel:
    stated: dict[str, Any] = {"kind": "mean", "aperture_s": 1e-4, **facts}
    return Channel(VOLTAGE, "V", np.repeat([1.0, 3.0], 20), **stated)


def test_a_log_whose_voltage_is_told_throughout_needs_no_finer_grid() -> None:
    assert lay(capture(EVEN, **{VOLTAGE: means()})).period_s == 1e-4
    moves = lay(capture(EVEN, **{VOLTAGE: means()}), moving=True)  # and jumps
    assert moves.period_s == pytest.approx(1e-4 / FINEST)
    calm = replace(means(), raw=np.r_[np.nan, np.ones(39)])
    assert lay(capture(EVEN, **{VOLTAGE: calm})).period_s == pytest.approx(1e-4 / FINER)
    for other in (
        means(kind="instant"), means(aperture_s=0.95e-4), means(delay_s=3e-6),
        means(undeclared=("delay",)),
        replace(means(), raw=np.r_[np.ones(20), 2.2, 3.0 * np.ones(19)]),  # it jumped in that time
    ):  # fmt: skip
        assert lay(capture(EVEN, **{VOLTAGE: other})).period_s == pytest.approx(1e-4 / FINEST)
    assert lay(capture(EVEN, **{VOLTAGE: means(aperture_s=0.99e-4)})).period_s == 1e-4


@pytest.mark.parametrize(
    ("readings", "ticks"), [(6400, FINEST), (6401, FINEST - 1), (11000, 5), (20000, 4)]
)
def test_a_voltage_that_jumps_asks_for_a_grid_as_fine_as_its_length_allows(
    readings: int, ticks: int
) -> None:
    """Whole ticks, so that a reading lies on one."""
    stamps = 100 * np.arange(readings)
    jumped = Channel(VOLTAGE, "V", np.repeat([0.0, 5.0], [99, readings - 99]))
    assert ticks == min(max(JUMPED_TICKS // readings, 4), FINEST)
    assert lay(capture(stamps, **{VOLTAGE: jumped})).period_s == pytest.approx(1e-4 / ticks)
    assert lay(capture(stamps, **{VOLTAGE: jumped}), True).period_s == pytest.approx(1e-4 / FINER)
    mean = replace(jumped, kind="mean", aperture_s=0.9e-4)
    assert lay(capture(stamps, **{VOLTAGE: mean}), True).period_s == pytest.approx(1e-4 / ticks)
    smooth = replace(jumped, raw=np.sin(np.arange(readings) / 50.0))
    assert lay(capture(stamps, **{VOLTAGE: smooth})).period_s == pytest.approx(1e-4 / FINER)
