"""100 Hz for 24 h of simulated time, in bounded memory: ``python -m tests.load.day --hours 24``.

The motor is left out (its readings are noise around zero), because integrating it for a day takes
half an hour; everything else is the real thing. The board's clock runs at 1 MHz, so that the steps
of a program, 2^32 ticks at most, reach that far.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

from motorid.acquire import record
from motorid.acquire.interrupt import Stop
from motorid.acquire.live import Live
from motorid.capture import store
from motorid.program import Program, Step, StepKind
from motorid.sim import bench, board, chain, identity
from motorid.sim import options as sim_options
from motorid.sim.port import open_sim
from tests.acquire.rigs import sim_rig
from tests.load.measure import peak_mb, resident_mb

CLOCK_HZ = 1_000_000
RATE_HZ = 100.0
HOUR_S = 3600.0


@contextlib.contextmanager
def slow_clock_and_no_motor() -> Iterator[None]:
    """Ticks of a microsecond, and a bench that computes nothing."""

    def still(self: bench.Bench, samples: int) -> tuple[Any, Any]:
        raw = np.full((samples, 3), 2048, np.int16)
        raw[:, 2] = 3276
        self.raw = raw[-1]
        return raw, np.zeros(samples, np.int64)

    with contextlib.ExitStack() as stack:
        for module in (sim_options, board, bench, chain, identity):
            stack.enter_context(mock.patch.object(module, "CLOCK_HZ", CLOCK_HZ))
        stack.enter_context(mock.patch.object(board, "AGE_TICKS", CLOCK_HZ // 20))
        stack.enter_context(mock.patch.object(bench.Bench, "run", still))
        yield


def run(hours: float, folder: Path) -> dict[str, Any]:
    """Captures so long a coast; what it took."""
    seconds = hours * HOUR_S
    memory: list[float] = []

    def progress(live: Live) -> None:
        now = resident_mb()
        if live.done_s > 0.02 * seconds and now is not None:
            memory.append(now)

    began = time.monotonic()
    plan = Program((Step(StepKind.COAST, seconds),))
    rig = sim_rig(program=plan)
    rig = replace(
        rig,
        sampling=replace(rig.sampling, rate_hz=RATE_HZ),
        limits=replace(rig.limits, run_time_s=seconds + 60, supply_min_v=0),
    )
    with slow_clock_and_no_motor():
        port = open_sim("sim://?speed=max&seed=1&pwm=20000&noise=0")
        recorder = record._Recorder(port, rig, plan, Stop(), progress)
        recorder.record(folder / "run.h5", False, "", "", checked=True)
    ran = peak_mb()
    capture = store.load(folder / "run.h5")
    return {
        "hours": hours,
        "samples": len(capture),
        "expected": round(seconds * RATE_HZ),
        "gaps": len(capture.gaps),
        "end": capture.end_reason,
        "memory grew while running by MB": round(memory[-1] - memory[0], 1) if memory else None,
        "peak MB, with building the file": ran,
        "file MB": round((folder / "run.h5").stat().st_size / 2**20, 1),
        "took s": round(time.monotonic() - began),
    }


def main() -> None:
    """Prints what came of it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--hours", type=float, default=24)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        print(json.dumps(run(options.hours, Path(folder)), indent=1))


if __name__ == "__main__":
    main()
