"""The most that each reader takes: what is larger is refused in one sentence, before it is read.

docs/file-format.md shows ``TABLE`` as ``markdown`` renders it.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from motorid.errors import DataError, MotoridError
from motorid.reading import file_size
from motorid.reading import size as size
from motorid.visible import on_one_line

KB, MB, GB = 1 << 10, 1 << 20, 1 << 30


@dataclass(frozen=True)
class Limits:
    """Of one reader; None where it has no such thing. Sizes in bytes.

    Time is bounded by work, never by a clock: ``passes`` over a file whose size is bounded, or for
    a child process ``cpu_s`` seconds of the processor and one more for every 4 MiB.
    """

    what: str
    file: int
    rows: int | None = None
    columns: int | None = None
    numbers: int | None = None  # in all
    line: int | None = None
    cell: int | None = None  # a cell, a text or a record
    passes: int | None = None
    cpu_s: int | None = None
    memory: int | None = None  # of a child process, beyond what its libraries take


TABLE = {
    "csv": Limits(
        "CSV table", GB, rows=10_000_000, columns=4096, line=256 * KB, cell=256 * KB, passes=3
    ),
    "mat": Limits(
        "MAT file",
        512 * MB,
        rows=10_000_000,
        columns=4096,
        numbers=50_000_000,
        cpu_s=10,
        memory=832 * MB,
    ),
    "columnar": Limits(
        "NPZ or Parquet file",
        512 * MB,
        rows=10_000_000,
        columns=4096,
        numbers=50_000_000,
        cpu_s=10,
        memory=2 * GB,
    ),
    "records": Limits(
        "JSON or labelled lines",
        256 * MB,
        rows=2_000_000,
        columns=256,
        numbers=20_000_000,
        line=256 * KB,
        passes=2,
    ),
    "sheet": Limits(
        "spreadsheet",
        64 * MB,
        columns=256,
        numbers=5_000_000,
        cpu_s=20,
        memory=2 * GB,
    ),
    "recording": Limits(
        "WPILib, MCAP, MDF or TDMS log",
        512 * MB,
        rows=10_000_000,
        columns=4096,
        numbers=50_000_000,
        cpu_s=20,
        memory=2 * GB,
    ),
    "look": Limits(
        "look at a table before its import", GB, columns=64, numbers=50_000_000, passes=4
    ),
    "capture": Limits(
        "capture",
        GB,
        rows=50_000_000,
        columns=64,
        numbers=120_000_000,
        cell=16 * MB,
        cpu_s=10,
        memory=3 * GB,
    ),
    "journal": Limits("journal", 4 * GB, cell=16 * MB, passes=2),
    "toml": Limits("rig, product or calibration file", MB, passes=1),
    "json": Limits("estimate or verdict", 64 * MB, passes=2),
    "bundle": Limits("bundle of a conformance run", 512 * MB, rows=1000, passes=1),
    "study": Limits("table of readings for a study or a trend", 64 * MB, passes=1),
    "firmware": Limits("firmware as Intel HEX", MB, passes=1),
    "history": Limits("history in a file", 64 * GB),
}
CSV, MAT, CAPTURE = TABLE["csv"], TABLE["mat"], TABLE["capture"]
COLUMNAR, RECORDS, LOOK = TABLE["columnar"], TABLE["records"], TABLE["look"]
SHEET, RECORDING = TABLE["sheet"], TABLE["recording"]
JOURNAL, TOML, JSON, HISTORY = TABLE["journal"], TABLE["toml"], TABLE["json"], TABLE["history"]
BUNDLE = TABLE["bundle"]  # rows: of its files
STUDY, FIRMWARE = TABLE["study"], TABLE["firmware"]
HEADINGS = (
    *("file", "size", "rows", "columns", "numbers in all", "a line"),
    *("a cell, text or record", "work", "memory"),
)
BYTES_A_SECOND = 4 * MB  # of a child's allowance of the processor


def refuse_large(path: Path, limits: Limits, error: type[MotoridError] = DataError) -> None:
    """Raises ``error`` unless ``path`` is a regular file of no more than its reader's size."""
    refuse_size(str(path), file_size(path, error), limits, error)


def refuse_size(
    name: str, found: int, limits: Limits = CAPTURE, error: type[MotoridError] = DataError
) -> None:
    """Raises ``error`` where ``name`` has more bytes than its reader takes."""
    if found > limits.file:
        raise error(
            f"{on_one_line(name)} has {size(found)}; a file of its kind ({limits.what}) "
            f"may have {size(limits.file)}"
        )


def beyond(count: int, most: int | None) -> bool:
    """Whether so many are more than a reader takes, if it has such a limit."""
    return most is not None and count > most


def cpu_s(limits: Limits, file_bytes: int) -> int:
    """Seconds of the processor that a child may spend on a file."""
    return (limits.cpu_s or 0) + file_bytes // BYTES_A_SECOND


def markdown() -> str:
    """The table, as docs/file-format.md has it."""
    rows = ["| " + " | ".join(HEADINGS) + " |", "|---" * len(HEADINGS) + "|"]
    return "\n".join([*rows, *(_row(limits) for limits in TABLE.values())])


def _row(limits: Limits) -> str:
    sizes = [limits.line, limits.cell]
    counts = [limits.rows, limits.columns, limits.numbers]
    work = "queries"
    if limits.passes:
        work = "1 pass" if limits.passes == 1 else f"{limits.passes} passes"
    elif limits.cpu_s:
        work = f"{limits.cpu_s} s of the processor, and 1 s for each {size(BYTES_A_SECOND)}"
    cells = [
        limits.what,
        size(limits.file),
        *("" if n is None else f"{n:,}" for n in counts),
        *("" if n is None else size(n) for n in sizes),
        work,
        "" if limits.memory is None else f"{size(limits.memory)} in a child process",
    ]
    return "| " + " | ".join(cells) + " |"
