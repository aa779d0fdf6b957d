"""What a capture's channels read, block by block, as the likelihood compares it with the model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, HELD, POSITION, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.signals.opened_voltage import emf_shows
from motorid.estimate.signals.source.discontinuous_current import unclear
from motorid.estimate.signals.time_grid import Timeline
from motorid.estimate.solver.problem import Block
from motorid.motor.reading import Output, Quantity

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

EMF = "back_emf"  # the terminal voltage while the bridge is open
FEWEST = 10  # readings that make a block
TINY = 1e-7  # of a channel's range: the floor of a noise level where no resolution is declared


@dataclass(frozen=True)
class Measured:
    """One block: its readings (SI), where they sit on the grid, and the roots of their weights.

    ``scale``: the model's unit in the channel's, which reads behind a gear.
    """

    block: Block
    values: Floats
    keep: NDArray[np.intp]  # grid ticks
    where: slice | NDArray[np.intp]  # the same; a slice where they follow each other
    root_weights: Floats | None
    row: int  # of the response
    channel: Channel
    unsigned: bool = False
    past: Floats | None = None  # share of a grid period by which each is later than its tick
    scale: float = 1.0

    @property
    def resolution(self) -> float:
        """Of a reading, in the model's unit."""
        return self.channel.resolution * self.scale

    @property
    def noise(self) -> float:
        """Declared of a reading, in the model's unit; 0: nothing."""
        return self.channel.noise * self.scale

    def of(self, response: Floats) -> Floats:
        """What the response (outputs, count) shows at these readings."""
        at_tick = response[self.row, self.where]
        if self.past is None:
            return at_tick
        return np.asarray(at_tick + self.past * (response[self.row, self.keep + 1] - at_tick))


def read(
    capture: Capture, timeline: Timeline, driven: Bools, shows_emf: bool
) -> tuple[tuple[Measured, ...], list[Output]]:
    """The blocks of a capture, and how the model must read for each."""
    outputs: list[Output] = []
    measured: list[Measured] = []
    gear = capture.wiring.gear_ratio or 1.0

    def add(channel: Channel, name: str, quantity: Quantity, keep: Bools, scale: float) -> None:
        shown = timeline.spread(np.where(_fresh(capture, channel), channel.values, np.nan))
        kept = np.flatnonzero(keep & np.isfinite(shown))
        if len(kept) >= FEWEST:
            block = _block(channel, name, shown[kept] * scale, kept, scale, len(outputs))
            if timeline.past is not None:
                block = replace(block, past=timeline.spread(timeline.past)[kept])
            measured.append(block)
            outputs.append(_output(channel, quantity, name))

    everywhere = ~_clipped(capture, timeline)
    everywhere[0] = False  # its window lies before the record
    current, motion_ = capture.get(CURRENT), motion(capture)
    if current is not None:
        # a magnitude tells nothing where noise decides its sign
        shown = everywhere & driven if current.unsigned else everywhere
        shown = shown & ~unclear(current, timeline, capture.wiring.pwm_hz)
        add(current, CURRENT, Quantity.CURRENT, shown, 1.0)
    if motion_ is not None:
        quantity = Quantity.POSITION if motion_.name == POSITION else Quantity.SPEED
        add(motion_, motion_.name, quantity, everywhere, gear)
    volts = capture.get(VOLTAGE)
    if volts is not None and shows_emf:
        add(volts, EMF, Quantity.SPEED, everywhere & emf_shows(capture, timeline, volts), 1.0)
    return tuple(measured), outputs


def _output(channel: Channel, quantity: Quantity, name: str) -> Output:
    """How the model reads for a channel, whose delay counts the filter before its converter."""
    after_s = after_filter_s(channel, name)
    filter_s = filter_of(channel, name)
    return Output(quantity, channel.window_s, after_s, channel.pwm_phase, filter_s)


def after_filter_s(channel: Channel, name: str) -> float:
    """The part of a block's delay (s) that its filter does not take."""
    taken_s = filter_of(channel, name)
    if second_order(channel, name):
        taken_s = channel.filter_delay_s
    return max(channel.delay_s - taken_s, 0.0)


def filter_of(channel: Channel, name: str) -> float:
    """Time constant (s) of the filter that the model has before a block's converter."""
    if channel.filter_order == 2:
        return 0.0
    return min(channel.filter_s, channel.delay_s)


def second_order(channel: Channel, name: str) -> bool:
    """The declared low-pass of a log's channel is of second order: its part of the delay too."""
    return channel.filter_order == 2 and channel.filter_s > 0.0 and name != EMF


def motion(capture: Capture) -> Channel | None:
    """Position where there is one, else speed: the two are rarely independent."""
    for name in (POSITION, SPEED):
        channel = capture.get(name)
        if channel is not None and np.isfinite(channel.values).any():
            return channel
    return None


def _fresh(capture: Capture, channel: Channel) -> Bools:
    """Samples (n,) at which a channel that repeats its readings has a new one."""
    held = capture.provenance.get(HELD, {})
    period = held.get(channel.name, 1) if isinstance(held, Mapping) else 1
    fresh = np.ones(len(capture), dtype=bool)
    if isinstance(period, int) and period > 1:
        changes = np.flatnonzero(np.diff(channel.raw)) + 1
        phase = int(np.bincount(changes % period, minlength=1).argmax())
        fresh = np.arange(len(capture)) % period == phase
    return fresh


def _clipped(capture: Capture, timeline: Timeline) -> Bools:
    """Grid ticks at which the current or voltage converter was at its end."""
    clipped = np.zeros(len(capture), dtype=bool)
    for name in (CURRENT, VOLTAGE):
        channel = capture.get(name)
        if channel is not None:
            clipped |= channel.saturated
    return timeline.spread(clipped.astype(np.float64)) > 0


def _block(
    channel: Channel,
    name: str,
    values: Floats,
    kept: NDArray[np.intp],
    scale: float,
    row: int,
) -> Measured:
    extent = float(np.ptp(values)) or float(np.abs(values).max()) or 1.0
    floor = max(channel.resolution * scale / np.sqrt(12.0), TINY * extent)
    roots, count = None, float(len(values))
    if name == POSITION and channel.resolution > 0:
        roots = repeated_count_weights(values)
        count = float((roots**2).sum())
    first, last = int(kept[0]), int(kept[-1]) + 1
    where = slice(first, last) if last - first == len(kept) else kept
    # readings of one kind have one noise
    group = f"{name} {channel.resolution * scale:g} {channel.noise * scale:.3g}"
    block = Block(name, floor, count, group)
    unsigned = channel.unsigned
    return Measured(block, values, kept, where, roots, row, channel, unsigned, scale=scale)


def repeated_count_weights(values: Floats) -> Floats:
    """Roots of weights that make a run of equal encoder counts worth one reading, (n,).

    The error of a count is the same as long as the count does not change.
    """
    edges = np.flatnonzero(np.diff(values)) + 1
    lengths = np.diff(np.concatenate([[0], edges, [len(values)]]))
    return np.asarray(np.repeat(lengths**-0.5, lengths), dtype=np.float64)
