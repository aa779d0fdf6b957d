"""Where a fit of two masses begins: a stiff shaft is no point to take a derivative at.

Shares of inertia, and resonances where the residuals' spectrum has peaks, are tried; the
parameters follow linearly.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.extended_capture_model import WideRecord
from motorid.estimate.model.extended_terms import TERMS, Term
from motorid.estimate.selection.extended_fit import scales_of
from motorid.estimate.selection.score_test import Candidate
from motorid.estimate.solver.autoregression import whitener
from motorid.estimate.solver.dense_products import project, square
from motorid.estimate.solver.problem import Linearised, Solution
from motorid.estimate.uncertainty.covariance import covariance_of

Floats = NDArray[np.float64]

SHARES = (0.3, 0.6, 0.85)
SWINGS = 5.0  # of the slowest resonance in a capture
PEAKS = 3  # of the residuals' spectrum that are tried
STANDS_OUT = 25.0  # a peak's power over the middle of its neighbours': noise reaches half of that
NEIGHBOURS = 100  # frequencies on either side, at most
NEAR = 2 / 3  # of a frequency: its neighbours reach from there to as far above; noise may be red
ABOUT = (0.98, 0.99, 1.0, 1.01, 1.02)  # times a peak's frequency
DAMPED = 0.02  # of critical
WORTH = 30.0  # of chi-square, that it must promise


Place = tuple[float, float]  # share of the inertia, resonance in rad/s


@dataclass(frozen=True)
class _Tried:
    """A shaft: chi-square that it leaves, the parameters' step (p,); no place: a stiff one."""

    left: float
    step: Floats
    place: Place | None


def springs(
    records: Sequence[MotorRecord],
    solution: Solution,
    values: Mapping[str, float],
    taken: Sequence[Term],
    asked: bool = False,
) -> list[Candidate]:
    """The stiffness and share of inertia that leave the least, if they leave less or are ``asked``.

    Where residuals are like noise there is nothing to explain.
    """
    term = TERMS["two-masses"]
    if term in taken or not (asked or _is_coloured(solution)):
        return []
    before = sum(square(line.residual) for line in solution.records)
    bare = _bare(records, solution, values)

    def best(places: Iterable[Place]) -> _Tried | None:
        tried = [_Tried(*_left(bare, solution, _shaft(values, *p)), p) for p in places]
        return min(tried, key=lambda one: one.left, default=None)

    found = best(product(SHARES, _resonances(records, solution)))
    if found is None:
        if not asked:
            return []
        found = _Tried(before, np.zeros(len(solution.values)), None)
    else:  # the other frequencies about a peak are tried for the best share alone
        share, peak = found.place or (0.0, 0.0)
        found = best((share, peak * about) for about in ABOUT) or found
    left, step = found.left, found.step
    start = _shaft(values, *found.place) if found.place else {}
    if before - left < WORTH and not asked:
        return []
    shift = step * solution.slopes
    moves = {u.name: float(move) for u, move in zip(solution.unknowns, shift, strict=True)}
    return [Candidate(term, before - left, moves, start, ())]


def _is_coloured(solution: Solution) -> bool:
    """Some channel's residuals have a spectrum that whitening would change."""
    return any(
        whitener(line.residual[part]) is not None
        for line in solution.records
        for part in line.slices
    )


def _resonances(records: Sequence[MotorRecord], solution: Solution) -> list[float]:
    """Where the residuals' spectra have their peaks, rad/s."""
    peaks = {
        float(peak)
        for k, record in enumerate(records)
        for left, m in zip(
            record.departures(solution.values, solution.own[k]), record.measured, strict=True
        )
        for peak in _peaks(left, (m.keep[-1] - m.keep[0]) * record.timeline.period_s)
    }
    return sorted(peaks)


def _shaft(values: Mapping[str, float], share: float, resonance: float) -> dict[str, float]:
    """A lightly damped shaft before that share of the inertia, with that resonance (rad/s)."""
    stiffness = values["J"] * share * (1 - share) * resonance**2
    return {"J2_share": share, "Ks": stiffness, "b": 2 * DAMPED * stiffness / resonance}


def _peaks(residual: Floats, duration_s: float) -> Floats:
    """The strongest frequencies (rad/s) of a residual whose slow part is taken off."""
    n = len(residual)
    power = np.abs(np.fft.rfft((residual - residual.mean()) * np.hanning(n))) ** 2
    top = 1 + np.flatnonzero((power[1:-1] > power[:-2]) & (power[1:-1] >= power[2:]))
    top = top[top > SWINGS]
    best = top[np.argsort(-power[top])][:PEAKS]
    middle = [np.median(power[_neighbours(int(k))]) for k in best]
    stands = best[power[best] > STANDS_OUT * np.array(middle)]
    return np.asarray(2 * np.pi * stands / duration_s, dtype=np.float64)


def _neighbours(k: int) -> slice:
    return slice(max(k - NEIGHBOURS, int(k * NEAR)), min(k + NEIGHBOURS, int(k / NEAR)) + 1)


def _bare(
    records: Sequence[MotorRecord], solution: Solution, values: Mapping[str, float]
) -> list[WideRecord]:
    """The records with a shaft that may be given, as they see noise."""
    free = (*(u.name for u in solution.unknowns), *TERMS["two-masses"].free)
    fixed = {n: v for n, v in values.items() if n not in free}
    scales = scales_of(records, values)
    out = []
    for record in records:
        taken = [t for t in TERMS.values() if t.phase and _has(record, t.phase.name)]
        wide = WideRecord(record, free, fixed, taken, scales, {}, first=False)
        wide.step_as(record)
        out.append(wide)
    return out


def _left(
    records: Sequence[WideRecord], solution: Solution, start: Mapping[str, float]
) -> tuple[float, Floats]:
    """Chi-square with such a shaft, once the shared parameters and nuisances have followed, and
    the parameters' step (p,) in search coordinates.
    """
    total, pull = 0.0, np.zeros(len(solution.values))
    shared = np.array([*solution.values, *(start[n] for n in TERMS["two-masses"].free)])
    for record, own, line in zip(records, solution.own, solution.records, strict=True):
        parts = record.residuals(shared, own)
        r = np.concatenate([p / s for p, s in zip(parts, line.sigmas, strict=True)])
        if not np.isfinite(r).all():
            return float("inf"), pull  # a spring too stiff to be followed
        total += square(r) - _explained(line, r)
        pull += project(line.orthogonal.T, r)
    step = covariance_of(solution.information) @ pull
    return total - float(pull @ step), step


def _has(record: MotorRecord, nuisance: str) -> bool:
    return any(u.name == nuisance for u in record.unknowns)


def _explained(line: Linearised, residual: Floats) -> float:
    """What the record's own nuisances take of it."""
    free, information = line.cleared()
    own = free.T
    if not len(own):
        return 0.0
    pull = project(own, residual)
    return float(pull @ covariance_of(information) @ pull)
