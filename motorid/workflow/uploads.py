"""A shift's captures on their way into an object store, none lost and none twice.

An inspection is on disk, in its own folder, before it comes here. A store that cannot be reached
stops no line: the folder keeps no mark, and is uploaded once the store answers, by this shift or
the next. Each file is read back and compared before the mark says so.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from motorid.capture.whole import write_whole
from motorid.errors import MotoridError
from motorid.storage import object_store
from motorid.storage.place import Url
from motorid.workflow.behind import Behind
from motorid.workflow.check import CAPTURE, VERDICT, WARM_UP
from motorid.workflow.shift_folder import serial_of, unsettled

MARK = "in-store"  # in an inspection's folder: the store has it
FILES = (WARM_UP, CAPTURE, VERDICT)  # in this order, so that a verdict there says all are there


def place_of(folder: Path, to: Url) -> Url:
    """Where the inspection in ``folder`` is in the store."""
    return to / folder.name


def upload(folder: Path, to: Url) -> None:
    """The inspection in ``folder``, and then the mark. Raises DataError or UsageError."""
    lines = []
    for name in FILES:
        if (folder / name).exists():
            url = place_of(folder, to) / name
            lines.append(f"{object_store.put(folder / name, url)}  {url}\n")
    write_whole(folder / MARK, "".join(lines).encode(), force=True)


@dataclass(frozen=True)
class Uploads:
    """Uploads inspections to the folder ``to`` of a store."""

    to: Url

    def take(self, folder: Path) -> str:
        """Uploads one inspection. What went wrong, in a sentence, or nothing."""
        try:
            if not (folder / MARK).exists():
                upload(folder, self.to)
        except (MotoridError, OSError) as error:
            return f"{serial_of(folder)} is not in the object store yet ({error})"
        return ""

    def catch_up(self, folder: Path) -> str:
        """Uploads what was left out. What was done and what was not, in a sentence.

        Raises DataError where the store does not answer.
        """
        done, left = 0, []
        for one in missing(folder):
            try:
                upload(one, self.to)
            except (MotoridError, OSError) as error:
                object_store.exists(self.to / MARK)  # raises where it is the store
                left.append(str(error))
            else:
                done += 1
        if not done and not left:
            return ""
        said = f"{done} inspections were uploaded. "
        return said + (f"{len(left)} could not be ({left[0]}). " if left else "")


def missing(folder: Path) -> Iterator[Path]:
    """Inspections that are judged and not in the store."""
    for one in unsettled(folder, MARK, lambda one: (one / MARK).exists()):
        if (one / VERDICT).exists():
            yield one


class UploadWorker(Behind):
    """Uploads behind the cycle."""

    what, where, does = "inspections", "in the object store", "uploads"
