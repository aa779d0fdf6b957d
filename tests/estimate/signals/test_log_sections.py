"""A log is cut where it pauses or its bridge opens; what is at rest beside a motion is left out."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.capture.model import Capture, Channel
from motorid.estimate.signals.log_sections import FEWEST, PAUSE, driven, unbroken
from motorid.estimate.signals.opened_bridge import Opening


def log(*lengths: int, pause: float = 100.0) -> Capture:
    """Stretches of so many rows, a row a millisecond, so many periods between two of them."""
    begins = np.cumsum([0.0, *(n - 1 + pause for n in lengths[:-1])])
    rows = np.concatenate([b + np.arange(n) for b, n in zip(begins, lengths, strict=True)])
    volts = Channel("terminal_voltage", "V", np.arange(len(rows), dtype=float))
    return Capture(np.rint(1e3 * rows).astype(np.int64), 1e6, {"terminal_voltage": volts})


def test_no_piece_spans_a_pause_and_no_row_is_lost() -> None:
    capture = log(100, 80, 120)
    cut = unbroken([capture])
    assert [len(piece) for piece in cut] == [100, 80, 120]
    shown = np.concatenate([piece.channels["terminal_voltage"].values for piece in cut])
    np.testing.assert_array_equal(shown, capture.channels["terminal_voltage"].values)
    for piece in cut:
        assert np.ptp(np.diff(piece.ticks)) == 0


@pytest.mark.parametrize(("share", "count"), [(0.9, 1), (1.1, 2)])
def test_a_pause_is_of_several_periods(share: float, count: int) -> None:
    assert len(unbroken([log(100, 100, pause=share * PAUSE)])) == count


def test_a_stretch_too_short_for_a_beginning_of_its_own_is_left_out() -> None:
    assert [len(piece) for piece in unbroken([log(100, FEWEST - 1, 90)])] == [100, 90]
    assert [len(piece) for piece in unbroken([log(100, FEWEST, 90)])] == [100, FEWEST, 90]


def moving(*stretches: bool, each: int = 100) -> Capture:
    """Stretches in which the motor turns or rests, with a pause between two."""
    capture = log(*(each for _ in stretches))
    speed = np.concatenate([np.arange(each) * float(turns) for turns in stretches])
    channels = {**capture.channels, "speed": Channel("speed", "rad/s", speed)}
    return Capture(capture.ticks, capture.clock_hz, channels)


def test_a_rest_between_pauses_tells_nothing_beside_a_motion() -> None:
    capture = moving(True, False, True)
    assert [piece.ticks[0] for piece in unbroken([capture])] == [
        capture.ticks[0], capture.ticks[200],
    ]  # fmt: skip


def test_a_motor_that_rests_throughout_is_left_whole() -> None:
    assert [len(piece) for piece in unbroken([moving(False, False)])] == [100, 100]


def test_a_rest_after_the_bridge_opened_is_left_out() -> None:
    capture = moving(True, True, False)
    kept = driven(capture, [Opening(110, 210, 210)])
    assert [(piece.ticks[0], len(piece)) for piece in kept] == [(0, 110)]
