"""Good rigs and good logs, drawn by a law of their own: nothing is wrong with any of them.

Motors by rated power, speed and time constants as catalogues list them; unlike the coverage study,
no figure follows a scaling law through the simulator's presets. Whatever a user states is right
within the uncertainty that he states.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from bench.coverage.rigs import OwnMotor
from bench.mistakes.chain import rounded
from bench.mistakes.command import Answer, fitted
from bench.mistakes.logs import Log, Rng, Station, Table, answer
from bench.mistakes.plant import Drive, Motor
from motorid.acquire.record import capture_over
from motorid.errors import MotoridError
from motorid.rig_file import parse
from motorid.sim.motor import Motor as Preset
from motorid.sim.port import SimPort

VOLTS = (3.0, 6.0, 9.0, 12.0, 18.0, 24.0, 36.0, 48.0)
NO_MORE = {"cogging": 0.0, "ripple": 0.0, "brush_drop": 0.0, "stiction": 1.0}
PWM_HZ = (10_000, 16_000, 20_000, 25_000, 40_000)


def _log_uniform(rng: Rng, low: float, high: float) -> float:
    return float(math.exp(rng.uniform(math.log(low), math.log(high))))


def draw_motor(rng: Rng) -> Motor:
    """A motor of 1 to 300 W, by what its catalogue page would say."""
    power = _log_uniform(rng, 1.0, 300.0)
    volts = float(rng.choice(VOLTS[:5] if power < 30 else VOLTS[3:]))
    stall_w = power * float(rng.uniform(4.0, 12.0))
    R = volts**2 / stall_w
    idle = float(rng.uniform(0.015, 0.09))  # no-load current over stall current
    top = float(rng.uniform(250.0, 1100.0))
    K = volts * (1 - idle) / top
    tau = _log_uniform(rng, 6e-3, 6e-2)
    tau_e = min(_log_uniform(rng, 6e-5, 3e-3), tau / 6)
    dry = float(rng.uniform(0.35, 0.9))
    drag = K * idle * volts / R  # torque at the no-load speed
    return Motor(R, tau_e * R, K, (1 - dry) * drag / top, tau * K**2 / R, dry * drag, volts)


@dataclass(frozen=True)
class Good:
    """One drawn case: what it is, its truth, and what its user is told.

    ``has``: wider models' terms whose effect the motor really has.
    """

    what: str
    truth: dict[str, float]
    answer: Answer
    has: frozenset[str] = frozenset()


def good_log(seed: int, folder: Path) -> Good:
    """A log of some drive, of converters of 10 to 16 bits, with right statements."""
    rng = np.random.default_rng([seed, 61])
    motor = draw_motor(rng)
    rate = 1.0 / (motor.L / motor.R * float(rng.uniform(0.25, 1.2)))
    rate = min(max(rate, 40.0 / motor.tau_s), 160.0 / motor.tau_s)
    station = Station(f"drawn {seed}", motor, float(f"{rate:.2g}"), float(rng.uniform(2.5, 5.0)))
    name, drive = draw_drive(rng)
    bits = int(rng.choice((10, 12, 14, 16)))
    noise = _log_uniform(rng, 0.3, 3.0)

    def converted(table: Table, at: Station, own: Rng) -> Table:
        out = dict(table)
        for channel, scale in at.scales.items():
            step = 3.0 * scale / 2**bits
            more = noise * step * own.standard_normal(len(table[channel]))
            out[channel] = rounded(table[channel] + more, step)
        return out

    said: tuple[str, ...] = ()
    if rng.random() < 0.5:
        said = ("--gain-uncertainty", "current=0.005", "--gain-uncertainty", "voltage=0.003",
                "--gain-uncertainty", "speed=0.001")  # fmt: skip
    if rng.random() < 0.3:
        said += ("--delay", "current=0", "--delay", "speed=0")
    log = Log(drive=drive, spoil=converted, options=lambda s: said, plate=bool(rng.random() < 0.5))
    what = f"log {seed}: {name}, {bits} bits, {station.rate_hz:g} Hz, {motor.volts:g} V"
    return Good(what, motor.truth, answer(log, station, folder, seed))


def draw_drive(rng: Rng) -> tuple[str, Any]:
    """Steps, a random sequence, ramps or a speed loop; each with a rest at the beginning."""
    kind = str(rng.choice(("steps", "one way", "random", "ramps")))
    shares = rng.uniform(0.25, 1.0, 7) * rng.choice((-1.0, 1.0), 7)
    if kind == "one way":
        shares = np.abs(shares)
    shares[0], shares[-1] = 0.0, 0.0
    bits = rng.integers(0, 2, 4000)
    phase = float(rng.uniform(0.2, 0.6))

    def drive(station: Station) -> Drive:
        volts, level_s, period_s = station.motor.volts, station.level_s, station.period_s
        hold_s = max(round(0.15 * station.motor.tau_s / period_s), 2) * period_s

        def wish(t: float, i: float, w: float) -> float:
            place = int(t / level_s + 1e-9)
            if place == 0:
                return 0.0
            if kind == "random":
                return volts * (0.9 if bits[int(t / hold_s + 1e-9)] else -0.5)
            if kind == "ramps":
                return volts * math.sin(2 * math.pi * phase * (t / level_s - 1.0))
            return volts * float(shares[min(place, len(shares) - 1)])

        return wish

    return kind, drive


def good_capture(seed: int, folder: Path) -> Good:
    """One run of a simulated rig whose file says what is so."""
    rng = np.random.default_rng([seed, 62])
    motor = draw_motor(rng)
    plain = seed % 2 == 0
    options = _options(rng, seed, motor)
    if plain:  # the motor is as the equations say
        options = replace(options, **NO_MORE)
    path = folder / "good.h5"
    text, what = _rig(rng, motor, options)
    what = f"rig {seed}, {'plain' if plain else 'real'} motor: {what}"
    truth = motor.truth
    try:
        rig = parse(text, f"good {seed}")
        port = SimPort(f"good {seed}", options)
        capture_over(port, rig, rig.program, path, force=True)
    except MotoridError as error:
        return Good(what, truth, Answer(3, None, str(error)))
    return Good(what, truth, fitted([path]), _effects(options))


def _effects(o: OwnMotor) -> frozenset[str]:
    sizes = {
        "brush-drop": o.brush_drop, "cogging": o.cogging, "ripple": o.ripple,
        "stribeck": o.stiction - 1.0,
    }  # fmt: skip
    return frozenset(name for name, size in sizes.items() if size)


def _options(rng: Rng, seed: int, m: Motor) -> OwnMotor:
    iron = bool(rng.random() < 0.5)
    own = Preset(
        title="drawn", source="bench", friction="", thermal="", voltage_v=m.volts,
        resistance_ohm=m.R, inductance_h=m.L, torque_constant_nm_a=m.K, inertia_kg_m2=m.J,
        viscous_nm_s=m.B, coulomb_nm=m.T0, commutator_segments=int(rng.choice((5, 7, 9, 13))),
        winding_k_w=5.0, winding_s=20.0, housing_k_w=15.0, housing_s=600.0,
        supply_v=1.15 * m.volts, switch_resistance_ohm=0.005 * m.R,
        supply_resistance_ohm=float(rng.uniform(0.002, 0.02)) * m.R,
        supply_capacitance_f=2e-3 / m.R,
    )  # fmt: skip
    pwm = int(rng.choice(PWM_HZ))
    return OwnMotor(
        own=own, motor="drawn", seed=seed, speed="max", baud=0, buffer=65_535, heating=False,
        ambient=25.0, pwm=pwm, bits=int(rng.choice((10, 12, 14))),
        noise=float(rng.uniform(0.4, 2.0)), cogging=m.T0 * float(rng.uniform(0, 0.15)) * iron,
        ripple=float(rng.uniform(0, 0.003)), brush_drop=m.volts * float(rng.uniform(0, 0.01)),
        stiction=float(rng.uniform(1.0, 1.2)), stribeck=float(rng.uniform(0.5, 4.0)),
        current_range=1.8 * m.stall_a, counts_per_turn=int(rng.choice((400, 1024, 2000, 4096))),
        aperture=1.0 / pwm, voltage_aperture=1.0 / pwm, edge_ceiling=4_000_000,
        dead_time=float(rng.uniform(1e-7, 6e-7)),
    )  # fmt: skip


def _rig(rng: Rng, m: Motor, options: OwnMotor) -> tuple[str, str]:
    """The rig's file, and what is special of it."""
    rates = [r for r in (2_000, 2_500, 4_000, 5_000, 8_000, 10_000) if options.pwm % r == 0]
    wanted = [r for r in rates if r * 60 * m.tau_s < 20_000] or rates[:1]
    rate = wanted[-1]
    bridge = 2 * options.preset.switch_resistance_ohm
    printed = {
        "voltage_v": m.volts, "resistance_ohm": m.R, "inductance_h": m.L,
        "torque_constant_nm_a": m.K, "inertia_kg_m2": m.J,
        "no_load_current_a": (m.T0 + m.B * m.top_rad_s) / m.K,
    }  # fmt: skip
    plate = [f"{k} = {v * rng.uniform(0.95, 1.05):.3g}" for k, v in printed.items()]
    plated = bool(rng.random() < 0.7)
    lines = [
        'name = "good"', 'port = "sim://"', "[wiring]",
        f"counts_per_turn = {options.counts_per_turn}", 'voltage_sense = "terminals"',
        f"bridge_resistance_ohm = {bridge!r}",
        f"bridge_resistance_uncertainty_ohm = {0.1 * bridge!r}",
        f"supply_voltage_v = {options.supply_v * rng.uniform(0.98, 1.02):.3g}",
        "[limits]", f"current_a = {1.7 * m.stall_a!r}", f"speed_rad_s = {1.8 * m.top_rad_s!r}",
        f"supply_min_v = {0.5 * options.supply_v!r}", f"supply_max_v = {1.4 * options.supply_v!r}",
        "[nameplate]", *(plate if plated else plate[:2]),
        "[conditions]", "ambient_c = 25.0", "ambient_uncertainty_c = 1.0",
        "[sampling]", f"rate_hz = {rate}",
        'channels = ["current", "terminal_voltage", "position"]',
    ]  # fmt: skip
    by_duty = bool(rng.random() < 0.4)
    levels = [0.3, 0.65, 1.0, -0.5] if rng.random() < 0.5 else [0.5, 1.0]
    lines += _coast(0.03)
    for level in levels:
        seconds = 4.5 * m.tau_s * rng.uniform(0.9, 1.2)  # no whole number of samples
        share = f"duty = {0.85 * level:.5g}" if by_duty else f"volts = {level * m.volts:.5g}"
        kind = "drive_duty" if by_duty else "drive_volts"
        lines += ["[[program.steps]]", f'kind = "{kind}"', f"duration_s = {seconds:.6f}", share,
                  'decay = "synchronous_slow"']  # fmt: skip
        lines += _coast(3.0 * m.tau_s)
        lines += ["[[program.steps]]", 'kind = "brake"', f"duration_s = {6 * m.tau_s:.6f}"]
    said = f"{'duty' if by_duty else 'volts'}, {rate} Hz, {options.bits} bits, {m.volts:g} V"
    return "\n".join(lines) + "\n", said


def _coast(seconds: float) -> list[str]:
    return ["[[program.steps]]", 'kind = "coast"', f"duration_s = {seconds:.6f}"]
