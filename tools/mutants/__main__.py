"""Tries mutants of the code: python -m tools.mutants [--rooms quality wire] [--count 60] [--seed 1]

Mutants are drawn by a seed. Each is tried by the tests that cover its line, in a copy of the
repository in out/mutants. Answers and the map of lines are kept there: a second run tries only what
changed. ``--tests "not slow"`` leaves slow tests out; the map is then noted in minutes. With
``--then slow`` what survives these meets the slow tests for its file, and those beside them.
``--among tests/estimate tests/frozen`` tries the tests of these folders, or files, alone: a lower
bound of what dies.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from datetime import UTC, datetime
from pathlib import Path

from tools.mutants import c_faults, python_faults
from tools.mutants.coverage_map import Map, brought_up_to_date, test_files
from tools.mutants.mutant import Mutant, digest, sample
from tools.mutants.score import CORE, GOALS, HEAD, Score
from tools.mutants.trial import Answer, Kept, in_turn, try_c, try_near, try_python
from tools.mutants.workplace import HOME, TREE, copied, git

GENERATED = "wire_gen"  # written from spec.toml; its own tests compare it


def mutants(room: str) -> list[Mutant]:
    """Every mutant of a room, or of the firmware's core."""
    if room == CORE:
        folder, ending, faults = TREE / "firmware" / "core", ".c", c_faults.mutants
    else:
        folder, ending, faults = TREE / "motorid" / room, ".py", python_faults.mutants
    files = sorted(path for path in folder.rglob(f"*{ending}") if GENERATED not in path.name)
    return [
        one
        for path in files
        for one in faults(path.relative_to(TREE).as_posix(), path.read_bytes())
    ]


def firmware_tests() -> tuple[str, ...]:
    """Files that decide what becomes of a mutant in C, besides the mutated one."""
    folder = TREE / "firmware"
    written = [*(folder / "core").glob("*.h"), *(folder / "test").glob("*.[ch]")]
    written += [*(folder / "ports" / "host").glob("*.[ch]"), folder / "Makefile"]
    named = [path.relative_to(TREE).as_posix() for path in sorted(written)]
    return (*named, *(name for name in test_files() if name.startswith("tests/conformance/")))


def tried(room: str, count: int, seed: int, attempt: Callable[[Mutant], Answer]) -> Score:
    """A room's sample; one that does not compile gives way to the next."""
    population = mutants(room)
    score = Score(room, len(population))
    for mutant in sample(population, seed):
        if len(score.answers) == count:
            break
        answer = attempt(mutant)
        if answer.outcome != "stillborn":
            score.answers.append((mutant, answer))
        if answer.outcome in ("survived", "uncovered"):
            print(f"{answer.outcome}: {mutant.path}:{mutant.line}: {mutant.change}", flush=True)
    return score


def result(
    scores: Sequence[Score], options: argparse.Namespace, minutes: float
) -> dict[str, object]:
    """What a file of results holds."""
    return {
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "seed": options.seed,
        "tests": options.tests or "all",
        "then": options.then,
        "among": options.among,
        "seconds_of_tests_for_a_mutant": options.budget,
        "minutes": round(minutes, 1),
        "rooms": {score.room: score.as_json() for score in scores},
    }


def _commit() -> str:
    """The commit that is checked out; "+changes" where files differ from it."""
    changed = git("status", "--porcelain", "-uno")
    return git("rev-parse", "--short=12", "HEAD").strip() + ("+changes" if changed else "")


def asked(arguments: Sequence[str]) -> argparse.Namespace:
    """The options of a call."""
    parser = argparse.ArgumentParser(
        prog="tools.mutants", description=(__doc__ or "").splitlines()[0]
    )
    add = parser.add_argument
    add("--rooms", nargs="+", choices=GOALS, default=list(GOALS), metavar="ROOM")
    add("--count", type=int, default=60, help="mutants a room (60)")
    add("--seed", type=int, default=1)
    add("--tests", default="", metavar="MARKER", help='pytest -m, as "not slow"')
    add(
        "--then",
        default="",
        metavar="MARKER",
        help="tests written for a survivor's file, that it meets too",
    )
    add("--among", nargs="+", default=["tests"], metavar="PLACE",
        help="tests of these folders or files alone: kills no fewer than it says")  # fmt: skip
    add("--budget", type=float, default=60.0, metavar="SECONDS",
        help="of tests for one mutant, as long as they take when all is well (60)")  # fmt: skip
    add("--json", type=Path, metavar="FILE", help="writes the result there")
    return parser.parse_args(arguments)


def attempts(options: argparse.Namespace) -> Callable[[Mutant], Answer]:
    """What tries a mutant of either language."""
    kept, files = Kept(HOME / "answers.jsonl"), firmware_tests()
    known, among = None, tuple(options.among)
    if set(options.rooms) != {CORE}:
        named = digest(options.tests, *among)[:8]
        known = brought_up_to_date(HOME / f"map-{named}.json", options.tests, among)

    def rounds(mutant: Mutant, known: Map) -> Iterator[Answer]:
        yield try_python(mutant, known, kept, options.budget)
        if options.then:
            yield try_near(mutant, kept, options.then, among, options.budget)

    def attempt(mutant: Mutant) -> Answer:
        if known is None or mutant.path.endswith(".c"):
            return try_c(mutant, kept, files)
        return in_turn(rounds(mutant, known))

    return attempt


def main(arguments: Sequence[str]) -> int:
    """Exit code 1 where a room misses its goal."""
    options = asked(arguments)
    began = time.monotonic()
    HOME.mkdir(parents=True, exist_ok=True)
    made_by = _commit()
    copied()  # later edits change nothing of this run
    attempt = attempts(options)
    scores = [tried(room, options.count, options.seed, attempt) for room in options.rooms]
    print("\n".join([HEAD, *(score.row() for score in scores)]))
    if options.json:
        made = {"commit": made_by, **result(scores, options, (time.monotonic() - began) / 60.0)}
        text = json.dumps(made, indent=1, ensure_ascii=False) + "\n"
        options.json.write_text(text, encoding="utf-8")
    return 0 if all(score.good for score in scores) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
