"""One capture of a driven motor as the likelihood sees it: residuals of current, motion and EMF."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, Capture
from motorid.errors import DataError
from motorid.estimate.bridge import bridge_prior, clamp_voltage, supply_voltage, switched_late
from motorid.estimate.changes import Changes
from motorid.estimate.conduction import confirmed, divided
from motorid.estimate.dead_time import dead_time_loss, swinging, turning
from motorid.estimate.excitation import excitation
from motorid.estimate.flow import Flow
from motorid.estimate.loss import Loss
from motorid.estimate.nuisance import nuisances, starts_at_rest
from motorid.estimate.readings import read
from motorid.estimate.rise import Rise, moving, rises
from motorid.estimate.sense import Sense, sense
from motorid.estimate.solution import Unknown
from motorid.estimate.source import Source, source_resistance, sources
from motorid.estimate.standstill import with_standstill
from motorid.estimate.supply import NO_SAGS, Sag, sags, seen
from motorid.estimate.timeline import lay
from motorid.estimate.types import PARAMETERS
from motorid.estimate.unrest import Unrest
from motorid.estimate.waveform import JOINED, Rival, Shape
from motorid.estimate.weighing import Weighed
from motorid.estimate.window import Window
from motorid.motor.response import Output, Quantity, Response, Stretch

Floats = NDArray[np.float64]

REMEMBERED = 3  # responses: an offset of a reading needs no new one


class MotorRecord(Weighed):
    """Residuals of one capture as a function of the free motor parameters and its nuisances.

    ``free`` names the shared vector; ``fixed`` holds the other parameters; ``shape`` is that of
    a log's voltage between its readings. Raises DataError when
    the capture has no voltage, or neither current nor motion.
    """

    names: tuple[str, ...] = PARAMETERS  # what ``free`` and ``fixed`` may name, in order

    def __init__(
        self,
        capture: Capture,
        free: Sequence[str],
        fixed: Mapping[str, float],
        shape: Shape = JOINED,
    ) -> None:
        self.capture = capture
        timeline = with_standstill(capture, lay(capture))
        sensed = sense(capture, timeline, shape)
        if sensed is None:
            raise DataError("the capture holds no voltage: R, L and K cannot be known from it")
        self.timeline = divided(capture, timeline, sensed)
        self.sensed: Sense = sensed
        self._heard = sensed  # less what the dead time takes, once the current is known
        self.gear = capture.wiring.gear_ratio or 1.0
        self._template = np.array([fixed.get(name, np.nan) for name in self.names])
        self._places = [self.names.index(name) for name in free]
        self.supply_v = supply_voltage(capture)
        self.clamp_v = clamp_voltage(capture, float(np.abs(sensed.volts).max()))
        self._lost = sensed.filled | np.isnan(self.timeline.spread(np.zeros(len(capture))))
        self.driven = self.timeline.driven
        self.sources: tuple[Source | None, ...] = tuple(None for _ in self.timeline.parts)
        self.switched_late = tuple(0 for _ in self.timeline.parts)  # interval up to which it is
        measured, self.outputs = read(capture, self.timeline, self.driven, sensed.shows_emf)
        if not measured:
            raise DataError("the capture holds neither a current nor a position or speed to fit")
        super().__init__(measured)
        self._unrest = Unrest(capture, self.timeline, sensed)
        self.settled = True  # what is lost is that of the model's own current
        self._loss = Loss.of(capture, self.timeline, self.driven, sensed.volts, sensed.commanded)
        self._own = nuisances(
            capture, self.timeline.period_s, self.driven, sensed, self._unrest, self.measured,
            self._loss.unknowns if self._loss is not None else (),
        )  # fmt: skip
        self.unknowns = tuple(self._own.unknowns)
        self.simulated = 0  # responses computed so far
        self.rivals: tuple[Rival, ...] = ()
        pwm = capture.wiring.pwm_hz
        self.response = self.respond(
            self.timeline.period_s,
            sensed.volts,
            self.outputs,
            pwm_period_s=1.0 / pwm if pwm else 0.0,
        )
        amperes = capture.get(CURRENT)
        if amperes is not None:
            ohms = bridge_prior(capture)[0] if sensed.shows_emf else 0.0
            self.take_sources(self.timeline.spread(amperes.values), ohms)
        else:
            self._excite()

    def twin(self) -> MotorRecord:
        """This record as it is now, whatever becomes of it; with a response of its own."""
        twin = copy(self)
        twin.response = self.respond(
            self.timeline.period_s,
            self.volts,
            self.outputs,
            self.stretches,
            self.response.pwm_period_s,
        )
        twin._memory = {}
        return twin

    @property
    def delay_is_free(self) -> bool:
        """The delay of the current is an unknown, not as declared."""
        return self._own.current_late >= 0

    def free_delay(self) -> None:
        """Let the delay of the current be an unknown, the last of all."""
        scale_s = self.response.pwm_period_s or self.timeline.period_s
        self._own.free_delay(self.capture.channels[CURRENT], scale_s)
        self.unknowns = tuple(self._own.unknowns)

    def hold_delay(self) -> None:
        """Take the delay of the current as declared again."""
        self._own.hold_delay()
        self.unknowns = tuple(self._own.unknowns)

    @property
    def starts_at_rest(self) -> bool:
        """The motor stands still, and carries no current, over the first few samples."""
        return starts_at_rest(self.capture, self.driven)

    # ---- excitation -------------------------------------------------------------------------

    def take_sources(
        self,
        current: Floats,
        ohms: float,
        mean: Floats | None = None,
        sagging: Mapping[int, Sag] = NO_SAGS,
    ) -> None:
        """Judge the sources with the current (count,) over windows, and its mean over intervals."""
        parts = self.timeline.parts
        self.sources = sources(self._heard, current, parts, self._lost, ohms, mean, sagging)
        self._excite()

    def _excite(self) -> None:
        driving = excitation(
            self.capture.wiring, self.supply_v, self.clamp_v, self._heard,
            self.timeline.parts, self.sources, self.switched_late,
        )  # fmt: skip
        self.volts, self.stretches, self._first = driving.volts, driving.stretches, driving.first
        self._memory: dict[tuple[float, ...], Floats] = {}
        self.response.excite(self.volts, self.stretches)
        for k, place in self._own.levels.items():
            mean = self._unrest.level_deviation(k, self.sources[k])
            self._own.expect(place, mean)
        self.unknowns = tuple(self._own.unknowns)

    def retake_sources(self, shared: Floats, own: Floats) -> None:
        """Judge the source lines with the model's own current over the voltage's windows."""
        period_s = self.timeline.period_s
        window = self.sensed.window or Window(period_s)
        outputs = [
            *window.outputs, Output(Quantity.SPEED, period_s), Output(Quantity.CURRENT, period_s),
            Output(Quantity.CURRENT),
        ]  # fmt: skip
        volts = self.volts - self._lost_volts(own)
        over = self.respond(period_s, volts, outputs, self.stretches)
        *rows, speed, mean, end = over(self.motor(shared), self._initial(own))
        current = window.current(np.array(rows), mean, self.timeline)
        self.simulated += 1
        resistance, inductance = (float(v) for v in self.motor(shared)[:2])
        self.timeline = confirmed(self.capture, self.timeline, inductance, resistance)
        parts = self.timeline.parts
        if self.sensed.commanded:
            taken = np.broadcast_to(self._heard.lost, len(mean))
            off = swinging(self.capture, parts, mean, taken, inductance, resistance)
            current, mean, end = current - off, mean - off, end - off
        risen = tuple(rises(self.capture, parts, mean, end, inductance, resistance))
        self._lose(mean, speed, risen, shared, own)
        self.switched_late = tuple(
            switched_late(self.capture, part, current, inductance, resistance) for part in parts
        )
        lost, shown = dead_time_loss(
            self.capture, parts, mean, inductance, resistance, risen, seen(window)
        )
        if self.sensed.commanded:
            given = self.sensed.volts - lost
            self._heard = replace(self.sensed, volts=given, lost=lost, lost_shown=lost)
        else:  # the readings show the loss: only their line must know of it
            self._heard = replace(self.sensed, lost=lost, lost_shown=shown)
        ohms = 0.0  # a supply gives way by what it shows, and before a brake there is none
        if not self.sensed.commanded:
            prior = bridge_prior(self.capture) if self.sensed.shows_emf else (0.0, np.inf)
            ohms = source_resistance(self._heard, current, parts, self._lost, prior)
        motor = self.motor(shared)
        for k, place in self._own.coasts.items():
            spread = self._unrest.speed_deviation(k, self.sources[k - 1], motor)
            self._own.expect(place, spread)
        source_v = self._heard.volts + self._heard.lost_shown + ohms * current
        sagging = sags(window, parts, source_v, current, ~self._lost, mean, risen, self.supply_v)
        self.take_sources(current, ohms, moving(mean, risen), sagging)

    def _lose(
        self, mean: Floats, speed: Floats, risen: Sequence[Rise], shared: Floats, own: Floats
    ) -> None:
        """Judge what is lost with the model's own ``mean`` current and speed (count,)."""
        if self._loss is None:
            return
        resistance_ohm, inductance_h = (float(v) for v in self.motor(shared)[:2])
        parts = self.timeline.parts
        emf = self.emf_constant(shared) * speed
        flow = Flow.of(self.capture, parts, mean, inductance_h, resistance_ohm, risen, emf)
        values = self._losing(own)
        unsure = turning(self.capture, self.timeline.parts, mean, inductance_h, resistance_ohm)
        followed = self._loss.follow(flow, resistance_ohm, values, unsure)
        self.settled = followed.near(self._loss, values)
        self._loss = followed
        self._own.expect(self._own.warming, *self._loss.rise[::-1])
        self._own.expect(self._own.loss_bend, *self._loss.bending(values))

    # ---- the model ----------------------------------------------------------------------------

    def respond(
        self,
        period_s: float,
        volts: Floats,
        outputs: Sequence[Output],
        stretches: Sequence[Stretch] = (Stretch(0),),
        pwm_period_s: float = 0.0,
    ) -> Response:
        """The model of the motor, at these readings."""
        return Response(period_s, volts, outputs, stretches, pwm_period_s)

    def unknown(self, name: str, start: float) -> Unknown:
        """A parameter beyond the six, of a model that has more. Raises KeyError where none has."""
        raise KeyError(name)

    def motor(self, shared: Floats) -> Floats:
        """(R, L, K, B, J, T0) for a vector of the free ones."""
        values = self._template.copy()
        values[self._places] = shared
        return values

    def readings(self, shared: Floats, own: Floats) -> Floats:
        """The response (outputs, count) before offsets; remembers the last few."""
        initial = self._initial(own)
        changes = Changes.of(self._own, own, len(self.timeline.parts))
        key = (*shared, *changes.key, *self._losing(own).values(), *initial)
        readings = self._memory.pop(key, None)
        if readings is None:
            self._drive(changes, self._lost_volts(own))
            readings = self.response(self.motor(shared), initial)
            self.simulated += 1
            if len(self._memory) >= REMEMBERED:
                del self._memory[next(iter(self._memory))]
        self._memory[key] = readings  # the latest used is the last to go
        return readings

    def _losing(self, own: Floats) -> dict[str, float]:
        """The unknowns of what is lost."""
        names = self._loss.shapes if self._loss is not None else ()
        return {name: self._own.of(own, name) for name in names}

    def _lost_volts(self, own: Floats) -> Floats | float:
        """V (count,) that they take beyond R i."""
        return 0.0 if self._loss is None else self._loss.volts(self._losing(own))

    def _drive(self, changes: Changes, lost: Floats | float) -> None:
        """Let the response be of these changes, with ``lost`` (V) off the voltage."""
        waveform = self.sensed.waveform
        moved: Floats | float = 0.0
        if waveform is not None and any(changes.late):
            first, *jumps = changes.late
            moved = waveform.means(self.timeline, first, jumps) - self.sensed.volts
        self.response.shift(changes.over(self.timeline.parts) + moved - lost)
        for k, kick in zip(self._own.coasts, changes.kicks, strict=True):
            self.response.kick(self._first[k], kick)
        for m in self.measured:
            if m.block.name == CURRENT:
                self.response.delay(m.row, changes.current_late)

    def _initial(self, own: Floats) -> tuple[float, ...]:
        return self._own.of(own, "initial_current"), self._own.of(own, "initial_speed"), 0.0

    def emf_constant(self, shared: Floats) -> float:
        """V·s/rad that an open bridge shows."""
        return float(self.motor(shared)[2])

    def fitted(self, shared: Floats, own: Floats) -> list[Floats]:
        """The model of every block's readings, offsets included, in its own unit (motor shaft)."""
        readings = self.readings(shared, own)
        K = self.emf_constant(shared)
        models = []
        for m in self.measured:
            y = m.of(readings)
            match m.block.name:
                case "current":
                    y = (np.abs(y) if m.unsigned else y) + self._own.of(own, "current_offset")
                case "position":
                    y = y + self._own.of(own, "position_origin")
                case "back_emf":
                    y = K * y + self._own.of(own, "voltage_offset")
            models.append(y)
        return models

    def fitted_by(self, response: Response, shared: Floats, own: Floats) -> list[Floats]:
        """``fitted`` if this response took the place of the record's."""
        usual, self.response = self.response, response
        self._memory.clear()
        moved = self.fitted(shared, own)
        self.response = usual
        self._memory.clear()
        return moved

    def fitted_with(self, shared: Floats, own: Floats, volts: Floats) -> list[Floats]:
        """``fitted`` if ``volts`` (count,) drove the motor in place of the source's."""
        usual, memory = self.volts, self._memory
        self._memory = {}
        self.response.excite(volts, self.stretches)
        moved = self.fitted(shared, own)
        self.response.excite(usual, self.stretches)
        self._memory = memory
        return moved

    def residuals(self, shared: Floats, own: Floats) -> list[Floats]:
        """Measured less fitted, weighed; one array per block."""
        return self.weighed(self.departures(shared, own))

    def departures(self, shared: Floats, own: Floats) -> list[Floats]:
        """Measured less fitted in SI units, one array per block."""
        fitted = self.fitted(shared, own)
        return [m.values - y for m, y in zip(self.measured, fitted, strict=True)]
