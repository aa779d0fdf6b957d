"""Writes a capture as HDF5. The layout is in docs/file-format.md."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from motorid import json_text
from motorid.capture.model import Capture
from motorid.capture.store_layout import (
    CHANNEL_FIELDS,
    CHUNK,
    FORMAT,
    GAPS,
    MAJOR,
    MINOR,
    PHASES,
    WIRING_FIELDS,
)
from motorid.version import __version__

if TYPE_CHECKING:
    import h5py


def to_bytes(capture: Capture) -> bytes:
    """The HDF5 file of ``capture``; the same capture always gives the same bytes."""
    import h5py

    from motorid.capture.content_digest import seal

    image = io.BytesIO()
    with h5py.File(image, "w", libver=("earliest", "v110")) as file:
        file.attrs.update(_root(capture))
        _write_samples(file, capture)
        _write_attributes(file.create_group("wiring"), capture.wiring, WIRING_FIELDS)
        phases = [(p.index, p.tick) for p in capture.phases]
        gaps = [(g.index, g.samples, g.reason.encode()[:120]) for g in capture.gaps]
        _write_rows(file, "phases", np.array(phases, dtype=PHASES))
        _write_rows(file, "gaps", np.array(gaps, dtype=GAPS))
        if capture.program is not None:
            _write_text(file, "program", json_text.dumps(capture.program.to_dict()), "json")
        provenance = file.create_group("provenance")
        for key, value in capture.provenance.items():
            if isinstance(value, str):
                _write_text(provenance, key, value, "text")
            else:
                _write_text(provenance, key, json_text.dumps(value), "json")
        seal(file)
    return image.getvalue()


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
    _write_rows(samples, "tick", np.asarray(capture.ticks, dtype="<i8"))
    samples["tick"].attrs["unit"] = "tick"
    samples["tick"].attrs["doc"] = "board clock at the sample; seconds = tick / clock_hz"
    for name, channel in capture.channels.items():
        raw = np.asarray(channel.raw)
        little = raw.astype(raw.dtype.newbyteorder("<"), copy=False)
        column = _write_rows(samples, name, little)
        column.attrs["doc"] = "raw reading; value in unit = scale * (raw - offset)"
        _write_attributes(column, channel, CHANNEL_FIELDS)


def _write_rows(group: h5py.Group, name: str, rows: NDArray[Any]) -> h5py.Dataset:
    """A column or table, with a checksum for every ``CHUNK`` rows."""
    if not len(rows):  # nothing has no checksum
        return group.create_dataset(name, data=rows)
    return group.create_dataset(name, data=rows, chunks=(min(len(rows), CHUNK),), fletcher32=True)


def _write_attributes(
    target: h5py.Group | h5py.Dataset, source: Any, names: tuple[str, ...]
) -> None:
    for name in names:
        value = getattr(source, name)
        if isinstance(value, tuple):
            value = " ".join(value) or None  # no text of no length: HDF5 has none
        if value is not None:
            target.attrs[name] = value


def _write_text(group: h5py.Group, name: str, text: str, encoding: str) -> None:
    import h5py

    data = text.replace("\0", "").encode()
    dtype = h5py.string_dtype("utf-8", max(1, len(data)))
    group.create_dataset(name, data=data, dtype=dtype).attrs["encoding"] = encoding
