"""Captures as HDF5: one self-describing file a run. The layout is in docs/file-format.md."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from datetime import datetime
from pathlib import Path
from typing import Any

from motorid.capture.model import Capture
from motorid.capture.naming import refuse_other_format
from motorid.capture.store_write import to_bytes as to_bytes
from motorid.capture.whole import write_whole
from motorid.errors import DataError
from motorid.limits import CAPTURE, refuse_large
from motorid.reading import open_file

_written: set[str] = set()  # SHA-256 of the files that this process has written


def save(capture: Capture, path: str | Path, force: bool = False) -> Path:
    """Writes ``capture`` to ``path``, whole or not at all; returns the path.

    Raises UsageError when ``path`` exists (unless ``force``) or is named as another kind of file,
    DataError when the disk refuses.
    """
    path = Path(path)
    refuse_other_format(path)
    refuse_long(path, len(capture))
    data = to_bytes(capture)
    write_whole(path, data, force=force)
    _written.add(hashlib.sha256(data).hexdigest())
    return path


def refuse_long(path: Path, samples: float) -> None:
    """Raises DataError where a capture of so many samples could not be read again."""
    if CAPTURE.rows is not None and samples > CAPTURE.rows:
        raise DataError(
            f"{path}: {samples:,.0f} samples are more than a capture may have "
            f"({CAPTURE.rows:,}): make the run shorter, or sample more slowly"
        )


def load(path: str | Path) -> Capture:
    """The capture in ``path``, with its SHA-256. Raises DataError when it is none, or damaged.

    What this process has written itself it reads itself; any other file is read by a child, which
    a damaged one may crash or hang.
    """
    refuse_large(Path(path), CAPTURE)
    with open_file(Path(path), DataError) as file:
        data = file.read() if _written else b""
    digest = hashlib.sha256(data).hexdigest()
    if digest in _written:
        from motorid.capture.store_read import read

        return read(data, str(path), digest, own=True)
    return _load_in_child(Path(path))


def _load_in_child(path: Path) -> Capture:
    from motorid.capture import child, store_child, store_pack

    try:
        found = child.arrays_from(store_child.__file__, path, CAPTURE)
        return store_pack.unpack(found)
    except child.ChildFailedError as error:
        raise DataError(
            f"{path}: not a readable capture file: damaged, or none ({error})"
        ) from None


def describe(capture: Capture) -> Mapping[str, Any]:
    """What an estimate cites of its input: path, SHA-256, samples, ambient, rig, calibration."""
    return {
        "path": capture.path,
        "sha256": capture.sha256,
        "samples": len(capture),
        "gaps": sum(gap.samples for gap in capture.gaps),
        "end_reason": capture.end_reason,
        "ambient_c": capture.ambient_c,
        "ambient_uncertainty_c": capture.ambient_uncertainty_c,
        "serial": capture.provenance.get("serial", ""),
        "duration_s": float(capture.time_s[-1]) if len(capture) else 0.0,
        **_instruments(capture.provenance),
    }


def _instruments(known: Mapping[str, Any]) -> dict[str, Any]:
    """What the readings' meaning rests on: rig and calibration, as captured and as re-analysed."""
    found: dict[str, Any] = {}
    if isinstance(known.get("created"), str):
        found["created"] = known["created"]
    if isinstance(known.get("rig_name"), str):
        found["rig_name"] = known["rig_name"]
    if known.get("rig"):
        found["rig_sha256"] = hashlib.sha256(str(known["rig"]).encode()).hexdigest()
    if _cites(known.get("calibration_file")):
        found["calibration"] = known["calibration_file"]
    if known.get("reanalysed"):
        found["reanalysed"] = known["reanalysed"]
    return found


def _cites(what: Any) -> bool:
    """Whether a file's provenance cites a calibration in the words that a reader needs."""
    texts = ("name", "sha256", "date", "oldest", "oldest_part")
    if not isinstance(what, Mapping) or not all(isinstance(what.get(t), str) for t in texts):
        return False
    try:
        return float(what["max_age_days"]) >= 0 and _zoned(what["oldest"])
    except (KeyError, TypeError, ValueError):
        return False


def _zoned(text: str) -> bool:
    return datetime.fromisoformat(text).tzinfo is not None
