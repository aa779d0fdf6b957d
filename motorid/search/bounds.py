"""The cube's walls, in one place: what to do at them, and what they mean in SI units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from motorid.errors import UsageError
from motorid.estimate.results.estimate import Floats

BOUNCE = 0.5  # the part of a particle's speed that a wall returns (methods of the review, PSO)


def uniform(rng: np.random.Generator, n: int, d: int) -> Floats:
    """The usual first generation, shape (n, d)."""
    return rng.random((n, d))


def clip(u: Floats) -> Floats:
    """Components outside go to the wall: the rule unless a definition names another."""
    return np.clip(u, 0.0, 1.0)


def redraw(u: Floats, rng: np.random.Generator) -> Floats:
    """Components outside are drawn again, uniformly: differential evolution's rule."""
    return np.where((u < 0.0) | (u > 1.0), rng.random(u.shape), u)


def bounce(u: Floats, v: Floats) -> tuple[Floats, Floats]:
    """A particle stops at the wall and its velocity turns and halves: the swarms' rule."""
    outside = (u < 0.0) | (u > 1.0)
    return clip(u), np.where(outside, -BOUNCE * v, v)


@dataclass(frozen=True)
class Box:
    """Named physical parameters with bounds: the unit cube's meaning.

    ``low`` and ``high`` (d,) in SI; ``log``: the cube is uniform in the logarithm.
    Raises UsageError on bounds that hold nothing.
    """

    names: tuple[str, ...]
    low: Floats
    high: Floats
    log: bool = False

    def __post_init__(self) -> None:
        for name, low, high in zip(self.names, self.low, self.high, strict=True):
            if not low < high or (self.log and low <= 0):
                raise UsageError(f"bounds of {name} hold nothing: {low:g} to {high:g}")

    @classmethod
    def around(
        cls, nominal: Mapping[str, float], below: float, above: float, log: bool = False
    ) -> Box:
        """Bounds from ``below`` to ``above`` times each nominal value."""
        values = np.array(list(nominal.values()))
        return cls(tuple(nominal), below * values, above * values, log)

    @property
    def d(self) -> int:
        """Number of parameters."""
        return len(self.names)

    def physical(self, u: Floats) -> Floats:
        """SI values (…, d) of points of the cube (…, d)."""
        if self.log:
            return np.asarray(self.low * (self.high / self.low) ** u)
        return np.asarray(self.low + (self.high - self.low) * u)

    def unit(self, values: Floats) -> Floats:
        """Points of the cube (…, d) of SI values (…, d)."""
        if self.log:
            return np.asarray(np.log(values / self.low) / np.log(self.high / self.low))
        return np.asarray((values - self.low) / (self.high - self.low))
