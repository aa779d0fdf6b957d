"""Run as a program: an NPZ or Parquet file -> its columns of numbers. See capture/child.py."""

from __future__ import annotations

import math
import zipfile
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from motorid.capture.child import serve
from motorid.errors import DataError
from motorid.limits import COLUMNAR, beyond

_NARROW = 64  # columns of a matrix that are columns of a table each
Columns = dict[str, Any]


def main(source: str, target: str) -> None:
    """Reads ``source`` and writes ``target``. Raises what the libraries raise."""
    with open(source, "rb") as file:
        head = file.read(4)
    found: Columns = {}
    others: list[str] = []
    for name, values in _parquet(source) if head == b"PAR1" else _npz(source):
        if not _keep(name, values, found):
            others.append(name)
    named = {f"a{index}": array for index, array in enumerate(found.values())}
    objects = np.array([(name, "no numbers") for name in others], dtype=str).reshape(-1, 2)
    np.savez(target, names=np.array(list(found), dtype=str), objects=objects, **named)


def _npz(source: str) -> Iterator[tuple[str, Any]]:
    """Each array; a member's head is looked at before the member is unpacked."""
    with zipfile.ZipFile(source) as archive:
        for member in archive.infolist():
            with archive.open(member) as file:
                _refuse_declared(member.filename, file)
    with np.load(source, allow_pickle=False) as stored:
        for name in stored.files:
            array = stored[name]
            if array.dtype.names:
                yield from ((f"{name}.{field}", array[field]) for field in array.dtype.names)
            else:
                yield name, array


def _refuse_declared(name: str, file: Any) -> None:
    """Raises DataError where an array says that it is beyond the limits, or holds objects."""
    form = np.lib.format
    version = form.read_magic(file)
    read = form.read_array_header_1_0 if version == (1, 0) else form.read_array_header_2_0
    shape, _, kind = read(file)
    if kind.hasobject:
        raise DataError(f"{name} holds Python objects, which are not read: save plain arrays")
    refuse_shape(name, shape)


def _parquet(source: str) -> Iterator[tuple[str, Any]]:
    try:
        from pyarrow import parquet
    except ImportError:
        raise DataError(
            "Parquet needs the package pyarrow: pip install 'motorid[parquet]'"
        ) from None
    file = parquet.ParquetFile(source)
    refuse_shape("the table", (file.metadata.num_rows, file.metadata.num_columns))
    for name in file.schema_arrow.names:
        column = file.read(columns=[name], use_threads=False).column(0)
        yield name, column.to_numpy()


def refuse_shape(name: str, shape: Sequence[int]) -> None:
    """Raises DataError for an array that is larger than the limits allow."""
    rows, numbers = max(shape, default=1), math.prod(shape)
    if beyond(rows, COLUMNAR.rows) or beyond(numbers, COLUMNAR.numbers):
        raise DataError(
            f"{name} has {rows:,} rows and {numbers:,} numbers; a file of its kind may have "
            f"{COLUMNAR.rows:,} and {COLUMNAR.numbers:,}: save a part of it"
        )


def _keep(name: str, values: Any, found: Columns) -> bool:
    """Keeps what is a column of numbers, and a matrix by its columns; False where it is none."""
    array = np.asarray(values)
    if array.dtype.kind == "M":  # moments: in seconds since the first
        known = array[~np.isnat(array)]
        since = array - (known[0] if known.size else array)
        array = since / np.timedelta64(1, "s")
    elif array.dtype.kind == "m":
        array = array / np.timedelta64(1, "s")
    if array.dtype.kind not in "iufb" or not array.size or array.ndim > 2:
        return False
    array = array.astype(np.float64, copy=False)
    if array.ndim < 2:
        found[name] = array.reshape(-1)
    elif array.shape[1] > _NARROW:
        return False
    else:
        for column in range(array.shape[1]):
            found[f"{name}[{column + 1}]"] = array[:, column]
    if beyond(len(found), COLUMNAR.columns):
        raise DataError(f"it holds more than {COLUMNAR.columns:,} columns, the most that it may")
    return True


if __name__ == "__main__":
    serve(main, ("numpy", "zipfile"))
