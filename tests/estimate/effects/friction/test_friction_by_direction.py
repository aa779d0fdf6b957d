"""Dry friction by direction: more of it one way, as much less the other."""

from __future__ import annotations

import pytest

from motorid.capture.model import POSITION
from motorid.estimate.effects.friction.friction_by_direction import FRICTION_BY_DIRECTION
from motorid.estimate.effects.influence_quantity import Instance
from tests.estimate.effects.benches import POINT, moved, record, start, usual


def test_one_way_it_is_more_dry_friction() -> None:
    """The rotor turns forwards alone."""
    subject = record("measured")
    assert (usual("measured")[POSITION][100:] > 0.0).all()
    share = 1e-3
    parts = subject.fitted(POINT, start(subject), {Instance(FRICTION_BY_DIRECTION): share})
    directed = {m.block.name: p for m, p in zip(subject.measured, parts, strict=True)}[POSITION]
    more = POINT.copy()
    more[5] *= 1.0 + share
    dry = usual("measured", more)[POSITION]
    assert directed - usual("measured")[POSITION] == pytest.approx(
        dry - usual("measured")[POSITION], rel=1e-3, abs=1e-9
    )
    assert moved("measured", FRICTION_BY_DIRECTION)[POSITION][-1] < 0.0
