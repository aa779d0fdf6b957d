"""Dry friction that is more at the first tick than at the last."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

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


@pytest.mark.parametrize(("duration_s", "share"), [(0.1, 0.003), (1.0, 0.03), (20.0, 0.03)])
def test_a_second_or_more_may_change_dry_friction_by_three_per_cent(
    duration_s: float, share: float
) -> None:
    timeline = SimpleNamespace(count=1000, period_s=duration_s / 1000)

    def judged(T0: float) -> Any:
        motor = np.array([2.0, 1e-3, 0.05, 4e-5, 2e-5, T0])
        return SimpleNamespace(timeline=timeline, judged_at=motor)

    prior = FRICTION_DRIFT.prior(judged(6e-3), 0)
    assert prior is not None
    assert (prior.sd, prior.mean) == (pytest.approx(share * 6e-3), 0.0)
    assert FRICTION_DRIFT.prior(judged(0.0), 0) is None
