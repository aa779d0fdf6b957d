"""The emulated Pico at 20 kHz: a stream without a drop, and motors identified.

    python bench/bench_pico.py [--seconds 60] [--rate 20000] [--seeds 5] [--motors NAME ..]

The stream has three channels over USB, with volts held, every check of the firmware and fast
edges. Then each motor is identified with each seed. A line shows errors and, in brackets, the half
width of the 95 % interval, in percent; a star where the truth lies beyond. No motor has a brush
drop: the last column is what the fit finds of one, in millivolts. Exit code 1 where a sample is
dropped, the sample interrupt takes more than half its period, or more values than chance allows lie
beyond.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np
from scipy.stats import binom

from tests.emulated.motors import NAMES, SURE, Figure, figures, fitted
from tests.emulated.pico_stream import INTERRUPT_S, stream

MOTORS = (
    "maxon-amax22-110147",
    "faulhaber-2338s006s",
    "qube-servo",
    "maxon-re35",
    "dunkermotoren-gr42",
    "pittman-14204s004",
)
DROP = "brush drop"
CHANCE = 0.001  # that so many values lie beyond where 95 % intervals are right


def streams(seconds: float) -> bool:
    """Whether the stream was whole."""
    found = stream(seconds)
    print("| s | samples | dropped | longest interrupt, us | edges/s | payload, bytes/s |")
    print("|---:|---:|---:|---:|---:|---:|")
    print(
        f"| {seconds:g} | {found.samples} | {found.dropped} | {1e6 * found.interrupt_s:.1f} "
        f"| {found.edges_hz:.0f} | {found.bytes_s:.0f} |",
        flush=True,
    )
    return found.is_whole and found.interrupt_s <= INTERRUPT_S


def identified(motor: str, seed: int, rate_hz: float) -> tuple[dict[str, Figure], float, float]:
    """Its six parameters, and the brush drop that is found with its standard uncertainty."""
    with tempfile.TemporaryDirectory() as folder:
        estimate = fitted(Path(folder), "pico", motor, seed, "&link=usb", rate_hz)
    drop = estimate.nuisance[DROP]
    assert drop.value is not None
    assert drop.total is not None
    return figures(motor, estimate), drop.value, drop.total


def is_beyond(figure: Figure) -> bool:
    return abs(figure.error) > figure.relative_half


def cell(figure: Figure) -> str:
    star = "*" if is_beyond(figure) else ""
    return f"{100 * figure.error:+.2f} ({100 * figure.relative_half:.2f}){star}"


def motors(names: list[str], seeds: int, rate_hz: float) -> bool:
    """Whether intervals hold as often as they say."""
    print(f"\n{rate_hz:g} Hz\n")
    print("| motor | seed | " + " | ".join(NAMES) + f" | {DROP}, mV |")
    print("|---|---:|" + "---:|" * (len(NAMES) + 1))
    beyond, drops = 0, []
    for seed in range(1, seeds + 1):
        for motor in names:
            found, drop, doubt = identified(motor, seed, rate_hz)
            beyond += sum(map(is_beyond, found.values()))
            drops.append(drop / doubt)
            cells = [*map(cell, found.values()), f"{1e3 * drop:+.1f} ({1e3 * SURE * doubt:.1f})"]
            print(f"| {motor} | {seed} | {' | '.join(cells)} |", flush=True)
    values = len(names) * seeds * len(NAMES)
    print(f"\n{values - beyond} of {values} values lie in their 95 % intervals")
    print(
        f"{DROP} over its standard uncertainty: mean {np.mean(drops):+.2f}, "
        f"root mean square {np.sqrt(np.mean(np.square(drops))):.2f}"
    )
    return bool(binom.sf(beyond - 1, values, 0.05) > CHANCE)


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--rate", type=float, default=20_000, help="Hz")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--motors", nargs="*", default=list(MOTORS))
    options = parser.parse_args()
    good = streams(options.seconds) if options.seconds > 0 else True
    if options.motors:
        good &= motors(options.motors, options.seeds, options.rate)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
