"""The conformance suite against a device, as a process of pytest in a working copy."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from motorid.errors import DataError

ROOT = Path(__file__).parents[3]
SUITE = Path("tests", "conformance")
REPORT, OUTPUT = "suite.xml", "suite.txt"
SHOWN = 5  # failures named in a sentence


@dataclass(frozen=True)
class Outcome:
    """How many cases passed and were skipped, and the names of those that failed."""

    passed: int
    failed: tuple[str, ...]
    skipped: int

    def sentence(self) -> str:
        """For a person."""
        said = f"{self.passed} passed, {len(self.failed)} failed, {self.skipped} skipped"
        more = "" if len(self.failed) <= SHOWN else " and others"
        return f"{said}: {', '.join(self.failed[:SHOWN])}{more}" if self.failed else said


def why_not() -> str:
    """Why the suite cannot run here, in a sentence; "" where it can."""
    if not (ROOT / SUITE).is_dir():
        return "the suite is not in an installed package: run this in a working copy of motorid"
    if importlib.util.find_spec("pytest") is None:
        return "the suite needs pytest: pip install pytest, or use the environment of make test"
    return ""


def run_suite(port: str, folder: Path, select: str = "") -> Outcome:
    """Runs it against the board behind ``port``; report and output go to ``folder``.

    ``select``: pytest's expression, of the cases wanted. Raises DataError where no case ran.
    """
    report = folder / REPORT
    wanted = f"device and ({select})" if select else "device"
    command = [sys.executable, "-m", "pytest", str(SUITE), "-k", wanted, "--device", port]
    command += ["-q", "-p", "no:cacheprovider", f"--junitxml={report.resolve()}"]
    with open(folder / OUTPUT, "wb") as file:
        done = subprocess.run(  # noqa: S603 - our own suite, by this Python
            command, cwd=ROOT, stdout=file, stderr=subprocess.STDOUT, check=False
        )
    if not report.is_file():
        raise DataError(f"the suite ended with {done.returncode} and no report: see {OUTPUT}")
    return read_report(report)


def read_report(path: Path) -> Outcome:
    """What a report in JUnit's format says. Raises DataError where it holds no case."""
    try:
        cases = list(ElementTree.parse(path).iter("testcase"))  # noqa: S314 - pytest wrote it here
    except ElementTree.ParseError as error:
        raise DataError(f"{path} is no report of the suite ({error})") from None
    failed, skipped = [], 0
    for case in cases:
        if case.find("failure") is not None or case.find("error") is not None:
            failed.append(str(case.get("name", "?")))
        elif case.find("skipped") is not None:
            skipped += 1
    passed = len(cases) - len(failed) - skipped
    if not passed and not failed:
        raise DataError("not one case of the suite ran: does the board answer on this port?")
    return Outcome(passed, tuple(failed), skipped)
