"""Ordinary mistakes at a rig and in logs: is each named, harmless, or wrong in silence?

python bench/bench_mistakes.py                         every one; writes bench/results/mistakes.json
python bench/bench_mistakes.py --only clock --seed 3  of that name, with other noise

Rigs are simulated and captured over their wire. Logs are integrated by an own plant in numpy. Both
go through the commands that a user types. An error counts from 4 standard uncertainties on. Ends
with 1 where an error beyond that stays unnamed, or where less than 95 % of the mistakes are named
or harmless.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from bench.mistakes import capture_cases, captures, log_cases, log_cases_more, logs
from bench.mistakes.score import DOUBTFUL, HARMLESS, LISTED, NAMED, OUTCOMES, SILENT, Score, score

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "bench" / "results" / "mistakes.json"
RIG, LOG = "rig", "log"
RIG_STATIONS = ("small", "medium")
GOOD = (NAMED, HARMLESS, LISTED)
GOAL = 0.95
TEMPERED = "room"  # mistakes whose truth is R at 25 °C as well


@dataclass(frozen=True)
class Row:
    """One mistake and how it ended on each motor."""

    name: str
    where: str
    scores: dict[str, Score]

    @property
    def outcome(self) -> str:
        """The worst of them."""
        return max((s.outcome for s in self.scores.values()), key=OUTCOMES.index)

    @property
    def worst(self) -> tuple[str, float]:
        """The largest error in u of a value that is not marked."""
        return max((s.worst for s in self.scores.values()), key=lambda one: abs(one[1]))

    @property
    def goes_wrong(self) -> bool:
        """An error that a reader is not warned of by its name."""
        return any(
            s.outcome not in (NAMED, HARMLESS, LISTED, DOUBTFUL) and abs(s.worst[1]) > 4
            for s in self.scores.values()
        )


def rows(only: str, where: Sequence[str], seed: int) -> Iterator[Row]:
    """Every mistake of that name."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        for rig in capture_cases.MISTAKES if RIG in where else ():
            if only in rig.name:
                yield Row(rig.name, RIG, {s: at_rig(rig, s, folder, seed) for s in RIG_STATIONS})
        for log in (*log_cases.MISTAKES, *log_cases_more.MORE) if LOG in where else ():
            if only in log.name:
                yield Row(
                    log.name, LOG, {s.name: in_log(log, s, folder, seed) for s in logs.STATIONS}
                )


def at_rig(mistake: capture_cases.Mistake, station: str, folder: Path, seed: int) -> Score:
    """One mistake at a simulated rig."""
    answer = captures.answer(mistake.rigged, station, folder, seed)
    true = captures.truth(captures.preset(station))
    if not mistake.name.startswith(TEMPERED):
        del true["R_25"]
    return score(answer, true, mistake.causes, mistake.traceless)


def in_log(mistake: log_cases.Mistake, station: logs.Station, folder: Path, seed: int) -> Score:
    """One mistake in a log."""
    answer = logs.answer(mistake.log, station, folder, seed)
    return score(answer, station.motor.truth, mistake.causes, mistake.traceless)


def show(row: Row) -> None:
    """Its row of the table."""
    each = ", ".join(f"{name} {s.outcome}" for name, s in row.scores.items())
    name, size = row.worst
    error = f"{name} {size:+.3g}" if name else "—"
    said = next((s.by for s in row.scores.values() if s.by), "") or next(
        (s.said[0] for s in row.scores.values() if s.said), ""
    )
    words = " ".join(said.split())[:90].replace("|", "/")
    print(f"| {row.name} | {row.where} | {row.outcome} | {each} | {error} | {words} |", flush=True)


def summary(found: Sequence[Row]) -> dict[str, Any]:
    """Counts of mistakes, each by its worst motor."""
    count = Counter(row.outcome for row in found)
    return {
        "mistakes": len(found),
        **{name: count[name] for name in OUTCOMES},
        "good": sum(count[name] for name in GOOD),
        "wrong_unnamed": sum(row.goes_wrong for row in found),
    }


def store(path: Path, found: Sequence[Row], seed: int) -> None:
    """The results file."""
    kept = {
        "commit": commit(),
        "seed": seed,
        "summary": summary(found),
        "mistakes": [
            {
                "name": row.name,
                "where": row.where,
                "outcome": row.outcome,
                "motors": {name: s.kept() for name, s in row.scores.items()},
            }
            for row in found
        ],
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(kept, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def commit() -> str:
    """What is checked out, with a plus where files differ from it."""
    words = ["git", "-C", str(ROOT), "describe", "--always", "--dirty=+", "--abbrev=12"]
    done = subprocess.run([*words, "--exclude=*"], capture_output=True, text=True, check=False)
    return done.stdout.strip()


def main() -> int:
    """Prints the table; 1 where a goal is missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="mistakes with that in their name")
    parser.add_argument("--where", nargs="*", choices=(RIG, LOG), default=(RIG, LOG))
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, help="results file; default: of a full run")
    chosen = parser.parse_args()
    full = not chosen.only and set(chosen.where) == {RIG, LOG} and chosen.seed == 1
    print("| mistake | in | ends | on each motor | largest error, u | first words |")
    print("|---|---|---|---|---|---|")
    found = []
    for row in rows(chosen.only, chosen.where, chosen.seed):
        found.append(row)
        show(row)
    counts = summary(found)
    print("\n" + ", ".join(f"{key} {value}" for key, value in counts.items()))
    out = chosen.out or (RESULTS if full else None)
    if out:
        store(out, found, chosen.seed)
    silent = [row for row in found if row.outcome == SILENT]
    for row in sorted(silent, key=lambda row: -abs(row.worst[1])):
        print(f"silent: {row.name} ({row.where}): {row.worst[0]} {row.worst[1]:+.3g} u")
    return 0 if not counts["wrong_unnamed"] and counts["good"] >= GOAL * len(found) else 1


if __name__ == "__main__":
    sys.exit(main())
