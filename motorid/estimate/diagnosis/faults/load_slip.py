"""A load that slips on the shaft while the torque to turn it is more than its joint holds.

A slipping load follows the shaft at a constant acceleration. With w2 its speed and J2 its inertia,

    K i = J dw/dt - J2 d(w - w2)/dt + B w + T0 sign(w)

so that the currents of a capture tell J2, once w2 is followed along the measured speed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT
from motorid.estimate.diagnosis.fault import Hypothesis, Words, added_voltage, series
from motorid.estimate.diagnosis.faults.motion import measured_speed
from motorid.estimate.fit.block_regression import (
    BLOCK,
    Blocks,
    Start,
    blocks,
    electrical,
    friction_columns,
    squares,
)
from motorid.estimate.model.capture_model import MotorRecord

Floats = NDArray[np.float64]

COARSE = 8  # samples at which the load is followed
RATES = np.geomspace(0.03, 0.9, 16)  # of the steepest acceleration, at which a slipping load goes
LEAST_SHARE = 0.05  # of the inertia
EXPLAINS = 0.15  # of the squares that the law of a fast load leaves: worth a fit


def seen(records: Sequence[MotorRecord]) -> tuple[Hypothesis, Start] | None:
    """The slipping load that the currents show, to be fitted; None where they show none."""
    b = blocks(records)
    begin = start(b) if b is not None else None
    return (_hypothesis(records, begin), begin) if begin is not None else None


def start(b: Blocks) -> Start | None:
    """Share of the inertia and acceleration of a slipping load, and the motor that it leaves."""
    law = friction_columns(b)
    rest, _, _ = squares(law, b.current)
    steepest = float(np.abs(b.acceleration).max())
    tried = [(rate, *squares(np.column_stack([law, -_behind(b, rate)]), b.current)[:2])
             for rate in (RATES * steepest).tolist()]  # fmt: skip
    rate, left, found = min(tried, key=lambda t: t[1])
    share = found[3] / found[0] if found[0] > 0 else 0.0
    if left > (1 - EXPLAINS) * rest or not LEAST_SHARE < share < 1:
        return None
    motor = electrical(b, b.driven)
    if motor is None:
        return None
    R, K = motor
    torques = {n: max(K * float(x), 0.0) for n, x in zip(("J", "B", "T0"), found, strict=False)}
    return Start((float(share), rate), {"R": R, "K": K, **torques})


def _behind(b: Blocks, rate: float) -> Floats:
    """d(w - w2)/dt of every block."""
    out = np.zeros(len(b.speed))
    for run, h in zip(b.runs, b.period_s.tolist(), strict=True):
        speed = b.speed[run]
        out[run] = np.gradient(speed - followed(speed, rate * h)) / h
    return out


def _hypothesis(records: Sequence[MotorRecord], begin: Start) -> Hypothesis:
    speeds = {id(r): s for r in records if (s := measured_speed(r, BLOCK)) is not None}

    def effect(record: MotorRecord, values: Floats, own: Floats, size: Floats) -> list[Floats]:
        """The torque that a slipping load does not take, as voltage and current."""
        share, rate = float(size[0]), float(size[1])
        R, L, K, _, J = (float(v) for v in record.motor(values)[:5])
        period, speed = record.timeline.period_s, speeds[id(record)]
        place = np.arange(len(speed))
        load = followed(speed[::COARSE], rate * period * COARSE)
        ahead = speed - np.interp(place, place[::COARSE], load)
        torque = share * J * np.diff(ahead, prepend=ahead[0]) / period
        torque = np.where(record.driven, torque, 0.0)
        volts = (R * torque + L * np.diff(torque, prepend=0.0) / period) / K
        out = added_voltage(record, values, own, volts)
        for k, _y in series(record, values, own, CURRENT):
            out[k] = out[k] - (torque / K)[record.measured[k].where]
        return out

    def words(size: Floats) -> Words:
        return Words(
            "load",
            f"{100 * size[0]:.0f} % of the inertia follows the shaft at {size[1]:.3g} rad/s² and "
            "no faster",
            "fasten the load to the shaft, or accelerate less",
        )

    rate = begin.size[1]
    return Hypothesis(
        "load_slips", effect, (begin.size,), (0.1, 0.1 * rate),
        (0.02, 0.1 * rate), (0.99, 10.0 * rate), words,
        belongs=lambda size: {"J": float(size[0])},
    )  # fmt: skip


def followed(speed: Floats, most: float) -> Floats:
    """``speed`` (n,) as something follows it that changes by ``most`` a step at most, (n,)."""
    values = speed.tolist()
    at, out = values[0], []
    for value in values:
        at += min(max(value - at, -most), most)
        out.append(at)
    return np.array(out)
