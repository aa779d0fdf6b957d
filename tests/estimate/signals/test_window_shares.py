"""What a filter's remnant takes of the first readings after a command, by exponentials written out.

A window of a second, or an instant, behind a filter of half a second: k seconds after a command
exp(-2 k) of an instant is of the command before.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import quad

from motorid.capture.model import VOLTAGE, Channel
from motorid.estimate.signals.time_grid import Part, Timeline
from motorid.estimate.signals.voltage_window import EDGE, Window
from motorid.motor.reading import Output, Quantity

Floats = NDArray[np.float64]
TAU = 0.5
INSTANT = Window(1.0, 0.0, TAU, TAU)  # its delay is the filter's
EARLIER = (1.0, 2.0, 3.0, 4.0, 7.0)


def line(*edges: int) -> Timeline:
    parts = tuple(Part(a, b) for a, b in pairwise(edges))
    return Timeline(1.0, edges[-1], np.arange(edges[-1]), parts, 0.0)


def shown(earlier: tuple[float, ...], level: float, was: float, count: int = 7) -> Floats:
    share = np.exp(-np.arange(1, count + 1) / TAU)
    return np.append(earlier, share * was + (1.0 - share) * level)


@pytest.mark.parametrize(
    ("aperture_s", "delay_s"), [(0.0, 0.5), (0.0, 0.7), (1.0, 0.5), (0.6, 0.9), (1.5, 0.2)]
)
@pytest.mark.parametrize("since_s", [0.0, 0.3, 1.0, 2.5])
def test_the_older_share_is_the_mean_of_what_the_filter_remembers(
    aperture_s: float, delay_s: float, since_s: float
) -> None:
    tau = min(TAU, delay_s)

    def remembered(t: float) -> float:
        return 1.0 if t < 0.0 else float(np.exp(-t / tau))

    end = since_s - (delay_s - tau)
    wanted = remembered(end)
    if aperture_s:
        wanted = quad(remembered, end - aperture_s, end, points=[0.0])[0] / aperture_s
    window = Window(1.0, aperture_s, delay_s, tau)
    assert window.older(np.array([since_s]))[0] == pytest.approx(wanted, abs=1e-6)


def test_the_remnant_is_that_of_the_last_reading_before() -> None:
    found = INSTANT.readings(shown(EARLIER, 10.0, 7.0), line(0, 5, 12))
    assert found[:5].tolist() == list(EARLIER)
    assert np.isnan(found[5])  # .135 of it is of before
    assert found[6:] == pytest.approx(10.0)


def test_after_a_part_without_a_reading_none_may_be_of_before() -> None:
    found = INSTANT.readings(shown((np.nan,) * 5, 10.0, 0.0), line(0, 5, 12))
    assert np.isnan(found[:8]).all()  # exp(-6) is more than a thousandth
    assert found[8:] == pytest.approx(10.0)


@pytest.mark.parametrize(("late_s", "knows"), [(0.0, False), (0.1, False), (-0.1, True)])
def test_the_last_reading_of_a_part_may_know_of_the_next(late_s: float, knows: bool) -> None:
    """Of every part but the last: a reading that came a whole sample later, but for so much."""
    window = Window(1.0, 0.0, 1.0 + TAU + late_s, TAU)
    assert window.lag == 1
    found = window.readings(np.full(16, 3.0), line(0, 5, 10, 15, 16))
    assert np.isnan(found[[4, 9, 14]]).tolist() == [knows] * 3
    assert np.isfinite(found[[3, 8, 13]]).all()


@pytest.mark.parametrize("lag", [1, 3, 5])
def test_as_many_readings_know_of_the_next_command_as_come_late(lag: int) -> None:
    """Behind a filter of so many samples; the last part has no next one."""
    window = Window(1.0, 0.0, float(lag), float(lag))
    assert window.foresees == lag
    assert Window(1.0, 0.0, float(lag)).foresees == 0  # whole samples late: of its own command
    found = window.readings(np.full(80, 3.0), line(0, 40, 80))
    assert np.isnan(found[40 - lag : 40]).all()
    assert np.isfinite(found[: 40 - lag]).all()


def test_in_a_short_part_more_of_a_reading_may_be_of_before() -> None:
    """Six intervals behind a filter of four: of the two that do not know what follows, the later
    holds exp(-6/4), and with it stands for the part. In two intervals there is none.
    """
    window = Window(1.0, 0.0, 4.0, 4.0)
    assert window.half_shows(6) == pytest.approx(np.exp(-6 / 4))
    assert window.half_shows(60) < 1e-3
    assert window.half_shows(4) == 1.0
    remembers = 10.0 - 3.0 * np.exp(-np.arange(1, 16) / 4)  # 7 V before, 10 V from then on
    found = window.readings(np.append(np.full(40, 7.0), remembers), line(0, 40, 46, 55))
    assert np.isnan(found[[40, *range(42, 46)]]).all()
    assert found[41] == pytest.approx(10.0)


def test_a_window_that_reaches_over_a_command_is_of_no_command() -> None:
    found = Window(1.0, 2.0).readings(np.arange(8.0), line(0, 4, 8))
    assert np.flatnonzero(np.isnan(found)).tolist() == [0, 4]
    nearly = Window(1.0, 1.0, 0.9 * EDGE).readings(np.arange(8.0), line(0, 4, 8))
    assert np.isfinite(nearly).all()


@pytest.mark.parametrize(("aperture_s", "wide"), [(0.0, 1.0), (0.25, 0.25)])
def test_without_a_filter_a_current_is_read_once(aperture_s: float, wide: float) -> None:
    """An instant of the voltage beside the mean of the current over an interval."""
    window = Window(1.0, aperture_s, 2.3)
    assert window.outputs == [Output(Quantity.CURRENT, wide, 2.3)]
    rows = np.array([np.arange(6.0), np.full(6, 9.0)])
    seen = window.current(rows, -np.arange(6.0), line(0, 3, 6))
    assert seen == pytest.approx([2.0, 3.0, 4.0, 5.0, -4.0, -5.0])  # put back by two samples


def test_behind_a_filter_a_current_is_read_so_and_its_mixtures_stay() -> None:
    read = shown(EARLIER, 10.0, 7.0)
    assert INSTANT.outputs == [Output(Quantity.CURRENT, 1.0, 0.0, filter_s=TAU)]
    seen = INSTANT.current(read[None, :], np.zeros(12), line(0, 5, 12))
    assert seen[:6] == pytest.approx(read[:6])
    assert seen[6:] == pytest.approx(10.0)


def test_a_channel_s_filter_is_within_its_delay() -> None:
    read = Channel(
        VOLTAGE, "V", np.zeros(1), kind="mean", aperture_s=0.3, delay_s=0.2, filter_s=0.5
    )
    assert Window.of(read, 1.0) == Window(1.0, 0.3, 0.2, 0.2)
    whole = Window(1.0, delay_s=2.9995)
    assert (whole.lag, whole.late_s) == (3, 0.0)
    assert Window(1.0, delay_s=2.9).late_s == pytest.approx(0.9)
