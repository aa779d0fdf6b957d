"""Where a fit of two masses begins: a stiff shaft is no point to take a derivative at."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from motorid.estimate.record import MotorRecord
from motorid.estimate.solution import Solution
from motorid.estimate.wider.screen import Candidate
from motorid.estimate.wider.terms import Term


def springs(
    records: Sequence[MotorRecord],
    solution: Solution,
    values: Mapping[str, float],
    taken: Sequence[Term],
) -> list[Candidate]:
    """The stiffness and share of inertia that leave the least, if they leave less."""
    return []
