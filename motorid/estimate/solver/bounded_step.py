"""A damped step of the linear model within the bounds of every unknown, nuisances eliminated.

The way to the model's minimum is followed to the first bound that it meets. What met it stays
there, the rest goes on to the minimum that is left to it. So the model falls all the way, and what
stops at a bound changes how far everything else goes: a primal active-set method (Nocedal and
Wright, Numerical Optimization, 2nd edition, section 16.5).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.solver.normal_equations import Normal
from motorid.estimate.solver.problem import bounded_inverse
from motorid.estimate.solver.search_coordinates import Coordinates

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


@dataclass
class Moving:
    """Unknowns on their way from ``at``: how far they have ``gone``, and which are ``held``."""

    at: Floats
    frame: Coordinates
    held: Bools
    gone: Floats = field(init=False)

    def __post_init__(self) -> None:
        self.gone = np.zeros(len(self.at))

    @property
    def reached(self) -> Floats:
        """Where they are, within the bounds."""
        return np.asarray(np.clip(self.at + self.gone, self.frame.lower, self.frame.upper))

    @property
    def stopped(self) -> Floats:
        """How far those have gone that are held; the others none."""
        return np.where(self.held, self.gone, 0.0)

    def target(self, free: Floats) -> Floats:
        """The way's end where all that are not held go so far."""
        return np.where(self.held, self.gone, free)

    def room(self, target: Floats) -> Floats:
        """The part of the way to a target that each may go, 1 where no bound is on it."""
        way, limit = np.abs(target - self.gone), np.abs(self._bounds(target) - self.gone)
        over = ~self.held & (way > limit)
        return np.where(over, limit / np.where(over, way, 1.0), 1.0)

    def go(self, target: Floats, part: float) -> bool:
        """That part of the way; whether any has no room for more, and stays at its bound."""
        ends = self.room(target) <= part if part < 1.0 else np.zeros(len(self.at), dtype=bool)
        moved = self.target(self.gone + part * (target - self.gone))
        self.gone = np.where(ends, self._bounds(target), moved)
        self.held = self.held | ends
        return bool(ends.any())

    def _bounds(self, target: Floats) -> Floats:
        """How far each may go at most, that way."""
        down = target < self.gone
        return np.asarray(np.where(down, self.frame.lower, self.frame.upper) - self.at)


@dataclass
class _Own:
    """The nuisances of a record on their way, and its damped normal equations."""

    moving: Moving
    normal: Normal
    damped: Floats
    inverse: Floats = field(init=False)

    def __post_init__(self) -> None:
        self.inverse = bounded_inverse(self.damped, self.moving.held)

    def go(self, target: Floats, part: float) -> None:
        """As far; of those that stop, nothing follows the shared unknowns any more."""
        if self.moving.go(target, part):
            self.inverse = bounded_inverse(self.damped, self.moving.held)

    @property
    def pull(self) -> Floats:
        """On the nuisances, as those that are held have gone."""
        return self.normal.go - self.damped @ self.moving.stopped

    def left(self) -> tuple[Floats, Floats]:
        """What is left of the equations of shared unknowns: (p, p), (p,)."""
        follows = self.normal.so @ self.inverse
        pull = self.normal.gs - self.normal.so @ self.moving.stopped - follows @ self.pull
        return self.normal.ss - follows @ self.normal.so.T, pull

    def target(self, shared: Floats) -> Floats:
        """Of the nuisances, as shared unknowns go so far."""
        return self.moving.target(self.inverse @ (self.pull - self.normal.so.T @ shared))


def bounded_step(
    frame: Coordinates,
    at: Floats,
    frames: Sequence[Coordinates],
    own: Sequence[Floats],
    normals: Sequence[Normal],
    damping: float,
) -> tuple[Floats, list[Floats]]:
    """Where shared unknowns (p,) and the nuisances of each record end."""
    records = [
        _Own(
            Moving(x, f, f.blocked(x, normal.go)),
            normal,
            normal.oo + damping * np.diag(np.diag(normal.oo)),
        )
        for normal, f, x in zip(normals, frames, own, strict=True)
    ]
    precision = np.diag(frame.precision.astype(np.float64))
    prior = precision + damping * np.diag(np.diag(precision + sum(n.ss for n in normals)))
    known = -frame.precision * (at - frame.mean)
    H, g = _left(records, prior, known)
    shared = Moving(at, frame, frame.blocked(at, g))
    for _ in range(1 + len(at) + sum(map(len, own))):
        target = shared.target(bounded_inverse(H, shared.held) @ (g - H @ shared.stopped))
        targets = [record.target(target) for record in records]
        rooms = [shared.room(target)]
        rooms += [one.moving.room(to) for one, to in zip(records, targets, strict=True)]
        part = min(float(room.min(initial=1.0)) for room in rooms)
        shared.go(target, part)
        for record, to in zip(records, targets, strict=True):
            record.go(to, part)
        if part == 1.0:
            break
        H, g = _left(records, prior, known)
    return shared.reached, [record.moving.reached for record in records]


def _left(records: Sequence[_Own], prior: Floats, known: Floats) -> tuple[Floats, Floats]:
    """The equations of the shared unknowns, every record's nuisances eliminated."""
    H, g = prior, known
    for record in records:
        information, pull = record.left()
        H, g = H + information, g + pull
    return H, g
