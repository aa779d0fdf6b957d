"""Names of operators: kept beside the seals, forgotten after a stated time, never in silence."""

from __future__ import annotations

import random
import sqlite3
from contextlib import closing
from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest

from motorid.cli.main import run
from motorid.errors import DataError
from motorid.quality.history import Entry, History, open_history
from motorid.quality.history.names import FORGOTTEN
from motorid.quality.history.trail import ORDER
from tests.history.records import BEGAN, record

YEAR = timedelta(days=365)


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """Motors 0 to 5, by anna and ben in turn, a week of seconds apart."""
    path = tmp_path / "line.db"
    with open_history(path) as history:
        for number in range(6):
            history.add(record(number, operator=("anna", "ben")[number % 2]))
        history.note(Entry(ORDER, "accepted", "anna", "k1", "SN-00000", at=BEGAN))
    return path


def sql(place: Path, *statements: str) -> list[Any]:
    with closing(sqlite3.connect(place)) as connection, connection:
        return [row for one in statements for row in connection.execute(one)]


def operators(history: History) -> list[str]:
    return [history.name_of(row.operator) for row in history.results()]


@pytest.mark.slow
def test_a_name_is_in_no_result_and_is_known_all_the_same(place: Path) -> None:
    cited = [row[0] for row in sql(place, "SELECT operator FROM results")]
    assert len(set(cited)) == 6  # two results of one person cannot be joined
    assert not any("anna" in one or "ben" in one for one in cited)
    with open_history(place, create=False) as history:
        assert operators(history) == ["anna", "ben"] * 3
        assert history.trail()[0]["who"] == "anna"


@pytest.mark.slow
def test_nobody_is_nobody(tmp_path: Path) -> None:
    with open_history(tmp_path / "line.db") as history:
        history.add(record(1))
        assert operators(history) == [""]
    assert sql(tmp_path / "line.db", "SELECT * FROM names") == []


@pytest.mark.slow
def test_old_names_are_forgotten_and_every_seal_holds(place: Path) -> None:
    with open_history(place) as history:
        early = history.forget_names("quality", now=BEGAN + YEAR)
        assert (early.names, early.days, history.sealed_names()) == (0, 365, 0)
        done = history.forget_names("quality", now=BEGAN + YEAR + timedelta(seconds=7))
        assert done.names == 4  # of motors 0, 1 and 2, and of the order
        assert operators(history) == [FORGOTTEN] * 3 + ["ben", "anna", "ben"]
        assert history.verify().problems == ()
        *_, entry = history.trail()
        assert (entry["action"], entry["who"], entry["reason"]) == (
            "forget names",
            "quality",
            "4 names",
        )
        assert history.trail()[0]["who"] == FORGOTTEN


@pytest.mark.slow
def test_a_forgotten_name_leaves_no_bytes(place: Path) -> None:
    with open_history(place) as history:
        history.forget_names(now=BEGAN + YEAR + timedelta(days=1))
        files = [path.read_bytes() for path in place.parent.iterdir()]
    assert not any(b"anna" in one or b"ben" in one for one in files)


@pytest.mark.slow
def test_another_rule_is_kept_and_said(place: Path) -> None:
    with open_history(place) as history:
        assert history.forget_names("quality", 10, now=BEGAN + timedelta(days=9)).days == 10
        assert history.forget_names(now=BEGAN + timedelta(days=11)).names == 7
        assert history.forget_names("boss", 0, now=BEGAN + 9 * YEAR).names == 0  # for ever
        said = [(one["action"], one["subject"]) for one in history.trail()]
    assert ("keep names", "10 days") in said
    assert ("keep names", "for ever") in said


EDITS = {
    "another name": ("UPDATE names SET name = 'eve' WHERE name = 'anna'", "it was edited"),
    "another salt": ("UPDATE names SET salt = 'x' WHERE name = 'ben'", "it was edited"),
    "a name less": ("DELETE FROM names WHERE name = 'ben'", "it was deleted"),
    "another citation": ("UPDATE results SET operator = 'eve' WHERE id = 2", "edited after"),
    "an order by another": ("UPDATE trail SET who = 'eve'", "edited after it was sealed"),
    "another outcome of an order": ("UPDATE trail SET outcome = 'refused'", "edited after"),
    "another chain": ("UPDATE trail SET chain = content", "does not follow"),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("edit", EDITS)
def test_an_edit_is_found(place: Path, edit: str) -> None:
    statement, said = EDITS[edit]
    sql(place, statement)
    with open_history(place, create=False) as history:
        assert any(said in problem for problem in history.verify().problems)


@pytest.mark.slow
def test_a_deleted_entry_of_the_trail_is_found(place: Path) -> None:
    with open_history(place) as history:
        history.note(Entry(ORDER, "refused", "ben", "k2", "SN-00009"))
    sql(place, "DELETE FROM trail WHERE position = 1")
    with open_history(place, create=False) as history:
        assert any("1 entries before it were deleted" in one for one in history.verify().problems)


@pytest.mark.slow
def test_an_entry_goes_in_once(place: Path) -> None:
    with open_history(place) as history:
        assert not history.note(Entry(ORDER, "accepted", "anna", "k1", "SN-00000"))
        assert history.note(Entry(ORDER, "accepted", "anna", "k2", "SN-00000"))
        assert len(history.trail()) == 2
        assert len(history.trail(serial="SN-0*", last=1)) == 1
        assert history.trail(serial="SN-1*") == history.trail(station="line-9") == []


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_whatever_is_added_and_forgotten_in_any_order_stays_whole(
    seed: int, tmp_path: Path
) -> None:
    draw = random.Random(seed)
    known: dict[int, str] = {}
    with open_history(tmp_path / "line.db") as history:
        cutoff = BEGAN
        for _ in range(30):
            match draw.randrange(3):
                case 0:
                    number = draw.randrange(200)
                    name = draw.choice(["", "anna", "Zoë", "x" * 200])
                    if history.add(
                        record(number, station=f"line-{draw.randrange(2)}", operator=name)
                    ):
                        known[number] = name
                case 1:
                    key = str(draw.randrange(20))
                    history.note(Entry(ORDER, "refused", "ben", key, station="line-0"))
                case _:
                    cutoff = max(cutoff, BEGAN + timedelta(seconds=draw.randrange(600)))
                    history.forget_names(now=cutoff + YEAR)
        history.forget_names(now=cutoff + YEAR)
        assert history.verify().problems == ()
        for row in history.results():
            number = int(row.serial[3:])
            gone = known[number] and row.at < cutoff
            assert history.name_of(row.operator) == (FORGOTTEN if gone else known[number])


@pytest.mark.slow
def test_a_name_within_an_older_seal_stays_and_is_counted(place: Path) -> None:
    sql(place, "UPDATE results SET operator = 'anna' WHERE id < 3")  # as step 0002 wrote them
    with open_history(place) as history:
        history.forget_names(now=BEGAN + 2 * YEAR)
        assert history.sealed_names() == 2
        assert operators(history)[:3] == ["anna", "anna", FORGOTTEN]


@pytest.mark.slow
@pytest.mark.parametrize("said", ["-1", "many", "1e3", "99999999"])
def test_a_damaged_rule_forgets_nobody(place: Path, said: str) -> None:
    sql(place, f"UPDATE meta SET value = '{said}' WHERE name = 'names_kept_days'")
    with open_history(place) as history:
        with pytest.raises(DataError, match="no number of days"):
            history.forget_names()
        assert operators(history) == ["anna", "ben"] * 3


@pytest.mark.slow
def test_a_history_from_before_names_were_cited_is_read(place: Path) -> None:
    sql(
        place,
        "DROP TABLE names",
        "DROP TABLE trail",
        "UPDATE alembic_version SET version_num = '0002'",
    )
    with open_history(place, create=False) as history:
        assert history.trail() == []
        assert history.verify().problems == ()
        assert len(history.results()) == 6


@pytest.mark.slow
def test_the_commands(place: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert run(["history", "trail", str(place)]) == 0
    shown = capfd.readouterr()
    assert "SN-00000" in shown.out
    assert "anna" in shown.out
    assert run(["history", "forget", str(place), "--keep", "400", "--by", "quality"]) == 0
    assert "names are kept for 400 days" in capfd.readouterr().out
    assert run(["history", "trace", str(place), "SN-00003"]) == 0
    assert "check by ben" in capfd.readouterr().out
    sql(place, "UPDATE results SET operator = 'anna' WHERE id = 1")
    assert run(["history", "forget", str(place), "--keep", "0"]) == 0
    said = capfd.readouterr().out
    assert "names are kept for ever" in said
    assert "1 results from before step 0003" in said
    assert run(["history", "forget", str(place), "--keep", "-1"]) == 2
