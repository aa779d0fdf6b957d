"""What is odd or wrong in the columns of a foreign table, by columns of a few numbers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorid.capture import table_checks as checks
from motorid.capture.columns import BadCell, Columns
from motorid.capture.mapping import Formula, parse_maps
from motorid.capture.model import Channel, Gap
from motorid.errors import DataError

LOG = Path("log.csv")
NAN = float("nan")


class Rows:
    """A source whose places are plain."""

    def place(self, row: int) -> str:
        return f"row {row}"


SOURCE: Any = Rows()


def columns(bad: tuple[BadCell, ...] = (), **values: list[float]) -> Columns:
    made = {name: np.array(column) for name, column in values.items()}
    return Columns(max(map(len, made.values())), made, bad)


def channel(name: str, values: Any, **facts: Any) -> Channel:
    return Channel(name, "", np.asarray(values, dtype=float), **facts)


def cleaned(given: Columns, drop_bad: bool = True) -> tuple[Columns, list[str]]:
    notes: list[str] = []
    return checks.good_cells(LOG, SOURCE, given, drop_bad, notes), notes


# -- cells that hold no number
@pytest.mark.parametrize("mark", [-999.0, -9999.0, -99999.0, 9999.0, 99999.0, 999999.0])
@pytest.mark.parametrize(("share", "far"), [(1 / 19.9, False), (1 / 20.1, True)])
def test_a_usual_mark_is_one_only_far_beyond_the_rest(mark: float, share: float, far: bool) -> None:
    rest = -abs(mark) * share
    found, notes = cleaned(columns(v=[rest, mark, 0.0, NAN]))
    assert found.values["v"].tolist()[:3] == pytest.approx(
        [rest, NAN if far else mark, 0.0], nan_ok=True
    )
    shown = f"{mark:g}"
    more = f"v holds {shown}, which looks like a mark for missing"
    lost = "2 rows are"  # with the cell that was empty before
    assert notes == (
        [f"{lost} bad, and their bad readings left out; the first: row 1, {more}"] * far
    )


@pytest.mark.parametrize("values", [[65535.0, 1.0], [-32768.0, 0.0], [-999.0], [-999.0, -999.0]])
def test_readings_that_are_no_marks(values: list[float]) -> None:
    found, notes = cleaned(columns(v=values))
    assert found.values["v"].tolist() == values
    assert not notes


def test_bad_cells_are_refused_by_the_first_of_them_and_counted_by_rows() -> None:
    bad = (BadCell(3, "i", "1,5"), BadCell(2, "w", ""))
    given = columns(
        bad, v=[1.0, 2.0, 3.0, 4.0, 5.0], i=[1.0, 1.0, 1.0, NAN, 9999.0],
        w=[0.0, 0.0, NAN, NAN, 0.0], one=[NAN],
    )  # fmt: skip
    with pytest.raises(DataError) as error:
        cleaned(given, drop_bad=False)
    assert str(error.value) == (
        "log.csv: row 2, column 'w' is empty; 3 rows are bad in all: repair the file, or leave "
        "such rows out with --drop-bad"
    )
    found, notes = cleaned(given)
    assert np.isnan(found.values["i"]).tolist() == [False, False, False, True, True]
    assert notes == [
        "3 rows are bad, and their bad readings left out; the first: row 2, w is empty"
    ]


def test_one_bad_cell_is_one_row() -> None:
    with pytest.raises(DataError, match=r"row 1, column 'i' holds 'x', not a number; 1 row is bad"):
        cleaned(columns((BadCell(1, "i", "x"),), i=[1.0, NAN]), drop_bad=False)
    with pytest.raises(DataError, match="1 row is bad"):  # of a number alone, which has no rows
        cleaned(columns((BadCell(0, "k", "x"),), i=[1.0, 2.0], k=[NAN]), drop_bad=False)


def test_columns_of_two_rows_have_two() -> None:
    bad = BadCell(0, "i", "x"), BadCell(1, "w", "y")
    with pytest.raises(DataError, match="2 rows are bad in all"):
        cleaned(columns(bad, i=[NAN, 1.0], w=[1.0, NAN]), drop_bad=False)


def test_marks_that_a_person_tells_are_left_out_of_the_columns_that_have_them() -> None:
    notes: list[str] = []
    given = columns(v=[1.0, -1.0, 0.5, -1.0], i=[2.0, 3.0, 0.5, 4.0], w=[9.0, 8.0, 7.0, 6.0])
    found = checks.without_told(given, (-1.0, 0.5), notes).values
    assert np.isnan(found["v"]).tolist() == [False, True, True, True]
    assert np.isnan(found["i"]).tolist() == [False, False, True, False]
    assert found["w"] is given.values["w"]
    assert notes == [
        "3 readings of v left out, as told (-1, 0.5)",
        "1 readings of i left out, as told (-1, 0.5)",
    ]
    assert given.values["v"].tolist() == [1.0, -1.0, 0.5, -1.0]


def test_a_quantity_without_a_reading_is_refused_by_name() -> None:
    checks.some_readings(LOG, {"current": np.array([NAN, 1.0, np.inf])})
    with pytest.raises(DataError, match=r"log\.csv: no usable row holds a number for speed"):
        checks.some_readings(LOG, {"current": np.ones(2), "speed": np.array([NAN, np.inf])})


@pytest.mark.parametrize(
    ("mapped", "said", "noted"),
    [
        ("current=i:A", "mA", True),
        ("current=i:A", "A", False),
        ("current=i:mA", "mA", False),
        ("current=i:A", "furlong", True),
        ("current=-i:A", "mA", False),  # no bare column
        ("position=i:counts", "deg", False),  # a register's counts are no unit of a header
    ],
)
def test_a_header_that_names_another_unit_is_noted(mapped: str, said: str, noted: bool) -> None:
    maps = parse_maps([mapped], 100.0)
    formulas = {name: Formula(one.expression, ["i"], {}) for name, one in maps.items()}
    notes = checks.header_notes(maps, formulas, {"i": said})
    expected = f"the file's header gives i in {said}, the map in A: the map was followed"
    assert notes == [expected] * noted


# -- stamps
@pytest.mark.parametrize(
    ("repeats", "count", "asks"),
    [
        (1, 40, "is time in the right unit"),
        (2, 40, "is time in the right unit"),  # 5 % of the rows
        (3, 40, "write stamps with more digits"),
    ],
)
def test_stamps_that_repeat(repeats: int, count: int, asks: str) -> None:
    ticks = np.arange(count)
    ticks[10 : 10 + 2 * repeats : 2] -= 1
    with pytest.raises(DataError, match=rf"row 20 repeats .* \({repeats} such in all\): {asks}"):
        checks.stamps_that_advance(LOG, SOURCE, ticks, 2.0 * np.arange(count), False, [])


def test_a_stamp_after_one_that_stepped_back_advances_only_beyond_the_highest() -> None:
    ticks, rows = np.array([0, 5, 4, 5, 6, 6, 7]), np.arange(7.0)
    with pytest.raises(DataError, match=r"row 2 steps back in time \(3 such in all\): is time in"):
        checks.stamps_that_advance(LOG, SOURCE, ticks, rows, False, [])
    notes: list[str] = []
    kept = checks.stamps_that_advance(LOG, SOURCE, ticks, rows, True, notes)
    assert kept.tolist() == [True, True, False, False, True, False, True]
    assert notes == ["3 rows left out whose stamps do not advance; the first: row 2"]


def test_stamps_that_all_advance_are_kept_without_a_word() -> None:
    notes: list[str] = []
    kept = checks.stamps_that_advance(
        LOG, SOURCE, np.array([3, 4, 9]), np.arange(3.0), False, notes
    )
    assert kept.tolist() == [True] * 3
    assert not notes


@pytest.mark.parametrize(("pause", "lost"), [(2499, None), (2501, 2), (3400, 2), (3600, 3)])
def test_a_pause_beyond_two_periods_and_a_half_is_a_gap(pause: int, lost: int | None) -> None:
    steps = np.full(60, 1000)
    steps[[20, 40]] = pause
    notes: list[str] = []
    found = checks.gaps(np.r_[0, np.cumsum(steps)], notes)
    if lost is None:
        assert (found, notes) == ((), [])
    else:
        why = "the time column pauses"
        assert found == (Gap(21, lost, why), Gap(41, lost, why))
        assert notes == ["2 pauses of more than 2.5 periods, recorded as gaps"]


@pytest.mark.parametrize(("off", "said"), [(-19, None), (21, "2 %"), (-21, "2 %"), (104, "10 %")])
def test_stamps_whose_periods_differ_are_said_to(off: int, said: str | None) -> None:
    steps = np.full(40, 1000)
    steps[::10] += off
    steps[5] = 50_000  # a pause is no period
    notes: list[str] = []
    checks.gaps(np.r_[0, np.cumsum(steps)], notes)
    expected = f"irregular stamps: 5 % of periods are off by {said} or more; kept"
    assert notes[:-1] == ([expected] if said else [])


def test_one_late_stamp_in_fifty_makes_no_irregular_record() -> None:
    steps = np.full(50, 1000)
    steps[7] = 2000
    notes: list[str] = []
    assert checks.gaps(np.r_[0, np.cumsum(steps)], notes) == ()
    assert not notes


@pytest.mark.parametrize(("period_s", "slow"), [(1.0, False), (1.1, True)])
def test_a_period_of_more_than_a_second_shows_no_start(period_s: float, slow: bool) -> None:
    notes: list[str] = []
    checks.gaps(np.arange(9) * int(period_s * 1e9), notes)
    said = f"the usual period is {period_s:g} s, too slow to show a motor start: "
    assert notes == [said + "is the time column's unit right?"] * slow


# -- repeated readings
def stairs(runs: list[int]) -> list[float]:
    """Readings that stay for so many samples each."""
    return [float(level) for level, run in enumerate(runs) for _ in range(run)]


@pytest.mark.parametrize(
    ("runs", "held"),
    [
        ([1, *[3] * 19, 1], 3),  # 20 changes
        ([1, *[3] * 18, 1], None),
        ([5, *[1] * 30], None),
        ([1, *[4, 8] * 15, 1], 4),
        ([1, *[3] * 37, *[4] * 3, 1], 3),
        ([1, *[3] * 36, *[4] * 4, 1], None),  # nine in ten
    ],
)
def test_readings_that_are_repeated(runs: list[int], held: int | None) -> None:
    values = stairs(runs)
    given = {"current": channel("current", values), "speed": channel("speed", [1.0] * len(values))}
    assert checks.held_samples(given) == ({} if held is None else {"current": held})


def test_missing_readings_are_no_changes() -> None:
    values = np.array(stairs([2] * 30))
    given = np.insert(values, [7, 20, 33], NAN)
    assert checks.held_samples({"speed": channel("speed", given)}) == {"speed": 2}
