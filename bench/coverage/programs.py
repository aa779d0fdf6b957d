"""The runs of one rig: three levels up and a coast; a reversal; three levels the other way."""

from __future__ import annotations

import math
from dataclasses import dataclass

from bench.coverage.motors import Drawn

REST_S = 0.05
SETTLING = 4.0  # mechanical time constants at each level
BRAKING = 7.0  # and at rest again, shorted
COAST_MARGIN = 1.2
LONGEST_COAST_S = 1.2
GLIDE = 0.3  # of the coast to rest, in the runs whose coast is cut short


@dataclass(frozen=True)
class Reach:
    """How far the bench drives the motor. ``by_duty``: programs in duty, else in volts."""

    top_v: float
    supply_v: float
    by_duty: bool
    tau_s: float  # mechanical, load included
    idle_rad_s: float  # at top_v
    stall_a: float  # at top_v


@dataclass(frozen=True)
class Run:
    """One program as TOML, and its length."""

    text: str
    duration_s: float


def reach(drawn: Drawn, share: float, by_duty: bool) -> Reach:
    """What suits this motor: a ``share`` of its voltage; a duty of 1 is the whole supply."""
    motor = drawn.motor
    top = share * motor.voltage_v
    R, K = motor.resistance_ohm, motor.torque_constant_nm_a
    inertia = motor.inertia_kg_m2 + drawn.load_inertia
    return Reach(
        top_v=top,
        supply_v=top if by_duty else 1.2 * top,
        by_duty=by_duty,
        tau_s=R * inertia / K**2,
        idle_rad_s=(top - R * motor.coulomb_nm / K) / K,
        stall_a=top / R,
    )


def runs(drawn: Drawn, within: Reach, decay: str) -> tuple[Run, ...]:
    """The three runs, all of which begin and end at rest."""
    drive, third = SETTLING * within.tau_s, 1 / 3
    coast = min(COAST_MARGIN * coasting_s(drawn, within.idle_rad_s), LONGEST_COAST_S)

    def run(shares: tuple[float, ...], coast_s: float) -> Run:
        steps = [_step("coast", REST_S)]
        steps += [_drive(share, drive, within, decay) for share in shares]
        steps += [_step("coast", coast_s), _step("brake", BRAKING * within.tau_s)]
        length = REST_S + len(shares) * drive + coast_s + BRAKING * within.tau_s
        return Run("".join(steps), length)

    return (
        run((third, 2 * third, 1.0), coast),
        run((0.5, -0.5, -0.8), GLIDE * coast),
        run((-third, -2 * third, -1.0), GLIDE * coast),
    )


def coasting_s(drawn: Drawn, speed: float) -> float:
    """Seconds in which viscous and dry friction stop the motor from ``speed``."""
    motor = drawn.motor
    B, T0 = motor.viscous_nm_s, motor.coulomb_nm
    inertia = motor.inertia_kg_m2 + drawn.load_inertia
    return inertia / B * math.log1p(B * speed / T0)


def _step(kind: str, seconds: float, more: str = "") -> str:
    return f'\n[[program.steps]]\nkind = "{kind}"\nduration_s = {seconds:.6g}\n{more}'


def _drive(share: float, seconds: float, within: Reach, decay: str) -> str:
    if within.by_duty:
        return _step("drive_duty", seconds, f'duty = {share:.6g}\ndecay = "{decay}"\n')
    volts = share * within.top_v
    return _step("drive_volts", seconds, f'volts = {volts:.6g}\ndecay = "{decay}"\n')
