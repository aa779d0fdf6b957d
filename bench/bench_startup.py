"""How long the command line takes to start, against bare imports, alternating in one run.

    python bench/bench_startup.py [ROUNDS=15]

    motorid --help    at most 2 x  python -c "import click"
    motorid fit FILE  at most 2 x  python -c "import numpy, scipy.optimize, h5py"

FILE is a 10,000-sample capture of the simulated rig. Exit code 1 where a ratio is above its target.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

TARGET = 2.0
ROUNDS = 15
SAMPLES = 10_000
COMMAND = str(Path(sys.executable).with_name("motorid"))


def seconds(command: list[str]) -> float:
    """Wall time of one run of a command, which must succeed."""
    began = time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return time.perf_counter() - began


def ratio(ours: list[str], bare: list[str], rounds: int) -> tuple[float, float, float]:
    """Median seconds of both, and the median of the ratio of neighbouring runs."""
    seconds(ours), seconds(bare)  # caches warm
    pairs = [(seconds(ours), seconds(bare)) for _ in range(rounds)]
    return (
        statistics.median(a for a, _ in pairs),
        statistics.median(b for _, b in pairs),
        statistics.median(a / b for a, b in pairs),
    )


def capture_of_samples(folder: Path) -> Path:
    """A capture of the simulated rig, cut to SAMPLES samples."""
    import motorid
    from motorid.workflow.record import bench

    rig = bench("sim", speed="max")
    whole = motorid.load(motorid.record(rig, folder / "whole.h5"))
    assert len(whole) >= SAMPLES, f"the simulated rig's run has only {len(whole)} samples"
    cut = replace(
        whole,
        ticks=whole.ticks[:SAMPLES],
        channels={
            name: replace(channel, raw=channel.raw[:SAMPLES])
            for name, channel in whole.channels.items()
        },
        phases=tuple(phase for phase in whole.phases if phase.tick <= whole.ticks[SAMPLES - 1]),
    )
    return motorid.save(cut, folder / "capture.h5")


def main(arguments: list[str]) -> int:
    """Prints both comparisons; 1 where one misses its target."""
    rounds = int(arguments[0]) if arguments else ROUNDS
    python = [sys.executable, "-c"]
    with tempfile.TemporaryDirectory() as folder:
        capture = str(capture_of_samples(Path(folder)))
        cases = {
            "motorid --help / import click": ([COMMAND, "--help"], [*python, "import click"]),
            "motorid fit / import numpy, scipy.optimize, h5py": (
                [COMMAND, "fit", capture],
                [*python, "import numpy, scipy.optimize, h5py"],
            ),
        }
        missed = 0
        for name, (ours, bare) in cases.items():
            a, b, r = ratio(ours, bare, rounds)
            verdict = "ok" if r <= TARGET else "MISSED"
            missed += r > TARGET
            print(f"{name}: {a * 1e3:.0f} ms / {b * 1e3:.0f} ms = {r:.2f} (at most 2) {verdict}")
    return int(missed > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
