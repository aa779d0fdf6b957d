"""What pytest does for mutants: it notes which test runs which line, or runs listed tests.

MUTANTS_NOTE=file   coverage is on: a context for each test; writes each test's processor seconds
MUTANTS_ONLY=file   a JSON list of tests: these alone, in this order
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

CONTEXT = "MUTANTS_CONTEXT"  # a process that a test starts says by it whose it is
_seconds: dict[str, float] = {}
_bad: set[str] = set()
_files: list[str] = []


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """After every conftest has marked and sorted."""
    listed = os.environ.get("MUTANTS_ONLY")
    if listed:
        place = {name: at for at, name in enumerate(json.loads(Path(listed).read_text()))}
        items[:] = sorted((i for i in items if i.nodeid in place), key=lambda i: place[i.nodeid])


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Lines that run from here on are this test's, in child processes too."""
    if "MUTANTS_NOTE" not in os.environ:
        return (yield)
    import coverage

    file = item.nodeid.partition("::")[0]
    if _files[-1:] != [file]:
        _files.append(file)
        _forget()
    os.environ[CONTEXT] = item.nodeid
    now = coverage.Coverage.current()
    assert now is not None
    now.switch_context(item.nodeid)
    began = _spent()
    try:
        return (yield)
    finally:
        _seconds[item.nodeid] = _spent() - began


def _spent() -> float:
    """Seconds of the processor, of this process and of those it waited for: load changes none."""
    return sum(os.times()[:4])


def _forget() -> None:
    """What an earlier file's tests left in a cache would hide the lines that this file needs."""
    for name, module in list(sys.modules.items()):
        if name.partition(".")[0] in ("motorid", "tests"):
            for value in list(vars(module).values()):
                clear = getattr(value, "cache_clear", None)
                if callable(clear):
                    clear()


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """A test that does not pass is of no use."""
    if report.outcome != "passed":
        _bad.add(report.nodeid)


def pytest_sessionfinish() -> None:
    """Writes the note."""
    if "MUTANTS_NOTE" in os.environ:
        good = {name: round(took, 4) for name, took in _seconds.items() if name not in _bad}
        Path(os.environ["MUTANTS_NOTE"]).write_text(json.dumps(good))
