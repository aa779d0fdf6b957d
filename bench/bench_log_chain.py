"""Faults of a log's measuring chain, stated and not: do the intervals hold the truth?

python bench/bench_log_chain.py            every fault; writes bench/results/log_chain.json
python bench/bench_log_chain.py --short    one fault on one motor

Each fault in three sizes, on three motors, stated at the import or not. Counts the 95 % intervals
that hold, those of doubtful parameters apart, and how often R, K and J are within 2 %. A gain that
nobody states leaves no trace and is counted apart. Ends with 1 where fewer than 90 % of the
intervals hold.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from bench.bench_mistakes import commit
from bench.mistakes.chain_faults import GAIN, Fault, faults, stated
from bench.mistakes.command import Answer
from bench.mistakes.logs import STATIONS, Log, Station, answer

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "bench" / "results" / "log_chain.json"
GOAL, NEAR = 0.90, 0.02
WELL_KNOWN = ("R", "K", "J")
PLAIN, TOLD, UNTRACED = "not stated", "stated", "gains not stated"


@dataclass
class Count:
    """Intervals of a group of fits: of estimated parameters, of doubtful ones; R, K, J near."""

    held: int = 0
    of: int = 0
    doubtful_held: int = 0
    doubtful: int = 0
    near: int = 0
    near_of: int = 0
    refused: int = 0
    missed: list[str] = field(default_factory=list)

    def add(self, found: Answer, truth: Mapping[str, float], where: str) -> None:
        """One fit."""
        self.refused += found.estimate is None
        for name, true in truth.items():
            one = found.parameters.get(name) or {}
            interval = one.get("interval_95")
            if name in WELL_KNOWN:
                value = one.get("value")
                self.near_of += 1
                self.near += value is not None and abs(value / true - 1) < NEAR
            if interval is None:
                continue
            holds = interval[0] <= true <= interval[1]
            if one["status"] == "doubtful":
                self.doubtful += 1
                self.doubtful_held += holds
                continue
            self.of += 1
            self.held += holds
            if not holds:
                half = (interval[1] - interval[0]) / 2
                off = abs(one["value"] - true) / half if half else float("inf")
                self.missed.append(f"{where} {name}: {100 * (one['value'] / true - 1):+.2f} %, "
                                   f"{off:.1f} half-widths")  # fmt: skip

    def plus(self, other: Count) -> Count:
        """Both together."""
        return Count(**{k: v + getattr(other, k) for k, v in vars(self).items()})

    @property
    def cells(self) -> str:
        """For the table."""
        doubtful = f" + {self.doubtful_held}/{self.doubtful} doubtful" if self.doubtful else ""
        return f"{self.held}/{self.of}{doubtful} | {self.near}/{self.near_of}"


def measured(
    fault: Fault | None, stations: Sequence[Station], said: bool, folder: Path, seed: int
) -> Count:
    """One fault of one size on every motor."""
    count = Count()
    for station in stations:
        log = Log()
        if fault:
            options = stated(fault, station) if said else ()
            log = Log(chain={fault.channel: fault.chain}, options=lambda s, o=options: o)
        where = f"{fault.name if fault else 'none'} {fault.size if fault else ''} {station.name}"
        count.add(answer(log, station, folder, seed), station.motor.truth, where)
    return count


def main() -> int:
    """Prints the table; 1 where the goal is missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--short", action="store_true", help="one fault on one motor")
    parser.add_argument("--only", default="", help="faults with that in their name")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, help="results file; default: of a full run")
    chosen = parser.parse_args()
    stations = STATIONS[2:] if chosen.short else STATIONS
    print(f"| fault | size | {PLAIN}: held | R, K, J in 2 % | {TOLD}: held | R, K, J in 2 % |")
    print("|---|---|---|---|---|---|")
    rows: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        if not (chosen.only or chosen.short):
            none = measured(None, stations, False, folder, chosen.seed)
            print(f"| none | | {none.cells} | | |", flush=True)
        for fault in sorted(faults(chosen.short), key=lambda f: (f.kind, f.name, f.size)):
            if chosen.only in fault.name:
                both = [measured(fault, stations, s, folder, chosen.seed) for s in (False, True)]
                print(f"| {fault.name} | {fault.size:g} | " + " | ".join(c.cells for c in both)
                      + " |", flush=True)  # fmt: skip
                rows.append({"fault": fault.name, "size": fault.size, "counts": both})
    traced = [row for row in rows if GAIN not in row["fault"]]
    traceless = [row for row in rows if GAIN in row["fault"]]
    totals = {
        PLAIN: sum_of([row["counts"][0] for row in traced]),
        TOLD: sum_of([row["counts"][1] for row in rows]),
        UNTRACED: sum_of([row["counts"][0] for row in traceless]),
    }
    for name, total in totals.items():
        print(f"\n{name}: {total.held} of {total.of} intervals hold "
              f"({total.held / max(total.of, 1):.1%}), doubtful {total.doubtful_held} of "
              f"{total.doubtful}; R, K, J within 2 %: {total.near} of {total.near_of}; "
              f"refused {total.refused}")  # fmt: skip
        for line in total.missed if name != UNTRACED else ():
            print(f"  missed: {line}")
    full = not (chosen.short or chosen.only) and chosen.seed == 1
    if out := chosen.out or (RESULTS if full else None):
        store(out, rows, totals)
    return 0 if all(totals[n].held >= GOAL * totals[n].of for n in (PLAIN, TOLD)) else 1


def sum_of(counts: Sequence[Count]) -> Count:
    """All of them together."""
    total = Count()
    for one in counts:
        total = total.plus(one)
    return total


def store(path: Path, rows: Sequence[Mapping[str, Any]], totals: Mapping[str, Count]) -> None:
    """The results file."""
    each = [
        {"fault": row["fault"], "size": row["size"]}
        | {n: vars(c) for n, c in zip((PLAIN, TOLD), row["counts"], strict=True)}
        for row in rows
    ]
    results = {
        "commit": commit(),
        "all": {name: vars(total) for name, total in totals.items()},
        "faults": each,
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(results, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
