"""Reads MATLAB files (v4 to v7.3) in a process of its own, with limits on time and memory."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motorid.capture import mat_child
from motorid.capture.array_source import ArraySource
from motorid.capture.child import ChildFailedError, arrays_from
from motorid.errors import DataError
from motorid.limits import MAT

Floats = NDArray[np.float64]

_SHOWN = 4
# part of a class's name -> what to do in MATLAB to have its readings as plain arrays
_EXPORTS = {
    "timetable": "writetimetable({0}, 'plain.csv')",
    "timeseries": "t = {0}.Time; y = {0}.Data; save('plain.mat', 't', 'y')",
    "table": "writetable({0}, 'plain.csv')",
    "dataset": "s = {0}.getElement(1).Values; t = s.Time; y = s.Data; save('plain.mat', 't', 'y')",
    "simulationoutput": "s = {0}.logsout{{1}}.Values; t = s.Time; y = s.Data; "
    "save('plain.mat', 't', 'y')",
    "sparse": "y = full({0}); save('plain.mat', 'y')",
    "stream": "load the file, take s = out.logsout{{1}}.Values, and save s.Time and s.Data",
    "datetime": "t = seconds({0} - {0}(1)); save('plain.mat', 't')",
    "duration": "t = seconds({0}); save('plain.mat', 't')",
}


class MatSource(ArraySource):
    """The numeric arrays of a MAT file.

    ``A[2]`` is the second column of a matrix, ``A[2,:]`` its second row. Raises DataError where the
    file cannot be read, or where reading it crashes, hangs or eats memory.
    """

    def __init__(self, path: Path) -> None:
        arrays, objects = _read(path)
        super().__init__(path, arrays, "MAT file", _said(objects))


def _read(path: Path) -> tuple[dict[str, Floats], dict[str, str]]:
    """Arrays by path, and the class of what is none, by path."""
    if not path.is_file():
        raise DataError(f"{path}: cannot be read: there is no such file")
    try:
        stored = arrays_from(mat_child.__file__, path, MAT)
    except ChildFailedError as error:
        raise DataError(f"{path} cannot be read as a MAT file ({error}): is it damaged?") from None
    names = [str(name) for name in stored["names"]]
    objects = {str(name): str(what) for name, what in stored["objects"]}
    return {name: stored[f"a{index}"] for index, name in enumerate(names)}, objects


def _said(objects: Mapping[str, str]) -> str:
    """What of a file holds readings that cannot be read here, and how to export them."""
    if not objects:
        return ""
    told = [f"{name} is a {what}" for name, what in list(objects.items())[:_SHOWN]]
    more = f", and {len(objects) - _SHOWN} more" if len(objects) > _SHOWN else ""
    known = (
        how.format(name)
        for part, how in _EXPORTS.items()
        for name, what in objects.items()
        if part in what.lower()
    )
    how = next(known, "save its arrays as plain variables")
    return f"{', '.join(told)}{more}, which only MATLAB reads: there, {how}"
