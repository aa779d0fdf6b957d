"""A current that is read through a capacitor, as of a probe set to AC, or of a transformer.

A time constant as long as the record leaves hardly a residual in a log: the current that friction
takes fades by a few per cent, and K, B, J follow it. A fit with the high-pass tells it all the
same, as it moves them far and lets the current's misfit fall. What a motor or a channel's zero may
do instead has a fit of its own.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT
from motorid.estimate.diagnosis import misfit
from motorid.estimate.diagnosis.fault import Hypothesis, Words, acting
from motorid.estimate.diagnosis.faults import model_alternatives
from motorid.estimate.diagnosis.faults.zeros import current_zero, voltage_zero
from motorid.estimate.diagnosis.refit import Refit, refit, residuals, starts
from motorid.estimate.diagnosis.score_test import Screen
from motorid.estimate.effects.reading.current_coupling import CURRENT_COUPLING, bounds, record_s
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import Suspect
from motorid.estimate.solver.autoregression import inflation
from motorid.estimate.solver.dense_products import square
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.covariance import covariance_of

Floats = NDArray[np.float64]

CODE = "current_coupled"
RIVALS = (model_alternatives, current_zero, voltage_zero)  # what else changes a steady current
RECORDS = (0.3, 1.0, 3.0, 10.0)  # time constants that are tried, in lengths of the record
HINTED = 15.0  # fall of F by the fit's derivatives, of a log that a fit looks at,
SURELY = 30.0  # and of the current's part of F by that fit, and beyond what a motor does by itself
ENOUGH, STEPS = 0.1, 60  # such fits end far nearer to their minimum than those of larger faults
FAR = 4.0  # standard deviations by noise, that it moves a parameter: else no one is hurt


def suspects(records: Sequence[MotorRecord], solution: Solution) -> list[Suspect]:
    """One, where a log's current is shown so.

    The current's part of F counts alone: a position adds up what the log's voltage leaves open, of
    which anything slow explains some.
    """
    found = hypotheses(records)
    if not found or any(record.sensed.waveform is None for record in records):
        return []
    hypothesis, most = found[0], inflation(solution)
    if Screen(records, solution).best(hypothesis).gain < HINTED * most:
        return []
    best = _best(records, solution, hypothesis)
    moved = _moved(solution, best)
    if not hypothesis.lower[0] < best.size[0] < hypothesis.upper[0] or not moved:
        return []
    left = _of_current(records, residuals(records, best, hypothesis)) + SURELY * most
    usual = refit(records, starts(records, solution), enough=ENOUGH, steps=STEPS)
    if _of_current(records, misfit.residuals(records, usual.search)) < left:
        return []
    for other in (h for rivals in RIVALS for h in rivals.hypotheses(records)):
        rival = _best(records, solution, other)
        if _of_current(records, residuals(records, rival, other)) < left:
            return []
    words = hypothesis.words(best.size)
    return [Suspect(CODE, words.where, words.evidence, words.action, "named", moved)]


def _best(records: Sequence[MotorRecord], solution: Solution, hypothesis: Hypothesis) -> Refit:
    """The best fit with a fault, from every second of its sizes. A friction that the fault took to
    zero stays there, so that closed forms begin as well.
    """
    begin, sizes = starts(records, solution), hypothesis.sizes[::2]
    found = [refit(records, begin, hypothesis, size, ENOUGH, STEPS) for size in sizes]
    return min(found, key=lambda one: one.objective)


def _of_current(records: Sequence[MotorRecord], left: Sequence[Sequence[Floats]]) -> float:
    """The current's part of F, but for a constant, of residuals as weighed."""
    return sum(
        m.block.count * math.log(max(square(r) / len(r), 1e-300))
        for record, blocks in zip(records, left, strict=True)
        for m, r in zip(record.measured, blocks, strict=True)
        if m.block.name == CURRENT
    )


def _moved(solution: Solution, best: Refit) -> dict[str, float]:
    """SI, by parameter: how far the fault moved it; empty: none by enough."""
    deviations = solution.slopes * np.sqrt(np.diag(covariance_of(solution.information)))
    moves = np.abs(best.values - solution.values)
    if not (moves > FAR * deviations)[deviations > 0.0].any():
        return {}
    return {u.name: float(m) for u, m in zip(solution.unknowns, moves, strict=True)}


def hypotheses(records: Sequence[MotorRecord]) -> list[Hypothesis]:
    """Of a current with a sign that every record has."""
    blocks = [record.block(CURRENT) for record in records]
    if any(m is None or m.unsigned for m in blocks):
        return []
    longest_s = max(map(record_s, records))
    most = min(bounds(record)[1] for record in records)

    def words(size: Floats) -> Words:
        time_s = 1.0 / float(size[0])
        return Words(
            "current",
            f"the current is AC-coupled: it reads as behind a high-pass of "
            f"{1.0 / (2.0 * math.pi * time_s):.2g} Hz (time constant {time_s:.2g} s), through "
            "which a steady current fades",
            CURRENT_COUPLING.remedy,
        )

    return [
        Hypothesis(
            CODE, acting(CURRENT_COUPLING), tuple((1.0 / (k * longest_s),) for k in RECORDS),
            (1.0 / longest_s,), (0.0,), (most,), words, quantity=CURRENT_COUPLING,
        )
    ]  # fmt: skip
