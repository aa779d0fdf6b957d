"""Effects that were not found, by closed forms: their priors, lines and words."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

from motorid.estimate.assembly import untold
from motorid.estimate.effects.friction import windage
from motorid.estimate.effects.influence_quantity import Use
from motorid.estimate.effects.iron import armature_reaction, saturation
from motorid.estimate.effects.registry import used
from motorid.estimate.solver.problem import Unknown
from motorid.estimate.uncertainty.undetected import Undetected, told

R, L, K, B, J, T0 = 2.0, 1e-3, 0.01, 1e-6, 1e-6, 1e-3
FOUR = (
    windage.WINDAGE, armature_reaction.ARMATURE_REACTION, saturation.SATURATION,
)  # fmt: skip


@dataclass
class Driven:
    judged_at: Any = (R, L, K, B, J, T0)
    volts: Any = (0.0, 6.0, -3.0)
    held: Any = field(default_factory=dict)


@dataclass
class Solved:
    unknowns: Any = (Unknown("J", 1.0, log=True), Unknown("B", 0.0, 0.0))
    values: Any = (J, B)


def found(shares: tuple[float, float], left: float) -> Undetected:
    return Undetected(windage.WINDAGE, np.array([shares[0], shares[1] * B]), left)


def test_each_effect_that_may_be_there_is_looked_at() -> None:
    assert set(FOUR) <= set(used(Use.UNDETECTED))


def test_windage_has_a_quarter_of_the_viscous_torque_at_no_load() -> None:
    prior = windage.WINDAGE.prior(Driven(), 0)
    assert prior is not None
    top = 6.0 / K
    assert prior.sd * top**2 == pytest.approx(windage.USUAL * B * top)
    assert windage.WINDAGE.prior(Driven(judged_at=None), 0) is None
    undivided = windage.WINDAGE.prior(Driven((R, L, K, 0.0, J, T0), held={"B": 0.0}), 0)
    assert undivided is not None  # dry friction is all that is known of any
    assert undivided.sd * top**2 == pytest.approx(windage.USUAL * T0)


def test_what_the_readings_tell_is_a_line_and_the_rest_is_said() -> None:
    known, left = found((0.0, 0.01), 0.05), found((0.02, 0.2), 0.6)
    assert list(told([known])) == [windage.WINDAGE.name]
    assert told([left]) == {}
    (said,) = untold.suspects([left], Solved())  # type: ignore[arg-type]
    assert said.strength == "not excluded"
    assert "B by +20.0%" in said.evidence
    assert "J by +2.0%" in said.evidence
    assert untold.suspects([found((1e-5, 1e-5), 0.6)], Solved()) == ()  # type: ignore[arg-type]
