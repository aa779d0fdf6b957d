"""Effects that a run does not show: what they would do, and a word of what would show them."""

from __future__ import annotations

import re

import numpy as np
import pytest

from motorid.estimate.effects.friction.load_friction import USUAL
from motorid.estimate.fit import joint_fit
from motorid.estimate.results.estimate import Estimate
from motorid.estimate.uncertainty import undetected
from motorid.estimate.uncertainty.findings import findings
from motorid.report import suspects
from tests.exact_capture import FAULHABER, Plan, clean_capture, noisy
from tests.six_parameters import fit


def fitted(*volts: float) -> Estimate:
    return fit([noisy(clean_capture(FAULHABER, Plan(volts=volts)), 1, 1e-2, 1e-3)], model="six")


@pytest.mark.slow
def test_driving_and_coasting_leave_load_friction_to_its_prior() -> None:
    """Forwards, c makes J, B and T0 larger by c alike, and no residual tells it."""
    found = fitted(3.0, 6.0)
    for name in ("J", "B", "T0"):
        assert "load friction" not in found.budget[name]
    (hidden,) = (s for s in found.suspects if s.code == "load_friction")
    assert (hidden.strength, hidden.allowed) == ("not excluded", False)
    said = dict(re.findall(r"(\w+) by ([-+][\d.]+)%", hidden.evidence))
    for name in ("J", "B", "T0"):
        assert abs(float(said[name])) == pytest.approx(100 * USUAL, rel=0.5)
    assert "load friction" in suspects.hidden(found)
    assert "brakes" in suspects.hidden(found)


@pytest.mark.slow
def test_a_step_down_brakes_the_motor_and_tells_it() -> None:
    found = fitted(6.0, 2.0)
    line = found.budget["J"].get("load friction", 0.0)
    assert line < 0.1 * USUAL * found.parameters["J"].value
    assert "load_friction" not in {s.code for s in found.suspects}
    assert found.parameters["J"].total < 0.01 * found.parameters["J"].value


@pytest.mark.slow
def test_what_is_no_answer_is_not_asked_what_effects_leave_open_of_it() -> None:
    capture = noisy(clean_capture(FAULHABER, Plan(volts=(3.0, 6.0))), 1, 1e-2, 1e-3)
    records, solution = joint_fit.solved([capture], {}, ())
    responses = records[0].simulated
    assert findings(records, solution, {}, (), profiled=False, answers=False).undetected == ()
    fewer = records[0].simulated - responses
    assert findings(records, solution, {}, (), profiled=False).undetected
    assert records[0].simulated - responses > 2 * fewer


def test_an_effect_beside_which_no_motor_has_readings_has_no_line(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """An inductance of next to nothing, as a misfit may leave it."""
    capture = noisy(clean_capture(FAULHABER, Plan(volts=(3.0, 6.0))), 1, 1e-2, 1e-3)
    records, solution = joint_fit.solved([capture], {}, ())
    assert undetected.undetected(solution, records)
    monkeypatch.setattr(
        undetected, "tangent", lambda record, *_: [np.nan * m.values for m in record.measured]
    )
    assert undetected.undetected(solution, records) == ()
