"""A production line in figures: yields, reasons, stations, and one quantity's charts.

All counts are the history's own (see ``history.tallies``); charts and indices are those of the
newest readings that a query chooses.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorid.errors import MotoridError
from motorid.quality.agreement import Share
from motorid.quality.capability import Capability, capability
from motorid.quality.history import History, Query
from motorid.quality.history.tallies import FIRST, LAST, REASON, TEST, counts
from motorid.quality.trend import Trend, trend

PASS, FAIL, INVALID = "PASS", "FAIL", "INVALID"
NEWEST, OF_STATION = 300, 100  # readings in charts and indices; of a station beside others
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Yield:
    """``tests`` by outcome. ``first``: PASS among the motors whose first test gave PASS or FAIL;
    ``last``: PASS among those whose newest test did.
    """

    tests: Mapping[str, int]
    first: Share
    last: Share

    @property
    def count(self) -> int:
        """Tests of any outcome."""
        return sum(self.tests.values())


@dataclass(frozen=True)
class Reason:
    """A quantity that decided ``count`` verdicts; ``side`` of its limits, "" where it has none.

    ``share`` of all reasons; ``together`` with the more frequent ones.
    """

    name: str
    side: str
    outcome: str
    count: int
    share: float
    together: float


@dataclass(frozen=True)
class Readings:
    """The newest readings (n,) of one quantity, oldest first; ``capability`` None: ``why`` not."""

    name: str
    unit: str
    results: Sequence[int]
    values: Floats
    low: float | None
    high: float | None
    capability: Capability | None
    why: str


@dataclass(frozen=True)
class Station:
    """One station beside the others; ``readings`` of the quantity that is looked at."""

    name: str
    yields: Yield
    readings: Readings | None


@dataclass(frozen=True)
class Line:
    """``days``: by day, in their order. ``trend`` None: ``why`` not."""

    yields: Yield
    days: Mapping[str, Yield]
    reasons: tuple[Reason, ...]
    quantities: tuple[Readings, ...]
    stations: tuple[Station, ...]
    quantity: str
    trend: Trend | None
    trend_of: Readings | None
    why: str


def line(history: History, query: Query, quantity: str = "", newest: int = NEWEST) -> Line:
    """The figures of what ``query`` chooses; its serial and outcome choose readings alone.

    ``quantity``: the one with charts; "": the one with the least Ppk.
    """
    of_all = replace(query, serial="", outcome="")
    with history.reading() as connection:
        by_day = counts(connection, of_all, ("day", "what", "outcome"))
        by_station = counts(connection, of_all, ("station", "what", "outcome"))
        reasons = counts(connection, of_all, ("what", "name", "side", "outcome"))
    found = _readings(history.readings(query, newest))
    chosen = quantity or _least(found)
    of_it = next((one for one in found if one.name == chosen), None)
    charts, why = _trend(of_it) if of_it else (None, f"no result here has measured {chosen!r}")
    stations = _by(by_station)
    return Line(
        _yield(_summed(by_day)),
        _by(by_day),
        _pareto(reasons),
        tuple(found),
        tuple(Station(n, y, _of_station(history, query, n, chosen)) for n, y in stations.items()),
        chosen, charts, of_it, why,
    )  # fmt: skip


def _summed(by: Counter[tuple[str, ...]]) -> Counter[tuple[str, ...]]:
    sums: Counter[tuple[str, ...]] = Counter()
    for (_, *rest), count in by.items():
        sums[tuple(rest)] += count
    return sums


def _by(found: Counter[tuple[str, ...]]) -> dict[str, Yield]:
    """Yields by the first part of the keys."""
    parts: dict[str, Counter[tuple[str, ...]]] = {}
    for (one, *rest), count in sorted(found.items()):
        parts.setdefault(one, Counter())[tuple(rest)] += count
    return {one: made for one, part in parts.items() if (made := _yield(part)).count}


def _yield(found: Counter[tuple[str, ...]]) -> Yield:
    """From counts by (what, outcome)."""
    first, last = (
        Share(found[what, PASS], found[what, PASS] + found[what, FAIL]) for what in (FIRST, LAST)
    )
    return Yield({one: found[TEST, one] for one in (PASS, FAIL, INVALID)}, first, last)


def _pareto(found: Counter[tuple[str, ...]]) -> tuple[Reason, ...]:
    kept = {key[1:]: count for key, count in found.items() if key[0] == REASON and count}
    total, together, out = sum(kept.values()), 0, []
    for (name, side, outcome), count in sorted(kept.items(), key=lambda one: (-one[1], one[0])):
        together += count
        out.append(Reason(name, side, outcome, count, count / total, together / total))
    return tuple(out)


def _readings(rows: Sequence[Any]) -> list[Readings]:
    """By quantity, in the order of their names; conditions, which have no spread, are left out."""
    by_name: dict[str, list[Any]] = {}
    for row in rows:
        by_name.setdefault(row.name, []).append(row)
    found = [_of(name, of_it) for name, of_it in by_name.items()]
    return [one for one in found if not np.all(np.isin(one.values, (0.0, 1.0)))]


def _of(name: str, rows: Sequence[Any]) -> Readings:
    newest = rows[-1]
    values = np.array([row.value for row in rows], dtype=np.float64)
    able, why = None, "it has no limits"
    if newest.low is not None or newest.high is not None:
        try:
            able = capability(values, newest.low, newest.high, shape="normal")
        except MotoridError as error:
            why = str(error)
    results = [row.result for row in rows]
    return Readings(name, newest.unit, results, values, newest.low, newest.high, able, why)


def _least(found: Sequence[Readings]) -> str:
    """The quantity with the least Ppk; "" where none has one."""
    able = [(o.capability.ppk.value, o.name) for o in found if o.capability is not None]
    known = [(value, name) for value, name in able if value is not None]
    return min(known)[1] if known else (found[0].name if found else "")


def _trend(readings: Readings) -> tuple[Trend | None, str]:
    values = readings.values
    try:
        return trend(
            values, np.arange(float(len(values))), quantity=readings.name, unit=readings.unit,
            lower=readings.low, upper=readings.high, small_shifts=True, shape="normal",
        ), ""  # fmt: skip
    except MotoridError as error:
        return None, str(error)


def _of_station(history: History, query: Query, station: str, quantity: str) -> Readings | None:
    rows = history.readings(replace(query, station=station), OF_STATION, quantity)
    return _of(quantity, rows) if rows else None
