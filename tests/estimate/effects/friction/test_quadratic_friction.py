"""Windage: its torque, and the size at which it is as large as usual friction."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.capture.model import POSITION
from motorid.estimate.effects.friction.quadratic_friction import QUADRATIC_FRICTION
from tests.estimate.effects.benches import FAULHABER, POINT, moved, record, usual


def test_it_brakes_like_a_little_more_viscous_friction() -> None:
    """c ω² is c |ω| as a viscous friction: between none and c times the top speed of it."""
    change = moved("measured", QUADRATIC_FRICTION)[POSITION]
    more = POINT.copy()
    more[3] *= 1.001
    viscous = (usual("measured", more)[POSITION] - usual("measured")[POSITION]) / (
        0.001 * FAULHABER["B"]
    )
    top = np.abs(np.diff(usual("measured")[POSITION])).max() / 1e-4  # rad/s
    assert (change[100:] < 0.0).all()
    ratio = change[100:] / viscous[100:]
    assert (ratio > 0.3 * top).all()
    assert (ratio < top).all()


def test_its_scale_is_the_usual_friction_at_the_top_speed() -> None:
    subject = record("measured")
    _, _, K, B, _, T0 = FAULHABER.values()
    top = float(np.abs(subject.volts).max()) / K
    assert QUADRATIC_FRICTION.scale(subject) == pytest.approx((T0 + B * top) / top**2, rel=1e-3)
