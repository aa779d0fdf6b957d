"""What the likelihood engine takes and gives: unknowns, blocks, records, and the solution."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.solver.dense_products import gram, square

Floats = NDArray[np.float64]

LEAST = 1e-250  # of an information: its inverse is still a number
LITTLE = 1.0  # of chi-square: what is left is a standard deviation by noise at most
SINGULAR = 1e-14  # of the largest eigenvalue: less is rounding


@dataclass(frozen=True)
class Unknown:
    """One parameter of the search.

    ``log``: searched in its logarithm, so positive. ``scale``: its typical size (linear ones only),
    which sets the finite-difference step. A finite ``prior_sd`` adds a Gaussian prior in the
    search's coordinate.
    """

    name: str
    start: float
    lower: float = -np.inf
    upper: float = np.inf
    log: bool = False
    scale: float = 1.0
    prior_mean: float = 0.0
    prior_sd: float = np.inf


@dataclass(frozen=True)
class Block:
    """A channel's residuals: ``floor`` is the least standard deviation they can have (SI, > 0).

    ``count`` is the number of readings they are worth: below their length when a record has
    weighted some down (its residuals are already multiplied by the roots of the weights). Blocks
    of one ``group`` share their standard deviation; without one, a block has its own.
    """

    name: str
    floor: float
    count: float
    group: str = ""


class Record(Protocol):
    """One capture as the engine sees it."""

    @property
    def simulated(self) -> int:
        """How many responses it has computed, by what they were worth in ordinary ones."""

    @property
    def unknowns(self) -> Sequence[Unknown]:
        """The record's own nuisances: offsets, origins."""

    @property
    def blocks(self) -> Sequence[Block]:
        """What the residuals are, in their order."""

    def residuals(self, shared: Floats, own: Floats) -> list[Floats]:
        """Measured less model in SI units, one array per block, free of NaN."""

    def foresee(self, points: Sequence[tuple[Floats, Floats]]) -> None:
        """Residuals at these (shared, own) are asked next: what is quicker at once is done here."""


@dataclass(frozen=True)
class Linearised:
    """A record at the solution, every row divided by its block's sigma.

    Shapes: ``residual`` (n,), ``shared`` (n, p) and ``own`` (n, m) derivatives of the *model* in
    search coordinates, ``orthogonal`` (n, p): ``shared`` less what the record's nuisances explain.
    """

    residual: Floats
    shared: Floats
    own: Floats
    orthogonal: Floats
    own_precision: Floats  # (m,) of the priors
    blocks: tuple[Block, ...]
    slices: tuple[slice, ...]
    sigmas: Floats
    held: tuple[int, ...] = ()  # nuisances at a bound and pulled further out: they follow nothing

    @cached_property
    def own_information(self) -> Floats:
        """(m, m) of the record's nuisances, the shared parameters held, priors and all."""
        return self._information(self.own)

    def cleared(self) -> tuple[Floats, Floats]:
        """Derivatives (n, m) of the nuisances that ``orthogonal`` is cleared of, those held as
        nothing, and their information (m, m)."""
        if not self.held:
            return self.own, self.own_information
        own = self.own.copy()
        own[:, list(self.held)] = 0.0
        return own, self._information(own)

    def _information(self, own: Floats) -> Floats:
        return gram(own.T, own.T) + np.diag(self.own_precision)


@dataclass(frozen=True)
class Derivatives:
    """Of every record's residuals, not weighted, and where they were taken (search coordinates).

    ``shared`` holds an array (p, n) a record, ``own_slopes`` one (m, n); positive: the model rises.
    """

    at: Floats
    own: tuple[Floats, ...]
    shared: tuple[Floats, ...]
    own_slopes: tuple[Floats, ...]


@dataclass(frozen=True)
class Solution:
    """The most likely parameters. Search coordinates: the logarithm of ``log`` unknowns."""

    unknowns: tuple[Unknown, ...]
    values: Floats  # (p,) SI
    own: tuple[Floats, ...]  # nuisances of each record, SI
    own_covariance: tuple[Floats, ...]  # of each record's nuisances, for white residuals
    information: Floats  # (p, p) in search coordinates, nuisances eliminated
    at_bound: NDArray[np.bool_]  # (p,)
    linearise: Callable[[], tuple[Linearised, ...]]
    objective: float  # F
    evaluations: int  # of all records together
    converged: bool
    derivatives: Derivatives | None = None  # as far as another search may lend them
    noise: float = 0.0  # of F, by noise of what drives the model: other models may pass less
    promised: float = np.inf  # of F, by what is left of a search that did not settle
    left: Floats | None = None  # (p,) the step to there, in search coordinates; None: it settled

    @property
    def fair(self) -> float:
        """F as it is held against that of other models."""
        return self.objective - self.noise

    @property
    def unfinished(self) -> bool:
        """The search did not settle, and what is left of it is no small part of what noise leaves
        open: the values may lie anywhere.
        """
        return not self.converged and self.promised >= LITTLE

    @cached_property
    def records(self) -> tuple[Linearised, ...]:
        """Every record at the solution; many a search on the way is not asked for them."""
        return self.linearise()

    @property
    def chi_square(self) -> float:
        """Sum of squared residuals over the block variances."""
        return float(sum(square(r.residual) for r in self.records))

    @property
    def degrees_of_freedom(self) -> int:
        """What the readings are worth in independent ones, less ``unknown_count``."""
        readings = sum(block.count for record in self.records for block in record.blocks)
        return int(readings) - self.unknown_count

    @property
    def unknown_count(self) -> int:
        """Free parameters and nuisances."""
        return int((~self.at_bound).sum()) + sum(len(own) for own in self.own)

    @property
    def covariance(self) -> Floats:
        """(p, p) in search coordinates for white residuals; 0 for parameters at a bound."""
        return bounded_inverse(self.information, self.at_bound)

    @property
    def slopes(self) -> Floats:
        """d value / d search coordinate, (p,)."""
        return np.array(
            [v if u.log else 1.0 for u, v in zip(self.unknowns, self.values, strict=True)]
        )


def bounded_inverse(information: Floats, at_bound: NDArray[np.bool_]) -> Floats:
    """Inverse over the parameters that are free; scaled first, pseudo where singular."""
    if not at_bound.any():
        return _inverse(information)
    free = np.flatnonzero(~at_bound)
    inverse = np.zeros_like(information)
    if len(free):
        place = np.ix_(free, free)
        inverse[place] = _inverse(information[place])
    return inverse


def _inverse(information: Floats) -> Floats:
    """By its eigenvalues, as numpy's ``pinv`` of a symmetric matrix does it with more around it."""
    diagonal = information.diagonal()
    # rounding may leave nothing, or less, of what nuisances explain: such a one stays where it is
    scale = np.where(diagonal > 0.0, np.maximum(diagonal, LEAST) ** -0.5, 0.0)
    scaled = np.clip(information * scale[:, None] * scale, -1.0, 1.0)
    sizes, ways = np.linalg.eigh(scaled)
    order = np.argsort(np.abs(sizes))[::-1]  # sums come out to their last digit as numpy's do
    sizes, ways = sizes[order], ways[:, order]
    least = SINGULAR * np.abs(sizes[:1]).max(initial=0.0)
    back = np.divide(1.0, sizes, where=np.abs(sizes) > least, out=np.zeros_like(sizes))
    return np.asarray(ways @ (back[:, None] * ways.T) * np.outer(scale, scale))
