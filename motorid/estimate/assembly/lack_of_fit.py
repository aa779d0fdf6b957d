"""What no model explains moves the parameters by as much as the parts of the program disagree.

A lack of fit that a named fault explains, or that was large enough to be sized before, is left as
it is. So is one of less than twice the noise that its channel declares: parts of a program differ
by as much, and every motor has a little of what no model has.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from motorid.estimate.assembly.doubt import settled
from motorid.estimate.diagnosis import input_noise, misfit, residual_remarks
from motorid.estimate.diagnosis.reach import LACK, disagreement, movable, stating
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import Estimate
from motorid.estimate.solver.problem import Solution

MUCH = 2.0  # times the noise of a channel


def with_lack(estimate: Estimate, records: Sequence[MotorRecord], solution: Solution) -> Estimate:
    """The estimate whose lack of fit, if it has one, states its moves.

    ``solution`` of ``records`` is that of the last model: the six parameters', or the better one's.
    """
    lacks = [one for one in estimate.diagnostics if one.code == LACK]
    sized = any(one.moves for one in lacks) or any(one.moves for one in estimate.suspects)
    if not lacks or sized:
        return estimate
    if not _is_much(records, solution):
        return estimate
    moves = movable(disagreement(records, solution), estimate.parameters)
    if not moves:
        return estimate
    said = stating(estimate.diagnostics, moves)
    finding = next(one for one in said if one.code == LACK)
    return settled(replace(estimate, diagnostics=said), [finding])


def _is_much(records: Sequence[MotorRecord], solution: Solution) -> bool:
    """The residuals of some channel are more than twice its noise."""
    left = misfit.residuals(records, solution)
    driven = input_noise.where_lacking(records, solution, left)
    return any(
        residual_remarks.lacking(record, m, r, more) > MUCH
        for record, blocks, variances in zip(records, left, driven, strict=True)
        for m, r, more in zip(record.measured, blocks, variances, strict=True)
    )
