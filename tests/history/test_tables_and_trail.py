"""Tables that the steps make, the trail as a person reads it, what other limits may change."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from sqlalchemy import UniqueConstraint, inspect, update
from sqlalchemy.dialects import sqlite

from motorid.errors import DataError
from motorid.quality.guard_band import Rule
from motorid.quality.history import History, MeasurementRecord, Query, open_history, trail
from motorid.quality.history import schema as s
from motorid.quality.history.candidates import candidates
from motorid.quality.history.engine import said
from motorid.quality.history.forgetting import RULE
from motorid.quality.history.steps import refuse_newer
from motorid.quality.limits import Limit
from motorid.quality.signed import Trusted
from tests.history.records import BEGAN, record

NOW = datetime(2026, 11, 20, tzinfo=UTC)


@pytest.fixture(scope="module")
def history(tmp_path_factory: pytest.TempPathFactory) -> Iterator[History]:
    with open_history(tmp_path_factory.mktemp("tables") / "line.db") as found:
        yield found


def test_the_tables_are_those_that_the_code_means(history: History) -> None:
    """Names, columns, which may be empty, keys in their order, what they cite, and indexes."""
    with history.reading() as connection:
        found = inspect(connection)
        assert set(s.results.metadata.tables) <= set(found.get_table_names())
        for name, table in s.results.metadata.tables.items():
            kinds = {c.name: c.type.compile(dialect=sqlite.dialect()) for c in table.columns}
            columns = {c["name"]: (c["nullable"], str(c["type"])) for c in found.get_columns(name)}
            assert columns == {c.name: (c.nullable, kinds[c.name]) for c in table.columns}, name
            assert list(columns) == [c.name for c in table.columns], name
            key = found.get_pk_constraint(name)["constrained_columns"]
            assert key == [c.name for c in table.primary_key], name
            cited = {
                (*one["constrained_columns"], one["referred_table"], *one["referred_columns"])
                for one in found.get_foreign_keys(name)
            }
            assert cited == {
                (fk.parent.name, fk.column.table.name, fk.column.name) for fk in table.foreign_keys
            }, name
            indexes = {one["name"]: one["column_names"] for one in found.get_indexes(name)}
            assert indexes == {i.name: [c.name for c in i.columns] for i in table.indexes}, name
            unique = {tuple(one["column_names"]) for one in found.get_unique_constraints(name)}
            assert unique == {
                tuple(c.name for c in one.columns)
                for one in table.constraints
                if isinstance(one, UniqueConstraint)
            }, name


def test_an_instant_goes_down_in_utc_and_comes_up_aware() -> None:
    kind = s.UtcDateTime()
    east = datetime.fromisoformat("2026-01-05T08:00:00+02:00")
    assert kind.process_bind_param(east, None) == datetime(2026, 1, 5, 6)
    assert kind.process_result_value(datetime(2026, 1, 5, 6), None) == east
    assert kind.process_bind_param(None, None) is kind.process_result_value(None, None) is None
    with pytest.raises(ValueError, match="time zone"):
        kind.process_bind_param(datetime(2026, 1, 5), None)


@pytest.mark.parametrize(
    ("kind", "good", "bad"),
    [
        (s.Words(9), ("", "x"), (3, b"x")), (s.LongWords(), ("x",), (3.0,)),
        (s.Number(), (1.5, 2, -0.0), ("1", float("nan"), float("inf"))),
        (s.Count(), (0, -3), (1.5, "1")), (s.LongCount(), (10**12,), (1.0,)),
    ],
)  # fmt: skip
def test_what_comes_up_is_what_it_should_be(
    kind: s.Words | s.Number, good: tuple[object, ...], bad: tuple[object, ...]
) -> None:
    assert kind.process_result_value(None, None) is None
    for value in good:
        assert kind.process_result_value(value, None) == value
    for value in bad:
        with pytest.raises(ValueError, match="it is damaged"):
            kind.process_result_value(value, None)


def test_newer_tables_are_refused_and_complaints_are_sentences() -> None:
    refuse_newer(s.STEP, "here")
    refuse_newer("0001", "here")
    with pytest.raises(DataError, match="here has tables of step 0999, this motorid knows"):
        refuse_newer("0999", "here")
    for error in (ValueError("x"), KeyError("x"), OverflowError("x"), AttributeError("x")):
        with pytest.raises(DataError, match="the history here cannot be used: "), said("here"):
            raise error
    with pytest.raises(RuntimeError), said("here"):
        raise RuntimeError


def test_the_trail_as_a_person_reads_it(tmp_path: Path) -> None:
    with open_history(tmp_path / "line.db") as history:
        for number, (station, serial, who) in enumerate(
            (("left", "M1", "kim"), ("right", "M1", ""), ("left", "M2", "lee"))
        ):
            entry = trail.Entry(
                trail.ORDER, "refused", who, f"key {number}", serial, "why", station,
                NOW + timedelta(seconds=number),
            )  # fmt: skip
            assert history.note(entry)
            assert not history.note(replace(entry, reason="other"))  # its key is there
        every = history.trail()
        assert [(one["subject"], one["who"]) for one in every] == [
            ("M1", "kim"), ("M1", ""), ("M2", "lee"),
        ]  # fmt: skip
        assert (every[0]["action"], every[0]["outcome"], every[0]["reason"], every[0]["at"]) == (
            "order", "refused", "why", NOW,
        )  # fmt: skip
        assert [one["position"] for one in every] == [1, 1, 2]
        assert [one["who"] for one in history.trail(last=2)] == ["", "lee"]
        assert [one["who"] for one in history.trail(station="left")] == ["kim", "lee"]
        assert [one["who"] for one in history.trail(serial="M1")] == ["kim", ""]
        assert len(history.trail(serial="M?", station="left")) == 2
        assert history.verify().problems == ()


def test_names_are_forgotten_by_their_age(tmp_path: Path) -> None:
    with open_history(tmp_path / "line.db") as history:
        for days, who in ((40, "kim"), (30, "lee"), (10, "pat")):
            one = replace(record(days, operator=who), at=NOW - timedelta(days=days))
            history.add(one)
        done = history.forget_names("boss", 30, NOW)
        assert (done.names, done.days) == (1, 30)
        shown = [history.name_of(row.operator) for row in history.results()]
        assert shown == ["(forgotten)", "lee", "pat"]
        actions = [(one["action"], one["subject"], one["reason"]) for one in history.trail()]
        before = (NOW - timedelta(days=30)).isoformat()
        assert sorted(actions) == [
            ("forget names", before, "1 names"), ("keep names", "30 days", ""),
        ]  # fmt: skip
        again = history.forget_names("boss", now=NOW)
        assert (again.names, again.days, len(history.trail())) == (0, 30, 2)
        ever = history.forget_names("boss", 0, NOW + timedelta(days=900))
        assert (ever.names, ever.days) == (0, 0)
        assert history.trail()[-1]["subject"] == "for ever"
        assert history.sealed_names() == 0
        assert history.verify().problems == ()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rule", "days"), [("36500", 36_500), ("36501", None), ("-1", None), ("3.5", None), ("", None)]
)
def test_a_rule_of_a_century_is_the_longest(tmp_path: Path, rule: str, days: int | None) -> None:
    with open_history(tmp_path / "line.db") as history:
        with history.engine.begin() as connection:
            connection.execute(update(s.meta).where(s.meta.c.name == RULE).values(value=rule))
        if days is None:
            with pytest.raises(DataError, match="is no number of days"):
                history.forget_names("boss", now=NOW)
        else:
            assert history.forget_names("boss", now=NOW).days == days


def test_limits_that_nobody_signed_are_named(tmp_path: Path) -> None:
    with open_history(tmp_path / "line.db") as history:
        history.add(record(1))
        history.add(replace(record(2), limits=""))
        history.add(replace(record(3), station="", versions={"product_signature": "{"}))
        found = list(history.unsigned(Trusted({})))
    assert [re.sub("limits [0-9a-f]{12}", "limits", one) for one in found] == [
        "station line-1, result 1, limits: nobody signed them",
        "station without a name, result 3, limits: their signature is damaged",
    ]


# what is stored of R: value, uncertainty, outcome; whether limits 2 to 3, by 2 u, may change it
STORED = {
    "inside": ((2.5, 0.1, "PASS"), False), "on the band": ((2.2000001, 0.1, "PASS"), False),
    "near low": ((2.19, 0.1, "PASS"), True), "near high": ((2.81, 0.1, "PASS"), True),
    "just inside": ((2.79, 0.1, "PASS"), False), "failed": ((2.5, 0.1, "FAIL"), True),
    "below": ((1.5, 0.1, "PASS"), True), "no value": ((None, 0.1, "PASS"), True),
    "no u": ((2.5, None, "PASS"), True), "negative u": ((2.5, -0.1, "PASS"), True),
}  # fmt: skip


@pytest.mark.slow
def test_results_that_other_limits_may_change(tmp_path: Path) -> None:
    """What surely passes stays in the database; so does a good result without a limit now."""
    limits = {"R": Limit("R", "ohm", 2.0, 3.0, Rule())}
    with open_history(tmp_path / "line.db") as history:
        for number, (serial, (stored, _)) in enumerate(STORED.items()):
            value, u, outcome = stored
            rows = (
                MeasurementRecord("R", "ohm", value, u, 1.0, 9.0, 0.0, outcome, reason="why"),
                MeasurementRecord("K", "1", 99.0, 1.0, 0.0, 1.0, 0.0, "PASS"),
            )
            history.add(replace(record(number), serial=serial, measurements=rows))
        bare = (MeasurementRecord("K", "1", 0.5, 0.0, 0.0, 1.0, 0.0, "PASS"),)
        history.add(replace(record(90), serial="not measured", measurements=bare))
        found = list(candidates(history, Query(), limits, (0, 99)))
        changed = [serial for serial, (_, changes) in STORED.items() if changes]
        assert [row.serial for row, _ in found] == [*changed, "not measured"]
        row, (constant, resistance) = found[0]
        assert (row.station, row.outcome, row.at) == (
            "line-1",
            "PASS",
            BEGAN + timedelta(seconds=6),
        )
        assert (constant.name, constant.value, constant.unit) == ("K", 99.0, "1")
        assert (resistance.value, resistance.uncertainty) == (2.19, 0.1)
        assert (resistance.outcome, resistance.reason) == ("PASS", "why")
        some = [row.id for row, _ in candidates(history, Query(), limits, (3, 7))]
        assert some == [4, 6, 7]
        assert not list(candidates(history, Query(product="fan"), limits, (0, 99)))
        one_sided = {"R": Limit("R", "ohm", high=3.0, rule=Rule())}
        serials = [row.serial for row, _ in candidates(history, Query(), one_sided, (0, 99))]
        assert "below" not in serials
        assert "near high" in serials
