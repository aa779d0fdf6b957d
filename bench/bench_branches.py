"""How much of the package the tests run, branches counted: at least 90 % is the floor.

python bench/bench_branches.py                         every test; an hour and more
python bench/bench_branches.py --quick                 the quick tests; minutes
python bench/bench_branches.py --tests tests/wire      those of some folders

Child processes count too: commands that a test starts, workers of a pool. A branch counts where the
tests took both of its ways. Ends with 1 below the floor, or where a test fails.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
FOLDER = ROOT / "out" / "branches"
FLOOR = 0.90
LEAST_SHOWN = 20  # files, those with most untaken lines and branches
SETTINGS = """[run]
branch = true
source_pkgs = motorid
parallel = true
patch = subprocess, _exit, fork
disable_warnings = no-data-collected, module-not-imported, module-not-measured
data_file = {folder}/data
[report]
exclude_also =
    if TYPE_CHECKING:
    raise NotImplementedError
    @overload
    class .*\\(Protocol\\):
"""


class Tally:
    """Lines and branches, and how many of them were taken."""

    def __init__(self) -> None:
        self.all = self.taken = 0

    def add(self, summary: Mapping[str, Any]) -> None:
        """Adds a file's, as coverage's JSON tells them."""
        self.all += summary["num_statements"] + summary["num_branches"]
        self.taken += summary["covered_lines"] + summary["covered_branches"]

    @property
    def share(self) -> float:
        """Of lines and branches, those that were taken; 1 of none."""
        return self.taken / self.all if self.all else 1.0


def room_of(file: str) -> str:
    """The folder below the package, or the package itself."""
    parts = Path(file).parts
    return "/".join(parts[:2]) if len(parts) > 2 else parts[0]


def tallies(files: Mapping[str, Any]) -> dict[str, Tally]:
    """Of every room, and of "all"."""
    found: dict[str, Tally] = defaultdict(Tally)
    for file, one in files.items():
        found[room_of(file)].add(one["summary"])
        found["all"].add(one["summary"])
    return dict(found)


def _coverage(*words: str) -> int:
    environment = {**os.environ, "COVERAGE_RCFILE": str(FOLDER / "settings.ini")}
    command = [sys.executable, "-m", "coverage", *words]
    return subprocess.run(command, cwd=ROOT, env=environment, check=False).returncode


def measured(tests: Sequence[str], jobs: int) -> tuple[int, dict[str, Any]]:
    """The tests' exit code, and every file of the package as coverage's JSON tells it."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    for old in FOLDER.glob("data*"):
        old.unlink()
    (FOLDER / "settings.ini").write_text(SETTINGS.format(folder=FOLDER), encoding="utf-8")
    pytest = ("-m", "pytest", "-q", "-n", str(jobs), "--dist", "worksteal")
    code = _coverage("run", *pytest, *tests)
    _coverage("combine", "--quiet")
    _coverage("json", "--quiet", "-o", str(FOLDER / "result.json"))
    return code, json.loads((FOLDER / "result.json").read_text(encoding="utf-8"))["files"]


def page(files: Mapping[str, Any]) -> str:
    """Tables of rooms, and of the files that miss most."""
    lines = ["| room | lines and branches | taken |", "|---|---|---|"]
    for room, tally in sorted(tallies(files).items(), key=lambda one: one[1].share):
        lines.append(f"| {room} | {tally.all} | {tally.share:.1%} |")
    lines += ["", "| file | untaken | taken |", "|---|---|---|"]
    each = {file: Tally() for file in files}
    for file, tally in each.items():
        tally.add(files[file]["summary"])
    worst = sorted(each.items(), key=lambda one: one[1].taken - one[1].all)
    for file, tally in worst[:LEAST_SHOWN]:
        lines.append(f"| {file} | {tally.all - tally.taken} | {tally.share:.1%} |")
    return "\n".join(lines)


def main(arguments: Sequence[str]) -> int:
    """Prints the tables; 1 below the floor or where a test fails."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--tests", nargs="*", default=[], help="files and folders; all by default")
    parser.add_argument("--quick", action="store_true", help="without those that are slow")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    options = parser.parse_args(arguments)
    tests = [*(["-m", "not slow"] if options.quick else []), *options.tests]
    code, files = measured(tests, options.jobs)
    print(page(files))
    share = tallies(files)["all"].share
    print(f"\nlines and branches taken: {share:.1%}; floor {FLOOR:.0%}; tests ended with {code}")
    return 0 if code == 0 and share >= FLOOR else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
