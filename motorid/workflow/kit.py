"""The parts of a bench as a beginner names them, and the files that describe it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from motorid import json_text
from motorid.errors import UsageError
from motorid.rig_file import parse as parse_rig
from motorid.rig_front_end import FrontEnd, load_front_end
from motorid.rig_model import Rig
from motorid.wire.enums import Sensor
from motorid.workflow.kit_front_end import FARTHEST, made

BOARDS = ("uno", "nano", "mega", "pico", "other")
FAMILIES = {"uno": "uno", "nano": "uno", "mega": "mega", "pico": "pico"}  # of front ends
DIVIDED = ("uno", "mega")  # families whose leads have a divider each
SUPPLY_ROOM = 0.2  # of the supply: by which it may be off before the board trips
SPEED_ROOM = 1.3  # of the no-load speed at the supply
CURRENT_ROOM = 0.9  # of the current limit: the largest V/R of the program
UNKNOWN_SPEED = 1000.0  # rad/s, where nobody tells the no-load speed
LEVELS = (0.3, 0.5, 0.75)  # of the highest level
# Dividers of an Uno's front end (docs/kit.md), 11.4 kohm each: driven forward the sensor's current
# feeds one of them, and across an open motor both are in series.
DIVIDERS_OHM, DIVIDERS_UNCERTAINTY_OHM = 15e3, 3e3


@dataclass(frozen=True)
class Able:
    """What a board can: encoder edges a second, and samples a second that are worth their bytes."""

    edges_hz: int = 40_000
    rate_hz: float = 4000.0


AVR, PICO = Able(), Able(1_000_000, 20_000.0)


@dataclass(frozen=True)
class Driver:
    """A bridge: the name of its inputs, and both switches in the path. Uncertainties: standard."""

    bridge: str
    ohm: float
    ohm_uncertainty: float
    most_a: float
    drop_v: float = 0.0
    drop_uncertainty_v: float = 0.0


# Typical figures of the data sheets: ST L298 and L6203, Infineon BTS 7960, ST VNH5019A, Toshiba
# TB6612FNG, TI DRV8871 and DRV8833. Uncertainties: a data sheet's limits over the root of 3.
DRIVERS = {
    "l298n": Driver("bipolar", 1.15, 0.3, 2.0, 1.4, 0.3),
    "l6203": Driver("mosfet", 0.6, 0.1, 4.0),
    "bts7960": Driver("mosfet", 0.016, 0.005, 30.0),
    "vnh5019": Driver("mosfet", 0.018, 0.005, 12.0),
    "tb6612fng": Driver("in_in", 0.5, 0.12, 1.2),
    "drv8871": Driver("in_in", 0.565, 0.06, 3.6),
    "drv8833": Driver("in_in", 0.36, 0.05, 1.5),
    "half-bridges": Driver("mosfet", 0.1, 0.1, 50.0),
    "in-in": Driver("in_in", 0.1, 0.1, 50.0),
    "pwm-dir": Driver("pwm_dir", 0.1, 0.1, 50.0),
    "pwm-dir-bare": Driver("pwm_dir_bare", 0.1, 0.1, 50.0),
}


@dataclass(frozen=True)
class Answers:
    """What somebody says of the bench. None: not known."""

    board: str
    port: str
    driver: str
    sensor: str  # a front end that comes with motorid, or a file
    counts_per_turn: int
    supply_v: float
    motor: str
    motor_v: float
    gear_ratio: float = 1.0
    resistance_ohm: float | None = None
    no_load_rpm: float | None = None
    most_a: float | None = None
    encoder_reversed: bool = False
    ambient_c: float = 22.0
    reference_v: float | None = None  # measured, where it is a supply

    @property
    def constant(self) -> float | None:
        """V s, what turning induces by the label; friction lets the motor turn a little slower."""
        rpm = self.no_load_rpm
        return self.motor_v / (rpm * math.tau / 60) if rpm else None

    @property
    def able(self) -> Able:
        """What such a board can, as long as it has not said so itself."""
        return PICO if self.board == "pico" else AVR


@dataclass(frozen=True)
class Kit:
    """The files of a bench, read as the commands will read them."""

    rig: Rig
    front_end: FrontEnd


def kit(said: Answers, name: str, front_end_file: str, able: Able = AVR) -> Kit:
    """The rig file ``name`` and its front-end file.

    ``front_end_file``: its name, as the rig file has it; "" where the rig shall name none.
    ``able``: what the board can.
    Raises UsageError where the parts do not fit together, RigError where one is no part at all.
    """
    if not said.motor.isprintable():
        raise UsageError("the motor's label holds letters that cannot be printed: write it anew")
    driver, sensor = DRIVERS[said.driver], load_front_end(said.sensor)
    if sensor.facts["sensor"] == Sensor.MAGNITUDE:
        raise UsageError(
            f"the sensor {said.sensor} shows no sign of the current, which a fit needs: choose one "
            "that sits in a motor lead, such as acs712-05"
        )
    family = FAMILIES.get(said.board)
    if family and (problem := sensor.misfit(f"motorid-{family}")):
        raise UsageError(f"{problem}: choose one for a {said.board}")
    _check_reference(said, sensor)
    front_end = made(said.sensor, driver.bridge, said.reference_v, front_end_file or "front")
    most_a = _most_a(said, driver, front_end)
    text = _rig_text(said, driver, most_a, name, front_end_file, able)
    return Kit(parse_rig(text, name), front_end)


def _check_reference(said: Answers, sensor: FrontEnd) -> None:
    nominal = float(sensor.facts["reference_v"])
    if said.reference_v is not None and abs(said.reference_v / nominal - 1) > FARTHEST:
        raise UsageError(
            f"a reference of {said.reference_v:g} V is far from the {nominal:g} V of "
            f"{said.sensor}: measure at the board's reference pin, with the board running"
        )


def _most_a(said: Answers, driver: Driver, front_end: FrontEnd) -> float:
    parts = {
        f"the driver {said.driver}": driver.most_a,
        f"the sensor {said.sensor}": front_end.facts["max_current_ma"] / 1e3,
    }
    who, least = min(parts.items(), key=lambda part: part[1])
    if said.most_a is not None and said.most_a > least:
        raise UsageError(
            f"{said.most_a:g} A is more than {who} bears, {least:g} A: give {least:g} or less"
        )
    return said.most_a or least


def _most_speed(said: Answers, edges_hz: int) -> float:
    """rad/s. Raises UsageError where the encoder is too fine for the board."""
    turns_s = edges_hz / said.counts_per_turn * said.gear_ratio
    ceiling = 0.98 * math.tau * turns_s
    if said.no_load_rpm is None:
        return min(UNKNOWN_SPEED, ceiling)
    fastest = said.no_load_rpm * math.tau / 60 * said.supply_v / said.motor_v
    if fastest > ceiling:
        edges = fastest / math.tau / said.gear_ratio * said.counts_per_turn
        raise UsageError(
            f"at {said.supply_v:g} V the encoder makes {edges:.0f} edges a second, and the board "
            f"counts {edges_hz}: take fewer lines, or a lower supply"
        )
    return min(SPEED_ROOM * fastest, ceiling)


def _top_v(said: Answers, most_a: float) -> float:
    """The highest level: of motor, supply, and what the current limit leaves at standstill."""
    if not 0.3 * said.motor_v <= said.supply_v <= 3 * said.motor_v:
        raise UsageError(
            f"a supply of {said.supply_v:g} V does not fit a motor of {said.motor_v:g} V: give "
            "both as they are"
        )
    top = min(said.motor_v, 0.95 * said.supply_v)
    if said.resistance_ohm is not None:
        top = min(top, CURRENT_ROOM * most_a * said.resistance_ohm)
    return top


def _rig_text(
    said: Answers, driver: Driver, most_a: float, name: str, front_end_file: str, able: Able
) -> str:
    top, speed = _top_v(said, most_a), _most_speed(said, able.edges_hz)
    levels = ", ".join(f"{top * share:.3g}" for share in LEVELS)
    low, high = said.supply_v * (1 - SUPPLY_ROOM), said.supply_v * (1 + SUPPLY_ROOM)
    drop = (
        f"bridge_drop_v = {driver.drop_v:g}              # bipolar switches: their saturation\n"
        f"bridge_drop_uncertainty_v = {driver.drop_uncertainty_v:g}\n"
        if driver.drop_v
        else ""
    )
    load = (
        f"terminal_load_ohm = {DIVIDERS_OHM:g}        # the dividers, behind the current's sensor\n"
        f"terminal_load_uncertainty_ohm = {DIVIDERS_UNCERTAINTY_OHM:g}\n"
        if FAMILIES.get(said.board) in DIVIDED
        else ""
    )
    named = f"front_end = {_quoted(front_end_file)}   # facts of sensor and dividers\n"
    ohm = said.resistance_ohm
    known = "" if ohm is None else f"resistance_ohm = {ohm:g}\n"
    return f"""\
# {said.motor} on a {said.driver} with {said.sensor}, written by `motorid init`.
# Change what is not so; docs/rig-file.md explains every key. Uncertainties are standard ones.
name = {_quoted(name)}
port = {_quoted(said.port)}
{named if front_end_file else ""}
[wiring]
counts_per_turn = {said.counts_per_turn}              # four a line of the encoder
gear_ratio = {said.gear_ratio:g}                   # motor turns for one turn of the encoder's shaft
encoder_reversed = {str(said.encoder_reversed).lower()}
voltage_sense = "terminals"      # dividers at the motor's terminals
bridge_resistance_ohm = {driver.ohm:g}     # both switches of the {said.driver}, typically
bridge_resistance_uncertainty_ohm = {driver.ohm_uncertainty:g}
{drop}{load}supply_voltage_v = {said.supply_v:g}

[limits]                         # the board trips beyond these and opens the bridge
current_a = {most_a:g}
speed_rad_s = {speed:.4g}
supply_min_v = {low:.3g}
supply_max_v = {high:.3g}
run_time_s = 30

[nameplate]                      # roughly; guards against burning the motor
voltage_v = {said.motor_v:g}
{known}
[sampling]
rate_hz = {able.rate_hz:g}
channels = ["current", "terminal_voltage", "position"]

[program]                        # climbs from rest, each ended by a coast to rest
levels_v = [[{levels}], [{top:.3g}]]
drive_s = 0.6
coast_s = 1.5

[conditions]
ambient_c = {said.ambient_c:g}
ambient_uncertainty_c = 2
"""


def _quoted(text: str) -> str:
    """A TOML string. Raises UsageError where the text cannot stand in one line."""
    if not text.isprintable():
        raise UsageError(f"{text!r} holds letters that cannot be printed: write it anew")
    return json_text.dumps(text)
