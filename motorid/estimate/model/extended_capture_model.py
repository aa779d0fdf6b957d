"""A capture as the likelihood sees it under a wider model."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.effects.friction.friction_drift import STRAIGHT
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.state.initial_warmth import INITIAL_WARMTH
from motorid.estimate.effects.state.ripple_phase import RIPPLE_PHASE
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.extended_terms import ADDED, COPPER_PER_K, NAMES, Scales, Term, unknown
from motorid.estimate.model.rotor_angle import measured_angle, rippled
from motorid.estimate.model.source_mixing import Mixer
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.signals.intersample_voltage import JOINED
from motorid.estimate.signals.measurements import EMF, Measured
from motorid.estimate.solver.problem import Unknown
from motorid.motor.reading import Output, Quantity, Stretch
from motorid.motor.response import Response
from motorid.motor.wide import START, WideResponse

Floats = NDArray[np.float64]
Priors = Mapping[str, tuple[float, float]]

PLACE = {name: k for k, name in enumerate(NAMES)}


class WideRecord(MotorRecord):
    """``MotorRecord`` whose shared parameters may be any of ``terms.NAMES``."""

    names = NAMES
    states = len(START)
    _steps: NDArray[np.uint8] | None = None
    _rotor: Floats | None = None  # its angle (rad) at every tick, where it is measured

    def __init__(
        self,
        six: MotorRecord,
        free: Sequence[str],
        fixed: Mapping[str, float],
        terms: Sequence[Term],
        scales: Scales,
        priors: Priors,
        first: bool,
    ) -> None:
        absent = {name: added.absent for name, added in ADDED.items()}
        log = six.sensed.waveform
        shape = log.shape if log is not None else JOINED
        super().__init__(six.capture, free, {**absent, **fixed}, shape)
        self.scales, self.priors = scales, priors
        self.modelled = frozenset(term.name for term in terms)
        self._repeats = any(term.per_turn for term in terms)
        self.repeating = six.repeating
        begins = [
            Instance(term.phase)
            for term in terms
            if term.phase and not (first and term.phase is INITIAL_WARMTH)
        ]
        self.estimate(*begins)
        self._carry(six, {one.name for one in (*self.instances, *begins)})
        self.adopt(six)

    def _carry(self, six: MotorRecord, known: Set[str]) -> None:
        """Have its unknowns besides, in its order: what was promoted, and faults that were found,
        of which no capture says anything.
        """
        more = {}
        for one, of_six in zip(six.instances, six.unknowns, strict=True):
            usual = one.unknown(self) or (of_six if one in six.found else None)
            if usual is not None and one.name not in known:
                more[one] = usual
        self._take([*zip(self.instances, self.unknowns, strict=True), *more.items()])
        self.found |= six.found & more.keys()

    def adopt(self, other: MotorRecord) -> None:
        """Be driven as another record of the same capture is."""
        self.foretold = other.foretold
        self.excite(other.driving)
        known = {u.name: u for u in other.unknowns}

        def expected(u: Unknown) -> Unknown:
            as_known = known.get(u.name, u)
            return replace(u, prior_mean=as_known.prior_mean, prior_sd=as_known.prior_sd)

        self._renew(expected)

    def follow(self, other: MotorRecord) -> None:
        """Take over how another record of the same capture sees noise, and its steps."""
        self.weigh_as(other)
        self.step_as(other)

    def step_as(self, other: MotorRecord) -> None:
        """Integrate with the steps of another record of the same capture."""
        if isinstance(other, WideRecord) and other._steps is not None:
            self._steps, self._rotor = other._steps, other._rotor
            self._prepare(self.response)
            self.standing.at_hand.clear()

    def starting(self, values: Mapping[str, float]) -> None:
        """Begin nuisances at these values, those that are named."""
        self._renew(lambda u: replace(u, start=values.get(u.name, u.start)))

    def _renew(self, change: Callable[[Unknown], Unknown]) -> None:
        self.unknowns = tuple(change(u) for u in self.unknowns)

    def respond(
        self,
        period_s: float,
        volts: Floats,
        outputs: Sequence[Output],
        stretches: Sequence[Stretch] = (Stretch(0),),
        pwm_period_s: float = 0.0,
    ) -> Response:
        """The wider motor, with the steps that were planned last."""
        response = WideResponse(period_s, volts, outputs, stretches, pwm_period_s)
        self._prepare(response)
        return response

    def _prepare(self, response: Response) -> None:
        assert isinstance(response, WideResponse)
        if self._steps is not None:
            response.levels = self._steps
        response.angle = self._rotor

    def plan(self, shared: Floats, own: Floats) -> None:
        """Choose the integration's steps for these parameters, and keep them."""
        assert isinstance(self.response, WideResponse)
        if self._repeats:
            self.locate(shared, own)
        setup = self.setup(own)
        self.response.plan(setup.loaded(self.motor(shared), NAMES), setup.initial)
        self._steps = self.response.levels
        self.standing.at_hand.clear()

    def locate(self, shared: Floats, own: Floats) -> None:
        """Let what repeats with the rotor follow its measured angle, where an encoder shows it."""
        angle = measured_angle(self, self.fitted(shared, own))
        if angle is None:
            return
        self._rotor = angle
        self._prepare(self.response)
        self.standing.at_hand.clear()

    def retake_sources(self, shared: Floats, own: Floats, mixer: Mixer | None = None) -> None:
        """As the six-parameter record's; the steps are planned anew."""
        super().retake_sources(shared, own, mixer)
        self.plan(shared, own)

    @property
    def integrated(self) -> int:
        """Steps of the integration that one response takes."""
        assert isinstance(self.response, WideResponse)
        return int((1 << self.response.levels.astype(np.int64)).sum())

    def unknown(self, name: str, start: float) -> Unknown:
        """A parameter beyond the six."""
        return unknown(name, start, self.scales, self.priors.get(name))

    def motor(self, shared: Floats) -> Floats:
        """The values by ``motorid.motor.wide.NAMES``: those of ``names``, and the time over which
        friction changes, if it does: at no rate it goes by a straight line.
        """
        values = np.append(super().motor(shared), 0.0)
        share, inertia = values[PLACE["J2_share"]], values[PLACE["J"]]
        values[PLACE["per_C_w"]] *= COPPER_PER_K * values[PLACE["R"]]
        values[PLACE["J2_share"]], values[PLACE["J"]] = share * inertia, (1 - share) * inertia
        if values[PLACE["T_f"]] != 0.0:
            values[-1] = self.scales.duration
            values[PLACE["r_f"]] = max(values[PLACE["r_f"]], STRAIGHT / values[-1])
        return values

    def _modelled(self, m: Measured, readings: Floats, shared: Floats, own: Floats) -> Floats:
        """As the six-parameter record's; an open bridge shows the ripple of K too."""
        steady = super()._modelled(m, readings, shared, own)
        ripple = self.motor(shared)[PLACE["k_K"]]
        if ripple == 0.0 or self._rotor is None or m.block.name != EMF:
            return steady
        return np.asarray(steady + ripple * self._rippled(m, steady, shared, own))

    def _rippled(self, m: Measured, volts: Floats, shared: Floats, own: Floats) -> Floats:
        """What a ripple of 1 adds to readings (n,) of a back-EMF."""
        assert self._rotor is not None
        wave = float(self.motor(shared)[PLACE["N_r"]]), self.sizes(own)[RIPPLE_PHASE.name]
        K, output = self.emf_constant(shared), self.outputs[m.row]
        return rippled(m, output, volts, K, wave, self._rotor, self.timeline.period_s)

    def emf_constant(self, shared: Floats) -> float:
        """V·s/rad that an open bridge shows."""
        return super().emf_constant(shared) * (1.0 + float(self.motor(shared)[PLACE["d_Ke"]]))

    def angle(self, shared: Floats, own: Floats) -> Floats:
        """The rotor's (count,), rad from the first tick: as measured, else the model's."""
        if self._rotor is not None:
            return self._rotor
        over = self.respond(
            self.timeline.period_s, self.volts, [Output(Quantity.POSITION)], self.stretches
        )
        setup = self.setup(own)
        return np.asarray(over(setup.loaded(self.motor(shared), NAMES), setup.initial)[0])


assert NAMES[: len(PARAMETERS)] == PARAMETERS
