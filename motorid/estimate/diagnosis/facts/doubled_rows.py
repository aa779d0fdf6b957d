"""Rows of a log that stand twice, under stamps that count them as if each were new.

A converter that repeats a reading catches up afterwards: the next change is as large as two. A row
that stands twice takes no time, so the next change is a usual one, and each such row makes the
log's time too long by a period.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture
from motorid.estimate.results.estimate import Diagnostic, Parameter

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

QUANTITIES = (VOLTAGE, CURRENT, SPEED, POSITION)
STEPS = 3.0  # of a channel's resolution: the changes on both sides of a repetition, at least
FEWEST, LEAST = 10, 0.005  # rows, and of all rows: fewer do no harm and may be chance
RARE = 5.0  # times as often as rows equal the one before the last
MOST = 0.45  # of the rows: above it each reading comes several times over
CATCHES_UP = 1.5  # usual changes after a repetition; a repeated reading makes two
FAR = 8  # rows beside a repetition that show how the signal moves


def findings(
    capture: Capture, parameters: Mapping[str, Parameter], where: str = ""
) -> Iterator[Diagnostic]:
    """Rows that stand twice. ``where``: " in run 2", or nothing."""
    places = find(capture)
    if not len(places):
        return
    share = len(places) / (len(capture) - len(places))
    yield Diagnostic(
        "rows_doubled", "error",
        f"{len(places)} rows stand twice{where}, all channels alike where the readings move, first "
        f"at {capture.time_s[places[0]]:.4g} s, and the stamps count them as new: time runs "
        f"{100 * share:.2g} % too long. Remove the second of each pair and its period before the "
        "import, or log again",
        _moves(capture, parameters, share),
    )  # fmt: skip


def find(capture: Capture) -> NDArray[np.intp]:
    """Rows (samples) that repeat the one before and take no time."""
    none = np.array([], dtype=np.intp)
    table = _table(capture)
    if capture.program is not None or table is None or len(table) < 4 * FAR:
        return none
    changes = np.diff(table, axis=0)
    again = np.r_[False, (changes == 0.0).all(axis=1)]
    alone = again & ~np.r_[again[1:], False] & ~np.r_[False, again[:-1]]
    after_two = np.r_[False, False, (table[2:] == table[:-2]).all(axis=1)] & ~again
    periods = np.diff(capture.time_s)
    timed = np.r_[False, periods > 0.5 * np.median(periods)]
    places = np.flatnonzero(alone & timed & _moving(changes, 1))
    places = places[(places >= FAR) & (places < len(table) - FAR)]
    chance = int((after_two & _moving(changes, 2)).sum())
    if len(places) < max(FEWEST, LEAST * len(table), RARE * (chance + 1)) or again.mean() > MOST:
        return none
    return none if _catch_up(table, places) > CATCHES_UP else places


def _table(capture: Capture) -> Floats | None:
    """(n, channels): what was read; None: fewer than two channels."""
    channels = [c for name in QUANTITIES if (c := capture.get(name)) is not None]
    if len(channels) < 2:
        return None
    return np.column_stack([np.asarray(c.raw, dtype=np.float64) for c in channels])


def _moving(changes: Floats, apart: int) -> Bools:
    """(n,) of n - 1 changes: rows k where a channel changes by more than a step on both sides.

    The sides are after row k and before row k - ``apart``.
    """
    sizes = np.abs(changes)
    steps = np.min(np.where(sizes > 0.0, sizes, np.inf), axis=0)
    large = sizes >= STEPS * steps
    out = np.zeros(len(changes) + 1, dtype=np.bool_)
    out[apart + 1 : -1] = (large[: -apart - 1] & large[apart + 1 :]).any(axis=1)
    return out


def _catch_up(table: Floats, places: NDArray[np.intp]) -> float:
    """The change after a repetition in usual changes, from the channel that moves most clearly."""
    best = 1.0, 0.0
    for column in table.T:
        beside = 0.5 * (column[places + FAR - 1] - column[places + 3])
        beside = beside + 0.5 * (column[places - 3] - column[places - FAR + 1])
        after = column[places + 1] - column[places]
        usual = 0.5 * (column[places + 2] - column[places + 1])
        usual = usual + 0.5 * (column[places - 1] - column[places - 2])
        moved = float(usual @ beside)
        noise = float(np.median(np.abs(usual - beside / (FAR - 4)))) * math.sqrt(beside @ beside)
        clear = moved / (noise + 1e-300)
        if moved > 0.0 and clear > best[1]:
            best = float(after @ beside) / moved, clear
    return best[0]


def _moves(capture: Capture, parameters: Mapping[str, Parameter], share: float) -> dict[str, float]:
    """What a time too long by that share does, and by chance a larger one in a short transient."""
    values = {n: p.value for n, p in parameters.items() if p.value is not None and p.value > 0.0}
    if not {"R", "K", "J"} <= values.keys():
        return dict.fromkeys(values, math.inf)
    spans = {"J": values["R"] * values["J"] / values["K"] ** 2}
    if "L" in values:
        spans["L"] = values["L"] / values["R"]
    period = float(np.median(np.diff(capture.time_s)))
    out = {}
    for name, span in spans.items():
        rows = max(span / period, 1.0)
        out[name] = values[name] * (share + 2.0 * math.sqrt(share / rows))
    if capture.get(SPEED) is None:
        out |= {n: share * values[n] for n in ("K", "B", "T0") if n in values}
    return out
