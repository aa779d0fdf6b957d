"""Subjects of influence quantities, made by hand: as much of a capture as declarations read."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from motorid.capture.model import Channel, Wiring
from motorid.estimate.effects.influence_quantity import InfluenceQuantity

MOTOR = np.array([2.0, 1e-3, 0.05, 4e-5, 2e-5, 6e-3])
TOP_V = 8.0


def block(name: str, values: Any = (1.0, 4.0, 2.0), **facts: Any) -> Any:
    channel = Channel(name, "", np.zeros(3), **facts)
    return SimpleNamespace(
        block=SimpleNamespace(name=name), channel=channel, values=np.array(values),
        keep=np.arange(len(values)), unsigned=channel.unsigned,
    )  # fmt: skip


def subject(*blocks: Any, **facts: Any) -> Any:
    """A capture of these blocks, judged by a motor, driven by 8 V at most."""
    known = {one.block.name: one for one in blocks}
    return SimpleNamespace(**{
        "block": known.get, "judged_at": MOTOR, "volts": np.array([3.0, -TOP_V]), "loss": None,
        "driven": np.array([False, True, True]), "pwm_period_s": 5e-5, "losing": {}, "held": {},
        "timeline": SimpleNamespace(period_s=1e-4, parts=(), count=2),
        "sensed": SimpleNamespace(waveform=None, channel=None, shows_emf=True, volts=np.zeros(2)),
        "capture": SimpleNamespace(wiring=Wiring(), provenance={}), "sources": (), **facts,
    })  # fmt: skip


def prior(quantity: InfluenceQuantity, of: Any, place: int = 0) -> tuple[float, float, Any] | None:
    found = quantity.prior(of, place)
    return None if found is None else (found.sd, found.mean, found.start)
