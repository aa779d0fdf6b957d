"""What acts on a channel is there with it alone; nothing else comes or goes."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest

from motorid.capture.model import CURRENT, POSITION, SPEED
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, instances
from motorid.estimate.effects.registry import REGISTRY
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS
from tests.estimate.effects.benches import BENCHES, POINT, record, start

BY_CURRENT = {"brush drop", "brush bend", "winding warming"}  # a drop follows the current's sign


@cache
def lacking(name: str, channel: str) -> MotorRecord:
    capture = BENCHES[name]()
    kept = {n: c for n, c in capture.channels.items() if n != channel}
    found = MotorRecord(replace(capture, channels=kept), PARAMETERS, {})
    found.retake_sources(POINT, start(found))
    return found


def places(quantity: InfluenceQuantity, subject: MotorRecord) -> list[int]:
    return [o.place for o in instances(quantity, subject) if o.unknown(subject) is not None]


def blocks(quantity: InfluenceQuantity) -> set[str]:
    """Which readings it acts on, if it acts on nothing else."""
    acting = [getattr(action, "block", None) for action in quantity.acts]
    return {name for name in acting if name} if all(acting) else set()


@pytest.mark.parametrize(
    ("name", "channel", "motion"),
    [
        ("measured", CURRENT, False), ("measured", POSITION, True), ("filtered", CURRENT, False),
        ("unstated", SPEED, True), ("unstated", CURRENT, False),
    ],
)  # fmt: skip
def test_what_acts_on_a_channel_needs_it(name: str, channel: str, motion: bool) -> None:
    gone = {POSITION, SPEED} if motion else {channel}
    whole, without = record(name), lacking(name, channel)
    needing = set()
    for quantity in REGISTRY:
        acts_on = blocks(quantity)
        if acts_on and acts_on <= gone:
            needing.add(quantity.name)
            assert places(quantity, without) == [], quantity.name
            assert not quantity.told(without), quantity.name
        elif not (motion or quantity.name in BY_CURRENT) and name == "measured":
            assert places(quantity, without) == places(quantity, whole), quantity.name
    assert len(needing) >= 3
    assert any(places(quantity, whole) for quantity in REGISTRY if quantity.name in needing)
