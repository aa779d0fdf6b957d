"""A capture as plain arrays, which a child hands to its parent, and back."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from motorid import json_text
from motorid.capture.facts import of_provenance
from motorid.capture.model import Capture, Channel, Gap, Phase, Wiring
from motorid.capture.store_layout import CHANNEL_FIELDS, WIRING_FIELDS
from motorid.program import Program

PLAIN = ("clock_hz", "clock_uncertainty", "end_reason", "ambient_c", "ambient_uncertainty_c",
         "sha256", "content_sha256", "path")  # fmt: skip


def pack(capture: Capture) -> dict[str, Any]:
    """A capture as arrays: ticks, each channel's readings by number, and the facts."""
    channels = list(capture.channels.values())
    facts = {name: getattr(capture, name) for name in PLAIN} | {
        "channels": [
            {"name": c.name} | {f: getattr(c, f) for f in CHANNEL_FIELDS if _is_written(c, f)}
            for c in channels
        ],
        "wiring": {name: getattr(capture.wiring, name) for name in WIRING_FIELDS},
        "program": capture.program.to_dict() if capture.program is not None else None,
        "phases": [(phase.index, phase.tick) for phase in capture.phases],
        "gaps": [(gap.index, gap.samples, gap.reason) for gap in capture.gaps],
        "provenance": dict(capture.provenance),
    }
    arrays = {f"raw{number}": np.asarray(c.raw) for number, c in enumerate(channels)}
    text = np.frombuffer(json_text.dumps(facts).encode(), dtype=np.uint8)
    return {"ticks": capture.ticks, "facts": text, **arrays}


def _is_written(channel: Channel, name: str) -> bool:
    """Infinity, which JSON does not know, is only ever the default of a reading's ends."""
    value = getattr(channel, name)
    return not (isinstance(value, float) and math.isinf(value))


def unpack(arrays: Any) -> Capture:
    """The capture that ``pack`` packed."""
    facts = json_text.loads(arrays["facts"].tobytes())
    channels = {
        fact["name"]: Channel(
            raw=arrays[f"raw{number}"], **fact | {"undeclared": tuple(fact["undeclared"])}
        )
        for number, fact in enumerate(facts["channels"])
    }
    program = facts["program"]
    return Capture(
        ticks=arrays["ticks"],
        channels=channels,
        wiring=Wiring(**facts["wiring"]),
        program=None if program is None else Program.from_dict(program),
        phases=tuple(Phase(*phase) for phase in facts["phases"]),
        gaps=tuple(Gap(*gap) for gap in facts["gaps"]),
        stated=of_provenance(facts["provenance"]),
        provenance=facts["provenance"],
        **{name: facts[name] for name in PLAIN},
    )
