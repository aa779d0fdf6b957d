"""A file whose readings are arrays of numbers with names."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motorid.capture.columns import BadCell, Columns, Described, unknown_column
from motorid.capture.csv_header import unit_cell
from motorid.errors import DataError

Floats = NDArray[np.float64]


class ArraySource:
    """Arrays by their path in the file: ``qm``, ``X.Data``, ``Y[3].Data``.

    A leading part may be left out where what remains is unambiguous. An array of one number is a
    constant. ``elsewhere``: what of the file is no such array, as a clause. ``units``: what the
    file says of an array's unit, by its path.
    """

    def __init__(
        self,
        path: Path,
        arrays: Mapping[str, Floats],
        layout: str,
        elsewhere: str = "",
        units: Mapping[str, str] | None = None,
    ) -> None:
        self._path, self._arrays = path, arrays
        self._paths = _names(arrays)
        self.names: Sequence[str] = list(self._paths)
        self.layout, self.elsewhere = layout, elsewhere
        short = {path: name for name, path in reversed(self._paths.items())}
        told = {path: unit_cell(unit) for path, unit in (units or {}).items()}
        spelled = {path: unit for path, unit in told.items() if unit}
        self.header_units: Mapping[str, str] = {
            name: spelled[path] for name, path in self._paths.items() if path in spelled
        }
        self.described: Sequence[Described] = [
            Described(short[path], (path,), spelled.get(path, ""))
            for path, array in arrays.items()
            if len(array) > 1
        ]
        self.rows = max(map(len, arrays.values()), default=0)
        self.constants: Mapping[str, float] = {
            name: float(arrays[path][0])
            for name, path in self._paths.items()
            if len(arrays[path]) == 1 and np.isfinite(arrays[path][0])
        }

    def place(self, row: int) -> str:
        return f"element {row + 1}"

    def read(self, names: Sequence[str]) -> Columns:
        values = {name: self._array(name) for name in names}
        lengths = {name: len(array) for name, array in values.items() if len(array) > 1}
        if len(set(lengths.values())) > 1:
            told = ", ".join(f"{name} has {length}" for name, length in lengths.items())
            raise DataError(f"{self._path}: columns differ in length: {told}; map columns of one")
        bad, cleaned = [], {}
        for name, array in values.items():
            finite = np.isfinite(array)
            if not finite.all():
                row = int(np.argmin(finite))
                bad.append(BadCell(row, name, str(array[row])))
                array = np.where(finite, array, np.nan)
            cleaned[name] = array
        return Columns(max(lengths.values(), default=1), cleaned, tuple(bad))

    def _array(self, name: str) -> Floats:
        if name not in self._paths:
            raise unknown_column(name, self.names)
        return self._arrays[self._paths[name]]


def _names(arrays: Mapping[str, Floats]) -> dict[str, str]:
    """Every tail of a dotted path that only one array has -> its path; long, short names first."""
    counts = Counter(tail for path in arrays for tail in _tails(path))
    tails = [(tail, path) for path in arrays for tail in _tails(path) if counts[tail] == 1]
    tails.sort(key=lambda pair: (len(arrays[pair[1]]) < 2, pair[0].count(".")))
    return dict(tails)


def _tails(path: str) -> list[str]:
    parts = path.split(".")
    return [".".join(parts[start:]) for start in range(len(parts))]
