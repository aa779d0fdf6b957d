"""Reads logs of signals (WPILib, MCAP, MDF4, TDMS) in a process of its own, with limits."""

from __future__ import annotations

from motorid.capture import recording_child
from motorid.capture.columnar_reader import ColumnarSource
from motorid.limits import RECORDING


class RecordingSource(ColumnarSource):
    """The signals of a log that are numbers, each with the stamps that it was logged with.

    Signals that share stamps make a table; nothing is resampled. Raises DataError where the file
    cannot be read, or where reading it crashes, hangs or eats memory.
    """

    program, limits, what = recording_child.__file__, RECORDING, "signals"
