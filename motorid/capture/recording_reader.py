"""Reads logs of signals (WPILib, MCAP, MDF4, TDMS) in a process of its own, with limits."""

from __future__ import annotations

from pathlib import Path

from motorid.capture import recording_child
from motorid.capture.array_source import ArraySource
from motorid.capture.child import ChildFailedError, arrays_from
from motorid.errors import DataError
from motorid.limits import RECORDING

_SHOWN = 4


class RecordingSource(ArraySource):
    """The signals of a log that are numbers, each with the stamps that it was logged with.

    Signals that share stamps make a table; nothing is resampled. Raises DataError where the file
    cannot be read, or where reading it crashes, hangs or eats memory.
    """

    def __init__(self, path: Path, kind: str) -> None:
        try:
            stored = arrays_from(recording_child.__file__, path, RECORDING)
        except ChildFailedError as error:
            raise DataError(f"{path} cannot be read as {kind} ({error}): is it damaged?") from None
        names = [str(name) for name in stored["names"]]
        arrays = {name: stored[f"a{index}"] for index, name in enumerate(names)}
        units = {name: str(u) for name, u in zip(names, stored["units"], strict=True) if str(u)}
        others = [str(name) for name, _ in stored["objects"]]
        more = f" and {len(others) - _SHOWN} more" if len(others) > _SHOWN else ""
        said = f"{', '.join(others[:_SHOWN])}{more}: no signals of numbers" if others else ""
        super().__init__(path, arrays, kind, said, units)
