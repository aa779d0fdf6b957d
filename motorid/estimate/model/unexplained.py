"""How much of what each channel shows the model leaves unexplained.

Chi-square says how many times the noise a residual is. A fine converter makes that large for a
misfit that matters to nobody. Here a residual is compared with the readings themselves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.measurements import EMF, Measured
from motorid.estimate.signals.time_grid import IRREGULAR
from motorid.estimate.solver.dense_products import square
from motorid.estimate.solver.problem import Solution

Floats = NDArray[np.float64]

CONTRADICTED = 0.25  # share beyond noise, above which no model of a motor explains a channel
UNSEEN = {CURRENT: 0.9}  # share, noise and all, above which a channel shows nothing of the motor,
UNSEEN_MOTION = 0.5  # and the same of a motion, where the model has one
NO_MOTION = 1e-3  # share of the readings that the model makes: less is a rotor at rest
AVERAGED = 16  # readings of a speed: one of counts is none or too much at each by itself
DECLARED = 2.0  # times the declared noise: what that explains is no contradiction


@dataclass(frozen=True)
class Unexplained:
    """Of one channel, all runs together: the residuals' share of its mean square.

    The back-EMF of an open bridge is compared with the voltage that drove the motor.

    ``share`` counts all of them, of a speed their means where those leave less; ``beyond`` what is
    more than twice the noise that the channel declares, or else than the noise that neighbours
    show. ``declared``: that noise is as large as the residuals. ``made``: the mean square of what
    the model makes, as such a share.
    """

    channel: str
    share: float
    beyond: float
    declared: bool
    made: float = 1.0

    @property
    def contradicts(self) -> bool:
        """No parameters of the model make the readings of this channel from the others'."""
        if self.declared:
            return False
        if (
            self.channel != CURRENT and self.made < NO_MOTION
        ):  # nothing turns: noise is all it shows
            return False
        return self.beyond > CONTRADICTED or self.share > UNSEEN.get(self.channel, UNSEEN_MOTION)


def unexplained(records: Sequence[MotorRecord], solution: Solution) -> list[Unexplained]:
    """Of every channel, in their order."""
    sums: dict[str, Floats] = {}
    for record, own in zip(records, solution.own, strict=True):
        left = record.departures(solution.values, own)
        for m, residual in zip(record.measured, left, strict=True):
            name = m.block.name
            sums[name] = sums.get(name, np.zeros(7)) + _sums(record, m, residual)
    return [_of(name, *found.tolist()) for name, found in sums.items()]


def shares(records: Sequence[MotorRecord], solution: Solution) -> dict[str, float]:
    """Of each channel's mean square, the share that the residuals are, noise and all."""
    return {one.channel: one.share for one in unexplained(records, solution)}


def unsupported(records: Sequence[MotorRecord], solution: Solution) -> Unexplained | None:
    """The channel that the model explains least, where it explains too little for any answer.

    None of logs with irregular stamps: nobody knows what their voltage did between readings.
    """
    if any(r.sensed.waveform is not None and r.timeline.jitter > IRREGULAR for r in records):
        return None
    found = [one for one in unexplained(records, solution) if one.contradicts]
    return max(found, key=lambda one: one.share, default=None)


def _sums(record: MotorRecord, m: Measured, residual: Floats) -> Floats:
    """Of squares: readings, residuals, their noise, what is declared of that, what is made; then
    readings and residuals of means.
    """
    made = m.values - residual
    shown = m.values
    if m.block.name == POSITION:  # which has no zero of its own
        shown, made = shown - shown.mean(), made - made.mean()
    count = len(residual)
    whole = square(shown)
    if m.block.name == EMF and record.driven.any():  # of a motor at rest there is none to explain
        whole = max(whole, float(np.mean(record.volts[record.driven] ** 2)) * count)
    declared = max(m.noise, m.resolution / np.sqrt(12.0)) ** 2 * count
    noise = DECLARED**2 * declared if m.noise > 0.0 else square(np.diff(residual)) / 2.0
    means = square(_means(shown)), square(_means(residual))
    return np.array([whole, square(residual), noise, declared, square(made), *means])


def _means(series: Floats) -> Floats:
    """Of as many neighbours each; of fewer than two times those, the series itself."""
    if len(series) < 2 * AVERAGED:
        return series
    whole = len(series) // AVERAGED * AVERAGED
    return np.asarray(series[:whole].reshape(-1, AVERAGED).mean(axis=1))


def _of(
    name: str, whole: float, left: float, noise: float, declared: float, made: float,
    shown: float, missed: float,
) -> Unexplained:  # fmt: skip
    if not whole > 0.0:
        return Unexplained(name, 0.0, 0.0, declared=True)
    beyond = max(left - max(noise, declared), 0.0) / whole
    share = left / whole
    if name == SPEED and shown > 0.0:
        share = min(share, missed / shown)
    return Unexplained(name, share, beyond, left <= DECLARED**2 * declared, made / whole)
