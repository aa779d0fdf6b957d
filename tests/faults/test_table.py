"""docs/faults.md says what happens."""

from __future__ import annotations

import pytest

from tests.faults import table
from tests.faults.scenarios import SCENARIOS


def test_there_are_forty_faults_and_each_is_named_once() -> None:
    names = [scenario.what for scenarios in SCENARIOS.values() for scenario in scenarios]
    assert len(names) == len(set(names)) >= 40
    page = table.PAGE.read_text(encoding="utf-8")
    assert [name for name in names if f"\n| {name} |" not in page] == []


@pytest.mark.slow
@pytest.mark.parametrize("title", list(SCENARIOS))
def test_the_page_says_what_happens(title: str) -> None:
    page = table.comparable(table.PAGE.read_text(encoding="utf-8"))
    for scenario in SCENARIOS[title]:
        assert table.comparable(table.row(scenario))[0] in page
