"""What cogging of every order would do to the readings of a record, without a response of it.

A log's rows lie so far apart that the rotor turns by radians of a period from one to the next: no
spectrum over the angle shows cogging there. What it does to starts and reversals stays in the
readings, and is asked for here order by order.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.effects.rotor.torque_wave import Run
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.measurements import EMF, Measured
from motorid.motor.reading import Output, Quantity

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

ORDERS = tuple(range(1, 61))  # periods a turn
ASKED = (Quantity.CURRENT, Quantity.SPEED, Quantity.POSITION)


def cogging_columns(
    record: MotorRecord,
    shared: Floats,
    own: Floats,
    orders: Sequence[int] = ORDERS,
    filtered: bool = True,
) -> Floats:
    """(orders, 2, n): change of the weighed readings, block after block, by 1 N·m times the cosine
    and the sine of order times angle. ``filtered``: as ``MotorRecord.weighed``'s.
    """
    current, speed, angle = record.runs(shared, own, [Output(q) for q in ASKED])
    motor = record.setup(own).loaded(record.motor(shared), record.names)
    run = Run(motor[:6], record.timeline.period_s, current, speed, angle - angle[0])
    shown = dict(zip(ASKED, run.waves(orders), strict=True))
    emf = record.emf_constant(shared)
    blocks = [
        _read(record, own, m, shown) * (emf if m.block.name == EMF else 1.0)
        for m in record.measured
    ]
    waves = np.concatenate(blocks, axis=1)
    rows = np.stack([waves.real, waves.imag], axis=1).reshape(2 * len(waves), -1)
    rows = record.filtered_rows(rows) if filtered else rows
    return np.asarray(rows.reshape(len(waves), 2, -1))


def _read(
    record: MotorRecord, own: Floats, m: Measured, shown: Mapping[Quantity, Complex]
) -> Complex:
    """What a block shows of it, (orders, n), behind what is known of its lag and its low-pass."""
    setup, output, period_s = record.setup(own), record.outputs[m.row], record.timeline.period_s
    series = shown[output.quantity]
    slow = (output.filter_s + setup.filter_s.get(m.block.name, 0.0)) / period_s
    late = (output.delay_s + setup.late_s.get(m.block.name, 0.0)) / period_s
    past = m.keep if m.past is None else m.keep + m.past
    wide = output.aperture_s / period_s
    read = _mean(_low_passed(series, slow), np.asarray(past - late, dtype=np.float64), wide)
    return read if m.root_weights is None else np.asarray(read * m.root_weights)


def _low_passed(series: Complex, slow: float) -> Complex:
    """Behind a low-pass of first order, of so many ticks."""
    from scipy.signal import lfilter

    if not slow > 0.0:
        return series
    kept = float(np.exp(-1.0 / slow))
    return np.asarray(lfilter([1.0 - kept], [1.0, -kept], series))


def _mean(series: Complex, at: Floats, wide: float) -> Complex:
    """Of (orders, count) over so many ticks before each place (n,) of it."""
    ticks = np.arange(series.shape[1])
    if wide > 0.0:
        total = np.cumsum(series, axis=1) - 0.5 * (series + series[:, :1])
        ends = [np.array([np.interp(x, ticks, row) for row in total]) for x in (at, at - wide)]
        return np.asarray((ends[0] - ends[1]) / wide)
    return np.array([np.interp(at, ticks, row) for row in series])
