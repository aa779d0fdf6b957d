"""The cycle of a station on the simulated line in real time, motor after motor, against 2 s.

    python bench/bench_cycle.py [MOTORS=7]

Capture, fit, verdict and records as ``motorid station`` makes them, in one warm process. Judged on
a computer of its own only: a core that is shared is waited for.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from motorid.quality.product import load_product
from motorid.rig import load_rig
from motorid.sim import truth
from motorid.workflow.check import Line, judge_files

MOST_S, MOST_JUDGED_S = 2.0, 0.15
PARTS = ("capture", "fit", "verdict", "records")


def main(arguments: list[str]) -> int:
    """Prints the figures; exit code 1 where one misses its target."""
    count = int(arguments[0]) if arguments else 7
    rig, product = load_rig("sim-line"), load_product("sim-disc")
    true = truth(rig.port)
    print(f"mechanical time constant {1e3 * true['J'] * true['R_25'] / true['K_25'] ** 2:.1f} ms")
    with tempfile.TemporaryDirectory() as name, Line(rig, product, Path(name)) as line:
        line.warm()
        done = [line.inspect(f"D{k:06d}") for k in range(count)]
        paths = [one.folder / "capture.h5" for one in done if one.folder]
        judged = [processor_s(lambda path=path: judge_files([path], product)) for path in paths]
    for part in PARTS:
        show(part, [one.seconds[part] for one in done])
    whole = [sum(one.seconds.values()) for one in done]
    show("the whole, on the clock", whole)
    show("fit and verdict, processor", judged)
    print("outcomes", *(str(one.verdict.outcome) for one in done))
    busy = os.getloadavg()[0] > (os.cpu_count() or 1)
    if busy:
        print("other programs hold the cores: the clock is shown and not judged")
    late = float(np.median(whole)) > MOST_S and not busy
    return int(late or float(np.median(judged)) > MOST_JUDGED_S)


def processor_s(work: Callable[[], object]) -> float:
    """Seconds of this process's own time that ``work`` takes."""
    began = time.process_time()
    work()
    return time.process_time() - began


def show(what: str, seconds: list[float]) -> None:
    """Median and extremes."""
    low, middle, high = np.quantile(seconds, [0.0, 0.5, 1.0])
    print(f"{what:<28}{middle:7.3f} s   {low:.3f} to {high:.3f}")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
