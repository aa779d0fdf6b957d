"""What the reader of rig files promises of any text: a rig within reason, or one sentence."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

from motorid.errors import RigError
from motorid.rig_file import parse
from tests.fuzz.sentence import check_sentence

ROOT = Path(__file__).resolve().parents[2]
CORPUS = Path(__file__).with_name("rigs")


def check(data: bytes) -> None:
    """Raises where some bytes, as text, break a promise."""
    text = data.decode("utf-8", "replace")
    try:
        rig = parse(text, "rig.toml")
    except RigError as error:
        check_sentence(str(error), len(data), begins="rig.toml: ")
        return
    limits = rig.limits
    assert 0 < limits.current_a < math.inf
    assert 0 < limits.speed_rad_s < math.inf
    assert 0 < limits.host_silence_s < math.inf
    assert limits.supply_min_v < limits.supply_max_v < math.inf
    assert 0 < rig.program.duration_s < math.inf
    assert all(step.duration_s > 0 and math.isfinite(step.level) for step in rig.program.steps)
    assert 0 < rig.sampling.rate_hz < math.inf
    assert rig.text == text
    assert parse(text, "rig.toml") == rig


def seeds() -> Iterator[bytes]:
    """The packaged rigs, and what was kept."""
    for path in sorted([*(ROOT / "rigs").glob("*.toml"), *CORPUS.glob("*")]):
        yield path.read_bytes()
