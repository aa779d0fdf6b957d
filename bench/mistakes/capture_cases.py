"""Mistakes at a rig: what was done, and the words that name it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bench.mistakes.captures import Edit, Rigged, Tables
from motorid.capture.model import CURRENT, Capture
from motorid.program import Decay, StepKind
from motorid.sim.motor import Motor


@dataclass(frozen=True)
class Mistake:
    """One mistake: what somebody did, and patterns of which one must be said."""

    name: str
    causes: tuple[str, ...]
    rigged: Rigged
    traceless: tuple[str, ...] = ()


def writes(table: str, **keys: Any) -> Edit:
    """Keys that the user wrote into a table of the rig file."""

    def edit(tables: Tables, motor: Motor) -> None:
        tables.setdefault(table, {}).update(keys)

    return edit


def supply_stated(factor: float) -> Edit:
    """Another supply voltage than there is."""

    def edit(tables: Tables, motor: Motor) -> None:
        tables["wiring"]["supply_voltage_v"] = factor * motor.supply_v

    return edit


def counts_over(divisor: float) -> Edit:
    """Lines for counts, or the like; limits as the motor needs them."""

    def edit(tables: Tables, motor: Motor) -> None:
        tables["wiring"]["counts_per_turn"] = 2048 / divisor

    return edit


def another_plate(tables: Tables, motor: Motor) -> None:
    """The label of another winding of the same size."""
    plate = tables["nameplate"]
    for key, power in (("resistance_ohm", 2), ("inductance_h", 2), ("torque_constant_nm_a", 1)):
        plate[key] *= 1.8**power
    plate["no_load_current_a"] /= 1.8
    plate["inertia_kg_m2"] *= 1.3


def sensed_at(where: str) -> Edit:
    """Where the user says that the voltage is taken."""
    return writes("wiring", voltage_sense=where)


def without_volts(tables: Tables, motor: Motor) -> None:
    """Volts are commanded and the supply is not recorded."""
    tables["sampling"]["channels"] = ["current", "position"]


def with_supply(tables: Tables, motor: Motor) -> None:
    """The supply's volts in place of the terminals'."""
    tables["wiring"]["voltage_sense"] = "supply"
    tables["sampling"]["channels"] = ["current", "supply_voltage", "position"]


def supply_limited(motor: Motor) -> dict[str, Any]:
    """A bench supply that gives half of the stall current."""
    return {"supply_limit": 0.5 * motor.stall_current_a, "supply_capacitance": 5e-4}


def channel(name: str, **keys: Any) -> Callable[[Capture, Motor], Capture]:
    """Facts that a board's firmware declares falsely of a channel."""

    def alter(capture: Capture, motor: Motor) -> Capture:
        changed = replace(capture.channels[name], **keys)
        return replace(capture, channels={**capture.channels, name: changed})

    return alter


def read_as(name: str, change: Callable[[Any, Capture, Motor], Any]):  # type: ignore[no-untyped-def]
    """Other readings of a channel, in its counts."""

    def alter(capture: Capture, motor: Motor) -> Capture:
        one = capture.channels[name]
        raw = np.rint(change(one.values, capture, motor) / one.scale + one.offset)
        kept = replace(one, raw=raw.astype(np.asarray(one.raw).dtype))
        return replace(capture, channels={**capture.channels, name: kept})

    return alter


def stops_at_half(values: Any, capture: Capture, motor: Motor) -> Any:
    """An amplifier that ends at half of the stall current, within the converter's range."""
    noise = np.random.default_rng(3).standard_normal(len(values)) * 0.002 * motor.stall_current_a
    most = 0.5 * motor.stall_current_a
    return np.where(np.abs(values) < most, values, np.sign(values) * most + noise)


def off_while_driven(values: Any, capture: Capture, motor: Motor) -> Any:
    """A zero that shifts by 1 % of stall while the bridge switches."""
    steps = capture.program.steps if capture.program else ()
    driven = np.zeros(len(values))
    for phase in capture.phases:
        driven[capture.ticks > phase.tick] = steps[phase.index].kind != StepKind.COAST
    return values + 0.01 * motor.stall_current_a * driven


def with_lost_rows(capture: Capture, motor: Motor) -> Capture:
    """A driver that loses a sample here and there and numbers the rest anew."""
    keep = np.random.default_rng(4).random(len(capture)) > 0.002
    channels = {n: replace(c, raw=np.asarray(c.raw)[keep]) for n, c in capture.channels.items()}
    return replace(capture, ticks=capture.ticks[: int(keep.sum())], channels=channels)


def of_decay(decay: Decay) -> Callable[[Capture, Motor], Capture]:
    """A program whose steps claim another decay than the bridge has."""

    def alter(capture: Capture, motor: Motor) -> Capture:
        assert capture.program
        steps = tuple(
            replace(step, decay=decay) if step.kind == StepKind.DRIVE_VOLTS else step
            for step in capture.program.steps
        )
        return replace(capture, program=replace(capture.program, steps=steps))

    return alter


def of_pwm(hertz: float) -> Callable[[Capture, Motor], Capture]:
    """Another PWM frequency than the timer makes."""
    return lambda c, motor: replace(c, wiring=replace(c.wiring, pwm_hz=hertz))


def both(*edits: Edit) -> Edit:
    """One after the other."""

    def edit(tables: Tables, motor: Motor) -> None:
        for one in edits:
            one(tables, motor)

    return edit


def _loaded(motor: Motor) -> dict[str, Any]:
    return {"load_inertia": 2 * motor.inertia_kg_m2}


def _slipping(motor: Motor) -> dict[str, Any]:
    torque = 0.2 * motor.torque_constant_nm_a * motor.stall_current_a
    return {"load_inertia": motor.inertia_kg_m2, "coupling": torque}


SPEED = (r"speed_scale", r"counts.per.turn|\bcounts\b[^.]*\bturn\b")
SUPPLY = (r"supply",)
SERIES = (r"series_resistance", r"leads?\b[^.]*resistance", r"resistance[^.]*\bleads?\b")
LOAD = (r"\bload_\w+", r"\bload\b", r"inertia\b[^.]*nameplate", r"nameplate[^.]*inertia")

MISTAKES = (
    Mistake("supply stated 30 % too high", SUPPLY, Rigged(edit=supply_stated(1.3))),
    Mistake("supply stated at half, volts commanded", SUPPLY,
            Rigged(edit=both(supply_stated(0.5), with_supply))),
    Mistake("lines stated for counts (4 too few)", SPEED, Rigged(edit=counts_over(4))),
    Mistake("counts per turn twice too many", SPEED, Rigged(edit=counts_over(0.5))),
    Mistake("gear stated that is not there", (*SPEED, r"\bgear"),
            Rigged(edit=writes("wiring", gear_ratio=3.0))),
    Mistake("encoder reversed", (r"encoder_sign", r"encoder[^.]*(other way|revers|sign)"),
            Rigged(hidden=lambda m: {"fault": "encoder_reversed"})),
    Mistake("current sensor reversed", (r"current_sign", r"current[^.]*(revers|sign|swap)"),
            Rigged(hidden=lambda m: {"fault": "current_reversed"})),
    Mistake("shunt wrong by 2", (r"current_scale",),
            Rigged(edit=writes("calibration.current", gain=2.0))),
    Mistake("amplifier wrong by 10", (r"current_scale", r"current\b[^.]*(gain|scale|factor)"),
            Rigged(edit=writes("calibration.current", gain=0.1))),
    Mistake("voltage divider wrong by 2", (r"voltage_scale", r"voltage\b[^.]*(gain|scale|factor)"),
            Rigged(edit=writes("calibration.terminal_voltage", gain=2.0))),
    Mistake("two motors pooled", (r"serial", r"(another|different|two) motors?", r"pooled"),
            Rigged(other={"magnet": 0.9, "copper": 1.08})),
    Mistake("label of another winding",
            (r"nameplate\b[^.]*\b(another|other|wrong|check)\b", r"check the nameplate"),
            Rigged(edit=another_plate)),
    Mistake("disc on the shaft, not stated", LOAD, Rigged(hidden=_loaded)),
    Mistake("belt slips", (r"load_slips",), Rigged(hidden=_slipping)),
    Mistake("leads not stated, sensed at the bridge", SERIES,
            Rigged(hidden=lambda m: {"lead_resistance": 0.6 * m.resistance_ohm, "sense": "bridge"},
                   edit=sensed_at("bridge"))),
    Mistake("bridge said to be the terminals", SERIES,
            Rigged(hidden=lambda m: {"lead_resistance": 0.6 * m.resistance_ohm,
                                     "sense": "bridge"})),
    Mistake("RC before the current's converter", (r"current_filtered", r"current_lag"),
            Rigged(hidden=lambda m: {"hidden_filter": 3e-4})),
    Mistake("supply limits its current, volts not recorded", SUPPLY,
            Rigged(hidden=supply_limited, edit=without_volts)),
    Mistake("supply sags, volts not recorded", SUPPLY,
            Rigged(hidden=lambda m: {"supply_resistance": 0.2 * m.resistance_ohm,
                                     "supply_capacitance": 1e-3 / m.resistance_ohm},
                   edit=without_volts)),
    Mistake("decay said to be fast", (r"decay",), Rigged(edit=with_supply,
                                                         alter=of_decay(Decay.FAST))),
    Mistake("decay said to be by diodes", (r"decay",),
            Rigged(edit=with_supply, alter=of_decay(Decay.DIODE))),
    Mistake("PWM frequency wrong by 4", (r"\bPWM\b",),
            Rigged(hidden=lambda m: {"pwm": 20_000}, edit=with_supply, alter=of_pwm(80_000.0))),
    Mistake("voltage averaged over 1.6 PWM periods", (r"\bPWM\b", r"alias"),
            Rigged(hidden=lambda m: {"pwm": 16_000, "voltage_aperture": 1e-4, "aperture": 6.25e-5},
                   edit=writes("sampling", rate_hz=8_000))),
    Mistake("aperture of the current wrong", (r"current_lag", r"current_filtered", r"aperture"),
            Rigged(hidden=lambda m: {"aperture": 1e-4, "delay": 4e-5},
                   alter=channel(CURRENT, aperture_s=1e-5, delay_s=0.0))),
    Mistake("clock 1 % off", (r"clock", r"time.base"),
            Rigged(hidden=lambda m: {"clock_ppm": 10_000}),
            traceless=("clock", "time_scale")),
    Mistake("room 20 K colder than stated", (r"ambient_\w+", r"temperature"),
            Rigged(edit=writes("conditions", ambient_c=45.0)),
            traceless=("ambient_temperature",)),
    Mistake("current clipped at half of stall", (r"current_saturated", r"saturat"),
            Rigged(alter=read_as(CURRENT, stops_at_half))),
    Mistake("current's zero shifts while driven", (r"current_offset",),
            Rigged(alter=read_as(CURRENT, off_while_driven))),
    Mistake("encoder loses counts", (r"encoder_loses_counts",),
            Rigged(hidden=lambda m: {"fault": "encoder_drop:0.02"}), traceless=("speed_scale",)),
    Mistake("edges faster than the counter", (r"encoder", r"edge"),
            Rigged(hidden=lambda m: {
                "edge_ceiling": int(0.7 * 2048 * m.voltage_v / m.torque_constant_nm_a / 6.2832)})),
    Mistake("samples lost, ticks renewed", (r"samples_dropped",), Rigged(alter=with_lost_rows)),
    Mistake("8 bits over ten times the range", (r"resolution", r"coarse", r"range"),
            Rigged(hidden=lambda m: {"bits": 8, "current_range": 8 * m.stall_current_a})),
)  # fmt: skip
