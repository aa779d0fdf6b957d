"""A log whose voltage is as noisy once more: what that does to the model's readings.

Noise of the voltage drives the model and not the motor. It leaves residuals, and a model that
passes less of it is left less: a lag between rows, a low-pass and an inductance all do. So an
objective is fair to two models only without what the noise leaves of each.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, VOLTAGE, Channel
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.intersample_voltage import OF_MEANS, Waveform, of_log
from motorid.estimate.signals.voltage_jumps import count_of, jumps, rounding, scatter
from motorid.estimate.signals.voltage_smoothing import smoothed
from motorid.estimate.solver.dense_products import square
from motorid.estimate.solver.problem import Solution

Floats = NDArray[np.float64]

DRAWS = 8  # of a log's noise
PAIRS = 4  # of draws and their opposites, by which an objective is judged
LITTLE = 0.5  # of an objective, by one pair: no more are drawn


def judged(records: Sequence[MotorRecord], solution: Solution) -> Solution:
    """With what of its objective is noise of the voltage as large as that of the readings."""
    each = zip(records, solution.own, strict=True)
    return replace(solution, noise=sum(_left(one, solution.values, own) for one, own in each))


def _left(record: MotorRecord, values: Floats, own: Floats) -> float:
    """What draws and their opposites leave of a current: no residual correlates with both.

    A motion adds noise up, so that a draw says little of another. Nor is more left than there is.
    """
    current = record.block(CURRENT)
    if current is None or record.sensed.waveform is None:
        return 0.0
    place, found = record.measured.index(current), list[float]()

    def total(one: MotorRecord) -> float:
        return square(one.residuals(values, own)[place])

    block, usual = record.blocks[place], total(record)
    variance = max(usual / max(block.count, 1.0), block.floor**2)
    for noise in _noises(record, PAIRS, levels=False):
        moved = [one for sign in (1.0, -1.0) if (one := _with(record, sign * noise)) is not None]
        more = sum((total(one) - usual) / len(moved) for one in moved)
        found.append(min(more / variance, block.count))
        if found[0] < LITTLE:
            break
    return float(np.mean(found)) if found else 0.0


def noisier(record: MotorRecord) -> Iterator[MotorRecord]:
    """The record, if its voltage had as much noise once more."""
    for noise in _noises(record, DRAWS):
        other = _with(record, noise)
        if other is not None:
            yield other


def _noises(record: MotorRecord, draws: int, levels: bool = True) -> Iterator[Floats]:
    """V (n,) of a log's readings; none: no log, or its voltage has no noise. ``levels``: with what
    a converter's steps leave of each level.
    """
    channel = record.capture.get(VOLTAGE)
    if record.sensed.waveform is None or channel is None:
        return
    there = np.flatnonzero(np.isfinite(channel.values))
    known = channel.values[there]
    deviation = scatter(known)
    if not deviation:
        return
    rng = np.random.default_rng(len(known))
    step = count_of(known)
    rounded = rounding(math.sqrt(max(deviation**2 - step**2 / 12.0, 0.0)), step) if levels else 0.0
    level = np.searchsorted(jumps(known), np.arange(len(known)), side="right")
    for _ in range(draws):
        noise = np.zeros(len(channel.values))
        each = deviation * rng.standard_normal(len(known))
        noise[there] = each + rounded * rng.standard_normal(level[-1] + 1)[level]
        yield noise


def _with(record: MotorRecord, noise: Floats) -> MotorRecord | None:
    """The record under a voltage with that noise, where no source was fitted to its readings."""
    waveform, channel = record.sensed.waveform, record.capture.get(VOLTAGE)
    if waveform is None or channel is None:
        return None
    moved = _shaken(record, waveform, channel, noise)
    if moved is None:
        return None
    as_heard = np.concatenate([
        np.full(part.stop - part.start, source is None)
        for part, source in zip(record.timeline.parts, record.sources, strict=True)
    ])  # fmt: skip
    return _driven_by(record, moved, as_heard)


def _shaken(
    record: MotorRecord, waveform: Waveform, channel: Channel, noise: Floats
) -> Waveform | None:
    """The waveform of readings with ``noise`` (n,) in V, which jumps where it did and is freed of
    noise as it was: a noisier log would be less.
    """
    if waveform.windows is None or waveform.shape in OF_MEANS:
        raw = np.asarray(channel.raw, dtype=np.float64) + noise / channel.scale
        channel = replace(channel, raw=raw)
        return of_log(record.capture, channel, record.shape, waveform.windows)
    known = np.isfinite(channel.values)
    moved = replace(waveform, volts=waveform.volts + smoothed(noise[known], waveform.windows))
    vars(moved).update(steps_off=waveform.steps_off, wanders=waveform.wanders)
    return moved


def _driven_by(record: MotorRecord, waveform: Waveform, as_heard: NDArray[np.bool_]) -> MotorRecord:
    """The record under another waveform, where no source was fitted to its readings."""
    twin = record.twin()
    volts = waveform.means(record.timeline)
    twin.volts = record.volts + np.where(as_heard, volts - record.sensed.volts, 0.0)
    twin.sensed = replace(record.sensed, waveform=waveform, volts=volts)
    twin.standing.excite(twin.volts, twin.stretches, twin.first)
    return twin
