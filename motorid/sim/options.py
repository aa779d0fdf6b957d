"""What a sim:// URL may say: every effect of the simulated rig, with its range."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from typing import Any
from urllib.parse import parse_qsl, urlsplit

from motorid.errors import UsageError
from motorid.sim.faults import Fault, parse_faults
from motorid.sim.motor import Motor, find_motor
from motorid.sim.nearest import unknown
from motorid.wire.spec import load

CLOCK_HZ = 16_000_000
MINOR = load().minor
MOST_SATURATION = 0.99  # of L, at any current
TRUE, FALSE = ("1", "true", "yes", "on"), ("0", "false", "no", "off")


def _number(default: float | None, low: float, high: float, doc: str) -> Any:
    return field(default=default, metadata={"low": low, "high": high, "doc": doc, "type": float})


def _integer(default: int | None, low: int, high: int, doc: str) -> Any:
    return field(default=default, metadata={"low": low, "high": high, "doc": doc, "type": int})


def _choice(default: str, choices: tuple[str, ...], doc: str) -> Any:
    return field(default=default, metadata={"choices": choices, "doc": doc, "type": str})


def _switch(default: bool, doc: str) -> Any:
    return field(default=default, metadata={"doc": doc, "type": bool})


def _text(default: str, doc: str) -> Any:
    return field(default=default, metadata={"doc": doc, "type": str})


@dataclass(frozen=True)
class Options:
    """Options of a simulated rig. None: the motor preset's, or drawn by the seed."""

    motor: str = _text("faulhaber-2338s006s", "motor preset, or the beginning of its name")
    seed: int = _integer(1, 0, 2**63 - 1, "of noise, errors of the measuring chain and faults")
    board: int = _integer(None, 0, 2**63 - 1, "seed of the chain's errors and serial number alone")
    speed: str = _choice("realtime", ("realtime", "max"), "pace; max runs on simulated time")
    fault: str = _text("", "faults, comma-separated: NAME[:VALUE][@SECONDS of the first run]")
    # motor
    clamped: bool = _switch(False, "a fixture holds the rotor")
    ambient: float = _number(23.0, -40, 100, "°C; winding and housing start there")
    heating: bool = _switch(True, "winding and magnets warm up")
    stiction: float = _number(1.15, 1, 10, "breakaway torque over Coulomb torque")
    stribeck: float = _number(1.0, 0, 1e3, "rad/s over which the excess of stiction decays")
    quadratic: float = _number(0.0, 0, 1e3, "N·m·s²/rad², friction with the square of speed")
    asymmetry: float = _number(0.0, -0.9, 0.9, "Coulomb torque forwards over its mean, less 1")
    load_inertia: float = _number(0.0, 0, 1e3, "kg·m² added to the rotor's")
    cogging: float = _number(0.0, 0, 1e3, "N·m, amplitude of the cogging torque")
    cogging_per_turn: float = _number(None, 1, 1000, "periods a turn (as the commutation)")
    brush_drop: float = _number(0.0, 0, 10, "V over both brushes at large current")
    brush_current: float = _number(None, 0, 1e4, "A at which it bends (5 % of stall)")
    ripple: float = _number(0.0, 0, 0.5, "relative commutation ripple of K and R")
    commutation: float = _number(0.0, 0, 1, "share of R that commutation adds at the speed V/K")
    commutation_speed: float = _number(
        0.0, 0, 1e5, "rad/s above which it does, as of lifting brushes"
    )
    fresh_friction: float = _number(
        0.0, 0, 10, "dry friction of a motor that has not turned yet over its own, less 1"
    )
    fresh_time: float = _number(1.0, 1e-3, 1e5, "s of turning, in which that falls to 1/e")
    load_friction: float = _number(
        0.0, 0, 0.5, "dry friction over the torque that the current makes"
    )
    reaction: float = _number(0.0, 0, 0.3, "share of K that is lost at the stall current")
    reaction_bend: float = _number(None, 0, 1e4, "A over which that loss sets in (5 % of stall)")
    saturation: float = _number(0.0, 0, 0.9, "share of dλ/di that is lost at the stall current")
    saturation_current: float = _number(None, 1e-6, 1e5, "A of half of all loss (half of stall)")
    eddy: float = _number(0.0, 0, 0.95, "share of L that lies beside an eddy resistance")
    eddy_time: float = _number(1e-4, 1e-6, 0.1, "s, that share of L over that resistance")
    # spread and defects of one motor
    copper: float = _number(1.0, 0.1, 10, "factor on R: thickness of the wire, joints")
    magnet: float = _number(1.0, 0.1, 10, "factor on K: charge of the magnets")
    winding: float = _number(1.0, 0.1, 10, "factor on the turns: K with it, R and L squared")
    friction: float = _number(1.0, 0, 100, "factor on B and T0")
    shorted_turn: float = _number(0.0, 0, 0.9, "share of one coil's turns that are shorted")
    unbalance: float = _number(0.0, 0, 1e3, "N·m, amplitude of a weight off the axis")
    brush_bounce: float = _number(0.0, 0, 1e3, "ohm that 3 of 10 commutations add, at random")
    coupling: float = _number(0.0, 0, 1e3, "N·m at which load_inertia slips; 0: it is fast")
    shaft_stiffness: float = _number(0.0, 0, 1e6, "N·m/rad, joins load_inertia; 0: it is fast")
    shaft_damping: float = _number(0.0, 0, 1e3, "N·m·s/rad, of that shaft")
    # bridge and supply
    supply: float = _number(None, 0, 1000, "V, unloaded")
    supply_resistance: float = _number(None, 0, 100, "ohm")
    supply_capacitance: float = _number(None, 0, 10, "F at the bridge")
    supply_limit: float = _number(0.0, 0, 1e4, "A, current limit of the supply; 0: none")
    supply_sinks: bool = _switch(True, "the supply takes current back, as a battery does")
    bridge_resistance: float = _number(None, 0, 100, "ohm, the two switches in the path")
    bridge_drop: float = _number(0.0, 0, 10, "V over both switches at large current, as an L298's")
    diode_drop: float = _number(0.7, 0, 5, "V of a body diode")
    dead_time: float = _number(200e-9, 0, 5e-6, "s at each switching edge")
    lead_resistance: float = _number(0.0, 0, 100, "ohm, both leads from bridge to motor")
    sense: str = _choice("terminals", ("terminals", "bridge"), "where terminal_voltage is taken")
    pwm: int = _integer(20_000, 1_000, 200_000, "Hz; must divide 16 MHz")
    decay_modes: str = _text("synchronous_slow+diode+fast", "decay modes the board offers")
    # measuring chain
    bits: int = _integer(12, 8, 15, "of the converter")
    noise: float = _number(1.0, 0, 1000, "counts rms of each reading")
    current_range: float = _number(None, 1e-6, 1e5, "A at full scale (1.5 x stall current)")
    voltage_range: float = _number(None, 1e-3, 1e5, "V at full scale (1.25 x supply)")
    aperture: float = _number(50e-6, 0, 1e-3, "s, window of the current; 0: an instant")
    delay: float = _number(5e-6, 0, 45e-6, "s from the window's end to the tick")
    phase: float = _number(None, 0, 1, "take the current at this fraction of a PWM period")
    delay_uncertainty: float = _number(0.0, 0, 1e-4, "s, of the delay of every channel")
    voltage_aperture: float = _number(100e-6, 0, 1e-3, "s, window of both voltages")
    voltage_delay: float = _number(0.0, 0, 45e-6, "s from that window's end to the tick")
    current_filter: float = _number(0.0, 0, 0.01, "s, declared RC before the current's converter")
    current_filter2: float = _number(0.0, 0, 0.01, "s, a second declared RC behind that one")
    voltage_filter: float = _number(0.0, 0, 0.01, "s, declared RC before both voltages' converters")
    filter_error: float = _number(0.0, -0.9, 9, "of both filters, true over declared, less 1")
    hidden_filter: float = _number(0.0, 0, 0.01, "s, RC before the current's that nobody declared")
    gain_uncertainty: float = _number(0.002, 0, 0.5, "of the current, relative")
    voltage_gain_uncertainty: float = _number(0.001, 0, 0.5, "of both voltages, relative")
    offset_uncertainty: float = _number(2.0, 0, 500, "counts, every channel")
    gain_error: float = _number(None, -0.9, 0.9, "of the current; instead of a drawn one")
    voltage_gain_error: float = _number(None, -0.9, 0.9, "of both voltages")
    offset_error: float = _number(None, -500, 500, "counts, current and voltages")
    current_cubic: float = _number(
        0.0, -0.2, 0.2, "of the current at full scale; falls as its square"
    )
    reference_drift: float = _number(0.0, -0.1, 0.1, "fall of the converters' reference in a run")
    reference_time: float = _number(1.0, 1e-3, 1e5, "s over which that drift sets in")
    eccentricity: float = _number(0.0, 0, 0.5, "rad, error of the encoder once a turn")
    counts_per_turn: int = _integer(2048, 4, 1_000_000, "of the encoder, after quadrature")
    edge_ceiling: int = _integer(2_000_000, 1000, 2**32 - 1, "counts/s the board follows")
    clock_uncertainty: float = _number(50.0, 0, 65_000, "1e-6, largest error of the clock")
    clock_ppm: float = _number(None, -1e5, 1e5, "clock error, 1e-6; instead of a drawn one")
    first_tick: int = _integer(0, 0, 2**32 - 1, "tick counter at power-on")
    # board and link
    baud: int = _integer(1_000_000, 0, 100_000_000, "of the link to the host; 0: no limit")
    buffer: int = _integer(2048, 32, 65_535, "samples the board keeps for the link or a burst")
    burst: int = _integer(4, 1, 16, "samples of a fast burst in the shortest period; 1: none")
    minor: int = _integer(MINOR, 0, MINOR, "protocol minor that the board speaks")
    brown_out: int = _integer(4300, 0, 65_535, "mV at which its detector resets it; 0: it is off")
    brown_out_least: int = _integer(3780, 0, 65_535, "mV that its clock needs; 0: it tells neither")
    front_end: str = _choice(
        "compiled", ("compiled", "none"), "what the board drives with while no facts are stored"
    )
    max_steps: int = _integer(64, 1, 255, "steps a program may have")
    max_step: float = _number(0.0, 0, 1e-3, "s, longest integration step; 0: chosen")

    @property
    def board_seed(self) -> int:
        """Which board this is: of its chain's errors, and its serial number."""
        return self.seed if self.board is None else self.board

    @property
    def preset(self) -> Motor:
        """The motor's figures."""
        return find_motor(self.motor)[1]

    @property
    def specimen(self) -> Motor:
        """The motor's figures with this specimen's spread; ``preset`` is what its label says."""
        m, turns = self.preset, self.winding
        R = m.resistance_ohm * turns**2 * self.copper
        K = m.torque_constant_nm_a * turns * self.magnet
        brake = self.shorted_turn * K**2 / R / m.commutator_segments  # current in the shorted turn
        return replace(
            m,
            resistance_ohm=R,
            inductance_h=m.inductance_h * turns**2,
            torque_constant_nm_a=K,
            viscous_nm_s=m.viscous_nm_s * self.friction + brake,
            coulomb_nm=m.coulomb_nm * self.friction,
        )

    @property
    def saturation_depth(self) -> tuple[float, float]:
        """The share of L that a very large current loses, and the current (A) that loses half."""
        stall = self.specimen.stall_current_a
        half = stall / 2 if self.saturation_current is None else self.saturation_current
        return self.saturation * (1 + (half / stall) ** 2), half

    @property
    def commutation_rise(self) -> float:
        """What commutation adds to R for each rad/s above its speed, Ω·s/rad."""
        if not self.commutation:
            return 0.0
        speed = self.frictionless_speed - self.commutation_speed
        return self.commutation * self.specimen.resistance_ohm / speed

    @property
    def frictionless_speed(self) -> float:
        """V/K, rad/s."""
        return self.specimen.voltage_v / self.specimen.torque_constant_nm_a

    @property
    def faults(self) -> tuple[Fault, ...]:
        """The faults asked for."""
        return parse_faults(self.fault)

    @property
    def supply_v(self) -> float:
        """The supply's unloaded voltage."""
        return self.preset.supply_v if self.supply is None else self.supply


def parse_url(url: str) -> Options:
    """The options of a sim:// URL. Raises UsageError naming the nearest option or the range."""
    parts = urlsplit(url)
    if parts.scheme != "sim":
        raise UsageError(f"{url!r} is not a sim:// URL")
    if parts.netloc or parts.path.strip("/"):
        raise UsageError(f"{url!r}: options follow a question mark, as in sim://?motor=maxon-re35")
    known = {f.name: f for f in fields(Options)}
    values: dict[str, Any] = {}
    for name, text in parse_qsl(parts.query, keep_blank_values=True):
        if name not in known:
            raise unknown(name, known, "option")
        if name in values:
            raise UsageError(f"sim://: option {name} is given twice")
        values[name] = _value(name, text, dict(known[name].metadata))
    return _checked(Options(**values))


def _value(name: str, text: str, rule: dict[str, Any]) -> Any:
    kind = rule["type"]
    if kind is str:
        if "choices" in rule and text not in rule["choices"]:
            raise unknown(text, rule["choices"], f"value of {name}")
        return text
    if kind is bool:
        if text.lower() not in TRUE + FALSE:
            raise UsageError(f"sim://: {name} is 0 or 1, not {text!r}")
        return text.lower() in TRUE
    try:
        value = kind(text)
    except ValueError:
        what = "a whole number" if kind is int else "a number"
        raise UsageError(f"sim://: {name} must be {what}, not {text!r}") from None
    if not rule["low"] <= value <= rule["high"]:
        raise UsageError(
            f"sim://: {name} must lie between {rule['low']:g} and {rule['high']:g}, not {text}"
        )
    return value


def _checked(options: Options) -> Options:
    find_motor(options.motor)
    parse_faults(options.fault)
    if CLOCK_HZ % options.pwm:
        raise UsageError(f"sim://: pwm must divide {CLOCK_HZ} Hz, {options.pwm} does not")
    capacitance, resistance = options.supply_capacitance, options.supply_resistance
    if options.supply_limit and capacitance == 0:
        raise UsageError("sim://: supply_limit needs a supply_capacitance above 0")
    if resistance == 0 and capacitance != 0:
        raise UsageError("sim://: supply_resistance=0 needs supply_capacitance=0")
    if options.current_filter2 and (options.hidden_filter or not options.current_filter):
        raise UsageError("sim://: current_filter2 needs a current_filter, and no hidden_filter")
    if options.shaft_stiffness and (options.coupling or not options.load_inertia):
        raise UsageError("sim://: shaft_stiffness needs a load_inertia above 0, and no coupling")
    if options.coupling and not options.load_inertia:
        raise UsageError("sim://: coupling needs a load_inertia above 0")
    if options.saturation and options.saturation_depth[0] > MOST_SATURATION:
        raise UsageError(
            "sim://: saturation needs a smaller saturation_current: no L would be left"
        )
    top = options.frictionless_speed
    if options.commutation and options.commutation_speed >= top:
        raise UsageError(f"sim://: commutation_speed must lie below V/K, {top:.0f} rad/s")
    decay_mask(options.decay_modes)
    return options


def decay_mask(text: str) -> int:
    """Bit n set for each decay mode n named, joined by "+". Raises UsageError."""
    from motorid.wire.enums import Decay

    names = [mode.name.lower() for mode in Decay if mode]
    mask = 0
    for name in text.replace(" ", "+").split("+"):  # an unescaped + in a URL is a space
        if name not in names:
            raise unknown(name, names, "decay mode")
        mask |= 1 << Decay[name.upper()]
    return mask
