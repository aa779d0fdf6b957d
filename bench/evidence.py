"""Evidence that takes hours: each part is run, and its result kept with the commit that made it.

    python bench/evidence.py                       every part; results go to bench/results
    python bench/evidence.py --parts coverage day  these alone
    python bench/evidence.py --short               seconds of each, to see that it still runs

One small text file a part. A short form proves nothing and goes to out/evidence.
"""

from __future__ import annotations

import argparse
import os
import platform
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
RESULTS, SCRATCH = ROOT / "bench" / "results", ROOT / "out" / "evidence"
LINES = 200  # of a part's output that are kept
PY = sys.executable
Command = tuple[str, ...]


@dataclass(frozen=True)
class Part:
    """What it shows, and the commands that show it: in full, and in their shortest form.

    ``{commit}`` stands for the commit, so that a study that was stopped goes on where it ended and
    never adds to another commit's.
    """

    name: str
    shows: str
    full: tuple[Command, ...]
    short: tuple[Command, ...]


def _bench(name: str, *arguments: str) -> Command:
    return (PY, f"bench/bench_{name}.py", *arguments)


def _module(name: str, *arguments: str) -> Command:
    return (PY, "-m", name, *arguments)


def _coverage(rigs: str) -> tuple[Command, ...]:
    rows = f"out/evidence/coverage-{rigs}-{{commit}}.jsonl"
    return (
        _bench("coverage", "--rigs", rigs, "--out", rows),
        _bench("coverage", "--tables", rows, "--causes"),
    )


def _effects(rigs: str, without: str) -> tuple[Command, ...]:
    """Motors with effects, then as many ``without`` any, for what is offered falsely."""
    rows = f"out/evidence/effects-{rigs}-{{commit}}.jsonl"
    plain = f"out/evidence/no-effects-{without}-{{commit}}.jsonl"
    drawn = ("coverage", "--parts", "bound", "fit", "auto", "--first")
    return (
        _bench(*drawn, "3000", "--effects", "--rigs", rigs, "--out", rows),
        _bench(*drawn, "4000", "--rigs", without, "--out", plain),
    )


FUZZED = ("wire", "rig", "csv", "journal", "board", "fit", "hdf5", "mat")
EXACT = ("--captures", "12", "--count", "1000", "--seeds", "1", "--motor", "faulhaber")
PARTS = (
    Part("coverage", "how often intervals hold the truth, on 2,000 drawn rigs",
         _coverage("2000"), _coverage("1")),
    Part("chain", "intervals with a bent sensor, a drifting reference, an eccentric encoder",
         (_bench("chain", "--rigs", "200", "--out", "out/evidence/chain-{commit}.jsonl"),),
         (_bench("chain", "--rigs", "1"),)),
    Part("exactness", "the fit against the Cramér-Rao bound, and its response's cost",
         (_bench("exactness"),), (_bench("exactness", *EXACT),)),
    Part("suspects", "faults of the measuring chain called by name, and false alarms",
         (_bench("suspects"),),
         (_bench("suspects", "--part", "clean", "--motor", "qube"),)),
    Part("mistakes", "ordinary mistakes at rigs and in logs: named, harmless, or silent",
         (_bench("mistakes"), _bench("log_chain"), _bench("false_alarms")),
         (_bench("mistakes", "--only", "encoder reversed"), _bench("log_chain", "--short"),
          _bench("false_alarms", "--count", "1"))),
    Part("stranger", "logs of a bench that shares nothing with the others, listed and drawn",
         (_bench("stranger"), _bench("stranger", "--drawn", "44")),
         (_bench("stranger", "--short"),)),
    Part("wider", "wider models named and sized",
         (_bench("wider"),), (_bench("wider", "brush", "--seeds", "1"),)),
    Part("effects", "the same on 500 drawn motors with iron, windage or friction under load",
         _effects("500", "100"), _effects("1", "1")),
    Part("foreign", "intervals on plants of others: 60 rigs of ngspice and 40 of MuJoCo",
         tuple(_bench("foreign_plants", "--kind", kind, "--rigs", rigs, *more)
               for kind, rigs in (("spice", "30"), ("mujoco", "20"))
               for more in ((), ("--seed", "101", "--effects"))),
         (_bench("foreign_plants", "--short"),)),
    Part("studies", "tests that take too long for every run",
         (_module("pytest", "-q", "-n", "2", "--studies", "-m", "study"),),
         (_module("pytest", "-q", "--studies", "-m", "study", "-k", "coverage_scores"),)),
    Part("mutants", "faults put into the code on purpose, and how many of them a test sees",
         (_module("tools.mutants", "--json", "bench/results/mutants.json"),),
         (_module("tools.mutants", "--rooms", "firmware", "--count", "1"),)),
    Part("branches", "lines and branches of the package that the quick tests take",
         (_bench("branches", "--quick"),),
         (_bench("branches", "--tests", "tests/wire/test_wire_framing.py"),)),
    Part("faults", "the laws of a capture under 10,000 random schedules of faults",
         (_module("tests.faults.run", "--count", "10000"),),
         (_module("tests.faults.run", "--count", "5"),)),
    Part("fuzz", "every parser, an hour each",
         tuple(_module("tests.fuzz.run", one, "--seconds", "3600") for one in FUZZED),
         tuple(_module("tests.fuzz.run", one, "--seconds", "1") for one in FUZZED[:1])),
    Part("day", "24 h of simulated time in bounded memory",
         (_module("tests.load.day", "--hours", "24"),),
         (_module("tests.load.day", "--hours", "0.02"),)),
    Part("link", "ten minutes at 10 kHz through a pseudo terminal, both cores busy",
         (_module("tests.load.pty", "--seconds", "600"),),
         (_module("tests.load.pty", "--seconds", "1", "--busy", "0"),)),
    Part("live", "ten minutes at 4 kHz on the live page: samples, frames a second",
         (_bench("live", "--seconds", "600"),), (_bench("live", "--seconds", "3"),)),
    Part("line", "defective motors on a simulated line: escapes, false alarms, the history",
         (_bench("line"),), (_bench("line", "2", "1"),)),
    Part("kills", "100 kills of a station, whose history is away at times: equal to the disk?",
         (_bench("kills"),), (_bench("kills", "1"),)),
    Part("plant", "twenty stations, one database, one broker, all killed at random: nothing lost",
         (_bench("plant"),),
         (_bench("plant", "--stations", "2", "--inspections", "1", "--replay", "20"),)),
    Part("verdicts", "verdicts on speed against the motor driven for long; dead motors, dead rigs",
         (_bench("verdicts", "2000", "--jobs", "2",
                 "--out", "out/evidence/verdicts-{commit}.jsonl"), _bench("dead_motors")),
         (_bench("verdicts", "2"), _bench("dead_motors", "2"))),
    Part("boards", "the boards' firmware, emulated: motors identified, rates sustained",
         (_bench("emulated_motors"), _bench("emulated_boards")),
         (_bench("emulated_boards", "--boards", "uno", "--rates", "4000", "--no-search"),)),
    Part("pico", "an emulated Pico: 60 s at 20 kHz without a drop, six motors by five seeds",
         (_bench("pico"),), (_bench("pico", "--seconds", "0.2", "--motors"),)),
)  # fmt: skip


def commit() -> str:
    """The commit that is checked out; "+changes" where files differ from it."""
    head = _said("git", "rev-parse", "--short=12", "HEAD")
    return head + ("+changes" if _said("git", "status", "--porcelain", "-uno") else "")


def _said(*command: str) -> str:
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    return done.stdout.strip()


def run(part: Part, short: bool, folder: Path) -> bool:
    """Runs a part and writes its result. True where every command did what it is for."""
    made_by, began, said, codes = commit(), time.monotonic(), "", []
    for command in part.short if short else part.full:
        words = [word.format(commit=made_by) for word in command]
        done = subprocess.run(
            words, cwd=ROOT, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            env={**os.environ, "PYTHONPATH": str(ROOT)}, check=False,
        )  # fmt: skip
        said += done.stdout
        codes.append(done.returncode)
    head = {
        "part": part.name,
        "shows": part.shows,
        "form": "short: proves nothing" if short else "full",
        "commit": made_by,
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "on": f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}",
        "took": f"{(time.monotonic() - began) / 60:.1f} min",
        "exit codes": " ".join(map(str, codes)),
    }
    (folder / f"{part.name}.txt").write_text(page(head, said), encoding="utf-8")
    return set(codes) <= ({0, 1} if short else {0})  # 1: a goal that a short form may miss


def page(head: dict[str, str], said: str) -> str:
    """A result: what made it, then the end of what was said, without this folder's name."""
    lines = said.replace(str(ROOT), ".").splitlines()
    left_out = [f"({len(lines) - LINES} lines before)"] if len(lines) > LINES else []
    return "\n".join(
        [*(f"{key}: {value}" for key, value in head.items()), "", *left_out, *lines[-LINES:], ""]
    )


def main(arguments: Sequence[str]) -> int:
    """Runs the parts that were asked for; exit code 1 where one of them failed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    names = [part.name for part in PARTS]
    parser.add_argument("--parts", nargs="*", choices=names, default=names, metavar="PART")
    parser.add_argument("--short", action="store_true", help="seconds of each part")
    options = parser.parse_args(arguments)
    folder = SCRATCH if options.short else RESULTS
    for needed in (folder, SCRATCH):
        needed.mkdir(parents=True, exist_ok=True)
    good = True
    for part in PARTS:
        if part.name in options.parts:
            print(f"== {part.name}: {part.shows}", flush=True)
            well = run(part, options.short, folder)
            good &= well
            where = (folder / f"{part.name}.txt").relative_to(ROOT)
            print(f"   {'done' if well else 'FAILED'}, see {where}", flush=True)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
