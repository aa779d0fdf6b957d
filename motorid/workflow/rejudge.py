"""Stored captures judged into the history: new ones, and those of old results by today's limits.

Captures are fitted on all cores or a cluster; this process alone writes the history, as answers
come. What an interrupted call has done is in the history, and is not done again.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorid.errors import DataError, MotoridError
from motorid.storage.captures import load, sha256_of
from motorid.storage.moved import Moved
from motorid.storage.place import place
from motorid.version import __version__
from motorid.workflow.task import Result, Task
from motorid.workflow.tasks import Progress, Workers, answers

if TYPE_CHECKING:
    from motorid.quality.history import History, Query
    from motorid.quality.history.records import Kind
    from motorid.quality.product import Product
    from motorid.storage.place import Place


@dataclass(frozen=True)
class Judged:
    """One motor, judged into the history. ``before``: its outcome until now; "" for none."""

    serial: str
    path: str
    before: str
    after: str
    reasons: tuple[str, ...]
    new: bool
    failure: str = ""


@dataclass(frozen=True)
class Asked:
    """Captures of one motor to judge together. ``sha256``: of each, or none where unknown."""

    places: tuple[Place, ...]
    sha256: tuple[str, ...] = ()
    before: str = ""


def judge_into(
    history: History,
    product: Product,
    places: Sequence[Place],
    **rest: Any,
) -> Iterator[Judged]:
    """Judges each capture by itself and adds the verdict, one after the other.

    ``rest``: station, operator (see ``ResultRecord``).
    """
    asked = {number: Asked((one,)) for number, one in enumerate(places)}
    tasks = {number: _task(one, product, "check", rest) for number, one in asked.items()}
    yield from _added(history, asked, tasks, 1, None)


def rejudge(
    history: History,
    product: Product,
    query: Query,
    *,
    folders: Sequence[Place] = (),
    jobs: Workers = 1,
    progress: Progress | None = None,
) -> Iterator[Judged]:
    """Judges the captures of the results that ``query`` chooses by today's ``product``.

    Captures are found where they were recorded, or under ``folders`` by name or in packs; another
    SHA-256 than the recorded one is a failure. The old results stay as they are.
    """
    moved, seen = Moved(folders), set[tuple[str, ...]]()
    asked: dict[int, Asked] = {}
    tasks: dict[int, Task] = {}
    for row in history.results(query)[::-1]:  # the newest outcome of a capture is the one before
        cited = history.captures_of(row.id)
        hashes = tuple(capture.sha256 for capture in cited)
        if not cited or hashes in seen:
            continue
        seen.add(hashes)
        try:
            places = tuple(found_capture(capture, moved) for capture in cited)
        except MotoridError as error:
            yield Judged(row.serial, cited[0].path, row.outcome, "", (), False, str(error))
            continue
        if done := _done(history, product, hashes):
            yield Judged(row.serial, cited[0].path, row.outcome, done.outcome, (), False)
            continue
        asked[row.id] = Asked(places, hashes, row.outcome)
        tasks[row.id] = _task(asked[row.id], product, "rejudged", {"station": row.station})
    yield from _added(history, asked, tasks, jobs, progress)


def _done(history: History, product: Product, hashes: tuple[str, ...]) -> Any:
    """The result of these very captures by this product and this motorid; None for none."""
    from motorid.quality.history.records import digest

    for row in history.results_of(hashes[0]):
        same = row.kind == "rejudged" and row.limits == digest(product.text)
        if same and row.versions.get("motorid") == __version__:
            cited = history.captures_of(row.id)
            if tuple(capture.sha256 for capture in cited) == hashes:
                return row
    return None


def found_capture(capture: Any, moved: Moved) -> Place:
    """Where a capture is: nothing else is taken for it. Raises DataError."""
    there = place(capture.path)
    if not isinstance(there, Path):  # whoever fits it checks its digest
        return moved.find(capture.sha256, there.name) or there
    if there.is_file() and sha256_of(there) == capture.sha256:
        return there
    if found := moved.find(capture.sha256, there.name):
        return found
    changed = "has other bytes now" if there.is_file() else "is not there any more"
    raise DataError(f"the capture {there} {changed}: say by --captures where captures are kept")


def _task(asked: Asked, product: Product, kind: Kind, rest: Mapping[str, Any]) -> Task:
    definition = {
        "captures": [str(one) for one in asked.places],
        "product": product.digest,
        "kind": kind,
        "motorid": __version__,
    }
    work = (asked.places, asked.sha256, product, kind, dict(rest))
    return Task(_judged, work, definition, _failed)


def _judged(
    places: tuple[Place, ...],
    sha256: tuple[str, ...],
    product: Product,
    kind: Kind,
    rest: Mapping[str, Any],
) -> Result:
    """The record of a verdict as plain data, or why there is none."""
    from motorid.quality.history.records import to_plain
    from motorid.workflow.check import judge_captures
    from motorid.workflow.history import record_of

    try:
        digests = sha256 or ("",) * len(places)
        captures = [load(one, known) for one, known in zip(places, digests, strict=True)]
        verdict, _ = judge_captures(captures, product)
        record = record_of(verdict, captures, product, kind=kind, **rest)
    except MotoridError as error:
        return _failed(str(error))
    return {"record": to_plain(record), "reasons": list(verdict.reasons), "failure": ""}


def _failed(says: str) -> Result:
    return {"record": {}, "reasons": [], "failure": says}


def _added(
    history: History,
    asked: Mapping[int, Asked],
    tasks: Mapping[int, Task],
    jobs: Workers,
    progress: Progress | None,
) -> Iterator[Judged]:
    """Adds each answer as it comes."""
    from motorid.quality.history.records import from_plain

    for done, (number, found) in enumerate(answers(tasks, jobs), 1):
        one = asked[number]
        path = str(one.places[0])
        if progress:
            progress(done, len(tasks))
        if found["failure"]:
            yield Judged("", path, one.before, "", (), False, found["failure"])
            continue
        record = from_plain(found["record"])
        new = history.add(record)
        reasons = tuple(found["reasons"])
        yield Judged(record.serial, path, one.before, record.outcome, reasons, new)
