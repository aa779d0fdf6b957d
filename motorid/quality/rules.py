"""Run rules on a chart's points: Western Electric (1956) and Nelson (1984).

Points come as deviations from the centre in standard deviations of the point plotted.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
RuleSet = Literal["western-electric", "nelson", "limits"]


@dataclass(frozen=True)
class Alarm:
    """A rule that point ``index`` completes; ``first`` is the first point of the pattern."""

    index: int
    first: int
    rule: str
    meaning: str


@dataclass(frozen=True)
class Rule:
    """``holds``: (windows, length) deviations -> whether each window shows the pattern."""

    name: str
    meaning: str
    length: int
    holds: Callable[[Floats], Flags]


def _beyond(windows: Floats, limit: float, least: int) -> Flags:
    """At least ``least`` of the points beyond ``limit`` on the same side, the last one too."""
    above, below = windows > limit, windows < -limit
    up = (above.sum(axis=1) >= least) & above[:, -1]
    down = (below.sum(axis=1) >= least) & below[:, -1]
    return np.asarray(up | down)


def _steady(windows: Floats) -> Flags:
    steps = np.diff(windows, axis=1)
    return np.asarray((steps > 0).all(axis=1) | (steps < 0).all(axis=1))


def _alternating(windows: Floats) -> Flags:
    steps = np.diff(windows, axis=1)
    return np.asarray((steps[:, 1:] * steps[:, :-1] < 0).all(axis=1))


def _hugging(windows: Floats) -> Flags:
    return np.asarray((np.abs(windows) < 1).all(axis=1))


def _mixture(windows: Floats) -> Flags:
    return np.asarray((np.abs(windows) > 1).all(axis=1))


def _of(length: int, least: int, limit: float, name: str, meaning: str) -> Rule:
    return Rule(name, meaning, length, lambda windows: _beyond(windows, limit, least))


LIMITS = (_of(1, 1, 3.0, "1", "a point beyond three sigma"),)
WESTERN_ELECTRIC = (
    *LIMITS,
    _of(3, 2, 2.0, "2", "two of three points beyond two sigma on one side"),
    _of(5, 4, 1.0, "3", "four of five points beyond one sigma on one side"),
    _of(8, 8, 0.0, "4", "eight points in a row on one side"),
)
NELSON = (
    *LIMITS,
    _of(9, 9, 0.0, "2", "nine points in a row on one side"),
    Rule("3", "six points in a row rising or falling", 6, _steady),
    Rule("4", "fourteen points in a row alternating", 14, _alternating),
    _of(3, 2, 2.0, "5", "two of three points beyond two sigma on one side"),
    _of(5, 4, 1.0, "6", "four of five points beyond one sigma on one side"),
    Rule("7", "fifteen points in a row within one sigma", 15, _hugging),
    Rule("8", "eight points in a row beyond one sigma, on both sides", 8, _mixture),
)
SETS: dict[str, tuple[Rule, ...]] = {
    "western-electric": WESTERN_ELECTRIC,
    "nelson": NELSON,
    "limits": LIMITS,
}


def alarms(deviations: Floats, rules: Sequence[Rule]) -> tuple[Alarm, ...]:
    """Every point that completes a rule's pattern, in the order of the points."""
    found: list[Alarm] = []
    for rule in rules:
        if len(deviations) < rule.length:
            continue
        ends = np.flatnonzero(rule.holds(sliding_window_view(deviations, rule.length)))
        found += [Alarm(int(k) + rule.length - 1, int(k), rule.name, rule.meaning) for k in ends]
    return tuple(sorted(found, key=lambda alarm: (alarm.index, alarm.rule)))
