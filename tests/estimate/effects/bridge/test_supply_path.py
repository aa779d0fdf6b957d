"""A resistance before the bridge: what each duty sees of it."""

from __future__ import annotations

import pytest

from motorid.estimate.effects.action import Bridge
from motorid.estimate.effects.bridge.supply_path import SUPPLY_PATH
from motorid.estimate.signals.time_grid import Part
from motorid.motor.reading import Stretch
from motorid.program import Decay, StepKind
from tests.estimate.effects.benches import record

SLOW, FAST = Decay.SYNCHRONOUS_SLOW, Decay.FAST


@pytest.mark.parametrize(
    ("part", "duty", "share"),
    [
        (Part(0, 9, StepKind.DRIVE_DUTY, -0.5, SLOW), 0.5, 0.25),
        (Part(0, 9, StepKind.DRIVE_DUTY, 1.0, SLOW), 1.0, 1.0),
        (Part(0, 9, StepKind.DRIVE_DUTY, 0.4, FAST), 0.7, 0.16),
        (Part(0, 9, StepKind.DRIVE_VOLTS, 4.0, SLOW), 0.5, 0.25),
        (Part(0, 9, StepKind.DRIVE_VOLTS, -4.0, FAST), 0.25, 0.25),
        (Part(0, 9, StepKind.DRIVE_DUTY, 0.5, Decay.DIODE), 0.5, 0.0),
        (Part(0, 9, StepKind.BRAKE), 0.0, 0.0),
        (Part(0, 9, StepKind.COAST), 0.0, 0.0),
    ],
)
def test_the_motor_sees_the_square_of_its_duty(part: Part, duty: float, share: float) -> None:
    (action,) = SUPPLY_PATH.acts
    assert isinstance(action, Bridge)
    more = action.change(Stretch(0, series_ohm=0.2, duty=duty), part, 0.04)
    assert more.series_ohm == pytest.approx(0.2 + share * 0.04)


def test_no_fit_has_it_by_itself() -> None:
    assert SUPPLY_PATH.prior(record("commanded"), 0) is None
