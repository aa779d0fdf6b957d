"""Captures as HDF5: one self-describing file a run. The layout is in docs/file-format.md."""

from __future__ import annotations

import hashlib
import io
from collections.abc import Mapping
from dataclasses import fields
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from motorid import json_text
from motorid.capture.model import Capture, Channel, Wiring
from motorid.capture.whole import write_whole
from motorid.errors import DataError
from motorid.reading import open_file
from motorid.version import __version__

if TYPE_CHECKING:
    import h5py

FORMAT = "motorid capture"
MAJOR, MINOR = 1, 0
REASON = "S120"
PHASES = np.dtype([("index", "<i4"), ("tick", "<i8")])
GAPS = np.dtype([("index", "<i8"), ("samples", "<i8"), ("reason", REASON)])
CHANNEL_FIELDS = tuple(f.name for f in fields(Channel) if f.name not in ("name", "raw"))
WIRING_FIELDS = tuple(f.name for f in fields(Wiring))
_written: set[str] = set()  # SHA-256 of the files that this process has written


def save(capture: Capture, path: str | Path, force: bool = False) -> Path:
    """Writes ``capture`` to ``path``, whole or not at all; returns the path.

    Raises UsageError when ``path`` exists (unless ``force``), DataError when the disk refuses.
    """
    path = Path(path)
    data = to_bytes(capture)
    write_whole(path, data, force=force)
    _written.add(hashlib.sha256(data).hexdigest())
    return path


def load(path: str | Path) -> Capture:
    """The capture in ``path``, with its SHA-256. Raises DataError when it is none, or damaged.

    What this process has written itself it reads itself; any other file is read by a child, which
    a damaged one may crash or hang.
    """
    with open_file(Path(path), DataError) as file:
        data = file.read() if _written else b""
    digest = hashlib.sha256(data).hexdigest()
    if digest in _written:
        from motorid.capture.store_read import read

        return read(data, str(path), digest)
    return _load_in_child(Path(path))


def _load_in_child(path: Path) -> Capture:
    from motorid.capture import child, store_child

    try:
        found = child.arrays_from(store_child.__file__, path, time_s=child.TIME_LIMIT_S)
        return store_child.unpack(found)
    except child.ChildFailedError as error:
        raise DataError(f"{path}: not a readable capture file ({error})") from None


def to_bytes(capture: Capture) -> bytes:
    """The HDF5 file of ``capture``; the same capture always gives the same bytes."""
    import h5py

    with h5py.File(io.BytesIO(), "w", libver=("earliest", "v110")) as file:
        file.attrs.update(_root(capture))
        _write_samples(file, capture)
        _write_attributes(file.create_group("wiring"), capture.wiring, WIRING_FIELDS)
        file["phases"] = np.array([(p.index, p.tick) for p in capture.phases], dtype=PHASES)
        file["gaps"] = np.array(
            [(g.index, g.samples, g.reason.encode()[:120]) for g in capture.gaps], dtype=GAPS
        )
        if capture.program is not None:
            _write_text(file, "program", json_text.dumps(capture.program.to_dict()), "json")
        provenance = file.create_group("provenance")
        for key, value in capture.provenance.items():
            if isinstance(value, str):
                _write_text(provenance, key, value, "text")
            else:
                _write_text(provenance, key, json_text.dumps(value), "json")
        file.flush()
        return bytes(file.id.get_file_image())


def _root(capture: Capture) -> dict[str, Any]:
    attributes = {
        "format": FORMAT,
        "format_major": MAJOR,
        "format_minor": MINOR,
        "written_by": f"motorid {__version__}",
        "clock_hz": capture.clock_hz,
        "clock_uncertainty": capture.clock_uncertainty,
        "end_reason": capture.end_reason,
        "ambient_uncertainty_c": capture.ambient_uncertainty_c,
    }
    if capture.ambient_c is not None:
        attributes["ambient_c"] = capture.ambient_c
    return attributes


def _write_samples(file: h5py.File, capture: Capture) -> None:
    samples = file.create_group("samples")
    samples["tick"] = np.asarray(capture.ticks, dtype="<i8")
    samples["tick"].attrs["unit"] = "tick"
    samples["tick"].attrs["doc"] = "board clock at the sample; seconds = tick / clock_hz"
    for name, channel in capture.channels.items():
        raw = np.asarray(channel.raw)
        column = samples.create_dataset(name, data=raw.astype(raw.dtype.newbyteorder("<")))
        column.attrs["doc"] = "raw reading; value in unit = scale * (raw - offset)"
        _write_attributes(column, channel, CHANNEL_FIELDS)


def _write_attributes(
    target: h5py.Group | h5py.Dataset, source: Any, names: tuple[str, ...]
) -> None:
    for name in names:
        value = getattr(source, name)
        if value is not None:
            target.attrs[name] = value


def _write_text(group: h5py.Group, name: str, text: str, encoding: str) -> None:
    import h5py

    data = text.replace("\0", "").encode()
    dtype = h5py.string_dtype("utf-8", max(1, len(data)))
    group.create_dataset(name, data=data, dtype=dtype).attrs["encoding"] = encoding


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
