"""Suspects that are looked for when somebody asks: a station's verdict waits for none."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, overload

import numpy as np

from motorid.estimate.diagnosis import rank
from motorid.estimate.diagnosis.faults import scale_errors
from motorid.estimate.effects.brush_and_heating import lossless
from motorid.estimate.fit.joint_fit import solved
from motorid.estimate.fit.parameter_bounds import held_values
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import Parameter, Suspect
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty import intervals
from motorid.estimate.uncertainty.findings import findings

_Fit = tuple[list[MotorRecord], Solution, Mapping[str, Parameter]]


def without_loss(
    records: Sequence[MotorRecord], parameters: Mapping[str, Parameter]
) -> Mapping[str, Parameter]:
    """The parameters of a fit whose brushes drop nothing and whose winding stays as it is."""
    held = {
        n: p.value for n, p in parameters.items() if p.status == "fixed" and p.value is not None
    }
    found = solved([lossless(record.capture) for record in records], held, ())
    return intervals.parameters(findings(*found, held_values(held, ()), ()))


class Suspects(Sequence[Suspect]):
    """The suspects of one fit, found at the first question and kept."""

    def __init__(
        self,
        records: Sequence[MotorRecord],
        solution: Solution,
        parameters: Mapping[str, Parameter],
    ) -> None:
        self._of: _Fit | None = ([record.twin() for record in records], solution, parameters)
        self._found: tuple[Suspect, ...] | None = None

    def look(self) -> tuple[Suspect, ...]:
        """The suspects, looked for anew as long as nobody has asked for them."""
        if self._of is None:
            return self._all()
        records, solution, parameters = self._of
        plate = scale_errors.read_nameplate(records[0].capture.stated.nameplate)
        top = max(float(np.abs(record.volts).max()) for record in records)
        if scale_errors.absurd(
            parameters, plate, top
        ):  # brushes would take what they can of the misfit
            parameters = without_loss(records, parameters)
        scales = scale_errors.suspects(parameters, plate, top)
        if scale_errors.absurd(parameters, plate, top) and scales[0].strength == "named":
            return scales  # volts a thousand times too high misfit in every other way as well
        found = rank.suspects(records, solution)
        if rank.spoiling(found):  # then the parameters say nothing of scales
            scales = scale_errors.suspects(parameters, {})
        return found + scales

    def _all(self) -> tuple[Suspect, ...]:
        if self._found is None:
            self._found = self.look()
            self._of = None  # the records are large
        return self._found

    @overload
    def __getitem__(self, index: int) -> Suspect: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[Suspect, ...]: ...
    def __getitem__(self, index: int | slice) -> Suspect | tuple[Suspect, ...]:
        return self._all()[index]

    def __len__(self) -> int:
        return len(self._all())

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Sequence) and self._all() == tuple(other)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return "Suspects(not looked for yet)" if self._found is None else repr(self._found)

    def __reduce__(self) -> tuple[Any, ...]:
        return tuple, (self._all(),)
