"""A rotor that is not clamped, on the real firmware: it opens the bridge within some counts."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motorid.acquire import record
from motorid.acquire.held_rotor import allowed_counts
from motorid.capture import store
from motorid.errors import RigError
from motorid.excitation import Levels, prbs
from motorid.program import Program, Rotor, Step, StepKind
from motorid.rig_file import parse
from tests.conformance.boards import emulator_lacks
from tests.emulated.motors import rig_text

pytestmark = pytest.mark.slow
STICKY = "&friction=8"  # holds the first weak pulse, and not the program
LEVELS = Levels(StepKind.DRIVE_DUTY, 0.0, 0.5)
WINDOW = 8  # samples of 250 us in the 2 ms of the board's speed


def test_the_firmware_stops_a_rotor_that_breaks_loose(tmp_path: Path) -> None:
    if lack := emulator_lacks():
        pytest.skip(f"no emulated uno: {lack}")
    rig = parse(rig_text("uno", "dunkermotoren-gr42", 3, STICKY))
    rig = replace(rig, nameplate=replace(rig.nameplate, resistance_ohm=5.95))
    program = Program((Step(StepKind.COAST, 0.01), *prbs(LEVELS, 4, 0.05)), Rotor.CLAMPED, 20.0)
    path = tmp_path / "run.h5"
    with pytest.raises(RigError, match="the rotor moved, and the board opened the bridge"):
        record.capture(rig, program, path)
    capture = store.load(path)
    assert capture.end_reason == "fault: over_speed"
    counts = np.rint(capture.channels["position"].values * 256 / (2 * np.pi))
    moved = np.flatnonzero(np.abs(counts - counts[0]) > allowed_counts(rig))
    assert len(moved) <= WINDOW
    assert np.abs(counts - counts[0]).max() < 3 * allowed_counts(rig)
