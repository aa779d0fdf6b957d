"""A fit again with every reading worth the same: what it lacks then stays in the residuals.

Whitening and thinning take lack of fit for noise, as they must where nobody knows better. A
search for what is lacking looks before they do.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from motorid.estimate import motor_fit
from motorid.estimate.likelihood import maximise
from motorid.estimate.record import MotorRecord
from motorid.estimate.solution import Solution
from motorid.estimate.wider.fit import scales_of
from motorid.estimate.wider.record import WideRecord
from motorid.estimate.wider.terms import Term


def plain(
    records: Sequence[MotorRecord],
    solution: Solution,
    values: Mapping[str, float],
    taken: Sequence[Term],
) -> tuple[list[WideRecord], Solution]:
    """The records and the solution without weights, near ``solution``; terms ``taken`` are in."""
    free = [u.name for u in solution.unknowns]
    fixed = {name: value for name, value in values.items() if name not in free}
    scales = scales_of(records, values)
    wide = []
    for k, (record, own) in enumerate(zip(records, solution.own, strict=True)):
        priors = record.priors if isinstance(record, WideRecord) else {}
        bare = WideRecord(record, free, fixed, taken, scales, priors, k == 0)
        bare.step_as(record)
        names = (u.name for u in record.unknowns)
        bare.starting(dict(zip(names, own.tolist(), strict=True)))
        wide.append(bare)
    start = motor_fit.unknowns(wide, free, motor_fit.merged(values, solution))
    return wide, maximise(start, wide, enough=motor_fit.ROUGH)
