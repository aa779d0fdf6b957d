"""The day's counts are those of the results, in any order of adding, for any stretch of time."""

from __future__ import annotations

import random
import sqlite3
from collections import Counter
from contextlib import closing
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from motorid.cli.main import run
from motorid.quality.history import MeasurementRecord, Query, ResultRecord, open_history, tallies
from motorid.quality.history.tallies import Key
from tests.history.records import record

BEGAN = datetime(2026, 11, 20, 21, 0, tzinfo=UTC)
BAD = {
    "FAIL": MeasurementRecord("R", "ohm", 3.0, 0.01, 2.4, 2.8, 0.02, "FAIL", reason="too high"),
    "INVALID": MeasurementRecord("run_complete", "1", 0.0, 0.0, 1.0, None, 0.0, "INVALID"),
    "PASS": MeasurementRecord("R", "ohm", 2.6, 0.01, 2.4, 2.8, 0.02, "PASS"),
}


def shift(seed: int, count: int = 60) -> list[ResultRecord]:
    """Motors of two stations and products over two days, some of them again, some of no number."""
    rng = random.Random(seed)
    found = []
    for number in range(count):
        outcome = rng.choice(["PASS", "PASS", "FAIL", "INVALID"])
        found.append(
            replace(
                record(number, station=f"line-{rng.randrange(2)}", outcome=outcome),
                serial=rng.choice(["", f"SN-{rng.randrange(12)}", f"SN-{number}"]),
                product=rng.choice(["pump", "fan"]),
                at=BEGAN + timedelta(minutes=rng.randrange(600)),
                measurements=(BAD[outcome],),
                kind=rng.choice(["check", "check", "check", "rejudged"]),
            )
        )
    return found


def by_hand(records: list[ResultRecord], since: datetime, until: datetime) -> Counter[Key]:
    """As the words of the module say it, without SQL; of equal times the one added later."""
    checks = [one for one in records if one.kind == "check"]
    motors: dict[tuple[object, ...], list[ResultRecord]] = {}
    for k, one in enumerate(checks):
        motors.setdefault((one.product, one.serial or k), []).append(one)
    found: Counter[Key] = Counter()
    for tests in motors.values():
        tests.sort(key=lambda one: one.at)
        for what, some in (("test", tests), ("first", tests[:1]), ("last", tests[-1:])):
            for one in some:
                if since <= one.at < until:
                    day = f"{one.at:%Y-%m-%d}"
                    found[Key(day, one.product, one.station, what, one.outcome)] += 1
                    if what == "test" and one.outcome != "PASS":
                        bad, side = BAD[one.outcome], "high" if one.outcome == "FAIL" else ""
                        key = Key(
                            day, one.product, one.station, "reason", one.outcome, bad.name, side
                        )
                        found[key] += 1
    return found


@pytest.mark.slow
@pytest.mark.parametrize(
    "seed", [0, pytest.param(1, marks=pytest.mark.study), pytest.param(2, marks=pytest.mark.study)]
)
def test_counts_are_those_by_hand_in_any_order_and_for_any_time(tmp_path: Path, seed: int) -> None:
    records = shift(seed)
    always = datetime(2000, 1, 1, tzinfo=UTC), datetime(2100, 1, 1, tzinfo=UTC)
    with open_history(tmp_path / "line.db") as history:
        for one in records:
            history.add(one)
            history.add(one)  # who retries counts nothing twice
        rows = {row.key: row for row in history.results()}
        kept = [one for one in records if one.key in rows]
        with history.reading() as connection:
            assert tallies.counts(connection, Query(), Key._fields) == by_hand(kept, *always)
            for hours in ((0, 2), (1, 4), (3, 27), (-30, 40)):
                since, until = (BEGAN + timedelta(hours=one) for one in hours)
                query = Query(since=since, until=until)
                found = tallies.counts(connection, query, Key._fields)
                assert +found == by_hand(kept, since, until), hours
            of_one = tallies.counts(connection, Query(serial="SN-1*", product="fan"), ("what",))
            sums = Counter(
                key.what
                for key in by_hand(
                    [r for r in kept if r.serial.startswith("SN-1") and r.product == "fan"], *always
                ).elements()
            )
            assert of_one == Counter({(what,): count for what, count in sums.items()})


@pytest.mark.slow
def test_counts_that_are_wrong_are_found_and_made_anew(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    place = tmp_path / "line.db"
    with open_history(place) as history:
        for one in shift(7, 20):
            history.add(one)
        assert history.verify().problems == ()
    with closing(sqlite3.connect(place)) as connection, connection:
        connection.execute("UPDATE tallies SET count = count + 1 WHERE what = 'first'")
    assert run(["history", "verify", str(place)]) == 4
    assert "the counts of 2026-11-2" in capsys.readouterr().out
    assert run(["history", "recount", str(place)]) == 0
    assert run(["history", "verify", str(place)]) == 0


@pytest.mark.slow
def test_a_history_without_counts_is_counted_from_its_results(tmp_path: Path) -> None:
    place, records = tmp_path / "line.db", shift(5, 20)
    with open_history(place) as history:
        for one in records:
            history.add(one)
        with history.reading() as connection:
            kept = tallies.counts(connection, Query(), Key._fields)
            places = tallies.places(connection)
    with closing(sqlite3.connect(place)) as connection, connection:
        connection.execute("DROP TABLE tallies")
        connection.execute("DROP INDEX ix_results_station_at")
        connection.execute("UPDATE alembic_version SET version_num = '0003'")
    with open_history(place, create=False) as history, history.reading() as reading:
        assert tallies.counts(reading, Query(), Key._fields) == kept
        assert tallies.places(reading) == places
    with open_history(place) as history, history.reading() as reading:  # and the step makes them
        assert tallies.kept(reading)
        assert tallies.counts(reading, Query(), Key._fields) == kept
        assert list(tallies.problems(reading)) == []
