"""The simulated bench: plant and sensors in C, driven a stretch of samples at a time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorid.errors import UsageError
from motorid.sim._plant import ffi, lib
from motorid.sim.chain import Chain, idle_period
from motorid.sim.options import CLOCK_HZ, Options
from motorid.wire.enums import Decay, Fault, StepKind

COPPER_PER_K = 0.0039
MAGNET_PER_K = -0.0011  # neodymium
DIODE_OHM_SHARE = 0.5  # of a switch's resistance
BRIDGE_BEND_A = 0.02  # within which a bipolar bridge's drop bends
BRUSH_CURRENT_SHARE = 0.05  # of the stall current
REACTION_BEND_SHARE = 0.05  # the same
SPEED_WINDOW_S = 2e-3
SHORTEST_STEP_S = 1e-8  # of integration: a sample at 10 kHz takes 10,000 of them, some ms
Raw = NDArray[np.int16]
Counts = NDArray[np.int64]


@dataclass(frozen=True)
class Guard:
    """Limits that open the bridge, in SI units and counts."""

    current_a: float
    speed_counts_s: float
    supply_min_v: float
    supply_max_v: float
    voltage_v: float = 0.0  # at the terminals; 0: any


@dataclass(frozen=True)
class SignCheck:
    """What may be against a drive's sign: A, V, counts. Signs are 1 or -1."""

    forward: int
    forward_counts: int  # that the encoder then counts
    samples: int
    current_a: float
    voltage_v: float
    counts: int


class Bench:
    """Motor, bridge, supply and converters of one set of options. Owns the C structure."""

    def __init__(self, options: Options, chain: Chain) -> None:
        self.options = options
        self.chain = chain
        self._c: Any = ffi.new("bench *")
        self._rng = np.random.default_rng([options.seed, 2])
        self.raw: Raw = np.zeros(3, np.int16)
        lib.plant_init(ffi.addressof(self._c, "plant"), plant_params(options, chain))
        if not self._c.plant.step >= SHORTEST_STEP_S:  # a call into C must not last for ever
            raise UsageError(
                f"sim://: these values need steps of {self._c.plant.step:.2g} s, too short to wait "
                "for: take a larger supply_capacitance or max_step, or a smaller resistance"
            )
        self._set_converters()
        encoder = self._c.encoder
        encoder.counts_per_turn = options.counts_per_turn
        encoder.angle = chain.encoder_angle
        encoder.eccentricity = options.eccentricity
        encoder.sign = 1
        if options.clamped:
            self.stall()
        self.set_period(idle_period(options, chain))

    # ------------------------------------------------------------------ set-up

    def _set_converters(self) -> None:
        stretch = CLOCK_HZ / self.chain.clock_hz  # the board's microsecond in true ones
        for index, converter in enumerate(self.chain.converters):
            adc = self._c.channel[index]
            adc.scale, adc.gain = converter.scale, converter.gain
            adc.offset, adc.noise = converter.true_offset, converter.noise
            adc.full = converter.full_scale
            adc.aperture = converter.aperture_s * stretch
            adc.delay = converter.true_delay_s * stretch
            adc.raw_min, adc.raw_max = 0, converter.raw_max
            adc.raw = int(converter.offset)
            lib.plant_filter(ffi.addressof(self._c, "plant"), index, *converter.poles_s)
        self._c.channel[lib.BENCH_CURRENT].cubic = self.options.current_cubic
        self._c.reference.drift = self.options.reference_drift
        self._c.reference.tau = self.options.reference_time
        self._set_zeroes()

    def _set_zeroes(self) -> None:
        self._c.limits.current_zero = self.chain.current.offset
        self._c.limits.supply_zero = self.chain.supply.offset
        self._c.limits.voltage_zero = self.chain.voltage.offset

    def redeclare(self, chain: Chain) -> None:
        """Other facts declare the same converters: limits and held volts go by them from now on."""
        self.chain = chain
        for index, converter in enumerate(chain.converters):
            adc = self._c.channel[index]
            adc.gain *= converter.scale / adc.scale
            adc.scale = converter.scale
        self._set_zeroes()

    def set_period(self, ticks: int, fast: int = 0) -> None:
        """Sample every so many ticks from now on, with so many readings of a fast burst in each.

        Raises UsageError when a window does not fit.
        """
        self.period_ticks, self.fast = ticks, fast
        self._c.fast = fast
        self.period_s = ticks / self.chain.clock_hz
        self._c.sample_period = self.period_s
        window = round(SPEED_WINDOW_S / self.period_s)
        self._c.limits.speed_samples = min(max(window, 1), lib.BENCH_HISTORY - 1)
        if lib.bench_init(self._c):
            raise UsageError(f"sim://: a window does not fit a sample period of {ticks} ticks")

    def set_driver(self, opens: bool) -> None:
        """Whether the bridge's driver can open it; one that cannot brakes in its place."""
        self._c.rest = lib.PLANT_COAST if opens else lib.PLANT_BRAKE
        self.command(StepKind.COAST)

    def arm(self, guard: Guard | None) -> None:
        """Watch these limits from the next sample on; None: watch nothing."""
        limits = self._c.limits
        self._c.trip = 0
        limits.armed = guard is not None
        limits.signs_left = 0
        if guard is None:
            return
        limits.current, limits.speed = guard.current_a, guard.speed_counts_s
        limits.supply_min, limits.supply_max = guard.supply_min_v, guard.supply_max_v
        limits.edge_ceiling = self.options.edge_ceiling
        limits.voltage = guard.voltage_v

    def check_signs(self, check: SignCheck | None) -> None:
        """Watch the signs of current, voltage and motion from the next sample on; None: no more."""
        limits = self._c.limits
        limits.signs_left = check.samples if check else 0
        if check:
            limits.forward, limits.forward_counts = check.forward, check.forward_counts
            limits.signs_from = self.count
            limits.sign_current, limits.sign_voltage = check.current_a, check.voltage_v
            limits.sign_counts = check.counts

    def seed_run(self, run: int) -> None:
        """Restart noise and reference, so that a run does not depend on the time before it."""
        self._c.reference.warm = 0.0
        self._rng = np.random.default_rng([self.options.seed, 3, run])

    # ------------------------------------------------------------------ running

    def command(self, kind: StepKind, level: float = 0.0, decay: Decay = Decay.NONE) -> None:
        """Begin a step now. ``level``: signed duty or signed volts."""
        if kind == StepKind.DRIVE_VOLTS:
            lib.bench_hold_volts(self._c, level, decay)
        else:
            modes = {StepKind.COAST: self._c.rest, StepKind.BRAKE: lib.PLANT_BRAKE}
            lib.bench_command(self._c, modes.get(kind, lib.PLANT_DRIVE), level, decay)

    def run(self, samples: int) -> tuple[Raw, Counts]:
        """Take up to ``samples`` samples: raw readings (n, 3) and counts (n,); short at a trip."""
        return self._run(samples, ffi.NULL)

    def run_fast(self, samples: int) -> tuple[Raw, Counts, Raw, Counts]:
        """The same with a fast burst beside it: its readings (n·fast, 3) and counts (n·fast,)."""
        burst: Any = ffi.new("bench_burst *")
        noise, raw, counts = self._rows(samples * self.fast)
        burst.noise, burst.raw, burst.count = _noise_at(noise), _raw_at(raw), _counts_at(counts)
        watched = self._run(samples, burst)
        kept = len(watched[1]) * self.fast
        return *watched, raw[:kept], counts[:kept]

    def _rows(self, rows: int) -> tuple[NDArray[np.float64], Raw, Counts]:
        """Room for so many readings, and their noise."""
        noise = self._rng.standard_normal((rows, 3))
        return noise, np.zeros((rows, 3), np.int16), np.zeros(rows, np.int64)

    def _run(self, samples: int, burst: Any) -> tuple[Raw, Counts]:
        noise, raw, counts = self._rows(samples)
        taken = lib.bench_run_fast(
            self._c, samples, _noise_at(noise), _raw_at(raw), _counts_at(counts), burst
        )
        if taken:
            self.raw = raw[taken - 1].copy()
        return raw[:taken], counts[:taken]

    @property
    def trip(self) -> tuple[Fault, int]:
        """What opened the bridge, and the offending reading."""
        return Fault(self._c.trip), int(self._c.trip_value)

    @property
    def count(self) -> int:
        """The encoder's count."""
        return int(self._c.encoder.count)

    @property
    def is_open(self) -> bool:
        """True while the bridge is commanded open, or brakes because its driver cannot open it."""
        return bool(self._c.plant.mode == self._c.rest)

    @property
    def plant(self) -> Any:
        """The C plant, for its state and its energies."""
        return self._c.plant

    def integrals(self) -> tuple[float, float, float, float]:
        """True seconds, A·s, and V·s at the terminals and at the supply, since the beginning."""
        seconds = self._c.samples * self.period_s
        return seconds, *(float(total) for total in self._c.total)

    # ------------------------------------------------------------------ faults

    def set_supply(self, volts: float) -> None:
        """The supply's unloaded voltage, from now on."""
        lib.plant_set_supply(ffi.addressof(self._c, "plant"), volts)

    def stall(self) -> None:
        """Jam the rotor."""
        lib.plant_lock(ffi.addressof(self._c, "plant"), 1)

    def break_encoder(self, sign: int, loss: float = 0.0) -> None:
        """-1: wired the other way, 0: dead; ``loss``: share of counts missed."""
        self._c.encoder.sign = sign
        self._c.encoder.loss = loss

    def break_converter(self, index: int, gain: float = 1.0, offset: float = 0.0) -> None:
        """Multiply a channel's gain and shift its offset (counts)."""
        self._c.channel[index].gain *= gain
        self._c.channel[index].offset += offset

    def freeze_converters(self) -> None:
        """Every reading repeats the last one."""
        for index in range(lib.BENCH_CHANNELS):
            self._c.channel[index].frozen = 1


def _noise_at(array: NDArray[np.float64]) -> Any:
    return ffi.cast("double *", array.ctypes.data)


def _raw_at(array: Raw) -> Any:
    return ffi.cast("short *", array.ctypes.data)


def _counts_at(array: Counts) -> Any:
    return ffi.cast("long long *", array.ctypes.data)


def plant_params(options: Options, chain: Chain) -> Any:
    """The C parameters of these options; a ``plant_params *`` that the caller keeps."""
    motor = options.specimen
    p: Any = ffi.new("plant_params *")
    p.resistance, p.inductance = motor.resistance_ohm, motor.inductance_h
    p.torque_constant = motor.torque_constant_nm_a
    fast = 0.0 if options.coupling or options.shaft_stiffness else options.load_inertia
    p.inertia = motor.inertia_kg_m2 + fast
    p.load_inertia, p.coupling_torque = options.load_inertia - fast, options.coupling
    p.unbalance, p.brush_bounce = options.unbalance, options.brush_bounce
    p.short_depth, p.segments = options.shorted_turn, motor.commutator_segments
    p.viscous, p.coulomb = motor.viscous_nm_s, motor.coulomb_nm
    p.shaft_stiffness, p.shaft_damping = options.shaft_stiffness, options.shaft_damping
    p.quadratic, p.asymmetry = options.quadratic, options.asymmetry
    p.fresh_friction, p.fresh_time = options.fresh_friction, options.fresh_time
    p.stiction = options.stiction * motor.coulomb_nm
    p.stribeck_speed = options.stribeck
    p.cogging = options.cogging
    p.cogging_per_turn = options.cogging_per_turn or motor.ripple_per_turn
    p.brush_drop = options.brush_drop
    bend = options.brush_current
    p.brush_current = BRUSH_CURRENT_SHARE * motor.stall_current_a if bend is None else bend
    p.k_ripple = p.r_ripple = options.ripple
    p.ripple_per_turn = motor.ripple_per_turn
    p.commutation, p.commutation_speed = options.commutation_rise, options.commutation_speed
    _set_iron(p, options)
    p.ambient = options.ambient
    p.copper_coefficient, p.magnet_coefficient = COPPER_PER_K, MAGNET_PER_K
    if options.heating:
        p.winding_resistance, p.housing_resistance = motor.winding_k_w, motor.housing_k_w
        p.winding_capacity = motor.winding_s / motor.winding_k_w
        p.housing_capacity = motor.housing_s / motor.housing_k_w
    _set_bridge(p, options, chain)
    return p


def _set_iron(p: Any, options: Options) -> None:
    stall, bend = options.specimen.stall_current_a, options.reaction_bend
    p.load_friction = options.load_friction
    p.reaction, p.reaction_bend = options.reaction, stall * REACTION_BEND_SHARE
    if bend is not None:
        p.reaction_bend = bend
    p.reaction_current = math.hypot(stall, p.reaction_bend) - p.reaction_bend
    p.saturation, p.saturation_current = options.saturation_depth
    p.eddy_share = options.eddy
    p.eddy_resistance = options.eddy * p.inductance / options.eddy_time


def _set_bridge(p: Any, options: Options, chain: Chain) -> None:
    motor = options.preset
    path = options.bridge_resistance
    p.pwm_period = CLOCK_HZ // options.pwm / chain.clock_hz
    p.dead_time = options.dead_time
    p.switch_resistance = motor.switch_resistance_ohm if path is None else path / 2
    p.switch_drop, p.switch_drop_current = options.bridge_drop, BRIDGE_BEND_A
    p.diode_drop = options.diode_drop
    p.diode_resistance = DIODE_OHM_SHARE * p.switch_resistance
    p.lead_resistance = options.lead_resistance
    p.sense_at_bridge = options.sense == "bridge"
    p.supply_voltage = options.supply_v
    resistance, capacitance = options.supply_resistance, options.supply_capacitance
    p.supply_resistance = motor.supply_resistance_ohm if resistance is None else resistance
    p.supply_capacitance = motor.supply_capacitance_f if capacitance is None else capacitance
    p.supply_limit = options.supply_limit
    p.supply_sinks = options.supply_sinks
    p.max_step = options.max_step
