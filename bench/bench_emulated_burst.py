"""L of motors whose current settles fast, through the emulated Uno.

    python bench/bench_emulated_burst.py [BOARD=uno] [MOTOR ..]

A run at 4 kHz, alone and beside four fast bursts of 4.75 ms at 16 kHz.

Each cell is L's error in percent and, in brackets, half of its 95 % interval.
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import motorid
from motorid.program import Decay, Program, Step, StepKind
from motorid.sim.motor import find_motor
from motorid.workflow.record import bench, bursting, capture_runs
from tests.emulated.motors import SURE, rig_text

MOTORS = ("faulhaber-2338s006s", "qube-servo", "maxon-re35")
CHANNELS = ("current", "supply_voltage", "position")  # the terminals' filter would smear the step
START = Program(
    (
        Step(StepKind.COAST, 0.5e-3),
        Step(StepKind.DRIVE_DUTY, 2e-3, 1.0, Decay.SYNCHRONOUS_SLOW),
        Step(StepKind.BRAKE, 1.25e-3),
        Step(StepKind.COAST, 1e-3),
    )
)


def cell(captures: list[Path], truth: float) -> str:
    found = motorid.fit(*captures).parameters["L"]
    return f"{100 * (found.value / truth - 1):+.2f} ({100 * SURE * found.total / truth:.2f})"


def main(arguments: list[str]) -> int:
    board = arguments[0] if arguments else "uno"
    print("| motor | L/R | run | run and bursts |\n|---|---:|---:|---:|")
    for motor in arguments[1:] or MOTORS:
        m = find_motor(motor)[1]
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            (folder / "rig.toml").write_text(rig_text(board, motor, 1), encoding="utf-8")
            rig = bench(str(folder / "rig.toml"))
            run = capture_runs(rig, folder / "run.h5")
            fast = bursting(replace(rig, voltage_sense="supply", program=START))
            fast = replace(fast, sampling=replace(fast.sampling, channels=CHANNELS))
            bursts = capture_runs(fast, folder / "burst.h5", repeat=4)
            sets = (run, [*run, *bursts])
            cells = " | ".join(cell(captures, m.inductance_h) for captures in sets)
        tau_ms = 1e3 * m.inductance_h / m.resistance_ohm
        print(f"| {motor} | {tau_ms:.3f} ms | {cells} |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
