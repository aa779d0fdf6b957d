"""Pulses longer than any usual driver makes them are named; usual ones are not."""

from __future__ import annotations

import pytest

from motorid.estimate.diagnosis.faults.bridge.pulse_distortion import UNUSUAL, suspects
from motorid.estimate.effects.bridge.pulse_distortion import USUAL_S
from motorid.estimate.fit.joint_fit import solved
from motorid.estimate.results.estimate import Suspect
from tests.estimate.effects.bridge.commanded import longer_by


def found(seconds: float) -> list[Suspect]:
    return suspects(*solved([longer_by(seconds)], {}, ()))


@pytest.mark.slow
@pytest.mark.parametrize(("share", "said"), [(1.5, "longer"), (-1.5, "shorter")])
def test_an_unusual_one_is_named_with_its_size(share: float, said: str) -> None:
    (one,) = found(share * UNUSUAL * USUAL_S)
    assert (one.code, one.strength, one.allowed) == ("pulses_distorted", "named", True)
    assert f"ns {said} than the duty asks for" in one.evidence
    assert one.moves == {}


@pytest.mark.slow
def test_a_usual_one_is_not() -> None:
    assert found(0.5 * UNUSUAL * USUAL_S) == []
