"""Verdicts into the history, and traces through it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorid.errors import DataError
from motorid.storage.captures import load, sha256_of
from motorid.storage.place import place

if TYPE_CHECKING:
    from motorid.capture.model import Capture
    from motorid.quality.history import History
    from motorid.quality.history.records import Kind, ResultRecord
    from motorid.quality.product import Product
    from motorid.quality.verdict import Verdict
    from motorid.storage.place import Place, Url
    from motorid.workflow.check import Inspection


def remember(
    history: History,
    verdict: Verdict,
    captures: Sequence[Place],
    product: Product,
    *,
    kind: Kind = "check",
    **rest: Any,
) -> bool:
    """Adds a verdict and the captures it rests on; False where the history has it already.

    ``rest``: station, operator, note, at (see ``ResultRecord``). It is on disk when this returns.
    """
    loaded = [load(path) for path in captures]
    return history.add(record_of(verdict, loaded, product, kind=kind, **rest))


def record_of(
    verdict: Verdict, captures: Sequence[Capture], product: Product, *, kind: Kind, **rest: Any
) -> ResultRecord:
    """What the history keeps of a verdict on ``captures``; see ``remember``."""
    from motorid.quality.history.records import from_verdict

    if seen := _seen_anew(verdict):
        rest["note"] = "; ".join(part for part in (rest.get("note", ""), seen) if part)
    return from_verdict(verdict, captures, kind=kind, limits=product.text, **rest)


def _seen_anew(verdict: Verdict) -> str:
    """Which rig and calibration captures were re-analysed with, in place of their own."""
    from motorid.report.words import instruments

    found = [instruments(one) for one in verdict.inputs if one.get("reanalysed")]
    return "; ".join(dict.fromkeys(found))


def remember_inspection(
    where: str,
    done: Inspection,
    product: Product,
    captures: Sequence[Place] = (),
    *,
    kept: Url | None = None,
    **rest: Any,
) -> bool:
    """Adds what came of one motor to the history at ``where``; ``captures`` if not its own one.

    ``kept``: the folder in an object store that its own folder is copied to.
    """
    from motorid.quality.history import open_history
    from motorid.workflow.check import CAPTURE

    own = [done.folder / CAPTURE] if done.folder else []
    loaded = [load(path) for path in captures or [path for path in own if path.exists()]]
    if kept is not None and not captures:
        loaded = [replace(one, path=str(kept / CAPTURE)) for one in loaded]
    with open_history(where) as history:
        return history.add(record_of(done.verdict, loaded, product, kind="check", **rest))


def trace(history: History, what: str) -> str:
    """From a serial number, a capture's file or the beginning of its SHA-256: all that hangs on it.

    Raises DataError where the history knows nothing of it.
    """
    if _is_file(found := place(what)):
        captures = history.captures(sha256=sha256_of(found))
    else:
        captures = history.captures(serial=what)
        if not captures and len(what) >= 6:
            captures = history.captures(sha256=what.lower())
    if not captures:
        raise DataError(f"the history {history.where} knows no motor and no capture {what!r}")
    return "\n\n".join("\n".join(_trace(history, capture)) for capture in captures)


def _is_file(found: Place) -> bool:
    return found.is_file() if isinstance(found, Path) else True


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
