"""How far intervals of the plain model must grow to cover those of a better model."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from motorid.estimate.assembly.doubt import SHARE, grown
from motorid.estimate.results.estimate import Alternative, Estimate, Parameter

COUNTED = 1.001  # of the share of half an interval beyond which a value is doubtful


@dataclass(frozen=True)
class Covering:
    """``moves`` and ``sides`` of the finding that a better model is, by parameter (its unit)."""

    moves: dict[str, float] = field(default_factory=dict)
    sides: dict[str, tuple[float, float]] = field(default_factory=dict)


def covering(plain: Estimate, better: Alternative, names: Iterable[str]) -> Covering:
    """Of each parameter whose interval the better model's reaches beyond, where the value moves, or
    that reaches, by half of the interval's half or more."""
    found = Covering()
    for name in names:
        sides = _sides(plain, better, name)
        if sides is not None:
            found.sides[name], found.moves[name] = sides, max(sides)
    return found


def excluded(plain: Estimate, better: Alternative, but: Sequence[str] = ()) -> list[str]:
    """Parameters whose interval does not hold the better model's value, ``but`` some."""
    out = []
    for name, p in plain.parameters.items():
        if name in but:
            continue
        value = better.parameters[name].value
        if value is None or p.value is None or p.interval_95 is None:
            continue
        if not p.interval_95[0] <= value <= p.interval_95[1]:
            out.append(name)
    return out


def _sides(plain: Estimate, better: Alternative, name: str) -> tuple[float, float] | None:
    p = plain.parameters[name]
    before = grown(p, plain.budget.get(name, {}))
    return covering_sides(p, better.parameters[name], before)


def covering_sides(
    p: Parameter, other: Parameter, before: float = 0.0
) -> tuple[float, float] | None:
    """Moves (its unit) below and above with which a finding makes ``p`` cover the ``other`` model's
    interval. None where that does not reach beyond it, or neither the value moves nor that reaches
    by half of the interval's half or more. ``before``: by how much findings widened half of it.
    """
    if p.value is None or p.interval_95 is None or other.value is None:
        return None
    (low, high), (least, most) = p.interval_95, other.interval_95 or (other.value, other.value)
    below, above = max(low - least, 0.0), max(most - high, 0.0)
    counts, lacking = SHARE * (high - low) / 2.0, max(below, above)
    if not lacking > 0.0 or max(abs(other.value - p.value), lacking) <= counts:
        return None
    below, above = _beside(below, before), _beside(above, before)
    enough = max(below, above, COUNTED * counts)
    return (enough, above) if below > above else (below, enough)


def _beside(lacking: float, before: float) -> float:
    """The move that widens by what is lacking: findings add in squares to those before."""
    return math.sqrt(lacking * (lacking + 2.0 * before))
