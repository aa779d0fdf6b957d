"""Friction that falls while the motor turns, by the simulated rig: it falls by the time of turning,
the term by the time of the capture.
"""

from __future__ import annotations

from math import exp
from pathlib import Path

import pytest

from motorid.program import Decay, Program, Step, StepKind
from tests.estimate.selection.test_iron import covers, measured, named
from tests.six_parameters import fit

FRESH, TIME_S = 0.5, 0.4
RUN = Program(
    (
        Step(StepKind.COAST, 0.02),
        *(
            Step(StepKind.DRIVE_VOLTS, 0.1, v, Decay.SYNCHRONOUS_SLOW)
            for v in (3.0, 6.0, 3.0, -2.0, -6.0, -3.0)
        ),
        Step(StepKind.COAST, 0.1),
    )
)


@pytest.mark.slow
def test_friction_that_falls_is_named_and_t0_is_that_at_the_end(tmp_path: Path) -> None:
    """The check before the capture has turned the motor for a while, so that some of it is gone."""
    capture, true = measured(tmp_path, f"fresh_friction={FRESH}&fresh_time={TIME_S}", RUN)
    estimate = fit([capture], model="auto")
    assert named(estimate) == ("friction-drift",)
    found = estimate.alternative.parameters
    assert all(covers(found[n], true[n]) for n in ("R", "L", "K", "B", "J"))
    assert covers(found["r_f"], 1.0 / TIME_S)
    left = exp(-found["r_f"].value * (capture.ticks[-1] - capture.ticks[0]) / capture.clock_hz)
    settled = found["T0"].value - found["T_f"].value * left / (1.0 - left)
    assert settled == pytest.approx(true["T0"], rel=0.02)
    assert 1.1 * settled < found["T0"].value + found["T_f"].value < (1.0 + FRESH) * settled
    assert {estimate.parameters[n].status for n in ("B", "T0")} == {"doubtful"}
    assert covers(estimate.parameters["B"], true["B"])
