"""Verdicts into the history, traces through it, and old captures judged by today's limits."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorid.errors import DataError, MotoridError

if TYPE_CHECKING:
    from motorid.quality.history import History, Query
    from motorid.quality.history.records import Kind
    from motorid.quality.product import Product
    from motorid.quality.verdict import Verdict
    from motorid.workflow.check import Inspection


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


def remember(
    history: History,
    verdict: Verdict,
    captures: Sequence[Path],
    product: Product,
    *,
    kind: Kind = "check",
    **rest: Any,
) -> bool:
    """Adds a verdict and the captures it rests on; False where the history has it already.

    ``rest``: station, operator, note, at (see ``ResultRecord``). It is on disk when this returns.
    """
    from motorid.capture import store
    from motorid.quality.history.records import from_verdict

    loaded = [store.load(path) for path in captures]
    if seen := _seen_anew(verdict):
        rest["note"] = "; ".join(part for part in (rest.get("note", ""), seen) if part)
    record = from_verdict(verdict, loaded, kind=kind, limits=product.text, **rest)
    return history.add(record)


def _seen_anew(verdict: Verdict) -> str:
    """Which rig and calibration captures were re-analysed with, in place of their own."""
    from motorid.report.words import instruments

    found = [instruments(one) for one in verdict.inputs if one.get("reanalysed")]
    return "; ".join(dict.fromkeys(found))


def remember_inspection(
    where: str, done: Inspection, product: Product, captures: Sequence[Path] = (), **rest: Any
) -> bool:
    """Adds what came of one motor to the history at ``where``; ``captures`` if not its own one."""
    from motorid.quality.history import open_history
    from motorid.workflow.check import CAPTURE

    own = [done.folder / CAPTURE] if done.folder else []
    paths = captures or [path for path in own if path.exists()]
    with open_history(where) as history:
        return remember(history, done.verdict, paths, product, **rest)


def judge_into(
    history: History, product: Product, paths: Sequence[Path], **rest: Any
) -> Iterator[Judged]:
    """Judges each capture and adds the verdict, one after the other."""
    for path in paths:
        yield _judged(history, product, [path], "", "check", rest)


def rejudge(
    history: History, product: Product, query: Query, *, folders: Sequence[Path] = ()
) -> Iterator[Judged]:
    """Judges the captures of the results that ``query`` chooses by today's ``product``.

    Captures are found where they were recorded, or by name under ``folders``; another SHA-256
    than the recorded one is a failure. The old results stay as they are.
    """
    seen: set[tuple[str, ...]] = set()
    for row in history.results(query)[::-1]:  # the newest outcome of a capture is the one before
        cited = history.captures_of(row.id)
        hashes = tuple(capture.sha256 for capture in cited)
        if not cited or hashes in seen:
            continue
        seen.add(hashes)
        try:
            paths = [found_capture(capture, folders) for capture in cited]
        except DataError as error:
            yield Judged(row.serial, cited[0].path, row.outcome, "", (), False, str(error))
            continue
        yield _judged(history, product, paths, row.outcome, "rejudged", {"station": row.station})


def found_capture(capture: Any, folders: Sequence[Path]) -> Path:
    """The file of a capture, and no other. Raises DataError."""
    from motorid.workflow.many import sha256_of

    there = Path(capture.path)
    elsewhere = (p for folder in folders for p in sorted(folder.rglob(there.name)))
    for path in [there, *elsewhere]:
        if path.is_file() and sha256_of(path) == capture.sha256:
            return path
    changed = "has other bytes now" if there.is_file() else "is not there any more"
    raise DataError(f"the capture {there} {changed}: say by --captures where captures are kept")


def _judged(
    history: History,
    product: Product,
    paths: Sequence[Path],
    before: str,
    kind: Kind,
    rest: dict[str, Any],
) -> Judged:
    from motorid.workflow.check import judge_files

    try:
        verdict, _ = judge_files(paths, product)
        new = remember(history, verdict, paths, product, kind=kind, **rest)
    except MotoridError as error:
        return Judged("", str(paths[0]), before, "", (), False, str(error))
    outcome = str(verdict.outcome)
    return Judged(verdict.serial, str(paths[0]), before, outcome, verdict.reasons, new)


def trace(history: History, what: str) -> str:
    """From a serial number, a capture's file or the beginning of its SHA-256: all that hangs on it.

    Raises DataError where the history knows nothing of it.
    """
    from motorid.workflow.many import sha256_of

    path = Path(what)
    if path.is_file():
        captures = history.captures(sha256=sha256_of(path))
    else:
        captures = history.captures(serial=what)
        if not captures and len(what) >= 6:
            captures = history.captures(sha256=what.lower())
    if not captures:
        raise DataError(f"the history {history.where} knows no motor and no capture {what!r}")
    return "\n\n".join("\n".join(_trace(history, capture)) for capture in captures)


def _trace(history: History, capture: Any) -> Iterator[str]:
    created = f"{capture.created:%Y-%m-%d %H:%M:%S} UTC" if capture.created else "unknown"
    yield f"motor {capture.serial or 'without a serial number'}"
    yield f"  {'capture':<12}{capture.path}"
    yield f"  {'sha256':<12}{capture.sha256}"
    yield f"  {'created':<12}{created}, {capture.samples} samples, {capture.end_reason}"
    for name in ("rig", "program", "calibration"):
        digest = getattr(capture, name)
        yield f"  {name:<12}{digest[:12] if digest else 'none'}"
    for row in history.results_of(capture.sha256):
        marginal = " MARGINAL" if row.marginal else ""
        by = f" by {history.name_of(row.operator)}" if row.operator else ""
        yield (
            f"  result {row.id}: {row.outcome or row.kind}{marginal}, {row.kind}{by} "
            f"{row.at:%Y-%m-%d %H:%M:%S} UTC, product {row.product or 'none'}, limits "
            f"{row.limits[:12] if row.limits else 'none'}, motorid {row.versions.get('motorid')}"
        )
        for m in history.measurements(row.id):
            if m.outcome and m.outcome != "PASS":
                yield f"    {m.name}: {m.outcome}. {m.reason}"
