"""Reads a spreadsheet (XLSX, XLS, ODS) in a process of its own, and its sheet as a text table."""

from __future__ import annotations

import tempfile
from pathlib import Path

from motorid.capture import sheet_child
from motorid.capture.child import ChildFailedError, arrays_from
from motorid.capture.csv_reader import CsvSource
from motorid.errors import DataError
from motorid.limits import SHEET


class SheetSource(CsvSource):
    """The sheet that holds most numbers, with whatever lines stand above them.

    A cell of a date and time becomes seconds since the first, one of a time or a duration seconds.
    Raises DataError where the file cannot be read, or where reading it crashes, hangs or eats
    memory.
    """

    def __init__(
        self, path: Path, decimal: str | None = None, thousands: str | None = None
    ) -> None:
        try:
            stored = arrays_from(sheet_child.__file__, path, SHEET)
        except ChildFailedError as error:
            raise DataError(
                f"{path} cannot be read as a spreadsheet ({error}): is it damaged?"
            ) from None
        sheet, others = str(stored["sheet"][0]), [str(name) for name in stored["others"]]
        # a table's lines are read piece by piece from a file, which lasts as long as this object
        self._folder = tempfile.TemporaryDirectory(prefix="motorid-")
        text = Path(self._folder.name) / "sheet.tsv"
        text.write_bytes(stored["text"].tobytes())
        super().__init__(path, sheet_child.SEPARATOR, decimal, thousands, text=text)
        plural = "" if self.header_lines == 1 else "s"
        self.layout = f"sheet {sheet!r}, {self.header_lines} header line{plural}"
        if others:
            named = ", ".join(map(repr, others))
            self.elsewhere = f"read was its sheet {sheet!r}, not {named}"
            self.layout += f"; not read: {named}"

    def place(self, row: int) -> str:
        return f"row {self.header_lines + row + 1}"
