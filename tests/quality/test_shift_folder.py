"""A station's folder with many inspections: the newest come first, and few files are looked at."""

from __future__ import annotations

import os
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from motorid.workflow import shift_folder
from motorid.workflow.shift_folder import name_of, newest_first, serial_of, unsettled

BEGAN = datetime(2026, 11, 25, 6, 0, tzinfo=UTC)


def inspection(folder: Path, serial: str, minutes: int, written: float) -> Path:
    one = folder / name_of(serial, BEGAN + timedelta(minutes=minutes))
    one.mkdir(parents=True)
    (one / "verdict.json").write_text("{}")
    os.utime(one / "verdict.json", (written, written))
    return one


def is_marked(one: Path) -> bool:
    return (one / "mark").exists()


@pytest.mark.slow
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(serial=st.text(min_size=1, max_size=20).filter(str.isprintable))
def test_a_folder_tells_its_motor(serial: str, tmp_path: Path) -> None:
    assert serial_of(tmp_path / name_of(serial, BEGAN)) == serial
    assert "/" not in name_of(serial, BEGAN)


def test_the_newest_come_first_across_steps(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shift_folder, "STEP", 4)
    made = [inspection(tmp_path, f"D{n}", 50 * n, 1e9 + n) for n in range(30)]
    (tmp_path / "orders.jsonl").write_text("")
    assert list(newest_first(tmp_path)) == made[::-1]


def test_an_hour_that_comes_twice_is_ordered_by_the_files(tmp_path: Path) -> None:
    """The clock went back after the first: its name says the later time."""
    before = inspection(tmp_path, "A", 59, 1e9)
    after = inspection(tmp_path, "B", 1, 1e9 + 60.0)
    assert list(newest_first(tmp_path)) == [after, before]


def test_the_first_comes_before_the_others_are_looked_at(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for n in range(300):
        inspection(tmp_path, f"D{n}", 60 * n, 1e9 + n)
    looked: list[Path] = []
    written = shift_folder._written
    monkeypatch.setattr(shift_folder, "_written", lambda one: (looked.append(one), written(one))[1])
    assert next(newest_first(tmp_path)).name.startswith("D299_")
    assert len(looked) < 2 * shift_folder.STEP


def test_one_motor_alone_also_where_its_number_begins_anothers(tmp_path: Path) -> None:
    first, second = inspection(tmp_path, "A", 0, 1e9), inspection(tmp_path, "A", 1, 1e9 + 1.0)
    inspection(tmp_path, "A_B", 2, 1e9 + 2.0)
    inspection(tmp_path, "AB", 3, 1e9 + 3.0)
    assert list(newest_first(tmp_path, "A")) == [second, first]


def test_a_folder_of_another_name_counts_as_the_newest(tmp_path: Path) -> None:
    inspection(tmp_path, "A", 0, 1e9)
    (tmp_path / "kept by hand").mkdir()
    assert next(one.name for one in newest_first(tmp_path)) == "kept by hand"
    assert list(newest_first(tmp_path / "nothing")) == []


def test_what_is_settled_is_asked_once(tmp_path: Path) -> None:
    made = [inspection(tmp_path, f"D{n}", n, 1e9) for n in range(5)]
    for one in made[:3]:
        (one / "mark").touch()
    asked: list[Path] = []

    def settled(one: Path) -> bool:
        asked.append(one)
        return is_marked(one)

    assert unsettled(tmp_path, "marked", settled) == made[3:]
    assert asked == made
    asked.clear()
    assert unsettled(tmp_path, "marked", settled) == made[3:]
    assert asked == made[3:]
    assert unsettled(tmp_path, "other", lambda one: False) == made  # a list of its own


def test_a_list_that_is_gone_or_cut_off_is_made_anew(tmp_path: Path) -> None:
    made = [inspection(tmp_path, f"D{n}", n, 1e9) for n in range(4)]
    for one in made[1:]:
        (one / "mark").touch()
    unsettled(tmp_path, "marked", is_marked)
    path = tmp_path / f"{shift_folder.LIST}marked"
    whole = path.read_bytes()
    for left in (b"", whole[:-10], whole[:20], b"\xff\x00" + whole):
        path.write_bytes(left)
        for _ in range(2):
            assert unsettled(tmp_path, "marked", is_marked) == made[:1]
    path.unlink()
    assert unsettled(tmp_path, "marked", is_marked) == made[:1]


def test_a_list_that_cannot_be_written_costs_nothing_but_time(tmp_path: Path) -> None:
    one = inspection(tmp_path, "A", 0, 1e9)
    (one / "mark").touch()
    (tmp_path / f"{shift_folder.LIST}marked").mkdir()
    assert unsettled(tmp_path, "marked", is_marked) == []
    assert unsettled(tmp_path / "nothing", "marked", is_marked) == []
