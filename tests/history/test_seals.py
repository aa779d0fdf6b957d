"""Edits, deletions, insertions and a cut tail are found; what was written as it should is whole."""

from __future__ import annotations

import random
import sqlite3
from contextlib import closing
from dataclasses import asdict
from pathlib import Path

import pytest

from motorid import json_text
from motorid.cli.main import run
from motorid.quality.history import History, open_history
from motorid.quality.history.chain import Head
from motorid.quality.history.records import digest as sha256
from motorid.quality.history.seals import content_of
from tests.history.records import UNSTEPPED, record

pytestmark = pytest.mark.slow


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """Ten results of two stations, alternating."""
    path = tmp_path / "line.db"
    with open_history(path) as history:
        for number in range(10):
            history.add(record(number, station=f"line-{number % 2}"))
    return path


def sql(place: Path, *commands: str) -> None:
    with closing(sqlite3.connect(place)) as connection, connection:
        for command in commands:
            assert connection.execute(command).rowcount != 0, command


def problems(place: Path, *anchors: Head) -> tuple[str, ...]:
    with open_history(place, create=False) as history:
        return history.verify(anchors).problems


def test_an_honest_history_is_whole(place: Path) -> None:
    with open_history(place) as history:
        history.add(record(3, station="line-1"))  # known already: no second seal
        found = history.verify([history.head("line-0"), history.head("line-1")])
    assert found.problems == ()
    assert (found.sealed, found.unsealed) == (10, 0)
    assert [(head.station, head.position) for head in found.heads] == [("line-0", 5), ("line-1", 5)]


EDITS = {
    "a value": "UPDATE measurements SET value = value + 1e-12 WHERE result = 4 AND name = 'R'",
    "an outcome": "UPDATE results SET outcome = 'FAIL' WHERE id = 4",
    "a serial": "UPDATE results SET serial = 'SN-99999' WHERE id = 4",
    "a time": "UPDATE results SET at = '2026-01-05 06:00:09.000001' WHERE id = 4",
    "a capture": "UPDATE captures SET path = 'elsewhere' WHERE serial = 'SN-00003'",
    "a measurement less": "DELETE FROM measurements WHERE result = 4 AND name = 'K'",
    "a measurement more": "INSERT INTO measurements (result, name, unit, outcome, marginal, reason)"
    " VALUES (4, 'L', 'H', '', 0, '')",
}


@pytest.mark.parametrize("edit", EDITS.values(), ids=list(EDITS))
def test_an_edit_is_found(place: Path, edit: str) -> None:
    sql(place, edit)
    assert problems(place) == ("station line-1, result 4: it was edited after it was sealed",)


ALL_OF_4 = [
    "DELETE FROM measurements WHERE result = 4",
    "DELETE FROM result_captures WHERE result = 4",
    "DELETE FROM results WHERE id = 4",
]
LAST = [one.replace("= 4", "= 10") for one in (*ALL_OF_4, "DELETE FROM seals WHERE result = 4")]


def test_a_deletion_is_found(place: Path) -> None:
    sql(place, *ALL_OF_4)
    assert problems(place) == ("station line-1, result 4: it was deleted",)
    sql(place, "DELETE FROM seals WHERE result = 4")
    assert "1 seals before it were deleted" in problems(place)[0]


def test_an_insertion_is_found(place: Path) -> None:
    sql(
        place,
        "INSERT INTO results (id, key, kind, serial, product, outcome, marginal, at, station, "
        "operator, note, versions) SELECT 11, 'x', kind, serial, product, outcome, marginal, at, "
        "station, operator, note, versions FROM results WHERE id = 1",
    )
    assert problems(place) == ("result 11: it was inserted without a seal",)


def test_a_cut_tail_and_a_chain_written_anew_are_found_by_the_anchors(place: Path) -> None:
    with open_history(place) as history:
        anchor = history.head("line-1")
    sql(place, *LAST)
    (said,) = problems(place)  # the day's counts alone show it inside
    assert said.startswith("station line-1: the counts of 2026-01-05 are not those of its results")
    with open_history(place) as history:
        history.recount()
    assert problems(place) == ()  # and now nothing does
    assert "the end was cut off" in problems(place, anchor)[0]


def test_a_forged_chain_differs_from_its_anchor(place: Path) -> None:
    with open_history(place) as history:
        anchor = history.head("line-1")
    sql(place, "UPDATE results SET outcome = 'FAIL' WHERE id = 4")
    forge(place, "line-1")
    with open_history(place) as history:
        history.recount()  # whoever forges a chain makes the counts fit as well
    assert problems(place) == ()
    assert len(problems(place, anchor)) == 1


def forge(place: Path, station: str) -> None:
    """What somebody does who has read this program."""
    with open_history(place) as history, history.engine.begin() as connection:
        chain = "0" * 64
        seals = connection.exec_driver_sql(
            "SELECT position, result FROM seals WHERE station = ? ORDER BY position", (station,)
        ).all()
        for position, result in seals:
            content = content_of(connection, result)
            chain = sha256(chain + content)
            connection.exec_driver_sql(
                "UPDATE seals SET content = ?, chain = ? WHERE station = ? AND position = ?",
                (content, chain, station, position),
            )


def test_older_results_are_unsealed_and_counted(place: Path) -> None:
    sql(place, "DROP TABLE seals", "DELETE FROM meta WHERE name = 'unsealed'", *UNSTEPPED)
    with open_history(place, create=False) as history:  # as an older motorid left it
        before = history.verify()
        assert (before.sealed, before.unsealed) == (0, 10)
        history.add(record(20))
        found = history.verify()
    assert (found.sealed, found.unsealed, found.problems) == (1, 10, ())
    sql(place, *ALL_OF_4)
    assert problems(place) == ("there were 10 results from before the seals, and there are 9 now",)


def test_any_one_change_of_any_table_is_found(place: Path) -> None:
    """Drawn: a row of a table that a result rests on, deleted or with one column changed."""
    rng = random.Random(20)
    with open_history(place) as history:
        anchors = [history.head("line-0"), history.head("line-1")]
    whole = place.read_bytes()
    for _ in range(10):
        for rest in place.parent.glob("line.db*"):
            rest.unlink()
        place.write_bytes(whole)
        table = rng.choice(["results", "measurements", "seals", "result_captures"])
        with closing(sqlite3.connect(place)) as connection, connection:
            rowid = rng.choice([r for (r,) in connection.execute(f"SELECT rowid FROM {table}")])
            connection.execute(f"DELETE FROM {table} WHERE rowid = ?", (rowid,))
        assert problems(place, *anchors), (table, rowid)


def test_the_command(place: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with open_history(place) as history:
        keep(history, tmp_path / "shift")
    call = ["history", "verify", str(place), "--inspections", str(tmp_path / "shift")]
    assert run(call) == 0
    assert "10 sealed results, 0 unsealed, 1 anchors" in capsys.readouterr().out
    sql(place, *LAST)
    assert run(call) == 4
    assert "DAMAGED station line-1" in capsys.readouterr().out
    (tmp_path / "shift" / "one" / "in-history").write_text("line.db\nnothing\n")
    assert run(call) == 4


def keep(history: History, folder: Path) -> None:
    """As a station marks an inspection."""
    (folder / "one").mkdir(parents=True)
    head = json_text.dumps(asdict(history.head("line-1")))
    (folder / "one" / "in-history").write_text(f"line.db\n{head}\n")
