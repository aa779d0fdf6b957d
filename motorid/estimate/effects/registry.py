"""What a capture brings of its own: offsets, the encoder's origin, the state it begins in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED, Capture, Channel
from motorid.estimate.effects.source_noise import Unrest
from motorid.estimate.signals.measurements import EMF, Measured, motion
from motorid.estimate.signals.voltage_sensing import Sense
from motorid.estimate.solver.problem import Unknown

Floats = NDArray[np.float64]

HEAD = 8  # samples that show whether a record begins at rest
EVEN = 12.0**-0.5  # standard deviation of what lies anywhere from 0 to 1
FARTHEST = 4.0  # standard uncertainties of a delay: beyond it the declaration is wrong
QUIET_SAMPLES = 10  # that tell an offset


@dataclass
class Nuisances:
    """The unknowns of one record, and where each sits; -1: it has none."""

    unknowns: list[Unknown] = field(default_factory=list)
    current_offset: int = -1
    position_origin: int = -1
    voltage_offset: int = -1
    initial_speed: int = -1
    initial_current: int = -1
    voltage_late: int = -1
    current_late: int = -1
    initial_warmth: int = -1
    cogging_phase: int = -1
    ripple_phase: int = -1
    voltage_loss: int = -1
    loss_bend: int = -1
    warming: int = -1
    levels: dict[int, int] = field(default_factory=dict)  # place by part of the program
    coasts: dict[int, int] = field(default_factory=dict)
    jumps: list[int] = field(default_factory=list)  # of a log's voltage
    further: dict[str, int] = field(default_factory=dict)  # by name, of which there may be many

    def add(self, unknown: Unknown) -> None:
        """Take one more."""
        if hasattr(self, unknown.name):
            setattr(self, unknown.name, len(self.unknowns))
        else:
            self.further[unknown.name] = len(self.unknowns)
        self.unknowns.append(unknown)

    def add_unrest(self, unrest: Unrest, volts: float, speed: float) -> None:
        """The level of every part and the speed every coast begins with, about the model's.

        ``volts`` and ``speed`` (rad/s) are typical of the capture.
        """
        for k in unrest.levels:
            self.levels[k] = len(self.unknowns)
            self.unknowns.append(Unknown(f"source_level_{k}", 0.0, scale=volts))
        for k in unrest.coasts if speed else ():
            self.coasts[k] = len(self.unknowns)
            self.unknowns.append(Unknown(f"coast_start_{k}", 0.0, scale=speed))

    def add_jumps(self, count: int) -> None:
        """How early each of a log's jumps came, as a share of the time that hides it."""
        for k in range(count):
            self.jumps.append(len(self.unknowns))
            share = Unknown(f"jump_{k}", 0.5, lower=0.0, upper=1.0, prior_mean=0.5, prior_sd=EVEN)
            self.unknowns.append(share)

    def free_delay(self, current: Channel, scale_s: float) -> None:
        """The last unknown: how much later (s) the current's readings are than declared.

        Never earlier than what they show. ``scale_s``: over which that changes its course.
        """
        sd = current.delay_uncertainty_s
        least, most = max(-FARTHEST * sd, -current.delay_s), FARTHEST * sd
        self.add(Unknown("current_late", 0.0, least, most, scale=scale_s, prior_sd=sd))

    def hold_delay(self) -> None:
        """The delay is as declared again."""
        del self.unknowns[self.current_late]
        self.current_late = -1

    def expect(self, place: int, deviation: float, mean: float = 0.0) -> None:
        """Give an unknown another prior; one that is absent has none."""
        if place >= 0:
            known = self.unknowns[place]
            self.unknowns[place] = replace(known, prior_mean=mean, prior_sd=deviation)

    def of(self, own: Floats, name: str) -> float:
        """Its value among the record's own (SI), 0 where it has none."""
        place = getattr(self, name, self.further.get(name, -1))
        return float(own[place]) if place >= 0 else 0.0


def nuisances(
    capture: Capture,
    period_s: float,
    driven: NDArray[np.bool_],
    sensed: Sense,
    unrest: Unrest,
    measured: Sequence[Measured],
    lost: Sequence[Unknown] = (),
) -> Nuisances:
    """Those that this capture can tell, or whose uncertainty its channels declare.

    ``lost``: those of the voltage that brushes and winding take.
    """
    names = {m.block.name: m for m in measured}
    found = Nuisances()
    current, position, emf = names.get(CURRENT), names.get(POSITION), names.get(EMF)
    if current is not None and not current.unsigned:
        sd = current.channel.offset_uncertainty or np.inf
        at_rest = current.values[~driven[current.keep]]
        quiet = len(at_rest) >= QUIET_SAMPLES
        if quiet or np.isfinite(sd):
            start = float(np.median(at_rest)) if quiet else 0.0
            found.add(Unknown("current_offset", start, scale=_extent(current.values), prior_sd=sd))
    if position is not None:
        first = float(position.values[0])
        found.add(Unknown("position_origin", first, scale=_extent(position.values)))
    if sensed.channel is not None and sensed.shows_emf:
        sd = sensed.channel.offset_uncertainty or np.inf
        if np.isfinite(sd) or (emf is not None and len(emf.values) >= QUIET_SAMPLES):
            found.add(Unknown("voltage_offset", 0.0, scale=_extent(sensed.volts), prior_sd=sd))
    if sensed.waveform is not None:  # stamps of a log are often off by a sample
        period = sensed.waveform.period_s
        stated = sensed.channel.delay_uncertainty_s if sensed.channel is not None else 0.0
        late = max(period, stated)
        found.add(Unknown("voltage_late", 0.0, scale=period, prior_sd=late))
        found.add_jumps(len(sensed.waveform.jumps))
    for unknown in lost:
        found.add(unknown)
    if not starts_at_rest(capture, driven):
        _moving_start(found, names.get(POSITION) or names.get(SPEED), period_s)
        if current is not None and driven[0]:
            first = float(current.values[0])
            found.add(Unknown("initial_current", first, scale=_extent(current.values)))
    moving = names.get(POSITION) or names.get(SPEED)
    found.add_unrest(unrest, _extent(sensed.volts), _speed(moving, period_s))
    return found


def _speed(moving: Measured | None, period_s: float) -> float:
    """Highest mean speed (rad/s) over a twentieth of the readings; 0: no motion was measured."""
    if moving is None:
        return 0.0
    if moving.block.name == SPEED:
        return float(np.abs(moving.values).max())
    step = max(len(moving.values) // 20, 1)
    turned, ticks = np.diff(moving.values[::step]), np.diff(moving.keep[::step])
    return float(np.abs(turned / ticks).max(initial=0.0)) / period_s


def _extent(values: Floats) -> float:
    return float(np.ptp(values)) or float(np.abs(values).max()) or 1.0


def _moving_start(found: Nuisances, moving: Measured | None, period_s: float) -> None:
    if moving is None:
        return
    first = moving.values[:HEAD]
    if moving.block.name == POSITION:
        first = np.gradient(first, moving.keep[:HEAD] * period_s)
    found.add(Unknown("initial_speed", float(first.mean()), scale=_extent(first)))


def starts_at_rest(capture: Capture, driven: NDArray[np.bool_]) -> bool:
    """The motor stands still, and carries no current, over the first few samples."""
    moving, current = motion(capture), capture.get(CURRENT)
    if moving is not None and moving.name == POSITION and _moves(moving):
        return False
    if moving is not None and moving.name == SPEED and not _is_near_zero(moving):
        return False
    return not driven[0] or current is None or _is_near_zero(current)


def _moves(position: Channel) -> bool:
    early, late = position.values[:HEAD], position.values[HEAD : 2 * HEAD]
    scatter = float(np.nanstd(np.diff(early)))
    return abs(float(np.nanmean(late - early))) > 2.0 * scatter + 1.5 * position.resolution


def _is_near_zero(channel: Channel) -> bool:
    head, scatter = channel.values[:HEAD], float(np.nanstd(np.diff(channel.values[: 8 * HEAD])))
    return abs(float(np.nanmean(head))) <= 3.0 * scatter + channel.resolution
