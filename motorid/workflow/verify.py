"""Whether files are still what was written: captures, journals, documents, histories, bundles."""

from __future__ import annotations

import os
import tempfile
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from motorid import json_seal
from motorid.errors import DataError, UsageError
from motorid.reading import open_file
from motorid.storage import pack
from motorid.storage.place import PACK as PACK_SUFFIX
from motorid.storage.place import File, Url
from motorid.workflow.archive import sealed

SCHEMA = "motorid-verify-1"
SOUND, NO_DIGEST, CUT_SHORT, DAMAGED = "sound", "carries no digest", "cut short", "damaged"
STATES = (SOUND, NO_DIGEST, CUT_SHORT, DAMAGED)
CAPTURE, JOURNAL, DOCUMENT, HISTORY = "capture", "journal", "document", "history"
BUNDLE = "bundle"  # a zip of a conformance run
PACK = "pack"  # a zip of captures, with an index beside it
_ZIP = b"PK\x03\x04"
_HEADS = {
    b"\x89HDF\r\n\x1a\n": CAPTURE,
    b"motorid journal ": JOURNAL,
    b"SQLite format 3\0": HISTORY,
}
_NAMED = {".json": DOCUMENT, ".zip": BUNDLE}  # by a person, who means one of ours
_DOCUMENTS = ("estimate.json", "verdict.json")


@dataclass(frozen=True)
class Finding:
    """Of one file: what kind it is, one of STATES, and a sentence of where or why; "" for none."""

    path: str
    kind: str
    state: str
    where: str = ""


def verify(paths: Iterable[File]) -> Iterator[Finding]:
    """What is to be said of each file, and of each of motorid's files in each folder, in order.

    Raises UsageError where a path is not there, as for every file that a person names to be read;
    DataError where it is a file that motorid does not write.
    """
    for path in paths:
        if isinstance(path, Url):
            yield from _stored(path)
            continue
        if path.is_dir():
            yield from (_finding(one, kind) for one, kind in _within(path))
            continue
        if not path.exists():
            raise UsageError(f"there is no file {path}: check the path")
        kind = _kind(path) or _NAMED.get(path.suffix, "")
        if not kind:
            raise DataError(f"{path} is no file that motorid writes, or damaged from its beginning")
        yield _finding(path, kind)


def as_data(findings: Sequence[Finding]) -> dict[str, Any]:
    """The findings for JSON."""
    counts = Counter(one.state for one in findings)
    return {
        "schema": SCHEMA,
        "counts": {state: counts[state] for state in STATES},
        "files": [asdict(one) for one in findings],
    }


def journal_remark(path: Path) -> tuple[str, ...]:
    """A sentence where the journal that ``path`` names, or the one beside it, is damaged."""
    from motorid.acquire.journal import journal_path
    from motorid.acquire.leftover import is_journal

    journal = path if is_journal(path) else journal_path(path)
    if not journal.is_file():
        return ()
    found = _journal(journal)
    if found.state != DAMAGED:
        return ()
    return (f"the journal is damaged ({found.where}); what follows that place is left out",)


def _within(folder: Path) -> Iterator[tuple[Path, str]]:
    for at, folders, names in os.walk(folder):
        folders.sort()
        for name in sorted(names):
            path = Path(at, name)
            kind = _kind(path) if path.is_file() else ""
            if not kind and path.suffix == ".json" and path.is_file() and _is_ours(path):
                kind = DOCUMENT
            if kind:
                yield path, kind


def _kind(path: Path) -> str:
    """By how a file begins, else by its name; "" for one that is not motorid's."""
    from motorid.acquire.leftover import is_journal

    if path.suffix == ".mat":
        return ""
    try:
        with open_file(path, DataError) as file:
            head = file.read(16)
    except (DataError, OSError):
        head = b""
    for begins, kind in _HEADS.items():
        if head.startswith(begins):
            return kind
    if head.startswith(_ZIP):
        from motorid.workflow.conformance.bundle import is_bundle

        if pack.is_sealed(path):
            return PACK
        return BUNDLE if is_bundle(path) else ""
    if is_journal(path):
        return JOURNAL
    if path.suffix == ".h5":
        return CAPTURE
    return DOCUMENT if path.name in _DOCUMENTS else ""


def _is_ours(path: Path) -> bool:
    """Whether a JSON file says that it is motorid's, or carries its digest."""
    try:
        document = json_seal.parse(path, "a document")
    except DataError:
        return False
    ours = str(document.get("schema", "")).startswith(("motorid-estimate", "motorid-verdict"))
    return ours or json_seal.carries_digest(document)


def _finding(path: Path, kind: str) -> Finding:
    checks = {
        CAPTURE: _capture,
        JOURNAL: _journal,
        DOCUMENT: _document,
        HISTORY: _history,
        BUNDLE: _bundle,
        PACK: _pack,
    }
    return _checked(path, kind, checks[kind])


def _checked(path: Any, kind: str, check: Callable[[Any], Finding]) -> Finding:
    try:
        return check(path)
    except DataError as error:
        return Finding(str(path), kind, DAMAGED, str(error).removeprefix(f"{path}: "))


def _capture(path: Path) -> Finding:
    from motorid.capture import store

    capture = store.load(path)
    if capture.content_sha256:
        return Finding(str(path), CAPTURE, SOUND)
    return Finding(str(path), CAPTURE, NO_DIGEST, "it is of format 1.0")


def _journal(path: Path) -> Finding:
    from motorid.acquire.journal_check import Wholeness, check_journal

    found = check_journal(path)
    place = f"from byte {found.at} on: {found.why}"
    match found.whole:
        case Wholeness.SOUND:
            return Finding(str(path), JOURNAL, SOUND)
        case Wholeness.OPEN:
            said = "every record is good, but it was not closed"
            return Finding(str(path), JOURNAL, NO_DIGEST, said)
        case Wholeness.CUT:
            return Finding(str(path), JOURNAL, CUT_SHORT, place)
    return Finding(str(path), JOURNAL, DAMAGED, place)


def _document(path: Path) -> Finding:
    document = json_seal.read(path, "an estimate or a verdict")
    kind = str(document.get("schema", DOCUMENT)).removeprefix("motorid-").rpartition("-")[0]
    if json_seal.carries_digest(document):
        return Finding(str(path), kind or DOCUMENT, SOUND)
    return Finding(str(path), kind or DOCUMENT, NO_DIGEST, "it is of minor 0")


def _history(path: Path) -> Finding:
    from motorid.quality.history.check import damage

    where = damage(path)
    if where:
        return Finding(str(path), HISTORY, DAMAGED, where)
    return Finding(str(path), HISTORY, NO_DIGEST, "its structure and its texts are good")


def _pack(path: File) -> Finding:
    if where := pack.damage(path):
        return Finding(str(path), PACK, DAMAGED, where)
    index = pack.read_index(path)
    said = f"{len(index.entries)} files of {index.station}, {index.day}"
    return Finding(str(path), PACK, SOUND, said)


def _stored(url: Url) -> Iterator[Finding]:
    """Of an object store: each pack and each capture that ``url`` is, or has in it."""
    from motorid.storage import captures

    if url.suffix == captures.SUFFIX:
        yield replace(_checked(captures.local(url), CAPTURE, _capture), path=str(url))
        return
    packs = [url] if url.suffix == PACK_SUFFIX else sealed(url)
    for one in packs:
        yield _checked(one, PACK, _pack)


def _bundle(path: Path) -> Finding:
    """Its digests first; then each file of motorid's in it, as if it lay there by itself."""
    from motorid.workflow.conformance.bundle import unpack

    with tempfile.TemporaryDirectory(prefix="motorid-") as scratch:
        manifest = unpack(path, Path(scratch))
        for one in verify([Path(scratch)]):
            if one.state in (DAMAGED, CUT_SHORT):
                name = Path(one.path).relative_to(scratch)
                return Finding(str(path), BUNDLE, DAMAGED, f"{name} in it: {one.where}")
    done = sum(part["outcome"] == "done" for part in manifest["parts"])
    said = f"{len(manifest['files'])} files; {done} of {len(manifest['parts'])} parts done"
    return Finding(str(path), BUNDLE, SOUND, said)
