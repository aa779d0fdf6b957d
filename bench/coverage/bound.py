"""How well the data of a rig could know the motor: the linearised bound, without the fit.

Fisher information of the six parameters and of everything else that is unknown about the readings,
each with the prior that its stated uncertainty gives; and again with a brush drop that nobody
knows, as the wider model has it. Where the motor has iron, windage or friction that follows load,
their sizes are unknown as well. The voltage is a source of unknown level behind an unknown
resistance in each part of the program, as read by its own noisy channel. Noise is the declared
noise of the converter with its rounding; an encoder's count is one reading for as long as it stays.
Derivatives are central differences of the exact response at the truth; no code of
``motorid.estimate`` takes part.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SUPPLY, VOLTAGE, Capture, Channel
from motorid.motor import wide
from motorid.motor.reading import Output, Quantity, Stretch
from motorid.motor.response import Response
from motorid.motor.wide import WideResponse
from motorid.program import StepKind

Floats = NDArray[np.float64]
NAMES = ("R", "L", "K", "B", "J", "T0")
STEP = 1e-5  # relative, of a central difference: larger ones make a gain look observable
FLOOR = 1e-15  # of the scaled information: beyond it nothing is known
FREE = np.inf
BRUSH = {"brush drop", "brush bend"}
BEND_SD = 1.0  # of the logarithm of a brush drop's current
CLAMP_DROPS_V = 1.4  # of the two diodes that carry a freewheeling current
TURN_ON = 3  # samples after a step at which a sensed voltage is not yet the part's own


@dataclass(frozen=True)
class Unknown:
    """One thing not known: how the readings of run ``run`` (None: of all) follow it; its prior."""

    name: str
    size: float  # step of the central difference
    prior_sd: float = FREE
    run: int | None = None


@dataclass(frozen=True)
class Brush:
    """The true drop over both brushes (V), and the current (A) at which it bends."""

    volts: float = 0.0
    amperes: float = 1.0

    def share(self, current: Floats, bend: float) -> Floats:
        """The drop over its largest; ``bend`` is added to the logarithm of its current."""
        return np.asarray(current / np.hypot(current, self.amperes * np.exp(bend)))


NO_DROP = Brush()
SHAPES = ("reaction_bend", "saturation_current", "eddy_time")  # known to a factor of e


class Twin:
    """The averaged model of one run at the truth, as a function of named changes."""

    def __init__(
        self,
        capture: Capture,
        truth: Mapping[str, float],
        series_ohm: float,
        brush: Brush,
        added: Mapping[str, float],
    ) -> None:
        self.capture, self.truth, self.series = capture, truth, series_ohm
        self.brush, self.added = brush, added
        self._amperes: Floats | None = None
        self._steps: NDArray[np.uint8] | None = None
        self.period = capture.period_s
        self.parts = _parts(capture)
        self.supply = capture.wiring.supply_voltage_v
        self.volts = capture.get(VOLTAGE)
        self.levels = [self._level(*part) for part in self.parts]

    def _level(self, start: int, stop: int, number: int) -> float:
        """Volts of the source in a part: what its channel shows once the step has settled."""
        step = self.capture.program.steps[number]  # type: ignore[union-attr]
        if step.kind == StepKind.DRIVE_DUTY:
            return step.level * self.supply
        return step.level if step.kind == StepKind.DRIVE_VOLTS else 0.0

    def readings(self, change: Mapping[str, float]) -> dict[str, Floats]:
        """Every channel's noise-free readings (n,) if things were off by ``change``."""
        get = change.get
        clock = 1.0 + get("clock", 0.0)
        levels = [v + get(f"level {k}", 0.0) for k, v in enumerate(self.levels)]
        volts = np.zeros(len(self.capture))
        stretches = []
        behind = self.series + get("series", 0.0) + get("source", 0.0)
        for level, (start, stop, number) in zip(levels, self.parts, strict=True):
            volts[start:stop] = level
            kind = self.capture.program.steps[number].kind  # type: ignore[union-attr]
            opened = kind == StepKind.COAST
            stretches.append(Stretch(start, opened, behind, self.supply + CLAMP_DROPS_V))
        source = volts
        if BRUSH & change.keys():
            volts = volts - self._dropped(volts, stretches, change)
        outputs = [self._output(name, get, clock) for name in (CURRENT, POSITION)]
        sensed = self.volts
        if sensed is not None:
            late = clock * sensed.delay_s + get(f"{VOLTAGE} delay", 0.0)
            wide = clock * sensed.aperture_s
            outputs += [Output(Quantity.CURRENT, wide, late), Output(Quantity.SPEED, wide, late)]
        motor = [self.truth[name] * (1.0 + get(name, 0.0)) for name in NAMES]
        rows = self._rows(clock * self.period, volts, outputs, stretches, motor, change)
        out = {
            CURRENT: rows[0] * (1 + get("current gain", 0.0)) + get("current offset", 0.0),
            POSITION: rows[1] + get("origin", 0.0),
        }
        if sensed is not None:
            out[VOLTAGE] = self._sensed(rows[2], rows[3], source, stretches, motor[2], change)
        return out

    def _rows(
        self,
        period_s: float,
        volts: Floats,
        outputs: Sequence[Output],
        stretches: Sequence[Stretch],
        six: Sequence[float],
        change: Mapping[str, float],
    ) -> Floats:
        """The response of the six, or with what the motor has besides."""
        if not self.added:
            return Response(period_s, volts, outputs, stretches)(six)
        response = WideResponse(period_s, volts, outputs, stretches)
        sizes = {name: v * (1.0 + change.get(name, 0.0)) for name, v in self.added.items()}
        motor = [*six, *(sizes.get(name, 0.0) for name in wide.NAMES[len(six) :])]
        if self._steps is None:
            response.plan(motor)
            self._steps = response.levels
        response.levels = self._steps
        return response(motor)

    def _dropped(
        self, volts: Floats, stretches: Sequence[Stretch], change: Mapping[str, float]
    ) -> Floats:
        """Volts (n,) by which the brushes' drop changes, at the current of the truth."""
        if self._amperes is None:
            mean = Output(Quantity.CURRENT, self.period)
            motor = [self.truth[name] for name in NAMES]
            self._amperes = Response(self.period, volts, [mean], stretches)(motor)[0]
        drop, bend = change.get("brush drop", 0.0), change.get("brush bend", 0.0)
        before, after = self.brush.share(self._amperes, 0.0), self.brush.share(self._amperes, bend)
        return np.asarray((self.brush.volts + drop) * after - self.brush.volts * before)

    def _output(self, name: str, get: Callable[..., float], clock: float) -> Output:
        channel = self.capture.channels[name]
        if name == POSITION:
            return Output(Quantity.POSITION)
        wide = channel.aperture_s if channel.kind == "mean" else 0.0
        late = clock * channel.delay_s + get(f"{CURRENT} delay", 0.0)
        return Output(Quantity.CURRENT, clock * wide, late)

    def _sensed(
        self,
        current: Floats,
        speed: Floats,
        volts: Floats,
        stretches: Sequence[Stretch],
        constant: float,
        change: Mapping[str, float],
    ) -> Floats:
        """The voltage channel: the source less its own drop, and the back-EMF while open."""
        shown = volts - change.get("source", 0.0) * current
        ends = [s.start for s in stretches[1:]] + [len(volts)]
        for stretch, end in zip(stretches, ends, strict=True):
            if stretch.open:
                shown[stretch.start : end] = constant * speed[stretch.start : end]
        gain, offset = change.get("voltage gain", 0.0), change.get("voltage offset", 0.0)
        return np.asarray(shown * (1 + gain) + offset)


def _parts(capture: Capture) -> list[tuple[int, int, int]]:
    """(first, end, step) of every step in samples, as the program began them."""
    ticks = round(capture.clock_hz * capture.period_s)
    first = int(capture.ticks[0])
    starts = [max((p.tick - first) // ticks + 1, 0) for p in capture.phases]
    starts[0] = 0
    spans = pairwise([*starts, len(capture)])
    return [(a, b, p.index) for (a, b), p in zip(spans, capture.phases, strict=True) if b > a]


def deviation(channel: Channel) -> float:
    """Standard deviation of one reading: declared noise and rounding."""
    return float(np.hypot(channel.noise, channel.resolution / np.sqrt(12)))


def weights(capture: Capture) -> dict[str, Floats]:
    """1/sd of every reading (n,), 0 where the reading tells nothing."""
    out = {}
    for name, channel in capture.channels.items():
        w = np.full(len(capture), 1.0 / deviation(channel))
        if name == POSITION:
            w *= _once_a_count(channel.values)
        w[0] = 0.0
        w[channel.saturated] = 0.0
        out[name] = w
    if VOLTAGE in out:
        for start, _, _ in _parts(capture):
            out[VOLTAGE][start : start + TURN_ON] = 0.0
    return out


def _once_a_count(values: Floats) -> Floats:
    """Roots of weights that add up to 1 over a stretch of equal counts."""
    starts = np.concatenate([[0], np.flatnonzero(np.diff(values)) + 1, [len(values)]])
    lengths = np.diff(starts)
    return np.asarray(np.repeat(lengths**-0.5, lengths))


def unknowns(captures: Sequence[Capture], twins: Sequence[Twin], late_s: float) -> list[Unknown]:
    """Everything that the readings depend on and nobody knows."""
    first = captures[0]
    current, wiring = first.channels[CURRENT], first.wiring
    sensed = first.get(VOLTAGE)
    level = sensed or first.channels[SUPPLY]
    gain = level.gain_uncertainty
    if sensed is None:  # a supply stays where it is: its offset is a gain of every voltage
        gain = float(np.hypot(gain, level.offset_uncertainty / np.median(np.abs(level.values))))
    amps, top = float(np.ptp(current.values)), float(np.ptp(level.values)) or 1.0
    where = sensed.sense if sensed is not None else "supply"
    leads, bridge = wiring.lead_resistance_uncertainty_ohm, wiring.bridge_resistance_uncertainty_ohm
    series = {"terminals": 0.0, "bridge": leads}.get(str(where), float(np.hypot(leads, bridge)))
    found = [Unknown(name, STEP) for name in NAMES]
    found += [
        Unknown("current gain", STEP, current.gain_uncertainty),
        Unknown("clock", STEP, first.clock_uncertainty),
        Unknown("series", STEP * twins[0].truth["R"], series),
        Unknown(f"{CURRENT} delay", 1e-7, late_s),
        Unknown("voltage gain", STEP, gain),
        Unknown("brush drop", STEP * top),
        Unknown("brush bend", STEP, BEND_SD),
        *(Unknown(name, STEP, 1.0 if name in SHAPES else FREE) for name in twins[0].added),
    ]
    if sensed is not None:
        found += [Unknown("source", STEP * twins[0].truth["R"])]
        found += [Unknown(f"{VOLTAGE} delay", 1e-7, late_s)]
    for k, (capture, twin) in enumerate(zip(captures, twins, strict=True)):
        own = capture.channels[CURRENT]
        found.append(Unknown("current offset", STEP * amps, own.offset_uncertainty, k))
        found.append(Unknown("origin", 1e-3, FREE, k))
        if sensed is not None:
            volts = capture.channels[VOLTAGE]
            found.append(Unknown("voltage offset", STEP * top, volts.offset_uncertainty, k))
        for n, (start, stop, step) in enumerate(twin.parts):
            kind = capture.program.steps[step].kind  # type: ignore[union-attr]
            if kind in (StepKind.DRIVE_DUTY, StepKind.DRIVE_VOLTS):
                prior = FREE if sensed is not None else deviation(level) / np.sqrt(stop - start)
                found.append(Unknown(f"level {n}", STEP * top, prior, k))
    return [u for u in found if u.prior_sd > 0]


@dataclass(frozen=True)
class AtTruth:
    """A rig's readings at the truth: ``things`` that are unknown (the six first), and by how much
    all weighed readings of each run follow a step of each, (p, n).
    """

    twins: Sequence[Twin]
    things: Sequence[Unknown]
    columns: Sequence[Floats]

    def known(self, without: Container[str]) -> list[int]:
        """Places of the things that are left."""
        return [k for k, thing in enumerate(self.things) if thing.name not in without]

    @property
    def priors(self) -> Floats:
        """Information (p,) of each thing by itself, before any reading."""
        sizes = [0.0 if np.isinf(u.prior_sd) else u.size / u.prior_sd for u in self.things]
        return np.square(sizes)

    def information(self, without: Container[str] = ()) -> Floats:
        """(q, q), priors among it, of what is left."""
        whole = sum(r @ r.T for r in self.columns) + np.diag(self.priors)
        left = self.known(without)
        return np.asarray(whole[np.ix_(left, left)])

    def bound(self, without: Container[str] = ()) -> dict[str, float]:
        """Smallest relative standard deviations of R to T0 that these data allow; ``without``:
        things that are known, such as ``BRUSH``, the drop over brushes.
        """
        found = _deviations(self.information(without))
        return {n: float(found[k] * self.things[k].size) for k, n in enumerate(NAMES)}


def linearised(
    captures: Sequence[Capture],
    truth: Mapping[str, float],
    late_s: float = 0.0,
    brush: Brush = NO_DROP,
    added: Mapping[str, float] | None = None,
) -> AtTruth:
    """The rig at the truth. ``late_s``: stated standard uncertainty of the delays of current and
    voltage. ``added``: fields of ``motor.wide`` (SI) that the motor has besides the six.
    """
    wiring = captures[0].wiring
    sensed = captures[0].get(VOLTAGE)
    where = sensed.sense if sensed is not None else "supply"
    both = wiring.lead_resistance_ohm + wiring.bridge_resistance_ohm
    series = {"terminals": 0.0, "bridge": wiring.lead_resistance_ohm}.get(str(where), both)
    twins = [Twin(capture, truth, series, brush, added or {}) for capture in captures]
    things = unknowns(captures, twins, late_s)
    each = enumerate(zip(captures, twins, strict=True))
    return AtTruth(twins, things, [_columns(c, t, things, k) for k, (c, t) in each])


def _deviations(information: Floats) -> Floats:
    """Standard deviations (p,), in the steps of each unknown."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(information), 1e-300))
    values, vectors = np.linalg.eigh(information * np.outer(scale, scale))
    variances = (vectors**2) @ (1.0 / np.maximum(values, FLOOR * values[-1]))
    return np.asarray(np.sqrt(variances) * scale)


def _columns(capture: Capture, twin: Twin, things: Sequence[Unknown], run: int) -> Floats:
    """Derivatives of all weighed readings of one run, in steps of each unknown: (p, n)."""
    weight = weights(capture)
    out = []
    for thing in things:
        if thing.run not in (None, run):
            out.append(None)
            continue
        high, low = (twin.readings(_change(thing, twin, s)) for s in (1.0, -1.0))
        parts = [weight[name] * (high[name] - low[name]) / 2 for name in high]
        out.append(np.concatenate(parts))
    size = next(len(column) for column in out if column is not None)
    return np.array([np.zeros(size) if column is None else column for column in out])


def _change(thing: Unknown, twin: Twin, sign: float) -> dict[str, float]:
    """The change that a step of one unknown makes; a supply's gain moves every level with it."""
    if thing.name == "voltage gain" and twin.volts is None:
        return {f"level {k}": sign * thing.size * v for k, v in enumerate(twin.levels)}
    return {thing.name: sign * thing.size}
