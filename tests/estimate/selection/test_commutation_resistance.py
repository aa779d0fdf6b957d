"""R that rises with speed, by the simulated rig, whose plant shares no code with the fit."""

from __future__ import annotations

from pathlib import Path

import pytest

from motorid.program import Decay, Program, Step, StepKind
from tests.estimate.selection.test_iron import covers, measured, named
from tests.six_parameters import fit

SHARE, LIFT = 0.07, 470.0  # of R at V/K, 781 rad/s
LEVELS = (3.0, 6.0, 2.5)
SHORT = Program(
    (
        Step(StepKind.COAST, 0.02),
        *(Step(StepKind.DRIVE_VOLTS, 0.06, v, Decay.SYNCHRONOUS_SLOW) for v in LEVELS),
        Step(StepKind.COAST, 0.1),
    )
)


def rise(true: dict[str, float], above: float) -> float:
    """Ω·s/rad that the option stands for."""
    return SHARE * true["R_25"] / (true["nominal_v"] / true["K_25"] - above)


@pytest.mark.slow
def test_what_commutation_adds_to_r_is_named_and_r_is_that_at_no_speed(tmp_path: Path) -> None:
    """As of brushes that lift: from a speed on."""
    options = f"commutation={SHARE}&commutation_speed={LIFT}"
    capture, true = measured(tmp_path, options, SHORT)
    estimate = fit([capture], model="auto")
    assert named(estimate) == ("commutation-resistance",)
    found = estimate.alternative.parameters
    assert covers(found["c_R"], rise(true, LIFT))
    assert covers(found["w_R"], LIFT)
    assert found["R"].value == pytest.approx(true["R"], rel=0.005)
    headline = estimate.parameters["R"]
    assert headline.status == "doubtful"
    assert abs(headline.value / true["R"] - 1.0) > 0.02
    assert all(covers(estimate.parameters[n], true[n]) for n in ("R", "L", "K", "B", "J", "T0"))


@pytest.mark.slow
def test_a_rise_from_no_speed_on_leaves_its_speed_at_nothing(tmp_path: Path) -> None:
    capture, true = measured(tmp_path, f"commutation={SHARE}", SHORT)
    estimate = fit([capture], model="commutation-resistance")
    found = estimate.alternative.parameters
    assert covers(found["c_R"], rise(true, 0.0))
    assert found["w_R"].value in (None, 0.0) or covers(found["w_R"], 0.0)
    assert found["R"].value == pytest.approx(true["R"], rel=0.005)
