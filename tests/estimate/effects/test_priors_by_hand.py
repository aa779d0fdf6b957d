"""When a quantity is there and how large it may be, on subjects made by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.effects.iron.armature_reaction import ARMATURE_REACTION
from motorid.estimate.effects.iron.eddies_in_pulses import EDDIES_IN_PULSES
from motorid.estimate.effects.iron.eddy_currents import EDDY_CURRENTS
from motorid.estimate.effects.iron.saturation import SATURATION
from motorid.estimate.effects.iron.share_of_inductance import ShareOfInductance, usual
from motorid.estimate.effects.source.commutation_resistance import COMMUTATION_RESISTANCE
from motorid.estimate.effects.source.duty_of_volts import DUTY_OF_VOLTS
from motorid.estimate.signals.time_grid import Part
from motorid.program import Decay, StepKind

MOTOR = np.array([2.0, 1e-3, 0.05, 4e-5, 2e-5, 6e-3])
STALL_A = 8.0 / 2.0


def judged(motor: np.ndarray | None = MOTOR) -> Any:
    return SimpleNamespace(judged_at=motor, volts=np.array([3.0, -8.0]))


def test_iron_is_expected_at_the_stall_current_of_the_motor() -> None:
    """2 % of K is gone there, and a fifth of L far beyond; half of that at half of the current."""
    reaction = ARMATURE_REACTION.prior(judged(), 0)
    assert reaction is not None
    assert (reaction.sd * STALL_A, reaction.mean) == (pytest.approx(0.02), 0.0)
    assert ARMATURE_REACTION.scale(judged()) == pytest.approx(1.0 / STALL_A)
    iron = SATURATION.prior(judged(), 0)
    assert iron is not None
    assert (iron.sd, iron.mean) == (0.2, 0.0)
    eddies = EDDY_CURRENTS.prior(judged(), 0)
    assert eddies is not None
    assert (eddies.sd, eddies.mean) == (0.2, 0.0)
    setup: Any = SimpleNamespace(motor={})
    (act,) = SATURATION.acts
    for size in (0.1, 0.05):  # of which the second comes on top
        act(setup, judged(), 0, size)  # type: ignore[operator]
    assert setup.motor["saturation"] == pytest.approx(0.15)
    assert setup.motor["saturation_current"] == pytest.approx(STALL_A / 2)
    (act,) = EDDY_CURRENTS.acts
    for size in (0.1, -0.04):
        act(setup, judged(), 0, size)  # type: ignore[operator]
    assert setup.motor["eddy"] == pytest.approx(0.06)
    assert setup.motor["eddy_time"] == pytest.approx(1e-4, rel=0.06)


def test_the_time_constant_of_eddies_has_a_uniform_prior_in_its_logarithm() -> None:
    """Between 30 and 300 us: forms with their chances have its mean and variance."""
    chances, times = [], []
    for chance, form in EDDY_CURRENTS.shaped:
        setup: Any = SimpleNamespace(motor={})
        (act,) = form.acts
        act(setup, judged(), 0, 0.1)  # type: ignore[operator]
        chances.append(chance)
        times.append(math.log(setup.motor["eddy_time"]))
    assert sum(chances) == pytest.approx(1.0)
    mean = float(np.average(times, weights=chances))
    assert mean == pytest.approx(math.log(3e-5 * 3e-4) / 2)
    spread = float(np.average((np.array(times) - mean) ** 2, weights=chances))
    assert spread == pytest.approx(math.log(10.0) ** 2 / 12.0)
    assert [one for _, one in SATURATION.shaped] == [SATURATION]


def test_commutation_is_expected_to_add_to_r_at_the_speed_of_the_highest_voltage() -> None:
    """1 % of R there; its size counts in R over that speed, 8 V over K."""
    top = 8.0 / MOTOR[2]
    prior = COMMUTATION_RESISTANCE.prior(judged(), 0)
    assert prior is not None
    assert (prior.sd * top, prior.mean) == (pytest.approx(0.01 * MOTOR[0]), 0.0)
    assert COMMUTATION_RESISTANCE.scale(judged()) * top == pytest.approx(MOTOR[0])
    assert COMMUTATION_RESISTANCE.prior(judged(None), 0) is None


def test_nothing_is_expected_of_iron_before_a_motor_is_known_or_without_an_inductance() -> None:
    assert ARMATURE_REACTION.prior(judged(None), 0) is None
    assert SATURATION.prior(judged(None), 0) is None
    assert EDDY_CURRENTS.prior(judged(None), 0) is None
    bare = MOTOR.copy()
    bare[1] = 0.0
    assert SATURATION.prior(judged(bare), 0) is EDDY_CURRENTS.prior(judged(bare), 0) is None
    assert ARMATURE_REACTION.prior(judged(bare), 0) is not None


def test_a_share_of_an_inductance_brings_along_where_it_sets_in() -> None:
    act = ShareOfInductance("saturation", "saturation_current", lambda subject: subject.knee_a)
    setup: Any = SimpleNamespace(motor={"saturation": 0.1})
    act(setup, SimpleNamespace(knee_a=3.0), 0, 0.05)
    assert setup.motor == {"saturation": pytest.approx(0.15), "saturation_current": 3.0}
    assert act.simulated
    found = usual(0.3)(judged(), 0)
    assert found is not None
    assert (found.sd, found.mean) == (0.3, 0.0)


@pytest.mark.parametrize(
    ("period_s", "pulsed", "held", "there"),
    [(2.6e-3, True, None, True), (2.4e-3, True, None, False), (2.6e-3, False, None, False),
     (2.6e-3, True, "held", False)],
)  # fmt: skip
def test_eddy_currents_are_expected_where_pulses_alone_tell_the_inductance(
    period_s: float, pulsed: bool, held: str | None, there: bool
) -> None:
    """L/R is .5 ms: a fifth of 2.5 ms."""
    parts = [SimpleNamespace(discontinuous=False), SimpleNamespace(discontinuous=pulsed)]
    subject: Any = SimpleNamespace(
        judged_at=MOTOR, foretold=held, shown_parts=parts,
        timeline=SimpleNamespace(period_s=period_s),
    )  # fmt: skip
    prior = EDDIES_IN_PULSES.prior(subject, 0)
    assert (prior is not None) is there
    if prior is not None:
        assert (prior.sd, prior.mean) == (pytest.approx(0.15 * MOTOR[1]), 0.0)
        assert EDDIES_IN_PULSES.scale(subject) == pytest.approx(MOTOR[1])
    subject.judged_at = None
    assert EDDIES_IN_PULSES.prior(subject, 0) is None


SLOW, FAST, NONE = Decay.SYNCHRONOUS_SLOW, Decay.FAST, Decay.NONE
VOLTS, DUTY = StepKind.DRIVE_VOLTS, StepKind.DRIVE_DUTY


@pytest.mark.parametrize(
    ("kind", "decay", "gain", "supply", "there"),
    [
        (VOLTS, SLOW, 0.01, False, True), (DUTY, SLOW, 0.01, False, False),
        (VOLTS, NONE, 0.01, False, False), (VOLTS, SLOW, 0.0, False, False),
        (VOLTS, SLOW, 0.01, True, False),
    ],
)  # fmt: skip
def test_a_duty_is_unknown_where_a_board_makes_volts_of_a_supply_that_nobody_read(
    kind: StepKind, decay: Decay, gain: float, supply: bool, there: bool
) -> None:
    parts = (Part(0, 5), Part(5, 9, kind, 3.0, decay))
    subject: Any = SimpleNamespace(
        timeline=SimpleNamespace(parts=parts), sensed=SimpleNamespace(gain_uncertainty=gain),
        capture=SimpleNamespace(get=lambda _: 1 if supply else None),
    )  # fmt: skip
    prior = DUTY_OF_VOLTS.prior(subject, 0)
    assert (prior is not None) is there
    assert prior is None or prior.sd == gain
