"""Dry friction that is more at the first tick than at the last."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.capture.model import POSITION
from motorid.estimate.effects.friction.friction_drift import FRICTION_DRIFT
from motorid.estimate.effects.influence_quantity import Instance
from tests.estimate.effects.benches import POINT, record, start, usual


def test_it_slows_the_first_part_of_a_run_as_more_dry_friction_and_the_last_hardly() -> None:
    """Its torque goes to nothing by a straight line: the mean over the run is half of it."""
    subject = record("measured")
    more = 1e-3 * float(POINT[5])
    parts = subject.fitted(POINT, start(subject), {Instance(FRICTION_DRIFT): more})
    found = {m.block.name: p for m, p in zip(subject.measured, parts, strict=True)}[POSITION]
    dry = POINT.copy()
    dry[5] += more
    constant, none = usual("measured", dry)[POSITION], usual("measured")[POSITION]
    share = (found - none)[100:] / (constant - none)[100:]
    assert share[0] == pytest.approx(1.0, abs=0.3)
    assert (np.diff(share[:: len(share) // 8]) < 0.0).all()
    assert 0.3 < share[-1] < 0.8
