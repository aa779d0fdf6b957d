"""A capture as a table of other programs: CSV, Parquet or MAT, in SI units, a row a sample.

The columns are ``time_s`` and one for each channel, with its unit behind its name. A missing
reading is an empty cell in CSV and NaN elsewhere; lost samples leave a jump of the time.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorid import csv_text
from motorid.capture import store
from motorid.capture.model import Capture
from motorid.errors import UsageError

Floats = NDArray[np.float64]
_SPELLED = {"rad/s": "rad_s", "N·m": "nm", "m/s": "m_s", "°C": "c"}


def columns(capture: Capture) -> dict[str, Floats]:
    """The table: each column by its name, shape (n,)."""
    found = {"time_s": capture.time_s}
    for name, channel in capture.channels.items():
        unit = _SPELLED.get(channel.unit, channel.unit.lower())
        found[f"{name}_{unit}" if unit.isidentifier() else name] = channel.values
    return found


def export_readings(path: Path, to: str) -> tuple[bytes, tuple[str, ...]]:
    """The file's bytes, and sentences on what the form does not hold. Raises DataError."""
    capture = store.load(path)
    said = ["the table holds readings alone: the program, the wiring and the calibration stay in "
            f"{path.name}"]  # fmt: skip
    if capture.gaps:
        lost = sum(gap.samples for gap in capture.gaps)
        said.append(f"{lost} lost samples have no row: the time jumps there")
    return FORMS[to](columns(capture)), tuple(said)


def _csv(table: Mapping[str, Floats]) -> bytes:
    rows = (
        (repr(value) if value == value else "" for value in row)
        for row in zip(*(column.tolist() for column in table.values()), strict=True)
    )
    return csv_text.table(list(table), rows).encode("utf-8")


def _parquet(table: Mapping[str, Floats]) -> bytes:
    try:
        import pyarrow as pa
        from pyarrow import parquet
    except ImportError:
        raise UsageError(
            "Parquet needs the package pyarrow: pip install 'motorid[parquet]', or --to csv"
        ) from None
    sink = io.BytesIO()
    parquet.write_table(pa.table(dict(table)), sink)
    return sink.getvalue()


def _mat(table: Mapping[str, Floats]) -> bytes:
    from scipy.io import savemat

    sink: Any = io.BytesIO()  # a file, whatever the stubs say
    savemat(sink, dict(table), oned_as="column", do_compression=True)
    return bytes(sink.getvalue())


FORMS: Mapping[str, Callable[[Mapping[str, Floats]], bytes]] = {
    "csv": _csv,
    "parquet": _parquet,
    "mat": _mat,
}
