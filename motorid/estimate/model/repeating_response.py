"""What a capture shows of what repeats with its rotor's angle, along the fitted motion.

The derivatives of all readings in each size, at size nothing, by the response that has commutation
ripple and cogging. They are taken once: a ripple of some per cent is a straight line in its sizes,
and what it bends beyond that is computed for the sizes that were found.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import POSITION, SPEED
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Instance
from motorid.estimate.effects.rotor.cogging import COGGING, friction
from motorid.estimate.effects.rotor.encoder_error import ENCODER_ERROR
from motorid.estimate.effects.rotor.friction_ripple import FRICTION_RIPPLE
from motorid.estimate.effects.rotor.k_ripple import K_RIPPLE
from motorid.estimate.effects.rotor.r_ripple import R_RIPPLE
from motorid.estimate.effects.rotor.repeating import Courses, of_order, order
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.rebuilt_response import rebuilt
from motorid.estimate.model.rotor_angle import measured_angle, rippled
from motorid.estimate.signals.measurements import EMF
from motorid.motor.reading import Output, Quantity
from motorid.motor.wide import AT_REST, NAMES, SIX, START, WideResponse

Floats = NDArray[np.float64]
Waves = Mapping[InfluenceQuantity, complex]
"""Amplitude and phase of each: the real part of it times e^(i order angle)."""

PLANNED = 0.03  # of K, R or friction: the ripple for which the integration's steps are chosen
TRIED = 1e-3  # of them: the same for a derivative
UNITS = (1.0, 1.0j)  # of an order's two unknowns
NOTHING: Waves = {}
RIPPLE_PHASE, COGGING_PHASE = START.index("ripple_phase"), START.index("cogging_phase")


def is_of_motor(one: Instance) -> bool:
    """What it is of moves the rotor or its current; else only what an encoder shows."""
    return one.quantity is not ENCODER_ERROR


class RepeatingResponse:
    """The run of a record at a solution, with what repeats with its rotor.

    ``angle`` (count,): the rotor's at every tick, rad; the model's where no encoder shows it.
    """

    def __init__(self, record: MotorRecord, shared: Floats, own: Floats) -> None:
        self.record, self._at = record, (shared, own)
        self._setup = setup = record.setup(own)
        self._motor = np.zeros(len(NAMES))
        self._motor[: len(SIX)] = setup.loaded(record.motor(shared), SIX)
        self._initial = [*setup.initial, *AT_REST[record.states :]]
        response = rebuilt(record, setup, WideResponse)
        assert isinstance(response, WideResponse)
        self._response = response
        angle = measured_angle(record, record.fitted(shared, own))
        if angle is None:
            turned = record.runs(shared, own, [Output(Quantity.POSITION)])[0]
            angle = turned - turned[0]
        self.angle: Floats = np.ascontiguousarray(angle)
        response.angle = self.angle
        speed = record.runs(shared, own, [Output(Quantity.SPEED)])[0]
        self._backwards = _goes_on(np.sign(speed)) < 0.0
        torque = friction(record)
        self._scales = {K_RIPPLE: 1.0, R_RIPPLE: 1.0, COGGING: torque, FRICTION_RIPPLE: torque}

    def slopes(self, periods: int) -> dict[Instance, Courses]:
        """Of ripple and cogging of so many periods a turn: what each block shows of a unit."""
        self._plan(periods, {q: PLANNED * scale for q, scale in self._scales.items()})
        usual = self._shown(periods, NOTHING)
        out: dict[Instance, Courses] = {}
        for quantity, scale in self._scales.items():
            for one, unit in zip(of_order(quantity, periods), UNITS, strict=True):
                size = TRIED * scale
                shown = self._shown(periods, {quantity: size * unit})
                out[one] = {block: (shown[block] - usual[block]) / size for block in shown}
        return out

    def bends(
        self, slopes: Mapping[Instance, Courses], sizes: Mapping[Instance, float]
    ) -> dict[str, Floats]:
        """What the blocks show of the motor's sizes beyond ``slopes`` times them, all orders."""
        total: dict[str, Floats] = {}
        for periods in sorted({order(one) for one in slopes if is_of_motor(one)}):
            for block, course in self.bend(periods, slopes, sizes).items():
                total[block] = total.get(block, 0.0) + course
        return total

    def bend(
        self, periods: int, slopes: Mapping[Instance, Courses], sizes: Mapping[Instance, float]
    ) -> Courses:
        """What the blocks show of one order's sizes beyond ``slopes`` times them."""
        waves = self._waves(periods, sizes)
        self._plan(periods, waves)
        usual, shown = self._shown(periods, NOTHING), self._shown(periods, waves)
        out = {block: shown[block] - usual[block] for block in shown}
        for quantity, wave in waves.items():
            for one, size in zip(of_order(quantity, periods), (wave.real, wave.imag), strict=True):
                for block in out:
                    out[block] = out[block] - size * slopes[one][block]
        return out

    def course(self, sizes: Mapping[Instance, float]) -> Floats:
        """What they add to the run by which the driving voltage is judged, (outputs, count)."""
        record = self.record
        asked, period_s = record.driving.asked, record.timeline.period_s
        response = WideResponse(period_s, record.volts, asked, record.stretches)
        total: Floats = np.zeros((len(asked), record.timeline.count))
        for periods in sorted({order(one) for one in sizes if is_of_motor(one)}):
            waves = self._waves(periods, sizes)
            run, response.angle = self._run(periods, waves), self._turned(periods, waves)
            response.plan(*run)
            total += response(*run) - response(*self._run(periods, NOTHING))
            record.simulated += 2
        return total

    def _waves(
        self, periods: int, sizes: Mapping[Instance, float]
    ) -> dict[InfluenceQuantity, complex]:
        """Of an order's sizes.

        R counts as far as it ripples in phase with K: one phase is all that the response has.
        """
        waves = {}
        for quantity in self._scales:
            cosine, sine = of_order(quantity, periods)
            if cosine in sizes:
                waves[quantity] = complex(sizes[cosine], sizes[sine])
        if K_RIPPLE in waves and R_RIPPLE in waves:
            along = cmath.rect(1.0, cmath.phase(waves[K_RIPPLE]))
            waves[R_RIPPLE] = (waves[R_RIPPLE] / along).real * along
        return waves

    def encoder_error(self, periods: int) -> dict[Instance, Courses]:
        """The same of an encoder whose error repeats so often in its own turn, by a unit (rad)."""
        record = self.record
        motion = record.block(POSITION) or record.block(SPEED)
        if motion is None:
            return {}
        turn = periods * self.angle[motion.keep] / record.gear
        if motion.block.name == POSITION:
            waves = record.gear * np.exp(1j * turn)
        else:
            speed = np.gradient(self.angle)[motion.keep] / record.timeline.period_s
            waves = 1j * periods * speed * np.exp(1j * turn)
        each = zip(of_order(ENCODER_ERROR, periods), UNITS, strict=True)
        return {one: {motion.block.name: (unit * waves).real} for one, unit in each}

    def _turned(self, periods: int, waves: Waves) -> Floats:
        """rad (count,), by which torques go: of friction half a period on where the rotor turns
        forwards, so that it is against the motion both ways. An order is friction alone.
        """
        if not waves.get(FRICTION_RIPPLE):
            return self.angle
        return np.where(self._backwards, self.angle, self.angle + math.pi / periods)

    def _plan(self, periods: int, waves: Waves) -> None:
        motor, initial = self._run(periods, waves)
        self._response.angle = self._turned(periods, waves)
        self._response.plan(motor, initial)
        self.record.simulated += 1

    def _run(self, periods: int, waves: Waves) -> tuple[Floats, list[float]]:
        """Motor and initial state of a run."""
        motor, initial = self._motor.copy(), self._initial.copy()
        K, R, cogs, rubs = (complex(waves.get(q, 0.0)) for q in self._scales)
        torque = cogs + rubs
        along = cmath.phase(K or R)
        known = {
            "k_ripple": abs(K), "r_ripple": (R * cmath.rect(1.0, -along)).real,
            "cogging": abs(torque), "ripple_per_turn": periods, "cogging_per_turn": periods,
        }  # fmt: skip
        for name, value in known.items():
            motor[NAMES.index(name)] = value
        initial[RIPPLE_PHASE] = along
        initial[COGGING_PHASE] = cmath.phase(torque) - math.pi / 2  # less a sine is a cosine
        return motor, initial

    def _shown(self, periods: int, waves: Waves) -> dict[str, Floats]:
        """What ideal channels show of a run, (n,) by block."""
        record, (motor, initial) = self.record, self._run(periods, waves)
        self._response.angle = self._turned(periods, waves)
        shown = record.shown(
            record.smoothed(self._response(motor, initial), self._setup), *self._at
        )
        record.simulated += 1
        m, K = record.block(EMF), complex(waves.get(K_RIPPLE, 0.0))
        if m is not None and K:
            constant, output = record.emf_constant(self._at[0]), record.outputs[m.row]
            wave, period_s = (float(periods), cmath.phase(K)), record.timeline.period_s
            more = rippled(m, output, shown[EMF], constant, wave, self.angle, period_s)
            shown[EMF] = shown[EMF] + abs(K) * more
        return shown


def _goes_on(signs: Floats) -> Floats:
    """(count,) with the next sign in the place of a rotor that stands: that way it breaks away."""
    moving = np.flatnonzero(signs)
    if not len(moving):
        return signs
    following = np.searchsorted(moving, np.arange(len(signs)))
    return np.asarray(signs[moving[np.minimum(following, len(moving) - 1)]])
