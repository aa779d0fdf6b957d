"""The same fit by motorid, from the peers' start. A second figure is the whole of ``motorid.fit``.

Usage: python motorid_fit.py DATA.npz, prints one JSON line {seconds, whole_seconds, parameters}.
"""

from __future__ import annotations

import json
import sys
import time

import numpy as np
from problem import NAMES, PERIOD_S, start

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.fit.multistart import solve
from motorid.estimate.model.capture_model import MotorRecord
from tests.six_parameters import fit

REPEATS = 5


def capture(data: dict[str, np.ndarray]) -> Capture:
    """The problem as a capture: voltage held over each interval, current and speed as instants."""
    n = len(data["v"])
    return Capture(
        ticks=np.arange(n, dtype=np.int64),
        clock_hz=1 / PERIOD_S,
        channels={
            VOLTAGE: Channel(
                VOLTAGE, "V", data["v"], kind="mean", aperture_s=PERIOD_S, sense="terminals"
            ),
            CURRENT: Channel(CURRENT, "A", data["i"]),
            SPEED: Channel(SPEED, "rad/s", data["w"]),
        },
    )


def main() -> None:
    """Fit a few times, print the median."""
    data = dict(np.load(sys.argv[1]))
    times, whole = [], []
    for _ in range(REPEATS):
        began = time.perf_counter()
        solution = solve([MotorRecord(capture(data), NAMES, {})], NAMES, start())
        times.append(time.perf_counter() - began)
        began = time.perf_counter()
        fit([capture(data)])
        whole.append(time.perf_counter() - began)
    fitted = dict(zip(NAMES, map(float, solution.values), strict=False))
    print(
        json.dumps(
            {
                "seconds": sorted(times)[REPEATS // 2],
                "whole_seconds": sorted(whole)[REPEATS // 2],
                "evaluations": solution.evaluations,
                "parameters": fitted,
            }
        )
    )


if __name__ == "__main__":
    main()
