"""What goes into the history: plain records, and the digest that makes each of them go in once."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any, Literal

from motorid import json_text

if TYPE_CHECKING:
    from motorid.capture.model import Capture
    from motorid.quality.verdict import Verdict

Kind = Literal["check", "rejudged", "fit", "golden"]
CALIBRATION = (  # of a capture's provenance: what its readings' meaning rests on
    *("descriptors", "zero", "configuration"),
    *("board_serial", "calibration_file", "calibration_text"),
)


@dataclass(frozen=True)
class MeasurementRecord:
    """One quantity: value and standard uncertainty in ``unit``, limits (None: none), outcome."""

    name: str
    unit: str
    value: float | None
    uncertainty: float | None = None
    low: float | None = None
    high: float | None = None
    guard_band: float | None = None
    outcome: str = ""
    marginal: bool = False
    reason: str = ""


@dataclass(frozen=True)
class CaptureRecord:
    """A capture as the history cites it: by the SHA-256 of its file, with the texts it rests on."""

    sha256: str
    path: str
    serial: str = ""
    created: datetime | None = None
    samples: int = 0
    end_reason: str = ""
    rig: str = ""
    program: str = ""
    calibration: str = ""


@dataclass(frozen=True)
class ResultRecord:
    """One judgement or one fit, with everything it rests on.

    ``limits`` is the product file's text, ``estimate`` the estimate's JSON. ``at`` must carry its
    time zone.
    """

    kind: Kind
    serial: str
    measurements: tuple[MeasurementRecord, ...]
    captures: tuple[CaptureRecord, ...] = ()
    product: str = ""
    outcome: str = ""
    marginal: bool = False
    at: datetime = field(default_factory=lambda: datetime.now(UTC))
    station: str = ""
    operator: str = ""
    note: str = ""
    versions: Mapping[str, str] = field(default_factory=dict)
    limits: str = ""
    estimate: str = ""

    @property
    def key(self) -> str:
        """Digest of what the result says and rests on; of the time only where no capture tells.

        The same capture judged again by the same limits, with the same answer, is the same result.
        """
        said = {
            "kind": self.kind,
            "serial": self.serial,
            "product": self.product,
            "outcome": self.outcome,
            "captures": [capture.sha256 for capture in self.captures],
            "limits": digest(self.limits),
            "versions": dict(sorted(self.versions.items())),
            "measurements": [asdict(m) for m in self.measurements],
            "at": "" if self.captures else self.at.astimezone(UTC).isoformat(),
        }
        return digest(json_text.canonical(said))


def to_plain(record: ResultRecord) -> dict[str, Any]:
    """``record`` as data that JSON can carry."""
    found: dict[str, Any] = json_text.loads(json_text.dumps(asdict(record)))
    found["at"] = record.at.isoformat()
    for said, capture in zip(found["captures"], record.captures, strict=True):
        said["created"] = capture.created.isoformat() if capture.created else None
    return found


def from_plain(data: Mapping[str, Any]) -> ResultRecord:
    """The record that ``to_plain`` made ``data`` of."""
    measured = tuple(MeasurementRecord(**one) for one in data["measurements"])
    captures = tuple(
        CaptureRecord(**{**one, "created": _instant(one["created"])}) for one in data["captures"]
    )
    at = datetime.fromisoformat(data["at"])
    return ResultRecord(**{**data, "measurements": measured, "captures": captures, "at": at})


def digest(text: str) -> str:
    """SHA-256 of a text, in hexadecimal."""
    return hashlib.sha256(text.encode()).hexdigest()


def capture_record(capture: Capture) -> CaptureRecord:
    """What the history keeps of a capture that was loaded from a file."""
    known = capture.provenance
    calibration = {k: known[k] for k in CALIBRATION if known.get(k)}
    program = capture.program
    return CaptureRecord(
        sha256=capture.sha256,
        path=capture.path,
        serial=str(known.get("serial", "")),
        created=_instant(known.get("created")),
        samples=len(capture),
        end_reason=capture.end_reason,
        rig=str(known.get("rig", "")),
        program=json_text.canonical(program.to_dict()) if program else "",
        calibration=json_text.canonical(calibration) if calibration else "",
    )


def _instant(text: Any) -> datetime | None:
    """A capture's creation time; None where its tool wrote none that can be read."""
    try:
        found = datetime.fromisoformat(str(text))
    except ValueError:
        return None
    return found if found.tzinfo else found.replace(tzinfo=UTC)


def from_verdict(
    verdict: Verdict,
    captures: Sequence[Capture],
    *,
    kind: Kind = "check",
    limits: str = "",
    estimate_json: str = "",
    **rest: Any,
) -> ResultRecord:
    """The record of a verdict; ``limits`` is the text of the product file it was judged by."""
    found = tuple(
        MeasurementRecord(
            m.quantity,
            m.limit.unit,
            _finite(m.reading.value),
            _finite(m.reading.uncertainty),
            _finite(m.limit.low),
            _finite(m.limit.high),
            _finite(m.guard_band),
            str(m.outcome),
            m.marginal,
            m.reason,
        )
        for m in verdict.measurements
    )
    return ResultRecord(
        kind,
        verdict.serial,
        found,
        tuple(capture_record(capture) for capture in captures),
        product=verdict.product,
        outcome=str(verdict.outcome),
        marginal=verdict.marginal,
        versions=dict(verdict.versions),
        limits=limits,
        estimate=estimate_json,
        **rest,
    )


def from_stored(
    stored: Mapping[str, Any], captures: Sequence[Capture], *, limits: str = "", **rest: Any
) -> ResultRecord:
    """The record of a verdict as it was written to disk, at its time (see ``quality.records``).

    ``rest``: station and operator, where the verdict does not say them itself.
    Raises KeyError or ValueError where a part of it is missing.
    """
    found = tuple(
        MeasurementRecord(
            str(m["quantity"]), str(m["unit"]), m["value"], m["uncertainty"], m["low"], m["high"],
            m["guard_band"], str(m["outcome"]), bool(m["marginal"]), str(m["reason"]),
        )
        for m in stored["measurements"]
    )  # fmt: skip
    rest |= {name: str(stored[name]) for name in ("station", "operator") if stored.get(name)}
    if stored.get("retest"):
        rest["note"] = f"tested again: {stored['retest']}"
    return ResultRecord(
        "check",
        str(stored["serial"]),
        found,
        tuple(capture_record(capture) for capture in captures),
        product=str(stored["product"]),
        outcome=str(stored["outcome"]),
        marginal=bool(stored["marginal"]),
        at=datetime.fromisoformat(str(stored["time"])),
        versions=dict(stored["versions"]),
        limits=limits,
        **rest,
    )


def _finite(value: float | None) -> float | None:
    """As a database can hold it: an absent limit is NULL and not infinity."""
    return float(value) if value is not None and math.isfinite(value) else None
