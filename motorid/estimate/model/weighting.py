"""What each reading of a capture counts: weights, thinning, filters against coloured noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.signals.measurements import Measured
from motorid.estimate.solver.dense_products import square
from motorid.estimate.solver.problem import Block

Floats = NDArray[np.float64]

INNOVATION = 0.3  # of a reading's least standard deviation, once its past is known


class Weighed:
    """The readings of one capture and what they count for: each in full until told otherwise."""

    def __init__(self, measured: tuple[Measured, ...]) -> None:
        self.measured = measured
        self.blocks = tuple(m.block for m in measured)
        self.filters: tuple[Floats | None, ...] = tuple(None for _ in measured)
        self.thinned = self.filters

    def whiten(self, filters: Sequence[Floats | None]) -> None:
        """Pass every block's residuals through a filter 1, -c1, -c2 .. from now on; None: as is."""
        self.filters = tuple(filters)
        self.thin([None] * len(self.measured))

    def thin(self, roots: Sequence[Floats | None]) -> None:
        """Multiply every block's readings (n,) by the roots of weights from now on; None: by 1."""
        self.thinned = tuple(roots)
        self.blocks = tuple(
            _worth(m, filter_, root)
            for m, filter_, root in zip(self.measured, self.filters, roots, strict=True)
        )

    def weigh_as(self, other: Weighed) -> None:
        """By the colour and the slow wandering of other records of the same readings."""
        filters, thinned = other.filters, other.thinned  # which may be its own
        self.whiten(filters)
        self.thin(thinned)

    def weighed(self, parts: Sequence[Floats], filtered: bool = True) -> list[Floats]:
        """Changes of the readings, one array per block, as the likelihood counts them."""
        own = [
            part if m.root_weights is None else part * m.root_weights
            for m, part in zip(self.measured, parts, strict=True)
        ]
        return self.filtered(own) if filtered else own

    def filtered(self, parts: Sequence[Floats]) -> list[Floats]:
        """``parts``, one array per block, which are multiplied by their own weights already, with
        what colour and slow wandering add to those."""
        out = []
        for f, thinned, part in zip(self.filters, self.thinned, parts, strict=True):
            r = part if thinned is None else part * thinned
            out.append(r if f is None else np.convolve(r, f, "valid"))
        return out

    def filtered_rows(self, table: Floats) -> Floats:
        """``filtered`` of every row (n,) of a table over all blocks."""
        if all(w is None for w in (*self.filters, *self.thinned)):
            return table
        edges = np.cumsum([len(m.values) for m in self.measured])[:-1]
        zeros = np.zeros(table.shape[1])  # tells how many are left where there is no row
        rows = [np.concatenate(self.filtered(np.split(row, edges))) for row in (zeros, *table)]
        return np.array(rows)[1:]


def _worth(m: Measured, filter_: Floats | None, thinned: Floats | None) -> Block:
    """A block whose readings pass through a filter, and are worth less."""
    block = m.block
    if thinned is not None:
        roots = thinned if m.root_weights is None else m.root_weights * thinned
        block = replace(block, count=square(roots))
    if filter_ is None:
        return block
    count = max(block.count - len(filter_) + 1, 1.0)
    return replace(block, floor=block.floor * INNOVATION, count=count)
