"""What no model explains moves the parameters by as much as the parts of the program disagree.

A lack of fit that a named fault explains, or that was large enough to be sized before, is left as
it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from motorid.estimate.assembly.doubt import SHARE, settled
from motorid.estimate.diagnosis.reach import LACK, disagreement
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import Estimate
from motorid.estimate.solver.problem import Solution


def with_lack(estimate: Estimate, records: Sequence[MotorRecord], solution: Solution) -> Estimate:
    """The estimate whose lack of fit, if it has one, states its moves.

    ``solution`` of ``records`` is that of the last model: the six parameters', or the better one's.
    """
    lacks = [k for k, one in enumerate(estimate.diagnostics) if one.code == LACK]
    sized = any(one.moves for one in estimate.suspects)
    if not lacks or sized or any(estimate.diagnostics[k].moves for k in lacks):
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
