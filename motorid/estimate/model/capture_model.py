"""One capture of a driven motor as the likelihood sees it: residuals of current, motion and EMF."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, Capture
from motorid.errors import DataError
from motorid.estimate.effects.action import Changes
from motorid.estimate.effects.held_inductance import Foretold
from motorid.estimate.effects.registry import nuisances, starts_at_rest
from motorid.estimate.effects.source_noise import Unrest
from motorid.estimate.model.reconstructed_voltage import Course, Driving
from motorid.estimate.model.source_mixing import Mixer
from motorid.estimate.model.weighting import Weighed
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.signals.discontinuous_current import divided
from motorid.estimate.signals.intersample_voltage import JOINED, Rival, Shape
from motorid.estimate.signals.measurements import read
from motorid.estimate.signals.pwm_bridge import ripple
from motorid.estimate.signals.standstill import with_standstill
from motorid.estimate.signals.thevenin_source import Source
from motorid.estimate.signals.time_grid import Timeline, lay
from motorid.estimate.signals.voltage_sensing import Sense, sense
from motorid.estimate.solver.problem import Unknown
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
        self.sensed: Sense = sensed
        self.driving = Driving.of(capture, divided(capture, timeline, sensed), sensed)
        self.shown_parts, self.shape = self.driving.timeline.parts, shape
        self.gear = capture.wiring.gear_ratio or 1.0
        self._template = np.array([fixed.get(name, np.nan) for name in self.names])
        self._places = [self.names.index(name) for name in free]
        self.driven = self.timeline.driven
        measured, self.outputs = read(capture, self.timeline, self.driven, sensed.shows_emf)
        if not measured:
            raise DataError("the capture holds neither a current nor a position or speed to fit")
        super().__init__(measured)
        self._unrest = Unrest(capture, self.timeline, sensed)
        loss = self.driving.loss
        self._own = nuisances(
            capture, self.timeline.period_s, self.driven, sensed, self._unrest, self.measured,
            loss.unknowns if loss is not None else (),
        )  # fmt: skip
        self.unknowns = tuple(self._own.unknowns)
        self.simulated = 0  # responses computed so far
        self.rivals: tuple[Rival, ...] = ()
        self.foretold: Foretold | None = None  # an inductance that no reading shows
        self.unsettled: Floats | None = None  # the last pass's change of parameters, if too large
        pwm = capture.wiring.pwm_hz
        self.response = self.respond(
            self.timeline.period_s,
            sensed.volts,
            self.outputs,
            pwm_period_s=1.0 / pwm if pwm else 0.0,
        )
        self.excite(self.driving)

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
    def timeline(self) -> Timeline:
        """The fit's intervals, and the parts of the program in them."""
        return self.driving.timeline

    @property
    def sources(self) -> tuple[Source | None, ...]:
        """What drives every part; None: the voltage as heard."""
        return self.driving.sources

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
    def ripples(self) -> bool:
        """PWM makes its current swing in some part, and what that takes is among its unknowns."""
        parts = self.timeline.parts
        swings = any(ripple(self.capture, part, 1.0)[0] > 0.0 for part in parts)
        return swings and self.driving.loss is not None

    @property
    def starts_at_rest(self) -> bool:
        """The motor stands still, and carries no current, over the first few samples."""
        return starts_at_rest(self.capture, self.driven)

    # ---- excitation -------------------------------------------------------------------------

    def excite(self, driving: Driving) -> None:
        """Be driven like that from here on."""
        self.driving, given = driving, driving.excitation
        self.volts, self.stretches, self._first = given.volts, given.stretches, given.first
        self._memory: dict[tuple[float, ...], Floats] = {}
        self.response.excite(self.volts, self.stretches)
        for k, place in self._own.levels.items():
            self._own.expect(place, self._unrest.level_deviation(k, self.sources[k]))
        self.unknowns = tuple(self._own.unknowns)

    def decide(self, decided: bool) -> None:
        """Whether what is a choice between two things, of what drives the motor, stays as it is."""
        self.driving = replace(self.driving, decided=decided)

    def retake_sources(self, shared: Floats, own: Floats, mixer: Mixer | None = None) -> None:
        """Judge what drives the motor with the model's own current; ``mixer``: to go on from what
        was judged before.
        """
        losing, motor = self._losing(own), self.motor(shared)
        driving = self.driving.judged(self._course(shared, own), losing)
        if mixer is not None:
            driving = mixer.next(self.driving, driving)
        for k, place in self._own.coasts.items():
            spread = self._unrest.speed_deviation(k, self.sources[k - 1], motor)
            self._own.expect(place, spread)
        if driving.loss is not None:
            self._own.expect(self._own.warming, *driving.loss.rise[::-1])
            self._own.expect(self._own.loss_bend, *driving.loss.bending(losing))
        self.excite(driving)

    def _course(self, shared: Floats, own: Floats) -> Course:
        period_s, window = self.timeline.period_s, self.driving.window
        outputs = [
            *window.outputs, Output(Quantity.SPEED, period_s), Output(Quantity.CURRENT, period_s),
            Output(Quantity.CURRENT),
        ]  # fmt: skip
        *rows, speed, mean, end = self.runs(shared, own, outputs)
        current = window.current(np.array(rows), mean, self.timeline)
        resistance, inductance = (float(v) for v in self.motor(shared)[:2])
        emf = self.emf_constant(shared) * speed
        return Course(current, mean, end, emf, resistance, inductance)

    def runs(self, shared: Floats, own: Floats, outputs: Sequence[Output]) -> Floats:
        """What the model itself does, (outputs, count), driven as it is now but for own changes."""
        volts = self.volts - self._lost_volts(own)
        over = self.respond(self.timeline.period_s, volts, outputs, self.stretches)
        self.simulated += 1
        return over(self.motor(shared), self._initial(own))

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
        names = () if self.driving.loss is None else self.driving.loss.shapes
        return {name: self._own.of(own, name) for name in names}

    def _lost_volts(self, own: Floats) -> Floats | float:
        """V (count,) that brushes and winding take beyond R i."""
        loss = self.driving.loss
        return 0.0 if loss is None else loss.volts(self._losing(own))

    def brush_drop(self, shared: Floats, own: Floats, amperes: Floats) -> Floats:
        """V (n,) over both brushes at currents (n,)."""
        loss, ohms = self.driving.loss, float(self.motor(shared)[0])
        if loss is None:
            return np.zeros(len(amperes))
        return loss.drop_at(amperes, ohms, self._losing(own))

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
