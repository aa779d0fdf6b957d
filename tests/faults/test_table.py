"""docs/faults.md says what happens."""

from __future__ import annotations

import os
import threading
from pathlib import Path

import pytest

from tests.faults import table
from tests.faults.laws import run
from tests.faults.scenarios import SCENARIOS
from tests.faults.test_schedules import QUIET


def test_there_are_forty_faults_and_each_is_named_once() -> None:
    names = [scenario.what for scenarios in SCENARIOS.values() for scenario in scenarios]
    assert len(names) == len(set(names)) >= 40
    page = table.PAGE.read_text(encoding="utf-8")
    assert [name for name in names if f"\n| {name} |" not in page] == []


def held() -> tuple[set[threading.Thread], int]:
    """Threads of this process, and how many descriptors (only Linux lists them)."""
    listed = Path("/proc/self/fd")
    return set(threading.enumerate()), len(os.listdir(listed)) if listed.is_dir() else 0


@pytest.fixture(scope="module")
def opened(tmp_path_factory: pytest.TempPathFactory) -> None:
    """A capture before: it opens what stays open, such as a random source."""
    run(QUIET, tmp_path_factory.mktemp("quiet"))


@pytest.mark.slow
@pytest.mark.usefixtures("opened")
@pytest.mark.parametrize("title", list(SCENARIOS))
def test_the_page_says_what_happens_and_nothing_is_left_open(title: str) -> None:
    """But where the host dies, of which a process of its own is left to the system."""
    page = table.comparable(table.PAGE.read_text(encoding="utf-8"))
    before = held()
    for scenario in SCENARIOS[title]:
        assert table.comparable(table.row(scenario))[0] in page
        if scenario.schedule.host in ("kill -9", "power failure"):
            continue
        now = held()
        assert now[0] <= before[0], scenario.what  # those of other tests may end meanwhile
        assert now[1] <= before[1], scenario.what
        before = now
