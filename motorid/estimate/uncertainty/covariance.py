"""Statistical covariance of a fit: correlated residuals, and the spread between runs.

Search coordinates throughout (the logarithm of positive parameters): a standard deviation there is
a relative one. With white residuals the covariance is H⁻¹. Correlated ones make it H⁻¹ S H⁻¹,
where S sums the derivatives against the residuals' spectrum; that spectrum is autoregressive, of
the order that Schwarz's criterion chooses, so that white residuals change
nothing. Three runs or more also show their own spread, and that of the parts of their programs:
what every one of them pulls at the answer is compared with what noise would.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.solver.autoregression import autoregression, fast_length, power
from motorid.estimate.solver.dense_products import gram, square
from motorid.estimate.solver.problem import Linearised, Solution
from motorid.estimate.uncertainty.between_run_variance import pull, spread_of

Floats = NDArray[np.float64]

FEWEST_RUNS = 3  # that show a spread
NOTHING = 1e-100  # information below it is none; the squares of its inverse can still be formed
FLOOR = 1e-13  # of a scaled information's eigenvalues: beyond it nothing is known


@dataclass(frozen=True)
class Statistical:
    """``covariance`` (p, p) in search coordinates; ``freedom`` (p,) of each standard deviation.

    ``coloured`` is the largest factor by which correlated residuals widened a parameter.
    """

    covariance: Floats
    freedom: Floats
    coloured: float
    between_runs: bool

    @property
    def deviations(self) -> Floats:
        """Standard deviations, (p,)."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))


def covariance_of(information: Floats) -> Floats:
    """Inverse that grows without end, and never vanishes, along directions nobody can see."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(information), NOTHING))
    # rounding may leave less than nothing of what nuisances explain: no correlation is beyond 1
    values, vectors = np.linalg.eigh(np.clip(information * scale[:, None] * scale, -1.0, 1.0))
    inverse = (vectors / np.maximum(values, FLOOR * values.max(initial=1.0))) @ vectors.T
    return np.asarray(inverse * np.outer(scale, scale))


def statistical(
    solution: Solution,
    shifts: Sequence[Floats] = (),
    parts: Sequence[NDArray[np.intp]] = (),
) -> Statistical:
    """Covariance of the shared parameters, those at a bound taken as free.

    ``shifts`` (p,) each are what one standard deviation of noise does that no residual shows;
    ``parts`` tell of every record which part of its program a residual (n,) belongs to.
    """
    inverse = covariance_of(solution.information)
    rows = sum(len(r.residual) for r in solution.records)
    few = rows / max(rows - len(solution.values) - sum(len(o) for o in solution.own), 1)
    white = inverse * few
    scores = sum(
        (score_covariance(r) for r in solution.records), np.zeros_like(solution.information)
    )
    coloured = inverse @ scores @ inverse * few
    before, after = np.diag(white), np.diag(coloured)
    # The residuals' colour may widen an interval; it is not trusted to narrow one.
    within = _with_variances(coloured, np.maximum(before, after))
    for shift in shifts:
        within = within + np.outer(shift, shift)
    widening = float(np.sqrt(np.max(after / np.maximum(before, 1e-300), initial=1.0)))
    freedom = np.full(len(before), np.inf)
    if len(solution.records) < FEWEST_RUNS:
        return Statistical(within, freedom, widening, False)
    return _between(solution, inverse, within, widening, parts)


def _with_variances(covariance: Floats, variances: Floats) -> Floats:
    """The same correlations with other variances."""
    before = np.diag(covariance)
    some = before > 0.0
    ratio = np.sqrt(np.where(some, variances, 0.0) / np.where(some, before, 1.0))
    return np.asarray(covariance * np.outer(ratio, ratio) + np.diag(np.where(some, 0.0, variances)))


def _between(
    solution: Solution,
    inverse: Floats,
    within: Floats,
    widening: float,
    parts: Sequence[NDArray[np.intp]],
) -> Statistical:
    """Adds what runs, and their parts, scatter beyond their noise; Welch-Satterthwaite freedom."""
    lines = solution.records
    spread, degrees = spread_of([pull(line, slice(None)) for line in lines], inverse)
    if parts:
        each = zip(lines, parts, strict=True)
        pulls = [pull(line, part == k) for line, part in each for k in np.unique(part)]
        finer, more = spread_of(pulls, inverse)
        spread, degrees = np.maximum(spread, finer), np.where(finer > spread, more, degrees)
    total = np.maximum(np.diag(within), spread)
    # what they show beyond white noise has their degrees, whatever explains it
    beyond = np.clip(spread - np.diag(inverse), 0.0, total)
    freedom = np.where(beyond > 0, degrees * total**2 / np.maximum(beyond**2, 1e-300), np.inf)
    return Statistical(_with_variances(within, total), freedom, widening, True)


def score_covariance(record: Linearised) -> Floats:
    """Sum over blocks of derivatives against the residuals' spectrum, (p, p)."""
    p = record.orthogonal.shape[1]
    total = np.zeros((p, p))
    for part in record.slices:
        columns, residual = record.orthogonal[part], record.residual[part]
        variance = square(residual) / max(len(residual), 1)
        coefficients, innovation = autoregression(residual)
        if not len(coefficients):
            total += max(variance, 1.0) * gram(columns.T, columns.T)
            continue
        size = fast_length(2 * len(residual))
        spectrum = power(coefficients, innovation, size)
        waves = np.fft.rfft(columns.T, size, axis=1)
        weights = np.full(len(spectrum), 2.0)
        weights[0] = 1.0
        if size % 2 == 0:
            weights[-1] = 1.0
        for half in (waves.real, waves.imag):
            total += gram(half * (spectrum * weights), half) / size
    return total
