"""A line's figures of a few results that are counted by hand."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from motorid.errors import UsageError
from motorid.quality.agreement import Share
from motorid.quality.history import History, MeasurementRecord, Query, open_history, tallies
from motorid.quality.history.candidates import bounds
from motorid.quality.history.export import export
from motorid.quality.history.query import matches
from motorid.quality.history.tallies import FIRST, LAST, REASON, TEST, counts
from motorid.quality.line import Reason, line
from tests.history.records import record

DAY = datetime(2026, 11, 20, tzinfo=UTC)
PASS, FAIL, INVALID = "PASS", "FAIL", "INVALID"
# hour after the first midnight, serial, product, station, outcome, R, kind
CHECKS = (
    (6, "M1", "pump", "left", FAIL, 3.0, "check"),
    (7, "M1", "pump", "left", PASS, 2.6, "check"),
    (8, "M2", "pump", "right", PASS, 2.5, "check"),
    (20, "M3", "pump", "left", INVALID, 2.45, "check"),
    (30, "M3", "pump", "right", FAIL, 2.3, "check"),
    (31, "", "pump", "left", PASS, 2.55, "check"),
    (32, "", "pump", "left", FAIL, 2.41, "check"),
    (50, "M1", "fan", "left", PASS, 2.65, "check"),
    (51, "M2", "pump", "left", FAIL, 2.9, "rejudged"),
    (52, "M4", "pump", "right", INVALID, 2.7, "check"),
)


@pytest.fixture(scope="module")
def history(tmp_path_factory: pytest.TempPathFactory) -> Iterator[History]:
    with open_history(tmp_path_factory.mktemp("line") / "line.db") as found:
        for number, (hour, serial, product, station, outcome, ohm, kind) in enumerate(CHECKS):
            made = (
                MeasurementRecord("R", "ohm", ohm, 0.01, 2.4, 2.8, 0.02, outcome),
                MeasurementRecord("run_complete", "1", 1.0, 0.0, 1.0, None, 0.0, PASS),
                MeasurementRecord("T0", "N·m", 1e-4 * number, 1e-6, None, None, 0.0, PASS),
            )
            found.add(
                replace(
                    record(number, station=station, outcome=outcome), serial=serial, kind=kind,
                    product=product, at=DAY + timedelta(hours=hour), measurements=made,
                )
            )  # fmt: skip
        yield found


def counted(history: History, query: Query, *by: str) -> dict[tuple[str, ...], int]:
    with history.reading() as connection:
        return {key: n for key, n in counts(connection, query, by).items() if n}


@pytest.mark.slow
def test_every_check_counts_and_a_motor_once(history: History) -> None:
    """M1 of the fan is another motor than that of the pump; what was judged again is no check."""
    assert counted(history, Query(), "what", "outcome") == {
        (TEST, PASS): 4, (TEST, FAIL): 3, (TEST, INVALID): 2,
        (FIRST, PASS): 3, (FIRST, FAIL): 2, (FIRST, INVALID): 2,
        (LAST, PASS): 4, (LAST, FAIL): 2, (LAST, INVALID): 1,
        (REASON, FAIL): 3, (REASON, INVALID): 2,
    }  # fmt: skip


@pytest.mark.slow
def test_a_reason_has_the_side_of_its_limits(history: History) -> None:
    """2.41 is within, and nearer to the lower limit."""
    found = counted(history, Query(), "what", "name", "side")
    reasons = {key[1:]: n for key, n in found.items() if key[0] == REASON}
    assert reasons == {("R", "high"): 1, ("R", "low"): 2, ("R", ""): 2}


@pytest.mark.parametrize(
    ("since", "until", "passed", "failed", "invalid"),
    [
        (None, None, 4, 3, 2), (0, 24, 2, 1, 1), (7, None, 4, 2, 2), (7, 31, 2, 1, 1),
        (8, 20, 1, 0, 0), (8, 20.5, 1, 0, 1), (None, 7, 0, 1, 0), (None, 7.5, 1, 1, 0),
        (24, 48, 1, 2, 0), (31, 53, 2, 1, 1), (20, 20, 0, 0, 0), (None, 24, 2, 1, 1),
        (24, None, 2, 2, 1), (31.5, 32.5, 0, 1, 0), (6.5, 50.5, 4, 2, 1),
    ],
)  # fmt: skip
def test_counts_of_any_stretch(
    history: History, since: float | None, until: float | None, passed: int, failed: int,
    invalid: int,
) -> None:  # fmt: skip
    """Whole days by the counts that are kept, the rest by the results themselves."""
    ends = [None if hour is None else DAY + timedelta(hours=hour) for hour in (since, until)]
    found = counted(history, Query(since=ends[0], until=ends[1]), "what", "outcome")
    tests = [found.get((TEST, outcome), 0) for outcome in (PASS, FAIL, INVALID)]
    assert tests == [passed, failed, invalid]


def test_counts_of_a_place_and_of_a_motor(history: History) -> None:
    tests = {(TEST, outcome): n for outcome, n in ((PASS, 3), (FAIL, 2), (INVALID, 1))}
    left = counted(history, Query(station="left"), "what", "outcome")
    assert {key: n for key, n in left.items() if key[0] == TEST} == tests
    some = Query(station="left", since=DAY + timedelta(hours=7))
    assert counted(history, some, "what", "outcome")[TEST, FAIL] == 1
    assert counted(history, Query(product="fan"), "what", "outcome") == {
        (TEST, PASS): 1, (FIRST, PASS): 1, (LAST, PASS): 1,
    }  # fmt: skip
    for pattern, count in (("M1", 3), ("M?", 7), ("M*", 7), ("*1", 3), ("m%", 0), ("_1", 0)):
        one = counted(history, Query(serial=pattern), "what")
        assert one.get((TEST,), 0) == count, pattern
    with history.reading() as connection:
        assert tallies.places(connection) == (["fan", "pump"], ["left", "right"])
        assert list(tallies.problems(connection)) == []


def test_the_figures_of_a_line(history: History) -> None:
    found = line(history, Query())
    assert found.yields.tests == {PASS: 4, FAIL: 3, INVALID: 2}
    assert (found.yields.count, found.yields.first, found.yields.last) == (
        9, Share(3, 5), Share(4, 6),
    )  # fmt: skip
    assert list(found.days) == ["2026-11-20", "2026-11-21", "2026-11-22"]
    assert [one.count for one in found.days.values()] == [4, 3, 2]
    assert found.reasons == (
        Reason("R", "", INVALID, 2, 0.4, 0.4), Reason("R", "low", FAIL, 2, 0.4, 0.8),
        Reason("R", "high", FAIL, 1, 0.2, 1.0),
    )  # fmt: skip
    assert [(one.name, one.yields.count) for one in found.stations] == [("left", 6), ("right", 3)]
    resistance, friction = found.quantities
    assert (resistance.name, resistance.unit, resistance.why) == ("R", "ohm", "it has no limits")
    assert resistance.values.tolist() == [check[5] for check in CHECKS]
    assert (resistance.low, resistance.high) == (2.4, 2.8)
    assert resistance.capability is not None
    assert resistance.capability.lower == 2.4
    assert (friction.capability, friction.why) == (None, "it has no limits")
    assert len(resistance.results) == len(set(resistance.results)) == 10
    assert (found.quantity, found.why) == ("R", "")
    assert found.trend_of is resistance
    assert found.trend is not None
    assert (found.trend.quantity, found.trend.unit, len(found.trend.charts)) == ("R", "ohm", 5)
    assert found.trend.days.tolist() == list(np.arange(10.0))
    right = found.stations[1].readings
    assert right is not None
    assert right.values.tolist() == [2.5, 2.3, 2.7]


def test_a_line_of_one_quantity_and_of_few_readings(history: History) -> None:
    friction = line(history, Query(), "T0", newest=4)
    assert friction.trend is not None
    assert friction.trend.values == pytest.approx([6e-4, 7e-4, 8e-4, 9e-4])
    assert friction.trend.capability is None
    absent = line(history, Query(), "K")
    assert (absent.trend, absent.why) == (None, "no result here has measured 'K'")
    assert [one.readings for one in absent.stations] == [None, None]
    few = line(history, Query(outcome=INVALID))
    assert few.trend is None
    assert "three readings" in few.why
    assert few.yields.count == 9  # an outcome chooses readings alone
    assert few.quantities[0].capability is None
    assert "more than 2 readings" in few.quantities[0].why
    none = line(history, Query(station="nowhere"))
    assert (none.quantity, none.quantities, none.stations) == ("", (), ())


def test_ranges_of_ids(history: History) -> None:
    """Ten results: three in each range, the last holds what is left; of a query, from its first."""
    assert bounds(history, Query(), 3) == [(0, 3), (3, 6), (6, 9), (9, 10)]
    assert bounds(history, Query(), 10) == [(0, 10)]
    assert bounds(history, Query(product="fan"), 3) == [(7, 8)]
    assert bounds(history, Query(product="none"), 3) == []


def test_an_export_says_its_format(history: History, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"ends in none of \.csv, \.parquet"):
        export(history, tmp_path / "line.txt")
    path = tmp_path / "line.CSV"
    assert export(history, path, Query(station="right")) == 9
    head, *rows = path.read_text(encoding="utf-8").splitlines()
    assert head.startswith("id,at,kind,serial,product,result_outcome,")
    assert len(rows) == 9
    with pytest.raises(UsageError, match="exists"):
        export(history, path)
    assert export(history, path, force=True) == 30


@pytest.mark.parametrize(
    ("pattern", "sql"),
    [("A1", "serial = 'A1'"), ("A*", "LIKE 'A%' ESCAPE"), ("A?", "LIKE 'A_' ESCAPE"),
     ("50%*", r"LIKE '50\%%'"), ("a_b?", r"LIKE 'a\_b_'"), ("a\\*", r"LIKE 'a\\%'")],
)  # fmt: skip
def test_wildcards_of_a_serial_number(pattern: str, sql: str) -> None:
    from sqlalchemy.dialects import sqlite

    from motorid.quality.history import schema as s

    found = matches(s.results.c.serial, pattern).compile(
        dialect=sqlite.dialect(paramstyle="named"), compile_kwargs={"literal_binds": True}
    )
    assert sql in str(found)
