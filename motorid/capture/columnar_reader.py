"""Reads NPZ and Parquet files in a process of their own, with limits on time and memory."""

from __future__ import annotations

from pathlib import Path

from motorid.capture import columnar_child
from motorid.capture.array_source import ArraySource
from motorid.capture.child import ChildFailedError, arrays_from
from motorid.errors import DataError
from motorid.limits import COLUMNAR

_SHOWN = 4


class ColumnarSource(ArraySource):
    """The columns of numbers of an NPZ or Parquet file.

    Moments become seconds since the first. ``A[2]`` is the second column of a matrix. Raises
    DataError where the file cannot be read, or where reading it crashes, hangs or eats memory.
    """

    program, limits, what = columnar_child.__file__, COLUMNAR, "columns"

    def __init__(self, path: Path, kind: str) -> None:
        try:
            stored = arrays_from(self.program, path, self.limits)
        except ChildFailedError as error:
            raise DataError(f"{path} cannot be read as {kind} ({error}): is it damaged?") from None
        names = [str(name) for name in stored["names"]]
        arrays = {name: stored[f"a{index}"] for index, name in enumerate(names)}
        units = dict(zip(names, map(str, stored.get("units", ())), strict=False))
        others = [str(name) for name, _ in stored["objects"]]
        more = f" and {len(others) - _SHOWN} more" if len(others) > _SHOWN else ""
        said = f"{', '.join(others[:_SHOWN])}{more}: no {self.what} of numbers" if others else ""
        super().__init__(path, arrays, kind, said, units)
