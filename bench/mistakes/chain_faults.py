"""Faults of a log's measuring chain in three sizes, and the words that state each at the import."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from bench.mistakes.log_cases import averaged, filtered, lagging, offset, times
from bench.mistakes.logs import Chain, Station

CHANNELS = {"i": "current", "w": "speed", "v": "voltage"}
SAMPLES = (1, 3, 10)
OFFSETS = (0.002, 0.005, 0.01)  # of the stall current
GAINS = (0.01, 0.015, 0.02)
WINDOWS = ("before", "around", "after")
LOW_PASS, DELAY, OFFSET, MEANS, GAIN = "low-pass", "delay", "offset", "means", "gain"


@dataclass(frozen=True)
class Fault:
    """One fault of one channel. ``size`` in samples, or relative; ``more``: order or window."""

    kind: str
    channel: str
    size: float
    more: str = ""

    @property
    def name(self) -> str:
        """Without its size."""
        return " ".join(filter(None, (CHANNELS[self.channel], self.more, self.kind)))

    @property
    def chain(self) -> Chain:
        """What it does to the channel."""
        if self.kind == LOW_PASS:
            return filtered(self.size, int(self.more[0]))
        if self.kind == DELAY:
            return lagging(self.size)
        if self.kind == OFFSET:
            return offset(self.size)
        return averaged(self.size, self.more) if self.kind == MEANS else times(1 + self.size)


def stated(fault: Fault, station: Station) -> Sequence[str]:
    """The options of the import that state the fault: the only place that knows them."""
    channel, time_s = CHANNELS[fault.channel], fault.size * station.period_s
    if fault.kind == LOW_PASS:
        return ("--filter", f"{channel}={time_s!r}s,{fault.more[0]}")
    if fault.kind == DELAY:
        return ("--delay", f"{channel}={time_s!r}s")
    if fault.kind == OFFSET:
        return ("--offset-uncertainty", f"{channel}={fault.size * station.motor.stall_a!r}")
    if fault.kind == MEANS:
        return ("--aperture", f"{channel}={time_s!r}s,{fault.more}")
    return ("--gain-uncertainty", f"{channel}={fault.size!r}")


def faults(short: bool) -> Iterator[Fault]:
    """Every fault in every size; ``short``: one of them."""
    if short:
        yield Fault(DELAY, "i", 3)
        return
    for k, samples in enumerate(SAMPLES):
        for channel in CHANNELS:
            yield Fault(LOW_PASS, channel, samples, "1st order")
            yield Fault(LOW_PASS, channel, samples, "2nd order")
            yield Fault(DELAY, channel, samples)
            yield Fault(GAIN, channel, GAINS[k])
        yield Fault(OFFSET, "i", OFFSETS[k])
        for window in WINDOWS:
            yield Fault(MEANS, "i", samples, window)
