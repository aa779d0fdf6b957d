"""Which reader takes a file: one table, tried in order."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from motorid.capture.columns import Source
from motorid.capture.table_options import TableOptions
from motorid.errors import DataError
from motorid.reading import open_file

_HEAD = 16384  # bytes that tell
_LINES = 50
_SHEETS = (".xlsx", ".xlsm", ".xlsb", ".xls", ".ods")
_ZIP_OR_OLDER = (b"PK", b"\xd0\xcf\x11\xe0")  # heads of sheets


@dataclass(frozen=True)
class Format:
    """``takes``: whether it reads a file with this suffix and these first bytes."""

    name: str
    takes: Callable[[str, bytes], bool]
    read: Callable[[Path, TableOptions], Source]


def source_of(path: Path, chosen: TableOptions) -> Source:
    """The file, opened by the first reader that takes it. Raises DataError."""
    with open_file(path, DataError) as file:
        head = file.read(_HEAD)
    suffix = path.suffix.lower()
    found = next(one for one in TABLE if one.takes(suffix, head))
    return found.read(path, chosen)


def _mat(path: Path, chosen: TableOptions) -> Source:
    from motorid.capture.mat_reader import MatSource

    return MatSource(path)


def _columnar(kind: str) -> Callable[[Path, TableOptions], Source]:
    def read(path: Path, chosen: TableOptions) -> Source:
        from motorid.capture.columnar_reader import ColumnarSource

        return ColumnarSource(path, kind)

    return read


def _records(kind: str) -> Callable[[Path, TableOptions], Source]:
    def read(path: Path, chosen: TableOptions) -> Source:
        from motorid.capture.record_reader import RecordSource

        return RecordSource(path, kind)

    return read


def _sheet(path: Path, chosen: TableOptions) -> Source:
    from motorid.capture.sheet_reader import SheetSource

    return SheetSource(path, chosen.decimal, chosen.thousands)


def _is_sheet(suffix: str, head: bytes) -> bool:
    return suffix in _SHEETS and head.startswith(_ZIP_OR_OLDER)


def _recording(kind: str) -> Callable[[Path, TableOptions], Source]:
    def read(path: Path, chosen: TableOptions) -> Source:
        from motorid.capture.recording_reader import RecordingSource

        return RecordingSource(path, kind)

    return read


def _are_records(kind: str) -> Callable[[str, bytes], bool]:
    def takes(suffix: str, head: bytes) -> bool:
        from motorid.capture.record_lines import kind_of

        wide = head.startswith((b"\xff\xfe", b"\xfe\xff"))
        text = head.decode("utf-16" if wide else "utf-8-sig", "replace")
        lines = text.splitlines()
        whole = lines if len(head) < _HEAD else lines[:-1]
        return kind_of(whole[:_LINES]) == kind

    return takes


def _csv(path: Path, chosen: TableOptions) -> Source:
    from motorid.capture.csv_reader import CsvSource

    return CsvSource(path, chosen.separator, chosen.decimal, chosen.thousands)


TABLE = (
    Format(
        "MAT file",
        lambda suffix, head: suffix == ".mat" or head.startswith((b"MATLAB", b"\x89HDF")),
        _mat,
    ),
    Format("Parquet", lambda _, head: head.startswith(b"PAR1"), _columnar("Parquet")),
    Format(
        "NPZ",
        lambda suffix, head: suffix == ".npz" and head.startswith(b"PK"),
        _columnar("NPZ"),
    ),
    Format("spreadsheet", _is_sheet, _sheet),
    Format("WPILib data log", lambda _, head: head.startswith(b"WPILOG"), _recording("WPILib log")),
    Format("TDMS", lambda _, head: head.startswith(b"TDSm"), _recording("TDMS")),
    Format("MDF", lambda _, head: head.startswith(b"MDF     "), _recording("MDF")),
    Format("MCAP", lambda _, head: head.startswith(b"\x89MCAP0"), _recording("MCAP")),
    Format("JSON lines", _are_records("JSON lines"), _records("JSON lines")),
    Format("labelled lines", _are_records("labelled lines"), _records("labelled lines")),
    Format("text table", lambda *_: True, _csv),
)
