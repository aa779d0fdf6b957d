"""Which units go together: as headers state, as is usual, as they make a motor of the readings.

Costs are in units of chi-square. A unit is sure if every set of units with another one costs at
least ``SURE`` more; else it is asked about.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from itertools import product
from typing import Literal

import numpy as np

from motorid.capture.model import CURRENT, POSITION, SPEED, SUPPLY, TORQUE, VOLTAGE
from motorid.capture.units import TIME, units_of
from motorid.estimate.diagnosis.facts.catalogue import distance_of
from motorid.estimate.diagnosis.facts.unit_mistakes import UNUSUAL
from motorid.workflow.proposal.assign import Pick
from motorid.workflow.proposal.laws import Found

SURE = 6.0
STATED, USUAL, PREFIXED, RARE = 16.0, 4.0, 3.0, 2.0  # cost of another unit than the one stated; ...
RELATED, OFF = 12.0, 0.05  # most that a slope of position costs; relative misfit that costs 1
GEARS = (1.0, 3.0, 10.0, 30.0, 100.0, 300.0)  # motor turns for one that was measured
GEAR_SPREAD = 1.5  # standard deviation of a gear's logarithm
BEYOND = 8.0  # cost of a largest reading that no usual motor has, SI
LARGEST = {CURRENT: (5e-3, 300.0), VOLTAGE: (0.5, 500.0), SUPPLY: (0.5, 500.0), SPEED: (0.3, 5e3)}
PREFIXES = ("mV", "mA")
LEVELS = 8  # different whole numbers, from which on they may be counts
Doubt = Literal["", "unproved", "counts"]
TRIED = {
    CURRENT: {"A": 0.0, "mA": PREFIXED},
    VOLTAGE: {"V": 0.0, "mV": PREFIXED},
    SPEED: {"rpm": 0.0, "rad/s": 0.0, "turn/s": RARE, "deg/s": RARE},
    POSITION: {"rad": 0.0, "deg": 0.0, "turn": RARE},
    SUPPLY: {"V": 0.0, "mV": PREFIXED},
    TORQUE: {"N·m": 0.0, "mN·m": 0.0, "N·cm": RARE, "oz·in": RARE, "lb·in": RARE},
}


@dataclass(frozen=True)
class Choice:
    """``units`` by quantity. ``open``: quantity -> units that may as well be meant, best first.

    ``distance``: of the motor that they make from those of catalogues; None: too little is known.
    """

    units: Mapping[str, str]
    open: Mapping[str, tuple[str, ...]]
    distance: float | None
    figures: Mapping[str, float]
    gear: float = 1.0  # about which it takes to be usual


@dataclass(frozen=True)
class Evidence:
    """What readings say in the file's own units.

    ``laws``: of voltage, current and speed; ``resistance``: highest voltage and R where no speed
    is; ``slope``: speed over the derivative of the position.
    """

    laws: Found | None = None
    resistance: tuple[float, float] | None = None
    slope: float | None = None


def choose(
    picks: Mapping[str, Pick], time_costs: Mapping[str, float], evidence: Evidence
) -> Choice:
    """The units that cost least together."""
    costs = {q: _costs(q, pick) for q, pick in picks.items()}
    if time_costs:
        costs = {TIME: dict(time_costs), **costs}
    costs = {q: one for q, one in costs.items() if one}
    names = list(costs)
    scored = []
    for units in product(*costs.values()):
        chosen = dict(zip(names, units, strict=True))
        total = sum(costs[q][u] for q, u in chosen.items())
        total += _of_slope(chosen, evidence.slope) + (_distance(chosen, evidence) or 0.0)
        scored.append((total, chosen))
    scored.sort(key=lambda one: one[0])
    _, best = scored[0] if scored else (0.0, {})
    return Choice(
        best,
        {
            q: others
            for q in names
            if (others := _others(q, costs[q], best, scored, _doubt(picks.get(q), evidence)))
        },
        _distance(best, evidence),
        figures(best, evidence),
        _gear(best, evidence),
    )


def _others(
    quantity: str,
    costs: Mapping[str, float],
    best: Mapping[str, str],
    scored: list[tuple[float, dict[str, str]]],
    doubt: Doubt,
) -> tuple[str, ...]:
    """Units of that quantity that are within SURE of the best, the best first; none: it is sure.

    A stated unit is never replaced unasked, and a prefix is never taken for its size alone.
    """
    near = [units[quantity] for total, units in scored if total - scored[0][0] < SURE]
    prefixed = best[quantity] in PREFIXES or len(set(near)) > 1
    if doubt == "counts" or (doubt == "unproved" and prefixed):
        near += list(costs)
    stated = min(costs, key=lambda unit: costs[unit])
    if len(costs) > 1 and min(c for u, c in costs.items() if u != stated) >= STATED:
        near += [stated]
    found = tuple(dict.fromkeys(near))
    return found if len(found) > 1 or found[0] != best[quantity] else ()


def _doubt(pick: Pick | None, evidence: Evidence) -> Doubt:
    """Whether nobody states a unit, and no motor's laws hold that would show one.

    Many whole numbers that contradict the laws may be a converter's counts.
    """
    law = evidence.laws
    if pick is None or pick.meaning.unit or (law is not None and law.holds):
        return ""
    column = pick.column
    if law is not None and column is not None and column.whole and column.levels > LEVELS:
        return "counts"
    return "unproved" if law is not None or evidence.resistance is None else ""


def ungeared(choice: Choice, evidence: Evidence) -> list[str]:
    """Units of the speed that make a usual motor of the readings without any gear."""
    found = []
    for unit in TRIED[SPEED]:
        motor = figures({**choice.units, SPEED: unit}, evidence)
        if "K" in motor and distance_of(motor) <= UNUSUAL:
            found.append(unit)
    return found


def _gear(units: Mapping[str, str], evidence: Evidence) -> float:
    """Motor turns for one that was measured, roughly, that make a usual motor; 1: none needed."""
    found = figures(units, evidence)
    if "K" not in found or distance_of(found) <= UNUSUAL:
        return 1.0
    return min(GEARS, key=lambda gear: _geared(found, gear))


def _costs(quantity: str, pick: Pick) -> dict[str, float]:
    said, tried = pick.meaning, TRIED.get(quantity, {})
    if said.strength >= 9.0 and said.unit:
        return {said.unit: 0.0}
    if said.unit and (said.unit.startswith("count") or said.unit not in tried):
        return {said.unit: 0.0}
    if said.unit:
        return dict.fromkeys(tried, STATED) | {said.unit: 0.0}
    if not tried:
        return {next(iter(units_of(quantity))): 0.0}
    costs = dict(tried)
    if said.usual:
        costs = {unit: cost + USUAL for unit, cost in tried.items()} | {said.usual: 0.0}
    low, high = LARGEST.get(quantity, (0.0, math.inf))
    known = pick.values[np.isfinite(pick.values)]
    largest = float(np.abs(known).max()) if len(known) else 0.0
    for unit, (_, scale) in units_of(quantity).items():
        if unit in costs and not low <= largest * scale <= high:
            costs[unit] += BEYOND
    return costs


def _scale(quantity: str, units: Mapping[str, str]) -> float | None:
    unit = units.get(quantity)
    known = units_of(quantity).get(unit or "")
    return known[1] if known is not None else None


def _of_slope(units: Mapping[str, str], slope: float | None) -> float:
    """Cost of a speed that is not the slope of the position, in those units."""
    scales = [_scale(quantity, units) for quantity in (TIME, SPEED, POSITION)]
    if slope is None or None in scales:
        return 0.0
    time, speed, position = (scale or 1.0 for scale in scales)
    ratio = abs(slope) * speed * time / position
    return min(RELATED, (math.log(ratio) / OFF) ** 2) if ratio > 0 else RELATED


def figures(units: Mapping[str, str], evidence: Evidence) -> dict[str, float]:
    """V, R, K and J in SI units, as far as the readings show them."""
    volts, amperes = _scale(VOLTAGE, units), _scale(CURRENT, units)
    speed, time = _scale(SPEED, units), _scale(TIME, units)
    laws = evidence.laws
    if volts is None or amperes is None:
        return {}
    if laws is not None and laws.holds:
        found = {"V": laws.top_v * volts, "R": laws.R * volts / amperes}
        if speed is not None:
            found["K"] = laws.K * volts / speed
            if laws.J_over_K is not None and time is not None:
                found["J"] = laws.J_over_K * amperes * time / speed * found["K"]
        return found
    if evidence.resistance is not None:
        top, ratio = evidence.resistance
        return {"V": top * volts, "R": ratio * volts / amperes}
    return {}


def _distance(units: Mapping[str, str], evidence: Evidence) -> float | None:
    found = figures(units, evidence)
    return _of_figures(tuple(sorted(found.items()))) if found else None


@cache
def _of_figures(known: tuple[tuple[str, float], ...]) -> float:
    """Distance from the catalogue, with whatever gear explains the speed best."""
    found = dict(known)
    if "K" not in found:
        return distance_of(found)
    return min(_geared(found, gear) for gear in GEARS)


def _geared(found: Mapping[str, float], gear: float) -> float:
    """Distance of the motor behind a gear, and what that gear itself costs."""
    motor = {**found, "K": found["K"] / gear}
    if "J" in found:
        motor["J"] = found["J"] / gear**2
    return distance_of(motor) + (math.log(gear) / GEAR_SPREAD) ** 2
