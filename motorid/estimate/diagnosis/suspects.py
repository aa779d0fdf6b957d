"""What may have spoiled a measurement: faults of the measuring chain, then scales."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from motorid.capture.model import POSITION
from motorid.estimate.diagnosis import rank
from motorid.estimate.diagnosis.faults import scale_errors
from motorid.estimate.effects.brush_and_heating import lossless
from motorid.estimate.fit.joint_fit import solved
from motorid.estimate.fit.parameter_bounds import held_values
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import Parameter, Suspect
from motorid.estimate.results.status import Status
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty import intervals
from motorid.estimate.uncertainty.findings import findings


def suspects(
    records: Sequence[MotorRecord],
    solution: Solution,
    parameters: Mapping[str, Parameter],
    tried: bool = True,
) -> tuple[tuple[Suspect, ...], rank.Convicted | None]:
    """Faults that these captures show, the surest first, and scales that they cannot check; and
    which of them a fit convicted.

    Fits with a fault as an unknown are made only where the residuals leave something to explain,
    and where ``tried``.
    """
    records = [record.twin() for record in records]  # trials judge sources anew
    plate = scale_errors.read_nameplate(records[0].capture.stated.nameplate)
    top = max(float(np.abs(record.volts).max()) for record in records)
    bare = parameters
    if scale_errors.absurd(
        parameters, plate, top
    ):  # brushes would take what they can of the misfit
        bare = without_loss(records, parameters)
    turned = any(POSITION in record.capture.channels for record in records)
    scales = scale_errors.suspects(bare, plate, top, turned, parameters)
    if scale_errors.absurd(bare, plate, top) and scales[0].strength == "named":
        return scales, None  # volts a thousand times too high misfit in every other way as well
    found, convicted = tuple(rank.direct(records)), None
    if tried:
        found, convicted = rank.suspects(records, solution, parameters)
    if rank.spoiling(found):  # then the parameters say nothing of scales
        scales = scale_errors.suspects(parameters, {}, turned=turned)
    return found + scales, convicted


def without_loss(
    records: Sequence[MotorRecord], parameters: Mapping[str, Parameter]
) -> Mapping[str, Parameter]:
    """The parameters of a fit whose brushes drop nothing and whose winding stays as it is."""
    held = {
        n: p.value
        for n, p in parameters.items()
        if p.status is Status.FIXED and p.value is not None
    }
    found = solved([lossless(record.capture) for record in records], held, ())
    return intervals.parameters(findings(*found, held_values(held, ()), ()))
