"""Segments of captures from the simulated rig: switched bridge, converters, ripple and all."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from motorid.acquire import record
from motorid.capture import store
from motorid.capture.model import Capture
from motorid.program import StepKind
from motorid.rig import load_rig
from motorid.segment import SegmentKind, segment

LEVEL = ["acceleration", "steady"]
EXPECTED = ["rest", *LEVEL * 3, "brake", "coast", "rest", *LEVEL, "coast", "rest"]
WANTED = {StepKind.COAST: SegmentKind.COAST, StepKind.BRAKE: SegmentKind.BRAKE}


def capture_of(rig_name: str, folder: Path, extra: str = "") -> Capture:
    rig = load_rig(rig_name)
    rig = dataclasses.replace(rig, port=f"{rig.port}&speed=max{extra}")
    return store.load(record.capture(rig, rig.program, folder / "run.h5"))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rig_name", "extra"),
    [
        ("sim", ""),
        ("sim", "&seed=9&noise=8"),
        ("sim", "&seed=2&noise=30"),
        ("sim", "&ripple=0.05&cogging=2e-4"),
        ("sim", "&seed=7&noise=3&brush_drop=0.4"),
        ("sim-pittman", ""),
        ("sim-qube", ""),
        ("sim-re35", ""),
    ],
)
def test_the_default_program_is_read_back_from_the_signals(
    rig_name: str, extra: str, tmp_path: Path
) -> None:
    capture = capture_of(rig_name, tmp_path, extra)
    found = segment(capture)
    assert [s.kind for s in found] == EXPECTED
    program = capture.program
    assert program is not None
    steps = [program.steps[p.index].kind for p in capture.phases]
    ticks = [p.tick for p in capture.phases]
    samples = np.searchsorted(capture.ticks, ticks)
    for kind, sample in zip(steps, samples, strict=True):
        wanted = WANTED.get(kind, SegmentKind.ACCELERATION)
        if sample == 0:
            continue
        near = min(found, key=lambda s: abs(s.start - sample))
        assert near.kind is wanted
        assert 0 <= near.start - sample <= 6  # the current needs a moment to go
