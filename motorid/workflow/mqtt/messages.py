"""Topics and payloads; their schemas are in motorid/schemas."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from motorid import json_seal, json_text
from motorid.workflow.check import VERDICT

STATE, EVENT, ACKNOWLEDGED = "motorid-mqtt-state-1", "motorid-mqtt-verdict-1", "acknowledged"
OFFLINE = "OFFLINE"


@dataclass(frozen=True)
class Topics:
    """A station's topics below ``root``, which is TOPIC/STATION."""

    root: str

    @property
    def state(self) -> str:
        """Retained: what the station does."""
        return f"{self.root}/state"

    @property
    def verdict(self) -> str:
        """One message for each verdict, and again until it is acknowledged."""
        return f"{self.root}/verdict"

    @property
    def acknowledged(self) -> str:
        """Where a consumer says which verdict it has."""
        return f"{self.verdict}/{ACKNOWLEDGED}"


def state(word: str, station: str, more: Mapping[str, Any] | None = None) -> bytes:
    """What a station does; ``more`` than that it is OFFLINE: serial, product, unacknowledged."""
    said = {"schema": STATE, "state": word, "station": station, **(more or {})}
    if more is not None:
        said["time"] = datetime.now(UTC).isoformat(timespec="milliseconds")
    return json_text.dumps(said).encode()


def verdict(folder: Path, station: str) -> tuple[str, bytes]:
    """Key and payload of the verdict in an inspection's folder. Raises DataError.

    The key is the digest of the verdict, so that who gets it twice knows.
    """
    stored = json_seal.read(folder / VERDICT, "a verdict")
    key = stored.get(json_seal.MEMBER) or json_seal.digest(stored)
    said = {"schema": EVENT, "key": key, "station": station, "folder": folder.name}
    return str(key), json_text.dumps({**said, "verdict": stored}).encode()


def acknowledged_key(payload: bytes) -> str:
    """The key that a consumer says it has; "" where it says none."""
    try:
        said = json_text.loads(payload)
    except json_text.JsonError:
        return ""
    key = said.get("key") if isinstance(said, dict) else None
    return key if isinstance(key, str) else ""
