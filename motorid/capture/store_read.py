"""Reads a capture file that may be damaged, foreign or hostile: checks sizes before it reads."""

from __future__ import annotations

import io
import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, cast, get_args

import h5py
import numpy as np
from numpy.typing import NDArray

from motorid import json_text
from motorid.capture.content_digest import HDF5_ERRORS, carried, checked
from motorid.capture.declared import of_old_import
from motorid.capture.facts import of_provenance
from motorid.capture.model import (
    FACTS,
    QUANTITIES,
    Capture,
    Channel,
    Curve,
    Fact,
    Gap,
    Kind,
    Phase,
    Sense,
    Wiring,
)
from motorid.capture.store_guard import Guard
from motorid.capture.store_layout import (
    CHANNEL_FIELDS,
    DECLARED_MINOR,
    FORMAT,
    MAJOR,
    SEALED_MINOR,
    WIRING_FIELDS,
)
from motorid.errors import DataError, MotoridError
from motorid.limits import CAPTURE
from motorid.program import Program

TEXTS = frozenset(
    {"unit", "kind", "sense", "undeclared", "nonlinearity_shape"}
)  # attributes; all others are numbers
ENDLESS = {"raw_min": -math.inf, "raw_max": math.inf}  # of a reading that never saturates
MAX_TEXT = CAPTURE.cell or 0  # bytes


def read(data: bytes, path: str, sha256: str, *, own: bool = False) -> Capture:
    """The capture in the HDF5 file ``data``. Raises DataError, naming ``path``.

    ``own``: this process wrote the very bytes, so that the digest of the content need not be made.
    """
    try:
        with h5py.File(io.BytesIO(data), "r") as file:
            content_sha256 = carried(file) if own else checked(file, len(data))
            return _Reader(file, len(data)).capture(path, sha256, content_sha256)
    except MotoridError as error:
        raise DataError(f"{path}: {error}") from None
    except HDF5_ERRORS as error:
        what = str(error).splitlines()[0][:200] if str(error) else type(error).__name__
        raise DataError(f"{path}: not a readable capture file: damaged, or none ({what})") from None


class _Reader(Guard):
    """The parts of a capture, each checked before it is read."""

    def capture(self, path: str, sha256: str, content_sha256: str) -> Capture:
        """All of it; ``content_sha256`` is the digest that it carries."""
        self.check_format(content_sha256)
        samples = self.group(self.file, "samples")
        ticks = self.integers(self.column(samples, "tick"), "samples/tick")
        if np.any(np.diff(ticks) <= 0):
            raise DataError("samples/tick does not increase: the file is damaged")
        known = [name for name in QUANTITIES if name in samples]
        names = known + [n for n in self.members(samples) if n != "tick" and n not in known]
        root, provenance = self.file, self.provenance()
        return Capture(
            ticks=ticks,
            clock_hz=self.positive(root, "clock_hz"),
            channels=self.as_imported({n: self.channel(samples, n) for n in names}, provenance),
            clock_uncertainty=self.number(root, "clock_uncertainty", 0.0),
            wiring=Wiring(**self.present(self.group(root, "wiring"), WIRING_FIELDS)),
            program=self.program(),
            phases=self.phases(),
            gaps=self.gaps(len(ticks)),
            end_reason=self.text_attribute(root, "end_reason", "completed"),
            ambient_c=self.number(root, "ambient_c", None),
            ambient_uncertainty_c=self.number(root, "ambient_uncertainty_c", 0.0),
            stated=of_provenance(provenance),
            provenance=provenance,
            sha256=sha256,
            content_sha256=content_sha256,
            path=path,
        )

    def check_format(self, content_sha256: str) -> None:
        if self.text_attribute(self.file, "format", "") != FORMAT:
            raise DataError("an HDF5 file, but not a motorid capture: see `motorid import --help`")
        major = self.number(self.file, "format_major", 0)
        if major != MAJOR:
            raise DataError(
                f"capture format {major:g} is not {MAJOR}, which this version reads: "
                "read it with the motorid that wrote it"
            )
        if not content_sha256 and self.number(self.file, "format_minor", 0) >= SEALED_MINOR:
            raise DataError("its digest is missing: the file is damaged")

    # -- data
    def column(self, parent: h5py.Group, name: str) -> NDArray[Any]:
        dataset = self.dataset(parent, name, 1)
        if dataset.dtype.kind not in "iuf" or dataset.dtype.itemsize > 8:
            raise DataError(f"{name} holds {dataset.dtype}, not numbers: the file is damaged")
        raw = dataset[...]
        return cast(NDArray[Any], raw.astype(raw.dtype.newbyteorder("="), copy=False))

    def integers(self, column: NDArray[Any], name: str) -> NDArray[np.int64]:
        if column.dtype.kind not in "iu":
            raise DataError(f"{name} holds {column.dtype}, not integers: the file is damaged")
        return column.astype(np.int64)

    def text(self, parent: h5py.Group, name: str) -> str:
        dataset = self.dataset(parent, name, 0)
        if h5py.check_string_dtype(dataset.dtype) is None:
            raise DataError(f"{name} is not text: the file is damaged")
        if dataset.dtype.itemsize > MAX_TEXT:
            raise DataError(f"{name} claims {dataset.dtype.itemsize} bytes of text: refused")
        value = dataset[()]
        return value.decode("utf-8") if isinstance(value, bytes) else str(value)

    def table(self, name: str, columns: tuple[str, ...]) -> NDArray[Any]:
        dataset = self.dataset(self.file, name, 1)
        if not set(columns) <= set(dataset.dtype.names or ()):
            raise DataError(f"{name} lacks one of {', '.join(columns)}: the file is damaged")
        return cast(NDArray[Any], dataset[...])

    # -- parts
    def channel(self, samples: h5py.Group, name: str) -> Channel:
        raw = self.column(samples, name)
        facts = self.present(samples[name], CHANNEL_FIELDS)
        for key, words in (("kind", Kind), ("sense", Sense), ("nonlinearity_shape", Curve)):
            allowed = get_args(words)
            if key in facts and facts[key] not in allowed:
                raise DataError(f"samples/{name}: {key} is {facts[key]!r}: the file is damaged")
        if not facts.get("scale"):
            raise DataError(f"samples/{name} has no scale: the file is damaged")
        order = facts.setdefault("filter_order", 1)
        if order not in (1, 2):
            raise DataError(f"samples/{name}: filter_order is {order}: the file is damaged")
        facts["filter_order"] = int(order)
        facts["undeclared"] = self.undeclared(facts.get("undeclared", ""), name)
        facts.setdefault("unit", "")
        for key in ("unsigned", "ratiometric"):
            facts[key] = bool(facts.get(key, False))
        return Channel(name=name, raw=raw, **facts)

    def undeclared(self, text: str, name: str) -> tuple[Fact, ...]:
        found = tuple(fact for fact in FACTS if fact in text.split())
        if len(found) != len(text.split()):
            raise DataError(f"samples/{name}: undeclared is {text!r}: the file is damaged")
        return found

    def as_imported(
        self, channels: dict[str, Channel], provenance: Mapping[str, Any]
    ) -> dict[str, Channel]:
        """Channels of another's file, of which an older format does not say what was stated."""
        told = self.number(self.file, "format_minor", 0) >= DECLARED_MINOR
        if told or "imported_from" not in provenance:
            return channels
        return {n: replace(c, undeclared=of_old_import(c)) for n, c in channels.items()}

    def phases(self) -> tuple[Phase, ...]:
        table = self.table("phases", ("index", "tick"))
        return tuple(Phase(int(row["index"]), int(row["tick"])) for row in table)

    def gaps(self, samples: int) -> tuple[Gap, ...]:
        gaps = tuple(
            Gap(int(row["index"]), int(row["samples"]), bytes(row["reason"]).decode("utf-8"))
            for row in self.table("gaps", ("index", "samples", "reason"))
        )
        if any(not 0 <= gap.index <= samples for gap in gaps):
            raise DataError("a gap lies outside the samples: the file is damaged")
        return gaps

    def program(self) -> Program | None:
        if "program" not in self.file:
            return None
        return Program.from_dict(json_text.loads(self.text(self.file, "program")))

    def provenance(self) -> dict[str, Any]:
        group = self.group(self.file, "provenance")
        found: dict[str, Any] = {}
        for key in self.members(group):
            text = self.text(group, key)
            encoded = self.text_attribute(group[key], "encoding", "text") == "json"
            found[key] = json_text.loads(text) if encoded else text
        return found

    # -- attributes: one number or one short text each
    def attribute(self, target: Any, name: str) -> Any:
        if name not in target.attrs:
            return None
        handle = target.attrs.get_id(name)
        text = h5py.check_string_dtype(handle.dtype) is not None
        if handle.shape != () or not (text or handle.dtype.kind in "iufb"):
            raise DataError(f"attribute {name} has the wrong type: the file is damaged")
        value = target.attrs[name]
        if isinstance(value, bytes):
            return value.decode("utf-8")
        return value if isinstance(value, str) else value.item()

    def text_attribute(self, target: Any, name: str, default: str) -> str:
        value = self.attribute(target, name)
        return value if isinstance(value, str) else default

    def number(self, target: Any, name: str, default: float | None) -> Any:
        value = self.attribute(target, name)
        if value is None:
            return default
        if isinstance(value, str) or not math.isfinite(value):
            raise DataError(f"attribute {name} is not a number: the file is damaged")
        return float(value)

    def positive(self, target: Any, name: str) -> float:
        value = self.number(target, name, None)
        if value is None or not value > 0:
            raise DataError(f"attribute {name} must be above 0: the file is damaged")
        return float(value)

    def present(self, target: Any, names: tuple[str, ...]) -> dict[str, Any]:
        found = {}
        for name in names:
            value = self.attribute(target, name)
            wrong = isinstance(value, str) != (name in TEXTS) or (
                isinstance(value, float) and not math.isfinite(value) and value != ENDLESS.get(name)
            )
            if value is not None and wrong:
                raise DataError(f"attribute {name} is {value!r}: the file is damaged")
            if value is not None:
                found[name] = value
        return found
