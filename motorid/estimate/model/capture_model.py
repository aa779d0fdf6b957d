"""One capture of a driven motor as the likelihood sees it: residuals of current, motion and EMF."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from copy import copy
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import Capture
from motorid.errors import DataError
from motorid.estimate.effects.action import Setup
from motorid.estimate.effects.brush_and_heating import Loss
from motorid.estimate.effects.influence_quantity import Instance, Use
from motorid.estimate.effects.loaded_motor import loaded
from motorid.estimate.effects.rotor.repeating import STEADY
from motorid.estimate.effects.source.held_inductance import Foretold
from motorid.estimate.effects.source_noise import SourceNoise
from motorid.estimate.effects.unstated import ahead
from motorid.estimate.model import own_unknowns
from motorid.estimate.model.low_passes import behind, declared, low_passes
from motorid.estimate.model.rebuilt_response import Planned, extended, rebuilt
from motorid.estimate.model.reconstructed_voltage import Course, Driving
from motorid.estimate.model.responses_at_hand import Key
from motorid.estimate.model.source_mixing import Mixer
from motorid.estimate.model.standing_response import Run, StandingResponse
from motorid.estimate.model.weighting import Weighed
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.signals.excitation import Excitation
from motorid.estimate.signals.intersample_voltage import (
    CONTINUOUS,
    CURVED_MEANS,
    JOINED,
    Rival,
    Shape,
)
from motorid.estimate.signals.measurements import EMF, Measured, read
from motorid.estimate.signals.source.discontinuous_current import divided
from motorid.estimate.signals.source.pwm_bridge import ripple
from motorid.estimate.signals.source.thevenin_source import Source
from motorid.estimate.signals.standstill import with_standstill
from motorid.estimate.signals.time_grid import Timeline, lay
from motorid.estimate.signals.voltage_sensing import Sense, sense
from motorid.estimate.solver.problem import Unknown
from motorid.motor.reading import Output, Stretch
from motorid.motor.response import Response
from motorid.motor.wide import NAMES, SIX

Floats = NDArray[np.float64]
Sizes = Mapping[Instance, float]

NOTHING: Sizes = {}


class MotorRecord(Weighed):
    """Residuals of one capture as a function of the free motor parameters and its own unknowns.

    ``free`` names the shared vector; ``fixed`` holds the other parameters; ``shape`` is that of
    a log's voltage between its readings. ``own`` vectors hold the sizes of ``instances``. Raises
    DataError when the capture has no voltage, or neither current nor motion.
    """

    names: tuple[str, ...] = PARAMETERS  # what ``free`` and ``fixed`` may name, in order
    modelled: frozenset[str] = frozenset()  # terms that a wider model has by itself
    states = 3  # of a run's beginning: current, speed, angle

    def __init__(
        self,
        capture: Capture,
        free: Sequence[str],
        fixed: Mapping[str, float],
        shape: Shape = JOINED,
    ) -> None:
        self.capture = capture
        laid = lay(capture, shape in CONTINUOUS, shape == CURVED_MEANS)
        timeline = with_standstill(capture, laid)
        sensed = sense(capture, timeline, shape)
        if sensed is None:
            raise DataError("the capture holds no voltage: R, L and K cannot be known from it")
        self.sensed: Sense = sensed
        self.driving = Driving.of(capture, divided(capture, timeline, sensed), sensed)
        self.shown_parts, self.shape = self.driving.timeline.parts, shape
        self.gear, self.held = capture.wiring.gear_ratio or 1.0, fixed
        self._template = np.array([fixed.get(name, np.nan) for name in self.names])
        self._places = [self.names.index(name) for name in free]
        self.driven = self.timeline.driven
        measured, self.outputs = read(capture, self.timeline, self.driven, sensed.shows_emf)
        if not measured:
            raise DataError("the capture holds neither a current nor a position or speed to fit")
        super().__init__(measured)
        self.noise = SourceNoise(capture, self.timeline, sensed)
        self.judged_at: Floats | None = None
        self.losing: Mapping[str, float] = {}
        self.planned: Planned | None = None  # the steps of the last run with a parameter more
        self.simulated = 0  # responses computed so far, by what they were worth
        self.untried = 0  # other starts that a search which misfits did not take, to end at all
        self.rivals: tuple[Rival, ...] = ()
        self.foretold: Foretold | None = None  # an inductance that no reading shows
        self.found: frozenset[Instance] = frozenset()  # of quantities that nobody stated
        self.repeating = STEADY  # with the rotor's angle
        self.outlying = False  # few readings lie far off, and no lag or low-pass explains them
        self.left_open: tuple[Floats, ...] = ()  # by them, shifts of the parameters
        self.as_stamped: Mapping[str, float] = {}  # parameters without them, where they are found
        self.unsettled: Floats | None = None  # the last pass's change of parameters, if too large
        self.between_ticks: Floats | None = None  # the same that a still finer grid would bring
        pwm = capture.wiring.pwm_hz
        self.pwm_period_s = 1.0 / pwm if pwm else 0.0
        response = self.respond(
            self.timeline.period_s, sensed.volts, self.outputs, pwm_period_s=self.pwm_period_s
        )
        self.standing = StandingResponse(response, self.measured, self.outputs)
        self._second_order = declared(self.measured, self.timeline.period_s)
        self._drive_by(self.driving)
        self._take(own_unknowns.of_use(Use.ESTIMATED, self))

    def twin(self, given: Excitation | None = None) -> MotorRecord:
        """This record as it is now, whatever becomes of it; with a response of its own. ``given``:
        what drives it instead, of whatever parts.
        """
        twin = copy(self)
        if given is not None:
            starts = [stretch.start for stretch in given.stretches]
            before = np.searchsorted(starts, [p.start for p in self.timeline.parts], "right") - 1
            twin.volts, twin.stretches, twin.first = given.volts, given.stretches, tuple(before)
        response = self.respond(
            self.timeline.period_s, twin.volts, self.outputs, twin.stretches, self.pwm_period_s
        )
        twin.standing = StandingResponse(response, self.measured, self.outputs, twin.first)
        return twin

    @property
    def response(self) -> Response:
        """The response that stands, which every run changes."""
        return self.standing.response

    # ---- what declarations read ---------------------------------------------------------------

    @property
    def timeline(self) -> Timeline:
        """The fit's intervals, and the parts of the program in them."""
        return self.driving.timeline

    @property
    def sources(self) -> tuple[Source | None, ...]:
        """What drives every part; None: the voltage as heard."""
        return self.driving.sources

    @property
    def loss(self) -> Loss | None:
        """What brushes and winding take from the motor's voltage."""
        return self.driving.loss

    def block(self, name: str) -> Measured | None:
        """The readings of a block."""
        return next((m for m in self.measured if m.block.name == name), None)

    @property
    def ripples(self) -> bool:
        """PWM makes its current swing in some part, and what that takes is among its unknowns."""
        parts = self.timeline.parts
        swings = any(ripple(self.capture, part, 1.0)[0] > 0.0 for part in parts)
        return swings and self.loss is not None

    # ---- its influence quantities -------------------------------------------------------------

    def _take(self, pairs: Iterable[tuple[Instance, Unknown]]) -> None:
        """Have these unknowns, in this order, and no others."""
        pairs = list(pairs)
        self.instances = tuple(one for one, _ in pairs)
        self.unknowns = tuple(unknown for _, unknown in pairs)
        self._simulated = [j for j, one in enumerate(self.instances) if one.quantity.simulated]
        self.standing.at_hand.clear()

    @property
    def propagated(self) -> tuple[tuple[Instance, Unknown], ...]:
        """Quantities that are no unknowns here, but whose uncertainty is stated."""
        stated = own_unknowns.of_use(Use.PROPAGATED, self)
        return tuple(pair for pair in stated if pair[0] not in self.instances)

    def estimate(self, *quantities: Instance) -> None:
        """Let these be unknowns too, the last of all."""
        more = own_unknowns.there(quantities, self)
        self._take([*zip(self.instances, self.unknowns, strict=True), *more])

    def propagate(self, *quantities: Instance) -> None:
        """Take these as declared again."""
        pairs = zip(self.instances, self.unknowns, strict=True)
        self._take([(one, unknown) for one, unknown in pairs if one not in quantities])

    def find(self, found: Mapping[Instance, Unknown]) -> None:
        """These are there, of sizes that their usual priors make unlikely: known so from now on.

        Those that were no unknowns are the last ones.
        """
        self.found |= found.keys()
        self._take({**dict(zip(self.instances, self.unknowns, strict=True)), **found}.items())

    def go_on(self, other: MotorRecord, own: Floats) -> None:
        """Have the unknowns of another record of the same readings, and begin where it ended."""
        self.found, self.rivals, self.untried = other.found, other.rivals, other.untried
        self.outlying = other.outlying
        self.left_open, self.as_stamped = other.left_open, other.as_stamped
        known = zip(other.instances, other.unknowns, own.tolist(), strict=True)
        self._take([(one, replace(unknown, start=size)) for one, unknown, size in known])

    def renew(self) -> None:
        """Priors follow what drives the motor; starts and bounds stay."""
        pairs = zip(self.instances, self.unknowns, strict=True)
        self.unknowns = tuple(own_unknowns.renewed(pairs, self, self.found))

    def sizes(self, own: Floats) -> dict[str, float]:
        """Its own unknowns (SI) by name."""
        return {u.name: float(x) for u, x in zip(self.unknowns, own, strict=True)}

    # ---- excitation -------------------------------------------------------------------------

    def excite(self, driving: Driving) -> None:
        """Be driven like that from here on."""
        self._drive_by(driving)
        self.renew()

    def _drive_by(self, driving: Driving) -> None:
        self.driving, given = driving, driving.excitation
        self.volts, self.stretches, self.first = given.volts, given.stretches, given.first
        self.standing.excite(self.volts, self.stretches, self.first)

    def decide(self, decided: bool) -> None:
        """Whether what is a choice between two things, of what drives the motor, stays as it is."""
        self.driving = replace(self.driving, decided=decided)

    def retake_sources(self, shared: Floats, own: Floats, mixer: Mixer | None = None) -> None:
        """Judge what drives the motor with the model's own current; ``mixer``: to go on from what
        was judged before.
        """
        self.losing, self.judged_at = self._losing(own), self.motor(shared)
        driving = self.driving.judged(self.course(shared, own), self.losing)
        self.excite(driving if mixer is None else mixer.next(self.driving, driving))

    def course(self, shared: Floats, own: Floats) -> Course:
        """Of the model's own run, by which what drives it is judged."""
        rows = self.runs(shared, own, self.driving.asked) + self.repeating.course
        resistance, inductance = (float(v) for v in self.motor(shared)[:2])
        return self.driving.course(rows, self.emf_constant(shared), resistance, inductance)

    def runs(self, shared: Floats, own: Floats, outputs: Sequence[Output]) -> Floats:
        """What the model itself does, (outputs, count), driven as it is now but for own changes."""
        loss = self.loss
        volts = self.volts if loss is None else self.volts - loss.volts(self._losing(own))
        over = self.respond(self.timeline.period_s, volts, outputs, self.stretches)
        setup = self.setup(own)
        found = over(setup.loaded(self.motor(shared), self.names), setup.initial)
        self.simulated += over.worth
        return found

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

    def _losing(self, own: Floats) -> dict[str, float]:
        """The unknowns of what is lost."""
        sizes = self.sizes(own)
        names = () if self.loss is None else self.loss.shapes
        return {name: sizes.get(name, 0.0) for name in names}

    def brush_drop(self, shared: Floats, own: Floats, amperes: Floats) -> Floats:
        """V (n,) over both brushes at currents (n,)."""
        ohms = float(self.motor(shared)[0])
        if self.loss is None:
            return np.zeros(len(amperes))
        return self.loss.drop_at(amperes, ohms, self._losing(own))

    def emf_constant(self, shared: Floats) -> float:
        """V·s/rad that an open bridge shows."""
        return float(loaded(self.motor(shared), self.names, self.capture.wiring.terminal_load_s)[2])

    def setup(self, own: Floats, more: Sizes = NOTHING) -> Setup:
        """One run with its own unknowns and what else is said of its quantities."""
        setup = Setup(self.timeline.count, [0.0] * self.states, self.capture.wiring.terminal_load_s)
        for one, size in (*zip(self.instances, own.tolist(), strict=True), *more.items()):
            for action in one.quantity.acts:
                action(setup, self, one.place, size)
        if self.sensed.waveform is not None:
            ahead.let_be(setup, self.measured)
        return setup

    def readings(self, shared: Floats, own: Floats, more: Sizes = NOTHING) -> Floats:
        """The response (outputs, count) before offsets and gains; remembers the last few."""
        if any(one.quantity.simulated for one in more):
            return self._simulate(shared, self.setup(own, more))
        key, at_hand = self._key(shared, own), self.standing.at_hand
        readings, worth = at_hand.take(key)
        if readings is None:
            readings = self._simulate(shared, self.setup(own))
        self.simulated += worth
        at_hand.use(key, readings)
        return readings

    def _key(self, shared: Floats, own: Floats) -> Key:
        """What a response depends on."""
        return (*shared, *own[self._simulated])

    def foresee(self, points: Sequence[tuple[Floats, Floats]]) -> None:
        """Compute the responses at these (shared, own) at once, where that is quicker."""
        at_hand, runs = self.standing.at_hand, {}
        if not self.standing.takes_several:
            return
        for shared, own in points:
            key = self._key(shared, own)
            if key not in runs and key not in at_hand:
                setup = self.setup(own)
                runs[key] = Run(setup, setup.onto(self.motor(shared), NAMES), self.stamped(setup))
        at_hand.expect(self.standing.several(runs, self.smoothed))

    def _simulate(self, shared: Floats, setup: Setup) -> Floats:
        motor = self.motor(shared)
        if len(motor) == len(SIX) and not setup.motor.keys() <= set(SIX):
            self.simulated += 1
            return self.smoothed(extended(self, motor, setup), setup)
        motor = setup.onto(motor, NAMES)
        if setup.rebuilt:
            response = rebuilt(self, setup, self.respond)
        else:
            response = self.standing.of(setup, self.stamped(setup))
        readings = response(motor, setup.initial)
        self.simulated += response.worth
        return self.smoothed(readings, setup)

    def smoothed(self, readings: Floats, setup: Setup) -> Floats:
        """Behind the low-passes of second order, declared or found."""
        found = low_passes(self.measured, self.outputs, setup, self.timeline.period_s)
        return behind({**self._second_order, **found}, readings)

    def stamped(self, setup: Setup) -> Floats | float:
        """V (count,) by which a log's voltage changes where its stamps do."""
        waveform = self.sensed.waveform
        late_s, filter_s, second_s = setup.log_late_s, setup.log_filter_s, setup.log_second_s
        moved = late_s or filter_s or second_s or any(setup.log_jumps.values())
        if waveform is None or not moved:
            return 0.0
        early = setup.early(len(waveform.jumps))
        means = waveform.means(self.timeline, late_s, early, filter_s, second_s**2)
        return means - self.sensed.volts

    def fitted(self, shared: Floats, own: Floats, more: Sizes = NOTHING) -> list[Floats]:
        """The model of every block's readings, in its own unit (motor shaft).

        ``more``: sizes of quantities beside its own unknowns.
        """
        models = self.shown(self.readings(shared, own, more), shared, own)
        for one, size in (*zip(self.instances, own.tolist(), strict=True), *more.items()):
            for action in one.quantity.acts:
                action.show(models, self, one, size)
        bend = self.repeating.bend
        return [models[m.block.name] + bend.get(m.block.name, 0.0) for m in self.measured]

    def shown(self, readings: Floats, shared: Floats, own: Floats) -> dict[str, Floats]:
        """What ideal channels would show of a response (outputs, count), (n,) by block."""
        return {m.block.name: self._modelled(m, readings, shared, own) for m in self.measured}

    def _modelled(self, m: Measured, readings: Floats, shared: Floats, own: Floats) -> Floats:
        """What an ideal channel of that block would show, (n,)."""
        y = m.of(readings)
        if m.block.name == EMF:
            return self.emf_constant(shared) * y
        return np.abs(y) if m.unsigned else y

    def fitted_with(self, shared: Floats, own: Floats, volts: Floats) -> list[Floats]:
        """``fitted`` if ``volts`` (count,) drove the motor in place of the source's."""
        with self.standing.driven_by(volts, self.volts, self.stretches):
            return self.fitted(shared, own)

    def residuals(self, shared: Floats, own: Floats) -> list[Floats]:
        """Measured less fitted, weighed; one array per block."""
        return self.weighed(self.departures(shared, own))

    def departures(self, shared: Floats, own: Floats) -> list[Floats]:
        """Measured less fitted in SI units, one array per block."""
        fitted = self.fitted(shared, own)
        return [m.values - y for m, y in zip(self.measured, fitted, strict=True)]
