"""Statistical covariance of a fit: correlated residuals, and the spread between runs.

Search coordinates throughout (the logarithm of positive parameters): a standard deviation there is
a relative one. With white residuals the covariance is H⁻¹. Correlated ones make it H⁻¹ S H⁻¹,
where S sums the derivatives against the residuals' spectrum; that spectrum is autoregressive, of
the order that Schwarz's criterion chooses, so that white residuals change
nothing. Three runs or more also show their own spread, and that of the parts of their programs:
what every one of them pulls at the answer is compared with what noise would.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.solver.autoregression import autoregression, fast_length, power
from motorid.estimate.solver.dense_products import gram, square
from motorid.estimate.solver.problem import Linearised, Solution
from motorid.estimate.uncertainty.between_run_variance import pull, spread_of

Floats = NDArray[np.float64]

FEWEST_RUNS = 3  # that show a spread
LEAST = 1e-100  # information below it is none; the squares of its inverse can still be formed
NOISE, SPREAD, SCATTER = "noise", "spread between runs", "scatter of a log"  # lines of a budget
FLOOR = 1e-13  # of a scaled information's eigenvalues: beyond it nothing is known


@dataclass(frozen=True)
class Known:
    """What was supposed of the unknowns of records before any data.

    ``shifts`` (k, p) of the parameters in search coordinates for one standard deviation of each
    cause, by name; ``apart`` (p, p) or 0: their covariance if no two records shared a cause, which
    is how the search counts them.
    """

    shifts: Mapping[str, Floats] = field(default_factory=dict)
    apart: Floats | float = 0.0


NOTHING = Known()
NO_CAUSES: Mapping[str, Sequence[Floats]] = {}


@dataclass(frozen=True)
class Statistical:
    """``covariance`` (p, p) in search coordinates; ``freedom`` (p,) of each standard deviation.

    ``coloured`` is the largest factor by which correlated residuals widened a parameter. ``lines``:
    variances (p,) by cause, which sum to those of ``covariance``.
    """

    covariance: Floats
    freedom: Floats
    coloured: float
    between_runs: bool
    lines: Mapping[str, Floats] = field(default_factory=dict)

    @property
    def deviations(self) -> Floats:
        """Standard deviations, (p,)."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))


def covariance_of(information: Floats) -> Floats:
    """Inverse that grows without end, and never vanishes, along directions nobody can see."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(information), LEAST))
    # rounding may leave less than nothing of what nuisances explain: no correlation is beyond 1
    values, vectors = np.linalg.eigh(np.clip(information * scale[:, None] * scale, -1.0, 1.0))
    inverse = (vectors / np.maximum(values, FLOOR * values.max(initial=1.0))) @ vectors.T
    return np.asarray(inverse * np.outer(scale, scale))


def statistical(
    solution: Solution,
    known: Known = NOTHING,
    unseen: Mapping[str, Sequence[Floats]] = NO_CAUSES,
    parts: Sequence[NDArray[np.intp]] = (),
) -> Statistical:
    """Covariance of the shared parameters, those at a bound taken as free.

    ``known``: what the priors of records' unknowns leave open. ``unseen``, by cause: shifts (p,)
    by one standard deviation of noise that no residual shows. ``parts`` tell of every record which
    part of its program a residual (n,) belongs to.
    """
    inverse = covariance_of(solution.information)
    rows = sum(len(r.residual) for r in solution.records)
    few = rows / max(rows - len(solution.values) - sum(len(o) for o in solution.own), 1)
    white = (inverse - known.apart) * few
    scores = sum(
        (score_covariance(r) for r in solution.records), np.zeros_like(solution.information)
    )
    coloured = inverse @ scores @ inverse * few
    before, after = np.maximum(np.diag(white), 0.0), np.diag(coloured)
    # The residuals' colour may widen an interval; it is not trusted to narrow one.
    within = _with_variances(coloured, np.maximum(before, after))
    lines = {NOISE: np.diag(within).copy()}
    for causes in (known.shifts, unseen):
        for name, shifts in causes.items():
            if len(shifts):
                table = np.asarray(shifts)
                within = within + table.T @ table
                lines[name] = lines.get(name, 0.0) + (table**2).sum(axis=0)
    widening = float(np.sqrt(np.max(after / np.maximum(np.diag(inverse), 1e-300), initial=1.0)))
    freedom = np.full(len(before), np.inf)
    if len(solution.records) < FEWEST_RUNS:
        return Statistical(within, freedom, widening, False, lines)
    return _between(solution, inverse, Statistical(within, freedom, widening, True, lines), parts)


def _with_variances(covariance: Floats, variances: Floats) -> Floats:
    """The same correlations with other variances."""
    before = np.diag(covariance)
    some = before > 0.0
    ratio = np.sqrt(np.where(some, variances, 0.0) / np.where(some, before, 1.0))
    return np.asarray(covariance * np.outer(ratio, ratio) + np.diag(np.where(some, 0.0, variances)))


def _between(
    solution: Solution,
    inverse: Floats,
    within: Statistical,
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
    before = np.diag(within.covariance)
    total = np.maximum(before, spread)
    # what they show beyond white noise has their degrees, whatever explains it
    beyond = np.clip(spread - np.diag(inverse), 0.0, total)
    with np.errstate(over="ignore"):  # next to nothing beyond has degrees without an end
        freedom = np.where(beyond > 0, degrees * total**2 / np.maximum(beyond**2, 1e-300), np.inf)
    causes = dict(within.lines)
    if (total > before).any():
        causes[SPREAD] = total - before
    covariance = _with_variances(within.covariance, total)
    return replace(within, covariance=covariance, freedom=freedom, lines=causes)


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
        weights[[0, -1]] = 1.0  # a length that is even has its highest frequency once
        for half in (waves.real, waves.imag):
            total += gram(half * (spectrum * weights), half) / size
    return total
