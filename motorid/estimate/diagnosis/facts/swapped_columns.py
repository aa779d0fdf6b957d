"""Two columns of a log under each other's names.

The laws of a motor (``motor_laws``) hold in one arrangement of its columns. The second law tells a
speed, which changes slowly, from a voltage; the signs tell a voltage from a current.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import permutations, product

from motorid.capture.model import Capture
from motorid.estimate.diagnosis.facts.motor_laws import (
    BLOCKS,
    QUANTITIES,
    Columns,
    columns,
    left,
)
from motorid.estimate.results.estimate import PARAMETERS, Diagnostic

GOOD = 0.1  # share that both laws together leave of the squares: a motor's columns
COARSE = BLOCKS // 4  # in which a speed of few bits shows how it changes as well
BETTER = 5.0  # times less than as stated


def findings(capture: Capture, where: str = "") -> Iterator[Diagnostic]:
    """Columns that fit a motor in another arrangement only. ``where``: " in run 2", or nothing."""
    found = find(capture)
    if found is None:
        return
    names = {q: q.replace("terminal_", "") for q in QUANTITIES}
    moved = [(names[q], names[of]) for q, of in zip(QUANTITIES, found, strict=True) if q != of]
    kind = f"{moved[0][0]} and {moved[0][1]} are swapped" if len(moved) == 2 else (
        "the columns have changed places")  # fmt: skip
    reads = ", ".join(f"the one called {called} reads as the {truly}" for truly, called in moved)
    yield Diagnostic(
        "columns_swapped", "error",
        f"{kind}{where}: {reads}; in that arrangement the readings follow a motor's laws, as "
        "stated they do not. Import again with the names exchanged",
        dict.fromkeys(PARAMETERS, math.inf),
    )  # fmt: skip


def find(capture: Capture) -> tuple[str, ...] | None:
    """Which channel holds the voltage, the current and the speed; None: as stated, or unclear."""
    found = columns(capture)
    if found is None:
        return None
    stated, tried = _shares(found, BLOCKS)
    if stated < GOOD:
        return None
    best = min(tried, key=lambda order: tried[order])
    if tried[best] > min(GOOD, stated / BETTER):
        return None
    stated, tried = _shares(found, COARSE)
    if tried[best] > stated / BETTER:
        return None  # only noise from row to row said so
    return tuple(QUANTITIES[k] for k in best)


def _shares(found: Columns, blocks: int) -> tuple[float, dict[tuple[int, int, int], float]]:
    """What both laws leave of the columns as stated, whichever is reversed, and in every order."""
    volts, current, speed = found
    signs = product((1.0, -1.0), repeat=2)  # a reversed column is another mistake
    stated = min(sum(left(volts, a * current, b * speed, blocks=blocks)) for a, b in signs)
    tried = {
        (a, b, c): sum(left(found[a], found[b], found[c], blocks=blocks))
        for a, b, c in permutations(range(3))
    }
    return stated, tried
