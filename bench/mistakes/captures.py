"""Captures of the simulated rig whose file, wiring or motor is not what its user believes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from bench.mistakes.command import Answer, fitted, say
from motorid.capture import store
from motorid.capture.model import Capture
from motorid.sim.motor import Motor, find_motor

MOTORS = {
    "small": "faulhaber-2338s006s",
    "medium": "dunkermotoren-gr42",
    "big": "maxon-re35",
}
Tables = dict[str, dict[str, Any]]
Edit = Callable[[Tables, Motor], None]
LEVELS = (0.4, 1.0, -0.7)  # of the nominal voltage, each followed by a coast and a brake
TAUS, COAST_TAUS, BRAKE_TAUS, REST_S = 4.0, 5.0, 5.0, 0.03


@dataclass(frozen=True)
class Rigged:
    """How a rig deceives its user.

    ``hidden``: options of the simulated rig that his file does not say. ``edit``: what he wrote
    into it. ``alter``: what became of the file of the capture. ``other``: as ``hidden``, of another
    motor whose run is fitted together with the first.
    """

    hidden: Callable[[Motor], Mapping[str, Any]] = lambda motor: {}
    edit: Edit = lambda tables, motor: None
    alter: Callable[[Capture, Motor], Capture] | None = None
    other: Mapping[str, Any] = field(default_factory=dict)


def preset(name: str) -> Motor:
    """The motor of that station."""
    return find_motor(MOTORS[name])[1]


def truth(motor: Motor) -> dict[str, float]:
    """The six parameters at 25 °C, where the simulated winding stays."""
    return {
        "R": motor.resistance_ohm,
        "L": motor.inductance_h,
        "K": motor.torque_constant_nm_a,
        "B": motor.viscous_nm_s,
        "J": motor.inertia_kg_m2,
        "T0": motor.coulomb_nm,
        "R_25": motor.resistance_ohm,
    }


def honest(motor: Motor) -> Tables:
    """The rig's file as one should write it."""
    m = motor
    top = m.voltage_v / m.torque_constant_nm_a
    bridge = 2 * m.switch_resistance_ohm
    return {
        "wiring": {
            "counts_per_turn": 2048,
            "voltage_sense": "terminals",
            "bridge_resistance_ohm": bridge,
            "bridge_resistance_uncertainty_ohm": 0.1 * bridge,
            "supply_voltage_v": m.supply_v,
        },
        "limits": {
            "current_a": 1.45 * m.stall_current_a,
            "speed_rad_s": 1.4 * top,
            "supply_min_v": 0.5 * m.supply_v,
            "supply_max_v": 1.5 * m.supply_v,
        },
        "nameplate": {
            "voltage_v": m.voltage_v,
            "resistance_ohm": m.resistance_ohm,
            "inductance_h": m.inductance_h,
            "torque_constant_nm_a": m.torque_constant_nm_a,
            "inertia_kg_m2": m.inertia_kg_m2,
            "no_load_current_a": (m.coulomb_nm + m.viscous_nm_s * top) / m.torque_constant_nm_a,
        },
        "sampling": {
            "rate_hz": _rate_hz(m),
            "channels": ["current", "terminal_voltage", "position"],
        },
        "conditions": {"ambient_c": 25.0, "ambient_uncertainty_c": 1.0},
    }


def _rate_hz(motor: Motor) -> int:
    """Fast enough for its current, and no faster."""
    return 10_000 if motor.inductance_h / motor.resistance_ohm < 5e-4 else 5_000


def rig_text(motor: str, tables: Tables, hidden: Mapping[str, Any]) -> str:
    """A rig file on the simulated bench."""
    options = {"motor": motor, "speed": "max", "baud": 0, "heating": 0, "ambient": 25, **hidden}
    url = "&".join(f"{key}={value}" for key, value in options.items())
    lines = ['name = "bench"', f'port = "sim://?{url}"']
    for name, keys in tables.items():
        lines += ["", f"[{name}]", *(f"{key} = {_toml(value)}" for key, value in keys.items())]
    return "\n".join(lines + _program(find_motor(motor)[1])) + "\n"


def _toml(value: Any) -> str:
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, list):
        return f"[{', '.join(map(_toml, value))}]"
    return repr(value)


def _program(motor: Motor) -> list[str]:
    m = motor
    tau = m.resistance_ohm * m.inertia_kg_m2 / m.torque_constant_nm_a**2
    lines = _step("coast", REST_S)
    for share in LEVELS:
        level = f"volts = {share * m.voltage_v:.4g}", 'decay = "synchronous_slow"'
        lines += [*_step("drive_volts", max(TAUS * tau, 0.05)), *level]
        lines += _step("coast", max(COAST_TAUS * tau, 0.05))
        lines += _step("brake", max(BRAKE_TAUS * tau, 0.03))
    return lines


def _step(kind: str, seconds: float) -> list[str]:
    return ["", "[[program.steps]]", f'kind = "{kind}"', f"duration_s = {round(seconds, 3)}"]


def answer(rigged: Rigged, station: str, folder: Path, seed: int = 1) -> Answer:
    """What a user of that rig is told: by the capture, then by the fit."""
    motor = preset(station)
    paths, said = [], ""
    others = [rigged.other] if rigged.other else []
    for number, more in enumerate(({}, *others)):
        tables = honest(motor)
        rigged.edit(tables, motor)
        hidden = {"seed": seed + number, "board": seed, **rigged.hidden(motor), **more}
        rig, path = folder / "rig.toml", folder / f"run-{number}.h5"
        rig.write_text(rig_text(MOTORS[station], tables, hidden), encoding="utf-8")
        serial = f"SN-{seed + number}"
        done = say("capture", "--rig", rig, "-o", path, "--serial", serial, "--force")
        said += done.err
        if done.code:
            return Answer(done.code, None, said)
        if rigged.alter:
            capture = rigged.alter(store.load(path), motor)
            store.save(replace(capture, sha256="", path=""), path, force=True)
        paths.append(path)
    return fitted(paths, before=said)
