"""Gains that nobody stated: what each parameter is if a channel reads 1 % too much.

No residual shows a gain. Where nobody stated how well it is known, no interval holds what it does,
and the answer says so instead of giving it as nothing.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.effects import scales
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Instance
from motorid.estimate.effects.reading.current_gain import CURRENT_GAIN
from motorid.estimate.effects.reading.motion_gain import MOTION_GAIN
from motorid.estimate.effects.source.voltage_gain import VOLTAGE_GAIN
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.tangent import tangent
from motorid.estimate.results.estimate import Parameter
from motorid.estimate.solver.dense_products import project
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.covariance import covariance_of

Floats = NDArray[np.float64]
Moves = dict[str, dict[str, float]]  # gain -> parameter or combination -> change in its unit

PART = 0.01  # by which a channel reads too much
LEAST = 1e-4  # of a value: what moves it by less does not
WORDS = {
    CURRENT: CURRENT_GAIN.name,
    VOLTAGE: VOLTAGE_GAIN.name,
    SPEED: MOTION_GAIN.name,
    POSITION: MOTION_GAIN.name,
}


def unstated_gains(solution: Solution, records: Sequence[MotorRecord]) -> Moves:
    """Change (SI) of each free parameter that a channel moves if it reads 1 % too much."""
    inverse = covariance_of(solution.information)
    slopes, names = solution.slopes, [unknown.name for unknown in solution.unknowns]
    pulls: dict[str, Floats] = {}
    for record, line, own in zip(records, solution.records, solution.own, strict=True):
        for quantity in _open(record):
            moved = tangent(record, solution.values, own, Instance(quantity))
            weighed = zip(record.weighed(moved), line.sigmas, strict=True)
            parts = np.concatenate([PART * change / sigma for change, sigma in weighed])
            pull = -project(line.orthogonal.T, parts)
            pulls[quantity.name] = pulls.get(quantity.name, 0.0) + pull
    return {
        gain: {
            name: float(move)
            for name, value, move in zip(
                names, solution.values, slopes * (inverse @ pull), strict=True
            )
            if abs(move) > LEAST * abs(value)
        }
        for gain, pull in pulls.items()
    }


def _open(record: MotorRecord) -> Iterator[InfluenceQuantity]:
    """Gains of channels that the fit reads, of which nobody stated anything."""
    moving, current = scales.moving(record), record.block(CURRENT)
    read: tuple[tuple[InfluenceQuantity, Channel | None], ...] = (
        (VOLTAGE_GAIN, record.sensed.channel),
        (CURRENT_GAIN, current.channel if current is not None else None),
        (MOTION_GAIN, moving.channel if moving is not None else None),
    )
    for quantity, channel in read:
        if channel is not None and not channel.states("gain"):
            yield quantity


def gains_of(captures: Sequence[Capture], names: Iterable[str]) -> dict[str, str]:
    """Gain -> channel, of those of ``names`` that some capture has without a word on its gain."""
    return {
        WORDS.get(name, f"{name} gain"): name
        for name in names
        if any(name in c.channels and not c.channels[name].states("gain") for c in captures)
    }


def moved(before: Mapping[str, Parameter], after: Mapping[str, Parameter]) -> dict[str, float]:
    """Change of each value that both answers have, where it changes."""
    values = ((name, p.value, after[name].value) for name, p in before.items() if name in after)
    known = ((n, a, b - a) for n, a, b in values if a is not None and b is not None)
    return {n: move for n, a, move in known if abs(move) > LEAST * abs(a)}
