"""One mutant tried: killed, and by what, or survived. Each answer is kept, and made once."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from tools.mutants.coverage_map import Map, file_of, lies_in, near, test_digest, written_for
from tools.mutants.mutant import Mutant, digest
from tools.mutants.workplace import HOME, TIMED_OUT, TREE, put, pytest, run

STARTING = 30.0  # of the processor, besides the tests' seconds, which coverage made longer
COMPILING = 300.0  # of the processor: no mutant makes a compiler slower
IN_C = 20.0  # of the processor: the core's tests take one
AT_BOARD = 60.0  # of the processor, for the suite and for each board that it starts
NO_TESTS, USAGE = 5, 4  # exit codes of pytest
NO_CONFTEST = "ImportError while loading conftest"  # a mutant that cannot be imported
PROGRESS = re.compile(r"^[.sxXFE]+(?= |$)", re.MULTILINE)  # of pytest -q, a sign a test
TESTS_IN_C = ("check-small", "check-large")


@dataclass(frozen=True)
class Answer:
    """What became of a mutant."""

    outcome: str  # "killed", "survived", "uncovered" or "stillborn" (it does not compile)
    by: str = ""
    tried: int = 0  # tests
    covering: int = 0
    seen_in: str = ""  # digest of the file of the test that killed it


class Kept:
    """Answers of earlier runs, by mutant and by what it was tried with."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.answers: dict[str, Answer] = {}
        if path.is_file():
            for line in path.read_text(encoding="utf-8").splitlines():
                entry = json.loads(line)
                key = entry.pop("key")
                self.answers[key] = Answer(**entry)

    def get(self, key: str, make: Callable[[], Answer]) -> Answer:
        """The answer; one that is new is written at once, so that a run can be stopped."""
        if key not in self.answers:
            self._put(key, make())
        return self.answers[key]

    def killed(self, key: str, make: Callable[[], Answer]) -> Answer:
        """As ``get``; one that a test killed stays so while that test is as it was.

        More tests, or more seconds for them, then try only what survived.
        """
        known = self.answers.get(key)
        if known is None or not _stands(known):
            known = make()
            if known.seen_in and known != self.answers.get(key):
                self._put(key, known)
        return known

    def _put(self, key: str, answer: Answer) -> None:
        self.answers[key] = answer
        with self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps({"key": key, **asdict(answer)}) + "\n")


def _stands(answer: Answer) -> bool:
    file = file_of(answer.by)
    return (TREE / file).is_file() and test_digest(file) == answer.seen_in


def try_python(mutant: Mutant, known: Map, kept: Kept, budget: float) -> Answer:
    """By the tests that run its line, until they took ``budget`` seconds when all was well."""
    covering = known.covering(mutant)
    chosen = within(covering, known.seconds, budget)
    if not chosen:
        return Answer("uncovered")
    source = (TREE / mutant.path).read_bytes()
    tests = sorted({file_of(test) for test in chosen})
    used = (json.dumps(sorted(chosen)), *(test_digest(name) for name in tests))
    key = digest(mutant.applied(source), *used)

    def made() -> Answer:
        put(mutant.path, mutant.applied(source))
        try:
            for batch in _batches(chosen, written_for(mutant.path)):
                outcome, by = _ran(batch, sum(known.seconds[test] for test in batch))
                if outcome == "killed":
                    break
        finally:
            put(mutant.path, source)
        seen_in = test_digest(file_of(by)) if "::" in by else ""
        return Answer(outcome, by, len(chosen), len(covering), seen_in)

    fault = digest("killed", mutant.path, mutant.applied(source))
    return kept.killed(fault, lambda: kept.get(key, made))


def _batches(tests: Sequence[str], own: set[str]) -> list[list[str]]:
    """Those of the files written for it by themselves: the others need not be collected then."""
    first = [test for test in tests if file_of(test) in own]
    others = [test for test in tests if file_of(test) not in own]
    return [batch for batch in (first, others) if batch]


def _ran(tests: Sequence[str], seconds: float) -> tuple[str, str]:
    """What becomes of the mutant that is in the copy now, by tests in this order."""
    only = HOME / "only.json"
    only.write_text(json.dumps(tests), encoding="utf-8")
    words = pytest("-x", "--tb=no", *sorted({file_of(test) for test in tests}))
    return _judged(*run(words, {"MUTANTS_ONLY": str(only)}, seconds + STARTING))


def try_near(
    mutant: Mutant, kept: Kept, marker: str, among: Sequence[str], budget: float
) -> Answer:
    """By the tests with a marker in the files written for the mutant's, then in those beside them,
    for so many seconds.

    Nobody noted which of them run its line: a kill counts if the test passes without the mutant.
    One that fails without it too says nothing, and is left out. Tests that are cut off by the
    budget count as one.
    """
    files = [name for name in near(mutant.path) if lies_in(name, among)]
    if not files:
        return Answer("uncovered")
    source = (TREE / mutant.path).read_bytes()
    key = digest(marker, str(budget), mutant.applied(source), *map(test_digest, files))

    def ran(sick: Sequence[str]) -> tuple[int, str]:
        put(mutant.path, mutant.applied(source))
        left_out = (f"--deselect={name}" for name in sick)
        words = pytest("-x", "--tb=no", "-m", marker, *left_out, *files)
        try:
            return run(words, {}, budget + STARTING)
        finally:
            put(mutant.path, source)

    def made() -> Answer:
        sick: list[str] = []
        while True:
            code, said = ran(sick)
            passed = sum(row.count(".") for row in PROGRESS.findall(said))
            if code == TIMED_OUT:
                return Answer("survived", "", passed, passed + 1)
            outcome, by = _judged(code, said)
            if "::" not in by:
                return Answer(outcome, by, passed, passed)
            test = by.partition("[")[0]
            if not run(pytest(test), {}, budget + STARTING)[0]:
                return Answer(outcome, by, passed, passed, test_digest(file_of(by)))
            print(f"{test} fails without a mutant too", flush=True)
            sick.append(test)

    return kept.get(key, made)


def in_turn(rounds: Iterable[Answer]) -> Answer:
    """Of one mutant: the round of tests that killed it, else what all rounds make together."""
    tried, covering, met = 0, 0, False
    for answer in rounds:
        tried, covering = tried + answer.tried, covering + answer.covering
        met = met or answer.outcome != "uncovered"
        if answer.outcome == "killed":
            return replace(answer, tried=tried, covering=covering)
    return Answer("survived" if met else "uncovered", "", tried, covering)


def within(tests: list[str], seconds: dict[str, float], budget: float) -> list[str]:
    """The first tests, and at least one, whose seconds add up to no more than the budget."""
    chosen, spent = [], 0.0
    for test in tests:
        spent += seconds[test]
        if chosen and spent > budget:
            break
        chosen.append(test)
    return chosen


def _judged(code: int, said: str) -> tuple[str, str]:
    """The outcome by the exit code of pytest, and the test that failed or how it ended.

    Names of tests may depend on the mutant: where none is left of those named, none saw it.
    """
    if code in (0, NO_TESTS):
        return "survived", ""
    if code == USAGE and NO_CONFTEST not in said:
        raise SystemExit(f"the tests cannot be run: {said}")
    if code == TIMED_OUT:
        return "killed", "no end"
    for line in said.splitlines():
        if line.startswith(("FAILED ", "ERROR ")):
            return "killed", line.split()[1]
    return "killed", f"exit code {code}"


def try_c(mutant: Mutant, kept: Kept, files: tuple[str, ...]) -> Answer:
    """By the core's own tests, with both sizes, then by the conformance suite on this computer."""
    source = (TREE / mutant.path).read_bytes()
    key = digest(mutant.path, mutant.applied(source), *(_content(name) for name in files))

    def made() -> Answer:
        put(mutant.path, mutant.applied(source))
        try:
            return _in_c()
        finally:
            put(mutant.path, source)

    return kept.get(key, made)


def _content(name: str) -> bytes | str:
    return test_digest(name) if name.endswith(".py") else (TREE / name).read_bytes()


def _in_c() -> Answer:
    # without warnings: the compiler must not do the tests' work
    make = ["make", "-s", "-C", "firmware", "WARN=-w", f"PYTHON={sys.executable}"]
    for name in TESTS_IN_C:
        target = f"build/test/{name}"
        if run([*make, target], {}, COMPILING)[0]:
            return Answer("stillborn")
        code, _ = run([f"firmware/{target}"], {}, IN_C)
        if code:
            return Answer("killed", "no end" if code == TIMED_OUT else f"make check ({name})")
    if run([*make, "all"], {}, COMPILING)[0]:  # what the suite finds built, it takes
        return Answer("stillborn")
    only = ("-x", "--tb=no", "-m", "not long", "-k", "host", "tests/conformance")
    code, said = run(pytest(*only), {}, AT_BOARD)
    outcome, by = _judged(code, said)
    return Answer(outcome, by)
