"""One capture of a driven motor as the likelihood sees it: residuals of current, motion and EMF."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture, Channel
from motorid.errors import DataError
from motorid.estimate.likelihood import Block, Unknown
from motorid.estimate.timeline import Part, lay
from motorid.estimate.types import PARAMETERS
from motorid.estimate.voltage import (
    Sense,
    Source,
    bridge_prior,
    clamp_voltage,
    pwm_shape,
    sense,
    source_resistance,
    sources,
    supply_voltage,
)
from motorid.motor.response import Output, Quantity, Response, Stretch

Floats = NDArray[np.float64]

EMF = "back_emf"  # the terminal voltage while the bridge is open
HEAD = 8  # samples that show whether a record begins at rest
QUIET_SAMPLES = 10  # that tell an offset
FREEWHEEL_SAMPLES = 3  # of an opened bridge whose voltage is not yet the back-EMF
INNOVATION = 0.3  # of a reading's least standard deviation, once its past is known
TINY = 1e-7  # of a channel's range: the floor of a noise level where no resolution is declared


@dataclass(frozen=True)
class Measured:
    """One block: its readings (SI), where they sit on the grid, and the roots of their weights."""

    block: Block
    values: Floats
    keep: NDArray[np.intp]  # grid ticks
    where: slice | NDArray[np.intp]  # the same; a slice where they follow each other
    root_weights: Floats | None
    row: int  # of the response
    channel: Channel
    unsigned: bool = False


@dataclass(frozen=True)
class _Nuisance:
    current_offset: int = -1
    origin: int = -1
    voltage_offset: int = -1
    speed: int = -1
    current: int = -1


class MotorRecord:
    """Residuals of one capture as a function of the free motor parameters and its nuisances.

    ``free`` names the shared vector; ``fixed`` holds the other parameters. Raises DataError when
    the capture has no voltage, or neither current nor motion.
    """

    def __init__(self, capture: Capture, free: Sequence[str], fixed: Mapping[str, float]) -> None:
        self.capture = capture
        self.timeline = lay(capture)
        sensed = sense(capture, self.timeline)
        if sensed is None:
            raise DataError("the capture holds no voltage: R, L and K cannot be known from it")
        self.sensed: Sense = sensed
        self.gear = capture.wiring.gear_ratio or 1.0
        self._template = np.array([fixed.get(name, np.nan) for name in PARAMETERS])
        self._places = [PARAMETERS.index(name) for name in free]
        self.supply_v = supply_voltage(capture)
        self.clamp_v = clamp_voltage(capture, sensed)
        self._lost = np.isnan(self.timeline.spread(np.zeros(len(capture))))
        self.driven = self._driven()
        self.sources: tuple[Source | None, ...] = tuple(None for _ in self.timeline.parts)
        self.measured, outputs = self._channels()
        if not self.measured:
            raise DataError("the capture holds neither a current nor a position or speed to fit")
        self.unknowns, self._own = self._nuisances()
        self.blocks = tuple(m.block for m in self.measured)
        self._filters: tuple[Floats | None, ...] = tuple(None for _ in self.measured)
        pwm = capture.wiring.pwm_hz
        self.response = Response(
            self.timeline.period_s, sensed.volts, outputs, pwm_period_s=1.0 / pwm if pwm else 0.0
        )
        amperes = capture.get(CURRENT)
        if amperes is not None:
            self.take_sources(self.timeline.spread(amperes.values), bridge_prior(capture)[0])
        else:
            self._excite()
        self._key: tuple[float, ...] = ()
        self._last = np.empty(0)

    # ---- set-up ---------------------------------------------------------------------------

    def _driven(self) -> NDArray[np.bool_]:
        """Intervals in which the bridge connects the motor, (count,)."""
        driven = np.ones(self.timeline.count, dtype=bool)
        for part in self.timeline.parts:
            driven[part.slice] = not part.open
        return driven

    def _channels(self) -> tuple[tuple[Measured, ...], list[Output]]:
        outputs: list[Output] = []
        measured: list[Measured] = []

        def add(channel: Channel, name: str, quantity: Quantity, keep: NDArray[np.bool_]) -> None:
            kept = np.flatnonzero(keep & np.isfinite(self.timeline.spread(channel.values)))
            if len(kept) >= QUIET_SAMPLES:
                measured.append(self._measured(channel, name, kept, len(outputs)))
                outputs.append(
                    Output(quantity, _aperture(channel), channel.delay_s, channel.pwm_phase)
                )

        everywhere = ~self._clipped()
        everywhere[0] = False  # its window lies before the record
        current, motion = self.capture.get(CURRENT), self._motion()
        if current is not None:
            # a magnitude tells nothing where noise decides its sign
            shown = everywhere & self.driven if current.unsigned else everywhere
            add(current, CURRENT, Quantity.CURRENT, shown)
        if motion is not None:
            quantity = Quantity.POSITION if motion.name == POSITION else Quantity.SPEED
            add(motion, motion.name, quantity, everywhere)
        volts = self.capture.get(VOLTAGE)
        if volts is not None and self.sensed.shows_emf:
            add(volts, EMF, Quantity.SPEED, everywhere & self._emf_shows())
        return tuple(measured), outputs

    def _motion(self) -> Channel | None:
        """Position where there is one, else speed: the two are rarely independent."""
        for name in (POSITION, SPEED):
            channel = self.capture.get(name)
            if channel is not None and np.isfinite(channel.values).any():
                return channel
        return None

    def _clipped(self) -> NDArray[np.bool_]:
        """Grid ticks at which the current or voltage converter was at its end."""
        clipped = np.zeros(len(self.capture), dtype=bool)
        for name in (CURRENT, VOLTAGE):
            channel = self.capture.get(name)
            if channel is not None:
                clipped |= channel.saturated
        return self.timeline.spread(clipped.astype(np.float64)) > 0

    def _emf_shows(self) -> NDArray[np.bool_]:
        shows = np.zeros(self.timeline.count, dtype=bool)
        for part in self.timeline.parts:
            if part.open:
                late = FREEWHEEL_SAMPLES if part.start else 0
                shows[part.start + late : part.stop] = True
        return shows

    def _measured(self, channel: Channel, name: str, kept: NDArray[np.intp], row: int) -> Measured:
        values = self.timeline.spread(channel.values)[kept]
        gear = self.gear if name in (POSITION, SPEED) else 1.0
        values = values * gear
        extent = float(np.ptp(values)) or float(np.abs(values).max()) or 1.0
        floor = max(channel.resolution * gear / np.sqrt(12.0), TINY * extent)
        roots, count = None, float(len(values))
        if name == POSITION and channel.resolution > 0:
            roots = repeated_count_weights(values)
            count = float((roots**2).sum())
        first, last = int(kept[0]), int(kept[-1]) + 1
        where = slice(first, last) if last - first == len(kept) else kept
        group = (
            f"{name} {channel.resolution:g} {channel.noise:.3g}"  # one kind of reading, one noise
        )
        block = Block(name, floor, count, group)
        return Measured(block, values, kept, where, roots, row, channel, channel.unsigned)

    def _nuisances(self) -> tuple[tuple[Unknown, ...], _Nuisance]:
        unknowns: list[Unknown] = []
        places: dict[str, int] = {}
        names = {m.block.name: m for m in self.measured}

        def add(key: str, unknown: Unknown) -> None:
            places[key] = len(unknowns)
            unknowns.append(unknown)

        quiet = int((~self.driven).sum())
        current = names.get(CURRENT)
        if current is not None and not current.unsigned:
            sd = current.channel.offset_uncertainty or np.inf
            if quiet >= QUIET_SAMPLES or np.isfinite(sd):
                size = float(np.ptp(current.values)) or 1.0
                at_rest = current.values[~self.driven[current.keep]]
                start = float(np.median(at_rest)) if len(at_rest) >= QUIET_SAMPLES else 0.0
                add("current_offset", Unknown("current_offset", start, scale=size, prior_sd=sd))
        position = names.get(POSITION)
        if position is not None:
            size = float(np.ptp(position.values)) or 1.0
            add("origin", Unknown("position_origin", float(position.values[0]), scale=size))
        emf = names.get(EMF)
        volts = self.sensed.channel
        if volts is not None and self.sensed.shows_emf:
            sd = volts.offset_uncertainty or np.inf
            if np.isfinite(sd) or (emf is not None and len(emf.values) >= QUIET_SAMPLES):
                size = float(np.abs(self.sensed.volts).max()) or 1.0
                add("voltage_offset", Unknown("voltage_offset", 0.0, scale=size, prior_sd=sd))
        if not self.starts_at_rest:
            self._moving_start(names, add)
        return tuple(unknowns), _Nuisance(**places)

    def _moving_start(self, names: Mapping[str, Measured], add: object) -> None:
        assert callable(add)
        motion = names.get(POSITION) or names.get(SPEED)
        if motion is not None:
            first = motion.values[:8]
            if motion.block.name == POSITION:
                first = np.gradient(motion.values[:8], motion.keep[:8] * self.timeline.period_s)
            size = float(np.abs(first).max()) or 1.0
            add("speed", Unknown("initial_speed", float(first.mean()), scale=size))
        current = names.get(CURRENT)
        if current is not None and self.driven[0]:
            size = float(np.ptp(current.values)) or 1.0
            add("current", Unknown("initial_current", float(current.values[0]), scale=size))

    @property
    def starts_at_rest(self) -> bool:
        """The motor stands still, and carries no current, over the first few samples."""
        motion, current = self._motion(), self.capture.get(CURRENT)
        if motion is not None and motion.name == POSITION and _moves(motion):
            return False
        if motion is not None and motion.name == SPEED and not _is_near_zero(motion):
            return False
        return self.timeline.parts[0].open or current is None or _is_near_zero(current)

    # ---- excitation -------------------------------------------------------------------------

    def take_sources(self, current: Floats, ohms: float) -> None:
        """Judge the sources with ``current`` (count,), the mean over their windows."""
        parts = self.timeline.parts
        self.sources = sources(self.sensed, current, parts, self._lost, ohms)
        self._excite()

    def _excite(self) -> None:
        volts = self.sensed.volts.copy()
        stretches = []
        for part, source in zip(self.timeline.parts, self.sources, strict=True):
            if source is not None:
                volts[part.slice] = source.volts
            ohms = self.sensed.series_ohm + (source.ohms if source else 0.0)
            stretches.append(self._stretch(part, ohms, volts))
        self.volts = volts
        self._key = ()
        self.response.excite(volts, stretches)
        self.stretches = tuple(stretches)

    def _stretch(self, part: Part, ohms: float, volts: Floats) -> Stretch:
        level = float(np.mean(volts[part.slice]))
        duty, swing = pwm_shape(part, level, self.supply_v)
        return Stretch(part.start, part.open, ohms, self.clamp_v, duty, swing)

    def retake_sources(self, shared: Floats, own: Floats) -> None:
        """Judge the source lines with the model's own current over the voltage's windows."""
        channel = self.sensed.channel
        aperture = (channel.aperture_s if channel else 0.0) or self.timeline.period_s
        window = Output(Quantity.CURRENT, aperture, channel.delay_s if channel else 0.0)
        over = Response(self.timeline.period_s, self.volts, [window], self.stretches)
        current = over(self.motor(shared), self._initial(own))[0]
        prior = bridge_prior(self.capture)
        ohms = source_resistance(self.sensed, current, self.timeline.parts, self._lost, prior)
        self.take_sources(current, ohms)

    # ---- the model ----------------------------------------------------------------------------

    def motor(self, shared: Floats) -> Floats:
        """(R, L, K, B, J, T0) for a vector of the free ones."""
        values = self._template.copy()
        values[self._places] = shared
        return values

    def readings(self, shared: Floats, own: Floats, period_s: float | None = None) -> Floats:
        """The response (outputs, count) before offsets; remembers the last one."""
        bias = float(own[self._own.voltage_offset]) if self._own.voltage_offset >= 0 else 0.0
        initial = self._initial(own)
        key = (*shared, bias, *initial, period_s or 0.0)
        if key != self._key:
            self.response.shift(-bias)
            self._last = self.response(self.motor(shared), initial, period_s)
            self._key = key
        return self._last

    def _initial(self, own: Floats) -> tuple[float, float, float]:
        n = self._own
        current = float(own[n.current]) if n.current >= 0 else 0.0
        return current, float(own[n.speed]) if n.speed >= 0 else 0.0, 0.0

    def fitted(self, shared: Floats, own: Floats, period_s: float | None = None) -> list[Floats]:
        """The model of every block's readings, offsets included, in its own unit (motor shaft)."""
        n = self._own
        readings = self.readings(shared, own, period_s)
        K = self.motor(shared)[2]
        models = []
        for m in self.measured:
            y = readings[m.row, m.where]
            if m.block.name == CURRENT:
                if m.unsigned:
                    y = np.abs(y)
                if n.current_offset >= 0:
                    y = y + own[n.current_offset]
            elif m.block.name == POSITION and n.origin >= 0:
                y = y + own[n.origin]
            elif m.block.name == EMF:
                y = K * y + (own[n.voltage_offset] if n.voltage_offset >= 0 else 0.0)
            models.append(y)
        return models

    def driven_by(self, volts: Floats, shared: Floats, own: Floats) -> list[Floats]:
        """The model of every block's readings if the source were ``volts`` (count,)."""
        self.response.excite(volts, self.stretches)
        self._key = ()
        moved = self.fitted(shared, own)
        self.response.excite(self.volts, self.stretches)
        self._key = ()
        return moved

    def whiten(self, filters: Sequence[Floats | None]) -> None:
        """Pass every block's residuals through a filter 1, -c1, -c2 .. from now on; None: as is."""
        self._filters = tuple(filters)
        self.blocks = tuple(
            m.block
            if f is None
            else replace(
                m.block,
                floor=m.block.floor * INNOVATION,
                count=max(m.block.count - len(f) + 1, 1.0),
            )
            for m, f in zip(self.measured, filters, strict=True)
        )

    def weighed(self, parts: Sequence[Floats], filtered: bool = True) -> list[Floats]:
        """Changes of the readings, one array per block, as the likelihood counts them."""
        out = []
        for m, f, part in zip(self.measured, self._filters, parts, strict=True):
            r = part if m.root_weights is None else part * m.root_weights
            out.append(r if f is None or not filtered else np.convolve(r, f, "valid"))
        return out

    def residuals(self, shared: Floats, own: Floats) -> list[Floats]:
        """Measured less fitted, weighed; one array per block."""
        return self.weighed(self.departures(shared, own))

    def departures(self, shared: Floats, own: Floats) -> list[Floats]:
        """Measured less fitted in SI units, one array per block."""
        fitted = self.fitted(shared, own)
        return [m.values - y for m, y in zip(self.measured, fitted, strict=True)]


def _moves(position: Channel) -> bool:
    early, late = position.values[:HEAD], position.values[HEAD : 2 * HEAD]
    scatter = float(np.nanstd(np.diff(early)))
    return abs(float(np.nanmean(late - early))) > 2.0 * scatter + 1.5 * position.resolution


def _is_near_zero(channel: Channel) -> bool:
    head, scatter = channel.values[:HEAD], float(np.nanstd(np.diff(channel.values[: 8 * HEAD])))
    return abs(float(np.nanmean(head))) <= 3.0 * scatter + channel.resolution


def _aperture(channel: Channel) -> float:
    return channel.aperture_s if channel.kind == "mean" else 0.0


def repeated_count_weights(values: Floats) -> Floats:
    """Roots of weights that make a run of equal encoder counts worth one reading, (n,).

    The error of a count is the same as long as the count does not change.
    """
    edges = np.flatnonzero(np.diff(values)) + 1
    lengths = np.diff(np.concatenate([[0], edges, [len(values)]]))
    return np.asarray(np.repeat(lengths**-0.5, lengths), dtype=np.float64)
