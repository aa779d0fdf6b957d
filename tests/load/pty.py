"""10 kHz x 3 channels through a pseudo terminal: ``python -m tests.load.pty --seconds 600``."""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from motorid.acquire import record
from motorid.acquire.live import Live
from motorid.capture import store
from motorid.program import Decay, Program, Step, StepKind
from tests.acquire.rigs import sim_rig
from tests.load.measure import peak_mb, resident_mb

ROOT = Path(__file__).resolve().parents[2]
STEP_S = 20.0
SETTLED_S = 5.0  # from here on memory must not grow


def program(seconds: float) -> Program:
    """3 V and coast in turns."""
    steps, left, drive = [], seconds, True
    while left > 1e-9:
        duration = min(STEP_S, left)
        kind = StepKind.DRIVE_VOLTS if drive else StepKind.COAST
        level, decay = (3.0, Decay.SYNCHRONOUS_SLOW) if drive else (0.0, Decay.NONE)
        steps.append(Step(kind, duration, level, decay))
        left, drive = left - duration, not drive
    return Program(tuple(steps))


@contextlib.contextmanager
def terminal(options: str = "seed=1") -> Iterator[str]:
    """A simulated board on a pseudo terminal, in a process of its own."""
    process = subprocess.Popen(
        [sys.executable, "-u", "-m", "motorid.cli.main", "sim", f"sim://?{options}", "--pty"],
        stdout=subprocess.PIPE,
        text=True,
        cwd=ROOT,
    )
    # it stands for hardware, which nobody slows down
    with contextlib.suppress(PermissionError, AttributeError):
        os.sched_setscheduler(process.pid, os.SCHED_RR, os.sched_param(1))
    try:
        assert process.stdout is not None
        yield process.stdout.readline().split()[-1]
    finally:
        process.terminate()
        process.wait(10)
        if process.stdout is not None:
            process.stdout.close()


@contextlib.contextmanager
def busy(cores: int) -> Iterator[None]:
    """So many processes that do nothing but compute."""
    code = "while True: pass"
    processes = [subprocess.Popen([sys.executable, "-c", code]) for _ in range(cores)]
    try:
        yield
    finally:
        for process in processes:
            process.kill()
            process.wait()


def run(
    seconds: float,
    folder: Path,
    cores: int = 0,
    pause_s: float = 0.0,
    host_silence_s: float = 0.5,
) -> dict[str, Any]:
    """Captures; ``pause_s`` is what the terminal takes to show each line of progress."""
    memory: list[float] = []
    late_s: list[float] = []  # wall time less the board's own

    def progress(live: Live) -> None:
        late_s.append(time.monotonic() - live.done_s)
        if pause_s:
            time.sleep(pause_s)
        now = resident_mb()
        if live.done_s >= SETTLED_S and now is not None:
            memory.append(now)

    plan = program(seconds)
    rig = sim_rig(program=plan)
    limits = replace(rig.limits, run_time_s=seconds + 10, host_silence_s=host_silence_s)
    with terminal() as path, busy(cores):
        rig = replace(rig, port=path, limits=limits)
        record.capture(rig, plan, folder / "run.h5", progress=progress)
    capture = store.load(folder / "run.h5")
    link = capture.provenance["link"]
    return {
        "seconds": seconds,
        "busy processes": cores,
        "load average": os.getloadavg()[0],
        "the board's clock fell behind by s": round(late_s[-1] - late_s[0], 2),
        "samples": len(capture),
        "expected": round(seconds * 10_000),
        "gaps": len(capture.gaps),
        "dropped by the board": link["done"]["dropped"],
        "bad frames": link["bad_frames"],
        "end": capture.end_reason,
        "memory grew by MB": round(memory[-1] - memory[0], 1) if memory else None,
        "peak MB, with building the file": peak_mb(),
    }


def main() -> None:
    """Prints what came of it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=600)
    parser.add_argument("--busy", type=int, default=2, help="processes that load the cores")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        print(json.dumps(run(options.seconds, Path(folder), options.busy), indent=1))


if __name__ == "__main__":
    main()
