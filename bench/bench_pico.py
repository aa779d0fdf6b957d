"""The emulated Pico at 20 kHz: a stream without a drop, and motors identified.

    python bench/bench_pico.py [--seconds 60] [--rates 3333 20000] [--seeds 5] [--motors NAME ..]

The stream has three channels over USB, with volts held, every check of the firmware and fast edges.
Then each motor is identified with each seed at each rate: how many of its six parameters lie in
their 95 % intervals, and errors and half widths in percent. Exit code 1 where a sample is dropped,
the sample interrupt takes more than half its period, or more values than chance allows lie beyond.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from scipy.stats import binom

from tests.emulated.motors import NAMES, Figure, identify
from tests.emulated.pico_stream import INTERRUPT_S, stream

MOTORS = (
    "maxon-amax22-110147",
    "faulhaber-2338s006s",
    "qube-servo",
    "maxon-re35",
    "dunkermotoren-gr42",
    "pittman-14204s004",
)
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


def identified(motor: str, seed: int, rate_hz: float) -> dict[str, Figure]:
    with tempfile.TemporaryDirectory() as folder:
        more = "&link=usb"
        return identify(Path(folder), "pico", motor, seed, more, rate_hz)


def motors(names: list[str], seeds: int, rates: list[float]) -> bool:
    """Whether intervals hold as often as they say."""
    print("\n| motor | Hz | inside | " + " | ".join(NAMES) + " |")
    print("|---|---:|---:|" + "---:|" * len(NAMES))
    beyond = 0
    for motor in names:
        for rate_hz in rates:
            runs = [identified(motor, seed, rate_hz) for seed in range(1, seeds + 1)]
            wrong = sum(abs(run[n].error) > run[n].relative_half for run in runs for n in NAMES)
            beyond += wrong
            worst = {n: max((run[n] for run in runs), key=lambda f: abs(f.error)) for n in NAMES}
            cells = (f"{100 * f.error:+.2f} ({100 * f.relative_half:.2f})" for f in worst.values())
            all_of = seeds * len(NAMES)
            print(
                f"| {motor} | {rate_hz:g} | {all_of - wrong} of {all_of} | {' | '.join(cells)} |",
                flush=True,
            )
    values = len(names) * len(rates) * seeds * len(NAMES)
    print(
        f"\n{values - beyond} of {values} values lie in their 95 % intervals; worst of seeds above"
    )
    return bool(binom.sf(beyond - 1, values, 0.05) > CHANCE)


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--rates", nargs="*", type=float, default=[3333, 20_000], help="Hz")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--motors", nargs="*", default=list(MOTORS))
    options = parser.parse_args()
    good = streams(options.seconds) if options.seconds > 0 else True
    if options.motors:
        good &= motors(options.motors, options.seeds, options.rates)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
