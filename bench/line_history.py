"""A line's history of any length, as a bench needs it: seeded, of 22 measurements a result.

    python bench/line_history.py line.db [RESULTS=20000] [TIMES=1]

With TIMES the whole is there so often, one after the other: other motors, other captures, later
times, the same values. That is made in SQL, and takes a quarter of the time.

Motors of the product sim-disc come from 20 stations, one every 3.15 s together: ten million a year.
Some 2 in 100 have one of the defects below; half of those, and all that could not be judged, are
tested again a minute later. In the last tenth the K of one station falls by two standard deviations
of the process. Outcomes and reasons are the product's own. The results carry no seals.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Connection, text

from motorid import json_text
from motorid.quality.history import History, open_history
from motorid.quality.history.records import digest
from motorid.quality.limits import Limit
from motorid.quality.product import load_product
from motorid.quality.verdict import Reading, decide

PRODUCT = load_product("sim-disc")
LIMITS = tuple(PRODUCT.limits.values())
NAMES = tuple(PRODUCT.limits)
CONDITIONS = ("run_complete", "model_fits")
UNTIL = datetime(2026, 11, 21, tzinfo=UTC)  # the newest result
APART = timedelta(seconds=3.15)
STATIONS = 20
PIECE = 10_000  # results in a transaction
DEFECTS = {  # quantity: share of the motors
    "T0": 0.006, "ripple_segment": 0.004, "brush_noise": 0.003, "B": 0.002, "R_25": 0.002,
    "unbalance": 0.001, "direction_current": 0.001, "K_25": 0.001,
}  # fmt: skip
NOT_JUDGED, AGAIN = 0.004, 0.5
WEAK_STATION, WEAK_FROM, WEAK_BY = 3, 0.9, 2.0  # whose K falls, from which share, by so many sd
Floats = NDArray[np.float64]
VERSIONS = json_text.dumps({"motorid": "1.0", "product": PRODUCT.digest})
TABLES = ("results", "captures", "result_captures", "measurements")
AGAIN_SQL = {  # the rows of the results from :first to :last, for those that are :by later
    "results": """SELECT id + :by, substr(key, 1, 56) || printf('%08x', id + :by), kind,
        printf('D%08d', substr(serial, 2) + :by), product, outcome, marginal,
        strftime('%Y-%m-%d %H:%M:%f', at, :later) || '000', station, operator, note, versions,
        limits, estimate FROM results WHERE id BETWEEN :first AND :last""",
    "captures": """SELECT substr(c.sha256, 1, 56) || printf('%08x', r.id + :by), path,
        printf('D%08d', substr(c.serial, 2) + :by),
        strftime('%Y-%m-%d %H:%M:%f', created, :later) || '000', samples, end_reason, rig, program,
        calibration FROM results r JOIN result_captures l ON l.result = r.id
        JOIN captures c ON c.sha256 = l.capture WHERE r.id BETWEEN :first AND :last""",
    "result_captures": """SELECT result + :by, position,
        substr(capture, 1, 56) || printf('%08x', result + :by) FROM result_captures
        WHERE result BETWEEN :first AND :last""",
    "measurements": """SELECT result + :by, name, unit, value, uncertainty, low, high, guard_band,
        outcome, marginal, reason FROM measurements WHERE result BETWEEN :first AND :last""",
}


@dataclass(frozen=True)
class Spread:
    """Mean, standard deviation and standard uncertainty of a quantity on this line."""

    mean: float
    sd: float
    u: float


def spread(limit: Limit) -> Spread:
    """Within the limits by four and a half standard deviations, guard band included."""
    if np.isinf(limit.low):
        return Spread(0.4 * limit.high, 0.11 * limit.high, 0.01 * limit.high)
    half = 0.5 * (limit.high - limit.low)
    return Spread(limit.low + half, 0.2 * half, 0.05 * half)


SPREADS = tuple(spread(limit) for limit in LIMITS)


def values(piece: int, first: int, total: int, count: int) -> tuple[Floats, NDArray[np.bool_]]:
    """What the results of a piece have measured (count, 20); which of them could not be judged."""
    rng = np.random.default_rng([2026, piece])
    means, sds = (np.array([getattr(one, name) for one in SPREADS]) for name in ("mean", "sd"))
    deviations = rng.standard_normal((count, len(LIMITS)))
    number = first + np.arange(count)
    station = number % STATIONS
    deviations += 0.3 * np.sin(1.0 + station[:, None] + np.arange(len(LIMITS)))
    weak = (station == WEAK_STATION) & (number > WEAK_FROM * total)
    deviations[weak, NAMES.index("K_25")] -= WEAK_BY
    drawn, edge = rng.random(count), 0.0
    for name, share in DEFECTS.items():
        hit = (drawn >= edge) & (drawn < edge + share)
        edge += share
        deviations[hit, NAMES.index(name)] += 5.0 + 3.0 * rng.random(int(hit.sum()))
    return np.abs(means + sds * deviations), rng.random(count) < NOT_JUDGED


def rows(piece: int, first: int, total: int, count: int) -> dict[str, list[tuple[Any, ...]]]:
    """What goes into each table."""
    measured, lost = values(piece, first, total, count)
    low, high = (np.array([getattr(limit, side) for limit in LIMITS]) for side in ("low", "high"))
    u = np.array([one.u for one in SPREADS])
    passed = (measured >= low + 2 * u) & (measured <= high - 2 * u)
    good = passed.all(axis=1) & ~lost
    again = np.random.default_rng([2027, piece]).random(count) < AGAIN
    out: dict[str, list[tuple[Any, ...]]] = {name: [] for name in TABLES}
    serials: list[str] = []
    for k in range(count):
        number = first + k
        before = k - STATIONS
        repeated = before >= 0 and not good[before] and (lost[before] or again[before])
        serials.append(serials[before] if repeated else f"D{number:08d}")
        at = UNTIL - APART * (total - number)
        found = list(_measurements(number, measured[k], passed[k], bool(lost[k])))
        outcome = "INVALID" if lost[k] else "PASS" if good[k] else "FAIL"
        marginal = outcome == "FAIL" and all(m[9] for m in found if m[8] == "FAIL")
        station, sha256 = f"line-{number % STATIONS + 1:02d}", digest(f"capture {number}")
        when = f"{at:%Y-%m-%d %H:%M:%S.%f}"
        out["results"].append(
            (number, digest(f"result {number}"), "check", serials[k], PRODUCT.name, outcome,
             marginal, when, station, "", "", VERSIONS, PRODUCT.digest, None)
        )  # fmt: skip
        path = f"captures/{station}/{serials[k]}_{at:%Y%m%dT%H%M%S}/capture.h5"
        out["captures"].append(
            (sha256, path, serials[k], when, 3100, "completed", None, None, None)
        )
        out["result_captures"].append((number, 0, sha256))
        out["measurements"] += found
    return out


def _measurements(
    number: int, measured: Floats, passed: NDArray[np.bool_], lost: bool
) -> Iterator[tuple[Any, ...]]:
    problem = "the run ended early (link lost): measure again" if lost else ""
    for name, said in zip(CONDITIONS, (problem, ""), strict=True):
        outcome = "INVALID" if said else "PASS"
        yield number, name, "1", float(not said), 0.0, 1.0, None, 0.0, outcome, False, said
    for limit, one, value, good in zip(LIMITS, SPREADS, measured, passed, strict=True):
        band, ends = 2 * one.u, tuple(None if np.isinf(e) else e for e in (limit.low, limit.high))
        about = (number, limit.quantity, limit.unit, float(value), one.u, *ends, band)
        if good:
            yield *about, "PASS", False, ""
            continue
        judged = decide(limit, Reading(limit.unit, float(value), one.u), limit.quantity)
        yield *about, str(judged.outcome), judged.marginal, judged.reason


def fill(history: History, total: int, *, first: int = 1, last: int | None = None) -> None:
    """Adds the results from ``first`` to ``last`` of ``total``, which is the newest. SQLite's."""
    with history.engine.begin() as connection:
        _insert(connection, "OR IGNORE INTO documents", [(PRODUCT.digest, PRODUCT.text)])
    for begin in range(first, (last or total) + 1, PIECE):
        count = min(PIECE, (last or total) + 1 - begin)
        with history.engine.begin() as connection:
            for table, found in rows(begin // PIECE, begin, total, count).items():
                _insert(connection, f"INTO {table}", found)


def repeat(history: History, count: int, times: int, *, first: int = 1) -> None:
    """The first ``count`` results again and again, until they are there so often. SQLite's.

    ``first``: how often they are there already.
    """
    for turn in range(first, times):
        by = turn * count
        later = f"+{by * APART.total_seconds():.3f} seconds"
        for begin in range(1, count + 1, PIECE):
            last = min(begin + PIECE - 1, count)
            about = {"by": by, "later": later, "first": begin, "last": last}
            with history.engine.begin() as connection:
                for table in TABLES:
                    connection.execute(text(f"INSERT INTO {table} {AGAIN_SQL[table]}"), about)


def _insert(connection: Connection, where: str, found: Sequence[tuple[Any, ...]]) -> None:
    places = ", ".join("?" * len(found[0]))
    connection.exec_driver_sql(f"INSERT {where} VALUES ({places})", list(found))


def main() -> None:
    """Makes a history."""
    total, times = (int(word) for word in (*sys.argv[2:], *("20000", "1")[len(sys.argv) - 2 :]))
    with open_history(Path(sys.argv[1])) as history:
        fill(history, total)
        repeat(history, total, times)


if __name__ == "__main__":
    main()
