"""Rows that a log of a motor getting up to speed lacks, by hand: how many places, how sure."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.diagnosis.faults import lost_rows
from motorid.program import Program, Step, StepKind

COUNT, TAU = 300, 120.0  # rows, and as many in a time constant
FOUR = {40: 1.0, 90: 2.0, 140: 1.0, 190: 1.0}  # rows that are missing before others


def log(missing: dict[int, float], without: tuple[str, ...] = (), **facts: Any) -> Capture:
    steps = np.ones(COUNT)
    for row, rows in missing.items():
        steps[row] += rows
    left = np.exp(-(np.cumsum(steps) - 1.0) / TAU)
    series = {VOLTAGE: np.full(COUNT, 9.0), CURRENT: 3.0 * left, SPEED: 400.0 * (1.0 - left)}
    rng = np.random.default_rng(2)
    channels = {n: Channel(n, "", y + 1e-3 * rng.standard_normal(COUNT)) for n, y in series.items()}
    channels = {n: c for n, c in channels.items() if n not in without}
    return Capture(1000 * np.arange(COUNT), 1e6, channels, **facts)


def found(missing: dict[int, float]) -> dict[int, float]:
    lost = lost_rows.find(log(missing))
    return {} if lost is None else dict(zip(lost.places.tolist(), lost.rows.tolist(), strict=True))


def test_rows_are_counted_at_each_place() -> None:
    assert found(FOUR) == FOUR
    (said,) = lost_rows.suspects(log(FOUR))
    assert said.evidence.startswith(
        "current and speed jump along their slopes by whole rows at 4 places, first at 0.04 s: 5 "
        "rows are missing there"
    )
    assert (said.code, said.where, set(said.moves)) == ("samples_dropped", "time", {"L", "J"})
    assert found({}) == {}


def test_three_places_are_enough() -> None:
    three = dict.fromkeys((40, 90, 140), 1.0)
    assert found(three) == three
    assert found(dict.fromkeys((40, 90), 1.0)) == {}


@pytest.mark.parametrize(("others", "known"), [((65,), True), ((65, 115), False)])
def test_places_that_miss_no_whole_rows_are_a_quarter_at_most(
    others: tuple[int, ...], known: bool
) -> None:
    """A row and a half, beside four places that miss whole ones."""
    assert found({**FOUR, **dict.fromkeys(others, 1.5)}) == (FOUR if known else {})


@pytest.mark.parametrize(("more", "known"), [(0.2, True), (-0.1, True), (0.45, False)])
def test_a_number_of_rows_may_miss_a_whole_one_by_a_third(more: float, known: bool) -> None:
    assert found({row: rows + more for row, rows in FOUR.items()}) == (FOUR if known else {})


def test_rows_too_many_are_none_that_are_missing() -> None:
    """A row that is there twice jumps back: by less than nothing."""
    assert found(dict.fromkeys(FOUR, -2.0)) == {}


def test_nothing_is_lost_where_a_program_counts_or_a_column_has_gaps() -> None:
    program = Program((Step(StepKind.COAST, 1.0),))
    assert lost_rows.find(log(FOUR, program=program)) is None
    for name in (VOLTAGE, CURRENT, SPEED):
        torn = log(FOUR)
        torn.channels[name].raw[200] = np.nan
        assert lost_rows.find(torn) is None
    assert lost_rows.find(log(FOUR, without=(VOLTAGE,))) is None
    assert lost_rows.find(log(FOUR, without=(CURRENT, SPEED))) is None
    assert lost_rows.find(log(FOUR, without=(CURRENT,))) is not None
    assert POSITION not in log(FOUR).channels
