"""Simulated rigs for tests of the capture path."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from motorid.acquire import record
from motorid.program import Program, StepKind, climbs
from motorid.rig import Rig, load_rig

SHORT = climbs(
    [[3.0], [6.0]], kind=StepKind.DRIVE_VOLTS, drive_s=0.08, coast_s=[0.1, 0.1], rest_s=0.02
)
SAMPLES = 3800  # of SHORT at 10 kHz


def sim_rig(options: str = "", *, program: Program = SHORT, speed: str = "max") -> Rig:
    """The packaged simulated rig with URL options added, and a program of 0.38 s."""
    rig = load_rig("sim")
    extra = f"&{options}" if options else ""
    return replace(rig, port=f"{rig.port}&speed={speed}{extra}", program=program)


def run(options: str, path: Path, **more: object) -> Path:
    """The capture of SHORT with these options of the simulated rig."""
    rig = sim_rig(options)
    return record.capture(rig, rig.program, path, **more)  # type: ignore[arg-type]
