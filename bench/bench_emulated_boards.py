"""Timing of the emulated boards: the tables of docs/emulated-rig.md, as Markdown.

    python bench/bench_emulated_boards.py [--boards uno mega] [--rates 1000 2000 4000] [--no-search]

At 1, 2 and 4 kHz with three channels, the encoder at rest and at full speed; then the search for
what each board sustains: shorter windows than the firmware has, and faster edges. Exit code 1
where a board does not sustain 4 kHz at full speed.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from motorid.errors import MotoridError
from tests.emulated.rates import LINK_BYTES_S, PER_SAMPLE, Figures, run, scaled, sustained

BOARDS = ("uno", "mega")
RATES = (1000, 2000, 4000)
FULL_SPEED_HZ = 39_500
CEILING = "-DENCODER_EDGE_CEILING={}u"


def row(f: Figures) -> str:
    """One run as a table row."""
    t = f.times
    late = f"{t['slot']['p99']} / {t['slot']['most']}"
    edge = f"{t['edge']['p99']} / {t['edge']['most']}" if t["edge"]["count"] else "-"
    start = t["start"]["most"] - t["start"]["least"]
    load = " | ".join(f"{f.share(k):.1%}" for k in ("slot", "sample", "edge", "send", "main"))
    return (
        f"| {f.board} | {f.rate_hz:.0f} | {f.edges_hz:.0f} | {late} | {edge} "
        f"| {t['receive']['most']} | {start} | {t['enable']['least']} to {t['enable']['most']} "
        f"| {t['sample']['most']} | {load} | {f.share('asleep'):.1%} "
        f"| {f.link_bytes_s / LINK_BYTES_S:.1%} | {f.bytes_a_sample:.2f} | {f.dropped} |"
    )


def holds(board: str, edges_hz: float, defines: str) -> bool:
    """A quarter of a second at the highest rate of firmware so compiled."""
    try:
        return sustained(run(board, 0, edges_hz, 0.25, defines))
    except (MotoridError, TimeoutError, AssertionError):
        return False  # it tripped while the host still asked, or does not answer


def last_that_holds(trials: list[int], test: Callable[[int], bool]) -> int:
    """The last of the trials, in order, before one fails; 0: not even the first."""
    best = 0
    for trial in trials:
        if not test(trial):
            break
        best = trial
    return best


def search(board: str) -> None:
    """The shortest slot and the fastest edges that the board holds."""
    slot = last_that_holds(
        [250, 245, 240, 235, 230, 225],  # a conversion takes 216
        lambda ticks: holds(board, FULL_SPEED_HZ, scaled(ticks)),
    )
    edges = last_that_holds(
        [40_000, 45_000, 50_000, 55_000, 60_000, 70_000, 80_000, 90_000],
        lambda hz: holds(board, 0.9875 * hz, CEILING.format(hz)),
    )
    rate = 1e6 / slot if slot else 0.0
    print(f"{board}: {rate:.0f} Hz (slots of {slot}) at {FULL_SPEED_HZ} edges/s;", end=" ")
    print(f"at 4000 Hz {edges} edges/s")


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("--boards", nargs="+", choices=BOARDS, default=BOARDS)
    parser.add_argument("--rates", nargs="+", type=int, default=RATES, help="Hz")
    parser.add_argument("--no-search", action="store_true", help="the table only")
    options = parser.parse_args()
    print(
        "| board | Hz | edges/s | slot late p99 / most | edge late p99 / most | receive late "
        "| sample's start jitter | enable from tick | longest sample | slots | samples | edges "
        "| send | main | asleep | link | bytes a sample | dropped |"
    )
    print("|---|" + "---:|" * 17)
    good = True
    for board in options.boards:
        for rate in options.rates:
            for edges in (0, FULL_SPEED_HZ):
                figures = run(board, rate, edges)
                good &= sustained(figures)
                print(row(figures), flush=True)
    print(f"\npayload a sample: {PER_SAMPLE} bytes; latencies in cycles of 62.5 ns\n")
    for board in () if options.no_search else options.boards:
        search(board)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
