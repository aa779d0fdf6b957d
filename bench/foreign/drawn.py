"""Drawn rigs of plants that are not ours: the motor, its bench, what is declared, what is true.

The motors are those of the coverage study's scaling laws, .5 to 500 W. Whatever the rig states with
an uncertainty is drawn from just that.

The truth of each parameter, in both plants:

- R: ohm between the motor's terminals, leads excluded. Neither plant warms up.
- L: H, dλ/di at no current and at low frequency, eddy branch included.
- K: N·m/A = V·s/rad at no current, its mean over a turn.
- B: N·m·s/rad, the torque that grows with speed in proportion; windage is none of it.
- J: kg·m², rotor and load.
- T0: N·m, dry friction of a motor that turns without a torque; what follows the load is none of it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from bench.coverage.motors import draw_motor
from bench.iron import EFFECTS, MECHANICAL, Iron, draw_iron
from motorid.capture.model import Sense
from motorid.program import Decay, Program, Step, StepKind

CLOCK_HZ = 16e6
NAMES = ("R", "L", "K", "B", "J", "T0")
TAU_S = (0.008, 0.04)  # mechanical; a load brings a light rotor there
SETTLING = 3.0  # of these at each level
REST_S, COAST_S = 0.03, 0.3
DAMPING = 4.0  # 1/ζ² of the supply's inductance


@dataclass(frozen=True)
class Channel:
    """One converter: declared and, after ``true_``, as it is. SI, but for counts."""

    scale: float
    middle: float
    raw_max: int
    noise: float  # counts
    aperture_s: float
    delay_s: float
    gain_u: float
    offset_u: float  # counts
    delay_u_s: float
    true_gain: float  # over the declared one
    true_offset: float  # counts, off the declared
    true_delay_s: float


@dataclass(frozen=True)
class Rig:
    """A drawn rig. What is stated of bridge and leads has ``_u`` as its standard uncertainty."""

    seed: int
    power_w: float
    truth: Mapping[str, float]  # R to T0
    iron: Iron
    supply_v: float
    supply_ohm: float
    supply_f: float
    bridge_ohm: float
    lead_ohm: float
    stated_bridge_ohm: float
    bridge_u: float
    stated_lead_ohm: float
    lead_u: float
    dead_s: float
    pwm_hz: float
    rate_hz: float
    clock_error: float  # relative
    clock_u: float
    sense: Sense
    counts_per_turn: int
    first_line: float  # rad
    current: Channel
    voltage: Channel
    nameplate: Mapping[str, float]
    program: Program

    @property
    def stall_a(self) -> float:
        """At the supply's voltage."""
        return self.supply_v / self.truth["R"]

    @property
    def idle_rad_s(self) -> float:
        """Without any friction, at the supply's voltage."""
        return self.supply_v / self.truth["K"]


def draw(seed: int, *, effects: bool = False, pwm: bool = True, iron: bool = True) -> Rig:
    """The rig of that seed; with ``effects`` one, two or three of EFFECTS. ``pwm`` False: a linear
    amplifier, whose voltage is read at the terminals; ``iron`` False: none of the electrical ones.
    """
    rng = np.random.default_rng([seed, 77])
    drawn = draw_motor(rng)
    motor = drawn.motor
    R, K = motor.resistance_ohm, motor.torque_constant_nm_a
    tau = min(max(R * (motor.inertia_kg_m2 + drawn.load_inertia) / K**2, TAU_S[0]), TAU_S[1])
    truth = {"R": R, "L": motor.inductance_h, "K": K, "B": motor.viscous_nm_s,
             "J": tau * K**2 / R, "T0": motor.coulomb_nm}  # fmt: skip
    ripple = float(rng.uniform(0.002, 0.01))
    commutations = motor.commutator_segments * (1 + motor.commutator_segments % 2)
    shape = draw_iron(rng, EFFECTS if iron else MECHANICAL) if effects else Iron()
    shape = replace(shape, ripple=ripple * (seed % 2 if iron else 0), ripple_per_turn=commutations)
    rate = float(rng.choice((5000, 10_000)))
    pwm_hz = float(rng.choice((10_000, 20_000), p=(0.7, 0.3))) if pwm else 0.0
    sense: Sense = ("terminals", "bridge", "supply")[int(rng.choice(3, p=(0.6, 0.2, 0.2)))]
    bridge, lead = R * float(rng.uniform(0.01, 0.06)), R * float(rng.uniform(0.002, 0.02))
    bridge_u, lead_u = (x * float(rng.uniform(0.05, 0.15)) for x in (bridge, lead))
    supply_v = motor.voltage_v
    window = 1.0 / (pwm_hz or rate)
    current = _channel(rng, 4.0 * supply_v / R, 0.5, window, (1e-3, 1e-2))
    low = 0.0 if sense == "supply" and pwm else 0.5
    voltage = _channel(rng, (1.3 if low == 0 else 2.6) * supply_v, low, window, (5e-4, 5e-3))
    clock_u = 30e-6
    plate = {"resistance_ohm": R, "inductance_h": truth["L"], "torque_constant_nm_a": K,
             "inertia_kg_m2": truth["J"],
             "no_load_current_a": (truth["T0"] + truth["B"] * supply_v / K) / K}  # fmt: skip
    return Rig(
        seed=seed,
        power_w=drawn.power_w,
        truth=truth,
        iron=shape,
        supply_v=supply_v,
        supply_ohm=R * float(rng.uniform(0.005, 0.04)),
        supply_f=float(rng.uniform(1e-3, 5e-3)) / R,
        bridge_ohm=bridge,
        lead_ohm=lead,
        stated_bridge_ohm=bridge - bridge_u * float(rng.standard_normal()),
        bridge_u=bridge_u,
        stated_lead_ohm=lead - lead_u * float(rng.standard_normal()),
        lead_u=lead_u,
        dead_s=float(rng.uniform(1e-7, 5e-7)) if pwm else 0.0,
        pwm_hz=pwm_hz,
        rate_hz=rate,
        clock_error=clock_u * float(rng.standard_normal()),
        clock_u=clock_u,
        sense=sense if pwm else "terminals",
        counts_per_turn=int(rng.choice((1000, 2000, 2048, 4096))),
        first_line=float(rng.uniform(0.0, 2 * math.pi)),
        current=current,
        voltage=voltage,
        nameplate={k: float(v * rng.uniform(0.94, 1.06)) for k, v in plate.items()}
        | {"voltage_v": supply_v},
        program=_program(tau, rate, 0.0 if pwm else supply_v),
    )


def _channel(
    rng: np.random.Generator, span: float, low: float, window_s: float, gain_u: tuple[float, float]
) -> Channel:
    """A converter of 12 bits over ``span``, zero at the share ``low`` of it."""
    bits = 12
    u = float(math.exp(rng.uniform(*np.log(gain_u))))
    delay, delay_u = float(rng.uniform(5e-6, 15e-6)), float(rng.uniform(1e-7, 1e-6))
    gain, offset, late = rng.standard_normal(3)
    return Channel(
        scale=span / 2**bits,
        middle=low * 2**bits,
        raw_max=2**bits - 1,
        noise=float(rng.uniform(0.5, 2.0)),
        aperture_s=window_s,
        delay_s=delay,
        gain_u=u,
        offset_u=0.3,
        delay_u_s=delay_u,
        true_gain=1 + u * float(gain),
        true_offset=0.3 * float(offset),
        true_delay_s=delay + delay_u * float(late),
    )


def shortened(rig: Rig) -> Rig:
    """The same rig for a trial of a moment: one level, a coast, a level backwards."""
    rest, drive, _, _, coast, back, *_, brake = rig.program.steps
    motor, tau = rig.truth, TAU_S[0]
    steps = [replace(step, duration_s=0.012) for step in (drive, coast, back)]
    light = {**motor, "J": tau * motor["K"] ** 2 / motor["R"]}
    program = Program((replace(rest, duration_s=0.004), *steps, replace(brake, duration_s=0.01)))
    return replace(rig, truth=light, program=program)


def _program(tau: float, rate_hz: float, volts: float) -> Program:
    """Three levels up, a coast, two the other way, a coast, one more, a brake.

    In duty, or as shares of ``volts`` where that is not 0.
    """

    def whole(seconds: float) -> float:
        return max(round(seconds * rate_hz / 10), 1) * 10 / rate_hz

    def drive(share: float) -> Step:
        kind = StepKind.DRIVE_VOLTS if volts else StepKind.DRIVE_DUTY
        level = share * (volts or 1.0)
        return Step(kind, whole(SETTLING * tau), level, Decay.SYNCHRONOUS_SLOW)

    coast = Step(StepKind.COAST, whole(min(8 * tau, COAST_S)))
    return Program((
        Step(StepKind.COAST, whole(REST_S)), drive(0.35), drive(0.65), drive(1.0), coast,
        drive(-0.5), drive(-0.8), coast, drive(0.6), Step(StepKind.BRAKE, whole(4 * tau)),
    ))  # fmt: skip
