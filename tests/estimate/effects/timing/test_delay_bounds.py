"""No reading shows what comes after it: a declared delay of nothing can only be longer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, VOLTAGE
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Instance
from motorid.estimate.effects.timing.current_delay import CURRENT_DELAY
from motorid.estimate.effects.timing.motion_delay import MOTION_DELAY
from motorid.estimate.effects.timing.voltage_delay import VOLTAGE_DELAY
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.tangent import tangent
from motorid.estimate.results.estimate import PARAMETERS
from tests.estimate.effects.benches import POINT, measured, start

UNCERTAIN_S = 2e-6


@pytest.mark.parametrize("delay_s", [0.0, 1e-6, 3e-5])
@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
@pytest.mark.parametrize(
    ("quantity", "channel"),
    [(CURRENT_DELAY, CURRENT), (MOTION_DELAY, POSITION), (VOLTAGE_DELAY, VOLTAGE)],
)
def test_any_declared_delay_has_a_tangent(
    quantity: InfluenceQuantity, channel: str, delay_s: float, share: float
) -> None:
    """With any share of it in a filter before the converter."""
    capture = measured()
    changed = replace(
        capture.channels[channel], delay_s=delay_s, filter_s=share * delay_s,
        delay_uncertainty_s=UNCERTAIN_S,
    )  # fmt: skip
    channels = {**capture.channels, channel: changed}
    record = MotorRecord(replace(capture, channels=channels), PARAMETERS, {})
    moved = tangent(record, POINT, start(record), Instance(quantity))
    assert all(np.isfinite(part).all() for part in moved)
    assert any(part.any() for part in moved)
    lower, upper = quantity.bounds(record)
    ahead = 1.0 if channel == VOLTAGE else 1.0 - share  # an open bridge has no filter
    assert -delay_s * ahead - 1e-15 <= lower <= 0.0 < upper
