"""What no model explains moves the parameters by as much as the parts of the program disagree.

A lack of fit that a named fault explains, or that was large enough to be sized before, is left as
it is. So is one of less than twice the noise that its channel declares: parts of a program differ
by as much, and every motor has a little of what no model has.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from motorid.estimate.assembly.doubt import SHARE, settled
from motorid.estimate.diagnosis import misfit
from motorid.estimate.diagnosis.reach import LACK, disagreement
from motorid.estimate.diagnosis.residual_remarks import declared_noise
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import Estimate
from motorid.estimate.solver.dense_products import square
from motorid.estimate.solver.problem import Solution

MUCH = 2.0  # times the noise that a channel declares


def with_lack(estimate: Estimate, records: Sequence[MotorRecord], solution: Solution) -> Estimate:
    """The estimate whose lack of fit, if it has one, states its moves.

    ``solution`` of ``records`` is that of the last model: the six parameters', or the better one's.
    """
    lacks = [k for k, one in enumerate(estimate.diagnostics) if one.code == LACK]
    sized = any(one.moves for one in estimate.suspects)
    if not lacks or sized or any(estimate.diagnostics[k].moves for k in lacks):
        return estimate
    if not _is_much(records, solution):
        return estimate
    moves = {}
    for name, move in disagreement(records, solution).items():
        p = estimate.parameters.get(name)
        if p is None or p.value is None or p.interval_95 is None:
            continue
        if move > SHARE * (p.interval_95[1] - p.interval_95[0]) / 2.0:
            moves[name] = move
    if not moves:
        return estimate
    said = list(estimate.diagnostics)
    said[lacks[0]] = replace(said[lacks[0]], moves=moves)
    return settled(replace(estimate, diagnostics=tuple(said)), [said[lacks[0]]])


def _is_much(records: Sequence[MotorRecord], solution: Solution) -> bool:
    """The residuals of some channel are more than twice the noise that it declares."""
    left = misfit.residuals(records, solution)
    return any(
        square(r) > (MUCH * declared_noise(m)) ** 2 * m.block.count > 0.0
        for record, blocks in zip(records, left, strict=True)
        for m, r in zip(record.measured, blocks, strict=True)
    )
