"""A board with its limits in force, for readings that are no capture: at rest, or at one level."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.acquire.board import Board, Fields
from motorid.acquire.check import check_supply, check_zero, judge_sensors
from motorid.acquire.contacts import check_inputs
from motorid.acquire.drive import drive, load, tripped
from motorid.acquire.interrupt import interruptible
from motorid.acquire.link import Port
from motorid.acquire.live import LiveView
from motorid.acquire.plan import sample_period, wire_program
from motorid.acquire.pulse import Pulse, weak_pulse
from motorid.acquire.record import Progress, configure
from motorid.acquire.safety import check_program, pulse_resistance
from motorid.acquire.timeline import Timeline
from motorid.capture.model import POSITION
from motorid.errors import RigError
from motorid.program import Decay, Program, Step, StepKind
from motorid.rig import Rig
from motorid.rig_keys import CHANNELS
from motorid.wire.codec import SampleBlock, mask_channels

HIGHEST_HZ = 1000.0  # of a level's samples: more would only load the link
BLOCKS = 16  # of a level's readings: their scatter tells the mean's uncertainty
BEFORE_S = 0.05
WEAK = 0.1  # duty of the pulse that shows what is connected
ZERO_S = 0.2
HIDDEN = 1 / math.sqrt(12)  # counts, where noise does not dither them


@dataclass(frozen=True)
class Level:
    """Mean raw reading of one channel over a steady level, in counts, and its uncertainty."""

    mean: float
    uncertainty: float  # standard: noise, and what it drifted by
    drift: float  # of the second half over the first


class Session:
    """One identified board. The bridge is open except within ``hold`` and ``pulse``."""

    def __init__(self, port: Port, rig: Rig, progress: Progress | None = None) -> None:
        self.port, self.progress = port, progress
        self.board = Board(port)
        self.board.identify()
        self.board.make_ready()
        names = tuple(name for name in self.board.descriptors if name in CHANNELS)
        sampling = replace(
            rig.sampling,
            rate_hz=min(rig.sampling.rate_hz, HIGHEST_HZ),
            channels=names,
            mode="stream",
        )
        self.rig = replace(rig, sampling=sampling)
        self.config = configure(self.board, self.rig)
        check_inputs(self.board, self.rig)
        self.last_zero: Fields = {}
        self.zero_samples = 0  # that it is the mean of

    @property
    def facts(self) -> Mapping[str, Fields]:
        """The descriptors of the board's channels."""
        return self.board.descriptors

    def zero(self, seconds: float = ZERO_S) -> tuple[Fields, int]:
        """Offsets at rest, and over how many readings."""
        rate_hz = self.board.identity["clock_hz"] / self.config["sample_period_ticks"]
        samples = int(min(max(seconds * rate_hz, 16), 4096))
        found = self.board.zero(samples)
        check_zero(found, self.board.descriptors)
        self.last_zero, self.zero_samples = found, samples
        return found, samples

    def resting(self, name: str, seconds: float) -> Level:
        """A channel's raw reading with the bridge open, from the board's live readings."""
        until = self.port.now() + seconds
        raw: list[float] = []
        while self.port.now() < until or len(raw) < 2 * BLOCKS:
            raw.append(float(self.board.ask("read_status")[f"{name}_raw"]))
            self.board.wait(seconds / (8 * BLOCKS))
        return level_of(np.array(raw))

    def pulse(self) -> Pulse:
        """A short pulse at a tenth of the supply: what is connected, and what it draws.

        Raises RigError where a sensor is dead, saturated or reversed, KeyboardInterrupt at a stop.
        """
        zero, _ = self.zero()
        supply_v = check_supply(self.board, self.rig)
        with interruptible() as stop:
            found = weak_pulse(self.board, self.rig, self.config, zero, stop, WEAK, supply_v)
        if found is None:
            raise KeyboardInterrupt("interrupted; the bridge is open")
        judge_sensors(self.rig, found)
        return found

    def hold(self, volts: float, seconds: float, pulse: Pulse) -> dict[str, Level]:
        """Drives so many volts for so long and opens the bridge; each channel over the last half.

        ``pulse`` tells what is connected: a level that could pass a limit of the rig is refused.
        Raises RigError where the board trips.
        """
        bound = pulse_resistance(pulse.volts, pulse.peak_a) if pulse.peak_a else None
        program = Program(
            (
                self.board.rest_step(BEFORE_S),
                Step(StepKind.DRIVE_VOLTS, seconds, volts, Decay.SYNCHRONOUS_SLOW),
            )
        )
        plate = replace(self.rig.nameplate, resistance_ohm=None)  # a resistor may stand there
        rig = replace(self.rig, nameplate=plate)
        supply_v = check_supply(self.board, self.rig)
        check_program(rig, program, resistance_ohm=bound, supply_v=supply_v)
        zero, _ = self.zero()
        period = sample_period(self.rig, self.board.identity)
        wire = wire_program(program, self.board.identity, period)
        load(self.board, wire)
        timeline = Timeline(period, wire.ticks // period, mask_channels(self.config["channels"]))
        view = LiveView(self.rig, self.board, zero, wire, self.progress)

        def consume(block: SampleBlock) -> None:
            timeline.add(block)
            view.consume(block)

        with interruptible() as stop:
            reason = drive(self.board, wire, self.config, stop, consume)
        if stop.requested:
            raise KeyboardInterrupt("interrupted; the bridge is open")
        if reason.startswith("fault"):
            raise RigError(f"at {volts:g} V {tripped(reason, self.board.trip)}")
        arrays = timeline.arrays()
        if not len(arrays.ticks):
            raise RigError(f"at {volts:g} V not one sample arrived: check the link")
        late = arrays.ticks > arrays.ticks[-1] - wire.steps[-1]["ticks"] // 2
        return {
            name: level_of(np.asarray(raw[late], dtype=np.float64))
            for name, raw in arrays.columns.items()
            if name != POSITION
        }

    def ticks(self, seconds: float, pairs: int) -> list[tuple[int, float, float]]:
        """The board's tick, and the port's time before and after asking for it, again and again."""
        found = []
        for _ in range(pairs):
            before = self.port.now()
            tick = int(self.board.ask("read_status")["tick"])
            found.append((tick, before, self.port.now()))
            self.board.wait(seconds / pairs)
        return found


def level_of(raw: NDArray[np.float64]) -> Level:
    """Mean of raw readings (n,), its uncertainty from the scatter of sixteen blocks, and drift.

    Who reads a meter meanwhile may do so at any moment: half the drift either way is its limit.
    """
    if len(raw) < 2 * BLOCKS:
        raise RigError("too few samples of a level arrived: check the link, or hold it for longer")
    means = np.array([block.mean() for block in np.array_split(raw, BLOCKS)])
    drift = float(means[BLOCKS // 2 :].mean() - means[: BLOCKS // 2].mean())
    scatter = float(means.std(ddof=1)) / math.sqrt(BLOCKS)
    hidden = HIDDEN if float(raw.std()) < 0.5 else 0.0
    return Level(float(raw.mean()), math.sqrt(scatter**2 + hidden**2 + drift**2 / 3), drift)
