"""Which test runs which line: noted once, and again only for tests and sources that changed."""

from __future__ import annotations

import ast
import json
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

from tools.mutants.mutant import Mutant, digest
from tools.mutants.workplace import HOME, TREE, pytest, run

Lines = dict[str, list[int]]  # of a source file, by its path
LONGEST = 4 * 3600.0  # seconds of a whole recording
SETTINGS = """[run]
source = {tree}/motorid
parallel = true
data_file = {home}/coverage/data
context = ${{MUTANTS_CONTEXT-}}
patch = subprocess, _exit, fork
disable_warnings = no-data-collected, module-not-imported, module-not-measured
"""


@dataclass(frozen=True)
class Map:
    """For each test its processor seconds and the lines it runs; for each file its digest."""

    seconds: dict[str, float]
    lines: dict[str, Lines]  # by test
    tests: dict[str, str]  # digest of each file of tests, with the helpers it imports
    sources: dict[str, str]  # digest of each source file, when it was run

    def covering(self, mutant: Mutant) -> list[str]:
        """Tests that run the mutant's line, those first that would see it soonest.

        These are the tests written for its file, then those of its room; among them the tests that
        run little else, whose answer hangs on this line the most. After them come the other tests
        of the same files, which share what the first ones made.
        For a line that runs on import, or only in processes that end without a word: tests that
        run anything of the file, and those whose file imports it. On import also those that look
        at all of its room.
        """
        exact = self._running(mutant.path, None if mutant.at_import else mutant.line)
        files = {file_of(test) for test in exact}
        if mutant.at_import or not exact:
            exact = self._running(mutant.path, None)
            files = {file_of(test) for test in exact} | importing(mutant.path)
        if mutant.at_import:
            looking = looking_at_all(mutant.path)
            exact |= {test for test in self.seconds if file_of(test) in looking}
        others = {test for test in self.seconds if file_of(test) in files} - exact
        own, room = written_for(mutant.path), mutant.path.split("/")[1]
        return [
            *sorted(exact, key=lambda test: (
                file_of(test) not in own, not _is_of(test, room), self._extent[test],
            )),
            *sorted(others, key=lambda test: self.seconds[test]),
        ]  # fmt: skip

    @cached_property
    def _extent(self) -> dict[str, tuple[int, float]]:
        """How many lines each test runs, and how long."""
        return {
            test: (sum(map(len, lines.values())), self.seconds[test])
            for test, lines in self.lines.items()
        }

    def _running(self, path: str, line: int | None) -> set[str]:
        """Tests that run that line of a file; None: any."""
        return {
            test
            for test, lines in self.lines.items()
            if path in lines and (line is None or line in lines[path])
        }


def file_of(test: str) -> str:
    """The file of a test, by its name."""
    return test.partition("::")[0]


def _is_of(test: str, room: str) -> bool:
    return test.startswith((f"tests/{room}/", f"tests/test_{room}", f"tests/{room}_"))


def written_for(path: str) -> set[str]:
    """Files of tests that import a source file, or that stand where it does."""
    folder, _, name = path.removeprefix("motorid/").rpartition("/")
    mirror = f"tests/{folder}/test_{name}"
    return importing(path) | ({mirror} & set(test_files()))


def near(path: str) -> list[str]:
    """Files of tests written for a source file, then the others of the folder of its mirror."""
    own, folder = written_for(path), f"tests/{path.removeprefix('motorid/').rpartition('/')[0]}"
    beside = {name for name in test_files() if name.rpartition("/")[0] == folder}
    return [*sorted(own), *sorted(beside - own)]


def lies_in(name: str, among: Sequence[str]) -> bool:
    """Whether a file is one of those, or in one of those folders."""
    return name in among or name.startswith(tuple(f"{one}/" for one in among))


def importing(path: str) -> set[str]:
    """Files of tests that name this module in an import."""
    module = path.removesuffix(".py").replace("/", ".").removesuffix(".__init__")
    return {str(name) for name in test_files() if module in imports(name)}


def test_files() -> list[str]:
    """Every file of tests, by its path in the repository."""
    found = (TREE / "tests").rglob("test_*.py")
    return sorted(path.relative_to(TREE).as_posix() for path in found)


def looking_at_all(path: str) -> set[str]:
    """Files of tests that import a room with that source file as a whole: ``import motorid.wire``.

    They go through its modules by themselves.
    """
    room = ".".join(path.split("/")[:2])
    return {str(name) for name in test_files() if room in wholes(name)}


@cache
def wholes(path: str) -> frozenset[str]:
    """Modules that a file of the repository imports as they are, and not names of them."""
    nodes = ast.walk(ast.parse((TREE / path).read_bytes()))
    return frozenset(a.name for node in nodes if isinstance(node, ast.Import) for a in node.names)


@cache
def imports(path: str) -> frozenset[str]:
    """Modules, and what may be modules, that a file of the repository names in its imports."""
    named = set()
    for node in ast.walk(ast.parse((TREE / path).read_bytes())):
        if isinstance(node, ast.Import):
            named |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            named |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return frozenset(named)


@cache
def test_digest(path: str) -> str:
    """Of a file of tests with its conftest files and the helpers that it imports."""
    known: set[str] = set()
    queue = [path]
    while queue:
        one = queue.pop()
        known.add(one)
        near = [str(parent / "conftest.py") for parent in Path(one).parents]
        helpers = [name.replace(".", "/") + ".py" for name in imports(one) if name[:6] == "tests."]
        queue += [p for p in {*near, *helpers} - known if (TREE / p).is_file()]
    return digest(*((TREE / one).read_bytes() for one in sorted(known)))


def loaded(path: Path) -> Map:
    """What was noted before."""
    if not path.is_file():
        return Map({}, {}, {}, {})
    return Map(**json.loads(path.read_text(encoding="utf-8")))


def brought_up_to_date(path: Path, marker: str, among: tuple[str, ...] = ("tests",)) -> Map:
    """The map, after running the tests that changed or that ran a source that changed.

    Of the tests in the folders or files ``among``; ``marker`` as of ``pytest -m``.
    """
    old = loaded(path)
    now = {name: digest((TREE / name).read_bytes()) for name in _sources()}
    changed = {name for name, was in old.sources.items() if now.get(name) != was}
    stale = {file_of(test) for test, lines in old.lines.items() if changed & lines.keys()}
    tests = [name for name in test_files() if lies_in(name, among)]
    current = {name: test_digest(name) for name in tests}
    again = [name for name in current if name in stale or old.tests.get(name) != current[name]]
    if again:
        print(f"noting which lines {len(again)} files of tests run", flush=True)
    seconds, lines = _noted(again, marker) if again else ({}, {})
    dropped = set(again) | (old.tests.keys() - current.keys())
    for test, took in old.seconds.items():
        if file_of(test) not in dropped:
            seconds[test], lines[test] = took, old.lines[test]
    made = Map(seconds, lines, current, now)
    path.write_text(json.dumps(vars(made)), encoding="utf-8")
    return made


def _sources() -> Iterator[str]:
    for path in sorted((TREE / "motorid").rglob("*.py")):
        yield path.relative_to(TREE).as_posix()


def _noted(files: Iterable[str], marker: str) -> tuple[dict[str, float], dict[str, Lines]]:
    """Runs tests in the copy under coverage: seconds and lines of those that pass."""
    from coverage import CoverageData

    folder, settings, note = HOME / "coverage", HOME / "coverage.ini", HOME / "note.json"
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.iterdir():
        old.unlink()
    settings.write_text(SETTINGS.format(tree=TREE, home=HOME), encoding="utf-8")
    words = pytest(*(["-m", marker] if marker else []), *files)
    command = [sys.executable, "-m", "coverage", "run", f"--rcfile={settings}", *words[1:]]
    code, said = run(command, {"MUTANTS_NOTE": str(note)}, LONGEST)
    if code not in (0, 1):
        raise SystemExit(f"the tests cannot be run: {said}")
    print(said.strip().splitlines()[-1], flush=True)
    seconds = json.loads(note.read_text(encoding="utf-8"))
    lines: dict[str, dict[str, set[int]]] = {test: {} for test in seconds}
    for file in folder.iterdir():
        data = CoverageData(str(file))
        data.read()
        for measured in data.measured_files():
            _add(data, measured, lines)
    return seconds, {
        test: {path: sorted(rows) for path, rows in files.items()} for test, files in lines.items()
    }


def _add(data: object, measured: str, lines: dict[str, dict[str, set[int]]]) -> None:
    path = Path(measured).relative_to(TREE).as_posix()
    for row, contexts in data.contexts_by_lineno(measured).items():  # type: ignore[attr-defined]
        for context in contexts:
            for test in context.split("|"):
                if test in lines:
                    lines[test].setdefault(path, set()).add(row)
