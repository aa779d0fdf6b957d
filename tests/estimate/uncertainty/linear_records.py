"""Records whose readings are linear in all that moves them, and the whole system of their fit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.solver.problem import Linearised

Floats = NDArray[np.float64]

P, M = 2, 2  # shared parameters, nuisances of each record
BLOCKS = (30, 20)  # readings
SIGMAS = np.array([0.5, 4.0])


@dataclass(eq=False)
class LinearRecord:
    """Derivatives (n, ·) of its readings in their unit, and what else is asked of a record."""

    shared: Floats
    own: Floats
    precision: Floats
    residual: Floats
    changes: Mapping[str, Floats] = field(default_factory=dict)  # (n,) by a unit of each quantity
    modelled: Sequence[str] = ()
    facts: Mapping[str, Any] = field(default_factory=dict)

    def __getattr__(self, name: str) -> Any:
        try:
            return self.__dict__["facts"][name]
        except KeyError as error:
            raise AttributeError(name) from error

    def weighed(self, blocks: Sequence[Floats]) -> list[Floats]:
        """Every reading counts by four, as by a weight of 4."""
        return [2.0 * block for block in blocks]

    def blocks(self, readings: Floats) -> list[Floats]:
        """(n,) by channel."""
        return np.split(readings, [BLOCKS[0]])

    def scaled(self, readings: Floats) -> Floats:
        """Weighed, and in standard deviations of its channel."""
        sigma = np.repeat(SIGMAS, BLOCKS)
        return np.asarray(2.0 * (readings.T / sigma).T)

    @property
    def line(self) -> Linearised:
        shared, own = self.scaled(self.shared), self.scaled(self.own)
        free = own.T @ own + np.diag(self.precision)
        orthogonal = shared - own @ np.linalg.solve(free, own.T @ shared)
        edges = (slice(0, BLOCKS[0]), slice(BLOCKS[0], sum(BLOCKS)))
        return Linearised(
            self.scaled(self.residual), shared, own, orthogonal, self.precision, (), edges, SIGMAS
        )


def drawn(seed: int, *names: str, **facts: Any) -> LinearRecord:
    """One that quantities of these names move."""
    rng = np.random.default_rng(seed)

    def column(*shape: int) -> Floats:
        return np.asarray((np.repeat(SIGMAS, BLOCKS) * rng.standard_normal((*shape, 50))).T)

    shared, own = column(P), column(M)
    residual = 0.1 * column()
    changes = {name: column() + shared @ [0.3, -0.5] + own @ [0.4, 0.0] for name in names}
    return LinearRecord(shared, own, np.array([3.0, 0.5]), residual, changes, facts=facts)


def solved(records: Sequence[LinearRecord]) -> Any:
    """A solution, as far as an uncertainty asks for it."""
    lines = tuple(record.line for record in records)
    information = sum((line.shared.T @ line.orthogonal for line in lines), np.zeros((P, P)))
    return SimpleNamespace(
        records=lines, information=information, values=np.ones(P), own=[np.zeros(M)] * len(lines),
        unknowns=(SimpleNamespace(name="R"), SimpleNamespace(name="L")),
    )  # fmt: skip


def system(records: Sequence[LinearRecord]) -> tuple[Floats, Floats]:
    """Derivatives (all readings, p + m for each record) of all unknowns at once, and H."""
    whole = np.zeros((sum(BLOCKS) * len(records), P + M * len(records)))
    precision = [np.zeros(P), *(record.precision for record in records)]
    for k, record in enumerate(records):
        rows = slice(sum(BLOCKS) * k, sum(BLOCKS) * (k + 1))
        whole[rows, :P] = record.line.shared
        whole[rows, P + M * k : P + M * (k + 1)] = record.line.own
    return whole, whole.T @ whole + np.diag(np.concatenate(precision))


def followed(records: Sequence[LinearRecord], changes: Sequence[Floats]) -> Floats:
    """(p + m for each record): what all unknowns make of changes of the readings, in their unit."""
    whole, H = system(records)
    scaled = np.concatenate([r.scaled(c) for r, c in zip(records, changes, strict=True)])
    return np.asarray(np.linalg.solve(H, whole.T @ scaled))
