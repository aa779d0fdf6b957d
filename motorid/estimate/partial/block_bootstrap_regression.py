"""Linear regression on correlated rows: physical bounds, and an uncertainty from blocks of rows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.partial.modulating_functions import COLUMNS, Rows

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

OFFSET = COLUMNS.index("offset")
_FRICTIONS = (COLUMNS.index("viscous"), COLUMNS.index("coulomb"))  # these brake: never negative
FEWEST_BLOCKS, MOST_BLOCKS = 12, 48
ROWS_A_BLOCK = 4
FEWEST_RUNS = 3  # that show how runs differ


@dataclass(frozen=True)
class Regression:
    """Coefficients by COLUMNS, and of further terms behind them, and what is known of them.

    ``covariance`` is over all columns: 0 for those that were not wanted, and for those at a bound
    the variance that they would have without it. ``freedom`` is the number of blocks less one:
    the degrees of freedom of Student's t.
    """

    coefficients: Floats  # (4,) or more
    covariance: Floats  # (4, 4)
    free: Bools  # (4,)
    at_bound: Bools  # (4,)
    residual: Floats  # (n,)
    freedom: int
    half_width_s: float
    rows: Rows

    @property
    def sigma(self) -> Floats:
        """Standard uncertainties, shape (4,)."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))

    def plain(self) -> Regression:
        """Of COLUMNS alone, as uncertain as beside the further terms."""
        n = len(COLUMNS)
        return replace(
            self, coefficients=self.coefficients[:n], covariance=self.covariance[:n, :n],
            free=self.free[:n], at_bound=self.at_bound[:n],
            rows=replace(self.rows, matrix=self.rows.matrix[:, :n]),
        )  # fmt: skip

    def widened(self, *moves: Floats) -> Regression:
        """As uncertain as independent moves (4,) of its free coefficients make it."""
        free = [np.where(self.free, move, 0.0) for move in moves]
        more = sum((np.outer(move, move) for move in free), np.zeros_like(self.covariance))
        return replace(self, covariance=self.covariance + more)


def solve(rows: Rows, wanted: Bools, known: Floats, half_width_s: float) -> Regression:
    """Least squares for the ``wanted`` columns; the others stay at ``known``.

    A friction that comes out negative is held at 0 and the rest solved again. The covariance is
    the delete-one-block jackknife's: blocks are stretches of motion, so that whatever correlates
    within a stretch is counted once. With three runs or more, leaving out one run at a time
    widens what it finds too narrow.
    """
    labels = blocks(rows)
    free, bound = wanted.copy(), np.zeros_like(wanted)
    values, covariance = _estimate(rows, labels, free, known)
    unbounded = np.diag(covariance)
    while negative := [column for column in _FRICTIONS if free[column] and values[column] < 0]:
        worst = min(negative, key=lambda column: values[column] / np.sqrt(unbounded[column]))
        free[worst], bound[worst] = False, True
        known = np.where(bound, 0.0, known)
        values, covariance = _estimate(rows, labels, free, known)
    covariance[bound, bound] = unbounded[bound]
    covariance = at_least(covariance, _between_runs(rows, free, known))
    return Regression(
        coefficients=values,
        covariance=covariance,
        free=free,
        at_bound=bound,
        residual=rows.drive - rows.matrix @ values,
        freedom=max(len(np.unique(labels)) - 1, 1),
        half_width_s=half_width_s,
        rows=rows,
    )


def _estimate(
    rows: Rows, labels: NDArray[np.int64], free: Bools, known: Floats
) -> tuple[Floats, Floats]:
    """Coefficients, and their covariance by leaving out one block of rows at a time."""
    drive = rows.drive - rows.matrix @ np.where(free, 0.0, known)
    scale = np.sqrt((rows.matrix**2).sum(axis=0))
    scale[scale == 0] = 1.0
    part = (rows.matrix / scale)[:, free]
    order = np.argsort(labels, kind="stable")
    edges = np.flatnonzero(np.diff(labels[order], prepend=-1))
    grams = np.add.reduceat(part[order, :, None] * part[order, None, :], edges)
    sides = np.add.reduceat(part[order] * drive[order, None], edges)
    every = np.where(free, 0.0, known)
    every[free] = np.linalg.lstsq(part, drive, rcond=None)[0] / scale[free]
    left_out = np.array([
        np.linalg.lstsq(gram, side, rcond=None)[0]
        for gram, side in zip(grams.sum(0) - grams, sides.sum(0) - sides, strict=True)
    ])  # fmt: skip
    spread = np.zeros((len(edges), len(scale)))
    spread[:, free] = (left_out - left_out.mean(axis=0)) / scale[free]
    return every, (len(edges) - 1) / len(edges) * spread.T @ spread


def _between_runs(rows: Rows, free: Bools, known: Floats) -> Floats:
    """Covariance by leaving out one run at a time; 0 where there are too few runs to tell."""
    runs = len(np.unique(rows.capture))
    if runs < FEWEST_RUNS:
        return np.zeros((len(free), len(free)))
    return _estimate(rows, rows.capture, free, known)[1]


def at_least(covariance: Floats, other: Floats) -> Floats:
    """The covariance, widened where the other has the larger variance."""
    mine, theirs = np.diag(covariance), np.diag(other)
    with np.errstate(divide="ignore", invalid="ignore"):
        widen = np.sqrt(np.where(mine > 0, np.maximum(theirs / mine, 1.0), 1.0))
    return np.asarray(covariance * np.outer(widen, widen))


def blocks(rows: Rows) -> NDArray[np.int64]:
    """A block number for each row: stretches of motion, cut or joined to a fair number."""
    labels = np.unique(rows.stretch, return_inverse=True)[1].astype(np.int64)
    while labels.max() + 1 < FEWEST_BLOCKS:
        sizes = np.bincount(labels)
        largest = int(sizes.argmax())
        if sizes[largest] < 2 * ROWS_A_BLOCK:
            break
        members = np.flatnonzero(labels == largest)
        labels[members[len(members) // 2 :]] = labels.max() + 1
    count = int(labels.max()) + 1
    if count > MOST_BLOCKS:
        labels = labels * MOST_BLOCKS // count
    return labels


def choose_width(
    candidates: Sequence[float], fit: Callable[[float], Regression | None], settled: bool = False
) -> Regression | None:
    """The answer at the bump width that knows the parameters best, with that choice's own share.

    Narrow bumps use more of the data; wide ones average away the speed's noise, delays between
    channels and what the model leaves out at high frequency. The least product of jackknife
    uncertainties wins. Where the model is right, half and double the width agree within that; where
    it is not, the answer moves, and its movement is added to the covariance (lack of fit).
    ``settled``: the movement counts in the choice as well.
    """
    found = [one for one in map(fit, sorted(candidates)) if one is not None]
    if not found:
        return None
    most = max(one.freedom for one in found)
    fair = [index for index, one in enumerate(found) if 2 * one.freedom >= most]
    if settled:
        return min((_with_move(found, index) for index in fair), key=_log_uncertainty)
    return _with_move(found, min(fair, key=lambda index: _log_uncertainty(found[index])))


def _with_move(found: Sequence[Regression], index: int) -> Regression:
    """One of these widths, as uncertain as its neighbours are elsewhere."""
    chosen = found[index]
    beside = [found[k] for k in (index - 1, index + 1) if 0 <= k < len(found)]
    moved = np.array([one.coefficients - chosen.coefficients for one in beside])
    moved = moved.reshape(len(beside), len(chosen.coefficients))
    shift = np.where(chosen.free, 1.0, 0.0) * moved
    extra = shift.T @ shift / max(len(beside), 1)
    return replace(chosen, covariance=chosen.covariance + extra)


def _log_uncertainty(one: Regression) -> float:
    """Of the coefficients by COLUMNS: further terms only help these."""
    sought = (one.free | one.at_bound)[: len(COLUMNS)]
    return float(np.log(np.maximum(one.sigma[: len(COLUMNS)][sought], 1e-300)).sum())
