"""Random benches around a motor, and the rig file that an honest user would write of each.

Whatever a user or a board states with an uncertainty is drawn from just that: the truth is the
stated figure plus the stated standard uncertainty times a normal number.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from bench.coverage.motors import Drawn, draw_motor
from bench.coverage.programs import Reach, reach, runs
from bench.iron import Iron, draw_iron
from motorid.rig import Rig
from motorid.rig_file import parse
from motorid.rig_keys import CALIBRATION
from motorid.sim.motor import Motor
from motorid.sim.options import Options

PWM_HZ = (8_000, 10_000, 16_000, 20_000, 25_000, 40_000)
COUNTS = (256, 400, 1000, 2000, 2048, 4096)
CLOCK_PPM = (50, 50, 50, 200, 5000)  # crystals, and a ceramic resonator
RATES_HZ = (1000, 2000, 2500, 4000, 5000, 8000, 10_000)
MOST_SAMPLES = 24_000  # of all runs of a rig
EDGE_CEILING = 4_000_000  # counts/s
DELAY_KEY = "delay_uncertainty_s"
NEUTRAL: dict[str, dict[str, Any]] = {  # effects that a study may take out, to see what they do
    "brush": {"brush_drop": 0.0},
    "cogging": {"cogging": 0.0},
    "ripple": {"ripple": 0.0},
    "stiction": {"stiction": 1.0},
    "heating": {"heating": False},
    "dead time": {"dead_time": 0.0},
}


@dataclass(frozen=True)
class OwnMotor(Options):
    """Options of a simulated rig whose motor is no preset."""

    own: Motor | None = None

    @property
    def preset(self) -> Motor:
        """The drawn motor."""
        assert self.own is not None
        return self.own


@dataclass(frozen=True)
class Stated:
    """What the user says of the bench, and how sure of it he is (standard uncertainties)."""

    bridge_ohm: float
    bridge_u: float
    lead_ohm: float
    lead_u: float
    ambient_c: float
    ambient_u: float
    sense: str
    decay: str
    counts: int
    nameplate: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Bench:
    """One drawn rig: what is true of it, what its user says, and the runs he makes."""

    seed: int
    drawn: Drawn
    options: OwnMotor
    stated: Stated
    iron: Iron
    rigs: tuple[Rig, ...]  # one for each run; they differ in their program alone

    @property
    def added(self) -> dict[str, float]:
        """What its motor has besides the six parameters, as fields of ``motor.wide`` (SI)."""
        stall = self.drawn.motor.stall_current_a
        bend, half = self.iron.bend * stall, stall / 2
        sizes = {
            "quadratic": self.options.quadratic,
            "load_friction": self.iron.load_friction,
            "reaction": self.iron.reaction / (math.hypot(stall, bend) - bend),
            "saturation": self.iron.saturation * (1.0 + (half / stall) ** 2),
            "eddy": self.iron.eddy,
        }
        shapes = {"reaction": ("reaction_bend", bend), "saturation": ("saturation_current", half),
                  "eddy": ("eddy_time", self.iron.eddy_s)}  # fmt: skip
        found = {name: size for name, size in sizes.items() if size}
        return found | dict(shape for name, shape in shapes.items() if name in found)


def draw_bench(seed: int, without: Sequence[str] = (), effects: bool = False) -> Bench:
    """The rig of that seed; ``without`` names effects of NEUTRAL that it shall not have.

    With ``effects`` its motor has one, two or three of those of ``bench.iron`` besides.
    """
    rng = np.random.default_rng([seed, 20])
    drawn = draw_motor(rng)
    share = 1.0 if drawn.power_w < 30 else float(rng.uniform(0.5, 1.0))
    within = reach(drawn, share, by_duty=bool(rng.random() < 0.4))
    stated = _draw_stated(rng, drawn)
    options = _draw_options(rng, seed, drawn, stated, within)
    for effect in without:
        options = replace(options, **NEUTRAL[effect])
    iron = draw_iron(np.random.default_rng([seed, 78])) if effects else Iron()
    options = _with_iron(options, iron)
    programs = runs(drawn, within, stated.decay)
    rate = _rate_hz(rng, options, sum(p.duration_s for p in programs))
    text = _rig_text(seed, stated, options, within, rate)
    rigs = tuple(parse(text + p.text, f"rig {seed}") for p in programs)
    return Bench(seed, drawn, options, stated, iron, rigs)


def _with_iron(options: OwnMotor, iron: Iron) -> OwnMotor:
    """The simulated rig with these effects."""
    motor = options.preset
    idle = motor.voltage_v / motor.torque_constant_nm_a
    return replace(
        options,
        reaction=iron.reaction,
        reaction_bend=iron.bend * motor.stall_current_a if iron.reaction else None,
        saturation=iron.saturation,
        eddy=iron.eddy,
        eddy_time=iron.eddy_s,
        quadratic=iron.windage * motor.viscous_nm_s / idle,
        load_friction=iron.load_friction,
    )


def _pick(rng: np.random.Generator, choices: tuple[Any, ...], weights: tuple[float, ...]) -> Any:
    return choices[int(rng.choice(len(choices), p=weights))]


def _log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    return float(math.exp(rng.uniform(math.log(low), math.log(high))))


def _draw_stated(rng: np.random.Generator, drawn: Drawn) -> Stated:
    motor = drawn.motor
    bridge = _log_uniform(rng, 0.005, 0.08) * motor.resistance_ohm
    lead = _log_uniform(rng, 0.001, 0.02) * motor.resistance_ohm
    K, R = motor.torque_constant_nm_a, motor.resistance_ohm
    friction = motor.coulomb_nm + motor.viscous_nm_s * motor.voltage_v / K
    printed = {
        "resistance_ohm": R,
        "inductance_h": motor.inductance_h,
        "torque_constant_nm_a": K,
        "inertia_kg_m2": motor.inertia_kg_m2 + drawn.load_inertia,
        "no_load_current_a": friction / K,
    }
    sense = _pick(rng, ("terminals", "bridge", "supply"), (0.55, 0.25, 0.2))
    decay = _pick(rng, ("synchronous_slow", "diode", "fast"), (0.75, 0.17, 0.08))
    if sense == "supply":  # wiring.md: without a sensed voltage only this decay can be fitted
        decay = "synchronous_slow"
    return Stated(
        bridge_ohm=bridge,
        bridge_u=bridge * float(rng.uniform(0.05, 0.2)),
        lead_ohm=lead,
        lead_u=lead * float(rng.uniform(0.05, 0.2)),
        ambient_c=float(np.round(rng.uniform(15, 32), 1)),
        ambient_u=float(rng.choice((0.5, 1.0, 2.0, 5.0))),
        sense=sense,
        decay=decay,
        counts=int(rng.choice(COUNTS)),
        nameplate={k: float(v * rng.uniform(0.94, 1.06)) for k, v in printed.items()},
    )


def _draw_options(
    rng: np.random.Generator, seed: int, drawn: Drawn, stated: Stated, within: Reach
) -> OwnMotor:
    normal = rng.standard_normal
    source = _log_uniform(rng, 0.002, 0.05) * drawn.motor.resistance_ohm
    return OwnMotor(
        own=drawn.motor,
        motor="drawn",
        seed=seed,
        speed="max",
        ambient=stated.ambient_c + stated.ambient_u * float(normal()),
        stiction=drawn.stiction,
        stribeck=drawn.stribeck_rad_s,
        load_inertia=drawn.load_inertia,
        cogging=drawn.cogging_nm,
        brush_drop=drawn.brush_drop_v,
        brush_current=drawn.brush_current_a,
        ripple=drawn.ripple,
        supply=within.supply_v,
        supply_resistance=source,
        supply_capacitance=_log_uniform(rng, 5e-5, 5e-3) / source,
        diode_drop=float(rng.uniform(0.5, 0.8)),
        dead_time=float(rng.uniform(0.0, 1e-6)),
        bridge_resistance=stated.bridge_ohm + stated.bridge_u * float(normal()),
        lead_resistance=stated.lead_ohm + stated.lead_u * float(normal()),
        sense="terminals" if stated.sense == "terminals" else "bridge",
        counts_per_turn=stated.counts,
        current_range=within.stall_a * float(rng.uniform(1.6, 2.6)),
        edge_ceiling=EDGE_CEILING,
        baud=0,
        buffer=65_535,
        **_draw_chain(rng),
    )


def _draw_chain(rng: np.random.Generator) -> dict[str, Any]:
    """Converter, windows and the tolerances that the board declares of them."""
    pwm = int(rng.choice(PWM_HZ))
    period = 1 / pwm
    window = _pick(rng, ("whole", "part", "instant"), (0.5, 0.3, 0.2))
    aperture = {
        "whole": period * int(rng.integers(1, 4)),
        "part": period * float(rng.uniform(0.1, 0.9)),
        "instant": 0.0,
    }[window]
    late = _log_uniform(rng, 1e-7, 2e-6) if DELAY_KEY in CALIBRATION else 0.0
    return {
        "pwm": pwm,
        "bits": int(rng.choice((10, 12, 12, 12, 14))),
        "noise": _log_uniform(rng, 0.4, 3.0),
        "aperture": round(aperture, 9),
        "delay": round(float(rng.uniform(8e-6, 20e-6)), 9),
        "phase": float(np.round(rng.uniform(0.1, 0.9), 3)) if window == "instant" else None,
        "delay_uncertainty": late,
        "voltage_aperture": round(period * int(rng.integers(1, 5)), 9),
        "voltage_delay": round(float(rng.uniform(8e-6, 20e-6)), 9),
        "gain_uncertainty": _log_uniform(rng, 1e-3, 2e-2),
        "voltage_gain_uncertainty": _log_uniform(rng, 5e-4, 1e-2),
        "offset_uncertainty": float(rng.uniform(0.5, 5.0)),
        "clock_uncertainty": float(rng.choice(CLOCK_PPM)),
    }


def _rate_hz(rng: np.random.Generator, options: Options, seconds: float) -> int:
    """The fastest rate that suits PWM and memory, or sometimes the next slower one."""
    longest = max(options.aperture + options.delay, options.voltage_aperture + 2e-5)
    fits = [
        rate
        for rate in RATES_HZ
        if options.pwm % rate == 0 and rate * longest < 1.9 and rate * seconds < MOST_SAMPLES
    ]
    if not fits:
        return RATES_HZ[0]
    return fits[-2] if len(fits) > 1 and rng.random() < 0.25 else fits[-1]


def _rig_text(seed: int, said: Stated, options: Options, within: Reach, rate_hz: int) -> str:
    """The rig file, but for the program."""
    voltage = "supply_voltage" if said.sense == "supply" else "terminal_voltage"
    plate = "".join(f"{key} = {value:.3g}\n" for key, value in said.nameplate.items())
    late = f"{DELAY_KEY} = {options.delay_uncertainty:.6g}\n"
    calibration = "".join(
        f"\n[calibration.{name}]\n{late}"
        for name in ("current", voltage)
        if options.delay_uncertainty
    )
    return f"""name = "drawn {seed}"
port = "sim://?seed={seed}"

[wiring]
counts_per_turn = {said.counts}
voltage_sense = "{said.sense}"
bridge_resistance_ohm = {said.bridge_ohm!r}
bridge_resistance_uncertainty_ohm = {said.bridge_u!r}
lead_resistance_ohm = {said.lead_ohm!r}
lead_resistance_uncertainty_ohm = {said.lead_u!r}
supply_voltage_v = {within.supply_v:.6g}

[limits]
current_a = {1.4 * within.stall_a:.4g}
speed_rad_s = {2.0 * within.idle_rad_s + 50:.6g}
supply_min_v = {0.4 * within.supply_v:.4g}
supply_max_v = {1.6 * within.supply_v:.4g}

[nameplate]
voltage_v = {within.top_v:.4g}
{plate}
[conditions]
ambient_c = {said.ambient_c}
ambient_uncertainty_c = {said.ambient_u}

[sampling]
rate_hz = {rate_hz}
channels = ["current", "{voltage}", "position"]
{calibration}"""
