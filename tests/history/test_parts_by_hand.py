"""Parts of the history by hand: months, chains, records as plain data, and what a query finds."""

from __future__ import annotations

import hashlib
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from sqlalchemy import make_url
from sqlalchemy.dialects import postgresql, sqlite

from motorid.errors import DataError
from motorid.quality.history import (
    History,
    MeasurementRecord,
    Query,
    engine,
    months,
    open_history,
    turns,
)
from motorid.quality.history import schema as s
from motorid.quality.history.chain import START, Head, broken
from motorid.quality.history.check import damage
from motorid.quality.history.citing import results_citing
from motorid.quality.history.records import (
    ResultRecord,
    _instant,
    from_plain,
    from_stored,
    from_verdict,
    to_plain,
)
from motorid.quality.limits import Limit
from motorid.quality.records import to_dict
from motorid.quality.verdict import Reading, Verdict, decide
from tests.history.records import BEGAN, record


def sha(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


# ---- months ------------------------------------------------------------------------------------


def test_the_month_of_an_instant_is_that_of_utc() -> None:
    east = timezone(timedelta(hours=2))
    assert months.month_of(datetime(2026, 12, 1, 1, tzinfo=east)) == 202611
    assert months.month_of(datetime(2026, 12, 1, 2, tzinfo=east)) == 202612


@pytest.mark.parametrize(
    ("since", "until", "low", "high"),
    [
        ((2026, 11), (2026, 12), 202611, 202613), ((2026, 11), None, 202611, 999913),
        (None, (2026, 11), 0, 202612),
    ],
)  # fmt: skip
def test_ids_of_some_months(
    since: tuple[int, int] | None, until: tuple[int, int] | None, low: int, high: int
) -> None:
    """From the first month to the last one, both whole; ids from before there were months too."""
    ends = [None if at is None else datetime(*at, 5, tzinfo=UTC) for at in (since, until)]
    (found,) = months.within(s.results.c.id, *ends)
    options = {"compile_kwargs": {"literal_binds": True}}
    said = str(found.compile(dialect=postgresql.dialect(), **options))
    assert said == (
        f"(results.id < {10**10} OR results.id >= {low * 10**10} AND results.id < {high * 10**10})"
    )
    assert str(found.compile(dialect=sqlite.dialect(), **options)) == "1 = 1"
    assert months.within(s.results.c.id, None, None) == []


@dataclass
class Server:
    """Which months a server has, and which it is asked to make; asked things are kept."""

    there: set[int]
    name: str = "postgresql"

    def __post_init__(self) -> None:
        self.dialect = SimpleNamespace(name=self.name)
        self.made: list[int] = []
        self.asked: list[str] = []

    def scalar(self, wanted: Any) -> str | None:
        (table,) = wanted.compile(dialect=postgresql.dialect()).params.values()
        return table if int(table.removeprefix("results_")) in self.there else None

    def execute(self, wanted: Any) -> None:
        compiled = wanted.compile(dialect=postgresql.dialect())
        self.asked.append(str(compiled))
        self.made += compiled.params.values()


@pytest.mark.parametrize(
    ("at", "there", "made"),
    [
        (datetime(2026, 11, 30, tzinfo=UTC), set(), {202611, 202612}),
        (datetime(2026, 12, 1, tzinfo=UTC), {202612}, {202701}),
        (datetime(2027, 1, 31, tzinfo=UTC), {202702}, {202701}),
        (datetime(2027, 1, 31, tzinfo=UTC), {202701, 202702}, set()),
        (datetime(9999, 12, 31, tzinfo=UTC), set(), {999912}),
        (datetime(9998, 12, 31, tzinfo=UTC), set(), {999812, 999901}),
    ],
)
def test_a_month_and_the_next_one_are_made_once(
    at: datetime, there: set[int], made: set[int]
) -> None:
    server = Server(there)
    months.make(server, at)  # type: ignore[arg-type]
    assert (set(server.made), len(server.made)) == (made, len(made))


def test_turns_are_waited_for() -> None:
    """By locks of a server, of which a motor's has one that all share; elsewhere by a row."""
    server, other = Server(set()), Server(set(), "mysql")
    for turn in (server, other):
        turns.of_motor(turn, "pump", "M1")  # type: ignore[arg-type]
        turns.of_chain(turn, "seals", "left")  # type: ignore[arg-type]
        turns.of_counts(turn)  # type: ignore[arg-type]
    assert ["shared" in said for said in server.asked] == [True, False, False, False]
    assert all("pg_advisory_xact_lock" in said for said in server.asked)
    assert server.made[0] == server.made[3]  # all counts
    assert len({*server.made}) == 3
    assert [said.endswith("FOR UPDATE") for said in other.asked] == [True] * 3
    own = int.from_bytes(hashlib.sha256(b"motorid seals of left").digest()[:8], "big", signed=True)
    assert server.made[2] == own


# ---- chains ------------------------------------------------------------------------------------


def chained(*contents: str, station: str = "left") -> list[SimpleNamespace]:
    head, rows = Head(station, 0, START), []
    for content in contents:
        link = head.link(content)
        head = Head(station, link["position"], link["chain"])
        rows.append(SimpleNamespace(**link, now=content))
    return rows


def said_of(rows: list[SimpleNamespace]) -> list[str]:
    return list(broken(rows, lambda row: f"row {row.position}", lambda row: row.now, "seals"))


def test_a_link_follows_from_the_one_before() -> None:
    one, two = chained("a", "b")
    assert (one.chain, one.position, one.station) == (sha("0" * 64 + "a"), 1, "left")
    assert (two.chain, two.position, two.content) == (sha(one.chain + "b"), 2, "b")


def test_what_is_wrong_with_a_chain() -> None:
    whole = [*chained("a", "b", "c", "d"), *chained("e", "f", station="")]
    assert said_of(whole) == []
    gone = [whole[0], *whole[3:]]
    assert said_of(gone) == ["station left, row 4: 2 seals before it were deleted"]
    assert said_of(whole[:4] + whole[5:]) == [
        "station without a name, row 2: 1 seals before it were deleted"
    ]
    whole[1].now, whole[2].now = "x", ""
    assert said_of(whole) == [
        "station left, row 2: it was edited after it was sealed",
        "station left, row 3: it was deleted",
    ]
    whole[1].now, whole[2].now, whole[1].content = "x", "c", "x"
    assert said_of(whole) == [
        "station left, row 2: its seal does not follow from the one before: it was edited"
    ]


# ---- records -----------------------------------------------------------------------------------


def test_a_record_as_plain_data_and_back() -> None:
    whole = replace(record(3, operator="kim"), note="n", marginal=True)
    bare = replace(whole, captures=(replace(whole.captures[0], created=None),))
    for one in (whole, bare):
        plain = to_plain(one)
        assert from_plain(plain) == one
        assert plain["at"] == one.at.isoformat()
    assert to_plain(bare)["captures"][0]["created"] is None


def test_what_makes_a_result_the_same() -> None:
    """The time counts only where no capture tells; who measured it, and a note, do not."""
    one = record(3)
    later = one.at + timedelta(days=1)
    for same in ({"at": later}, {"station": "x"}, {"operator": "x"}, {"note": "x"},
                 {"estimate": "x"}, {"marginal": True}):  # fmt: skip
        assert replace(one, **same).key == one.key, same
    changes: dict[str, Any] = {"kind": "fit", "versions": {}, "captures": (), "measurements": ()}
    for name, value in (
        changes | dict.fromkeys(("serial", "product", "outcome", "limits"), "x")
    ).items():
        other = {name: value}
        assert replace(one, **other).key != one.key, other
    bare = replace(one, captures=())
    assert replace(bare, at=later).key != bare.key
    east = bare.at.astimezone(timezone(timedelta(hours=3)))
    assert replace(bare, at=east).key == bare.key


@pytest.mark.parametrize(
    ("text", "instant"),
    [
        ("2026-01-05T06:00:00", BEGAN), ("2026-01-05T08:00:00+02:00", BEGAN), ("yesterday", None),
        (None, None), ("", None),
    ],
)  # fmt: skip
def test_the_time_of_a_capture(text: str | None, instant: datetime | None) -> None:
    assert _instant(text) == instant


def test_a_record_of_a_verdict_and_of_a_stored_one() -> None:
    made = (
        decide(Limit("R_25", "ohm", 2.4), Reading("ohm", 2.41, 0.01), "resistance"),
        decide(Limit("J", "kg·m²", 0.0, 1.0), Reading("kg·m²", problem="lost"), "inertia"),
    )
    verdict = Verdict("pump", "M1", made, (), {"v": "1"})
    found = from_verdict(verdict, (), kind="golden", limits="L", estimate_json="E", at=BEGAN)
    assert found == ResultRecord(
        "golden", "M1",
        (
            MeasurementRecord("R_25", "ohm", 2.41, 0.01, 2.4, None, 0.02, "FAIL", True,
                              made[0].reason),
            MeasurementRecord("J", "kg·m²", None, None, 0.0, 1.0, 0.0, "INVALID", False,
                              "inertia: lost"),
        ),
        (), "pump", "FAIL", True, BEGAN, "", "", "", {"v": "1"}, "L", "E",
    )  # fmt: skip
    assert from_verdict(verdict, ()).kind == "check"
    stored = {**to_dict(verdict, time=BEGAN, who={"station": "left"}), "retest": "why"}
    again = from_stored(stored, (), limits="L", operator="kim", station="other")
    assert again.measurements == found.measurements
    assert (again.kind, again.serial, again.product, again.at) == ("check", "M1", "pump", BEGAN)
    assert (again.outcome, again.marginal, again.note) == ("FAIL", True, "tested again: why")
    assert (again.station, again.operator, again.limits) == ("left", "kim", "L")
    assert from_stored({**stored, "retest": ""}, ()).note == ""


# ---- what is found -----------------------------------------------------------------------------


@pytest.fixture(scope="module")
def history(tmp_path_factory: pytest.TempPathFactory) -> Iterator[History]:
    """Six motors of two stations; the fifth is the second again, later and by its own capture."""
    with open_history(tmp_path_factory.mktemp("parts") / "line.db") as found:
        for number in range(6):
            one = record(
                number, station=f"line-{number % 2}", outcome="FAIL" if number == 3 else "PASS"
            )
            found.add(replace(one, serial="SN-00001") if number == 4 else one)
        yield found


def test_results_that_are_asked_for(history: History) -> None:
    def ids(*of: Any, **more: Any) -> list[int]:
        return [row.id for row in history.results(*of, **more)]

    assert ids() == [1, 2, 3, 4, 5, 6]
    assert ids(last=2) == [5, 6]
    assert ids(before=4) == [1, 2, 3]
    assert ids(last=2, before=4) == [2, 3]
    assert ids(Query(station="line-1")) == [2, 4, 6]
    assert ids(Query(outcome="FAIL")) == [4]
    assert ids(Query(kind="fit")) == []
    assert ids(Query(since=BEGAN + timedelta(seconds=6), until=BEGAN + timedelta(seconds=12))) == [
        3, 4,
    ]  # fmt: skip
    assert history.count() == 6
    assert history.count(Query(serial="SN-0000[1]")) == 0
    assert history.count(Query(serial="*1")) == 2
    second = history.result(2)
    assert second is not None
    assert [row.id for row in history.same_motor(second)] == [2, 5]
    assert history.result(7) is None


def test_captures_and_what_rests_on_them(history: History) -> None:
    every = history.captures()
    assert len(every) == 6
    assert [row.serial for row in history.captures("SN-0000?")] == [row.serial for row in every]
    (third,) = history.captures("SN-00003")
    assert history.captures(sha256=third.sha256[:12]) == [third]
    assert history.captures(sha256="%") == []
    assert history.captures("SN-00002", third.sha256[:12]) == []
    assert [row.id for row in history.results_of(third.sha256)] == [4]
    assert [row.sha256 for row in history.captures_of(4)] == [third.sha256]
    assert "line-1" in history.document(third.rig)
    assert history.document(None) == history.document("0" * 64) == ""
    assert results_citing(history, [row.sha256 for row in every[:2]] * 400) == 2
    assert results_citing(history, []) == 0


def test_readings_of_a_quantity(history: History) -> None:
    rows = history.readings(Query(), 2)
    assert [(row.result, row.name) for row in rows] == [(5, "K"), (5, "R"), (6, "K"), (6, "R")]
    only = history.readings(Query(station="line-0"), 2, "R")
    assert [(row.result, row.value) for row in only] == [(3, 2.602), (5, 2.604)]
    assert history.readings(Query(), 9, "L") == []
    series = history.series("R", Query(outcome="PASS"), last=2)
    assert [row.value for row in series] == [2.604, 2.605]
    times, values = history.arrays("R", Query(), 3)
    assert values.tolist() == [2.603, 2.604, 2.605]
    assert times[1] - times[0] == 3_000_000
    empty = history.arrays("L", Query())
    assert (len(empty[0]), len(empty[1])) == (0, 0)


def test_what_is_damaged_is_said(history: History, tmp_path: Path) -> None:
    """A copy of the whole one, then with another text, then no database at all."""
    copy = tmp_path / "copy #1?.db"
    with closing(sqlite3.connect(history.where)) as own, closing(sqlite3.connect(copy)) as other:
        own.backup(other)
    assert damage(copy) == ""
    with closing(sqlite3.connect(copy)) as other, other:
        (digest,) = other.execute("SELECT sha256 FROM documents LIMIT 1").fetchone()
        other.execute("UPDATE documents SET text = text || ' ' WHERE sha256 = ?", (digest,))
    assert damage(copy) == f"the text {digest[:12]} is not what its digest says"
    whole = copy.read_bytes()
    copy.write_bytes(whole[:4096] + bytes(4096) + whole[8192:])
    assert damage(copy) not in ("", f"the text {digest[:12]} is not what its digest says")
    copy.write_bytes(b"nothing" * 1000)
    assert damage(copy).startswith("it is no whole history (")


@pytest.mark.parametrize(
    ("url", "seconds", "bounds"),
    [
        ("sqlite:///x.db", 5.0, None), ("postgresql+psycopg://h/d?options=x", 5.0, None),
        ("postgresql+psycopg://h/d", 4.6, (5, 4600)), ("postgresql+psycopg://h/d", 0.5, (2, 500)),
    ],
)  # fmt: skip
def test_patience_bounds_a_server(url: str, seconds: float, bounds: tuple[int, int] | None) -> None:
    expected: dict[str, Any] = {}
    if bounds:
        expected = {
            "connect_timeout": bounds[0], "tcp_user_timeout": bounds[1],
            "options": f"-c statement_timeout={bounds[1]} -c lock_timeout={bounds[1]}",
        }  # fmt: skip
    assert engine._bounds(make_url(url), seconds) == expected


def test_a_database_is_shown_without_its_password() -> None:
    assert engine.shown(make_url("postgresql+psycopg://me:secret@host/line")) == "line"
    assert engine.shown(make_url("postgresql+psycopg://me:secret@host")) == "postgresql+psycopg"


def test_a_file_is_spoken_to_with_care(tmp_path: Path) -> None:
    with open_history(tmp_path / "line.db", patience_s=2.5) as history, history.reading() as found:
        for name, value in (
            ("busy_timeout", 2500), ("foreign_keys", 1), ("synchronous", 2), ("secure_delete", 1),
            ("journal_mode", "wal"),
        ):  # fmt: skip
            assert found.exec_driver_sql(f"PRAGMA {name}").scalar() == value
    with pytest.raises(DataError, match="there is no history"):
        open_history(tmp_path / "none.db", create=False)
