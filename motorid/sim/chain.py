"""The measuring chain: what the board declares of its channels, and what is true of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.sim.options import CLOCK_HZ, Options
from motorid.wire.enums import Channel, ChannelKind, Unit

Floats = NDArray[np.float64]
UNSYNCHRONISED = 65_535
IDLE_TICKS = CLOCK_HZ // 10_000


@dataclass(frozen=True)
class Converter:
    """One analogue channel. ``gain`` and what is called true, the board does not know."""

    channel: Channel
    unit: Unit
    scale: float  # unit per count, declared
    offset: float  # counts, declared
    gain: float  # true over declared
    true_offset: float  # counts
    noise: float  # counts rms
    aperture_s: float  # by the board's clock; 0: an instant
    delay_s: float  # declared, without the filter's
    true_delay_s: float
    poles_s: tuple[float, float]  # true time constants; 0: none
    phase: float | None
    gain_uncertainty: float
    offset_uncertainty: float
    bits: int
    slope_s: float = 0.0  # declared coefficient of s of the filter, and root of that of s²
    root_s: float = 0.0
    raw_min: int = 0  # readings at or below are declared saturated, and at or above
    raw_end: int = 0

    @property
    def kind(self) -> ChannelKind:
        """Mean or instant."""
        return ChannelKind.MEAN if self.aperture_s else ChannelKind.INSTANT

    @property
    def full_scale(self) -> float:
        """The largest size of a reading, in its unit."""
        return self.scale * (2.0**self.bits - self.offset)

    @property
    def raw_max(self) -> int:
        """The highest reading; the lowest is 0."""
        return int(2**self.bits) - 1


@dataclass(frozen=True)
class Chain:
    """Current, terminal voltage and supply; the clock; the encoder's first line."""

    current: Converter
    voltage: Converter
    supply: Converter
    clock_ppm: float
    encoder_angle: float

    @property
    def converters(self) -> tuple[Converter, Converter, Converter]:
        """In the order of the wire's channel numbers."""
        return self.current, self.voltage, self.supply

    @property
    def clock_hz(self) -> float:
        """Ticks in a true second."""
        return CLOCK_HZ * (1 + self.clock_ppm * 1e-6)


def draw_chain(options: Options) -> Chain:
    """The chain of that board: errors drawn from the declared uncertainties unless given.

    How its encoder happens to lie is no error, and the seed's.
    """
    gains, offsets, ppm, _, late = _drawn(options, options.board_seed)
    angle = _drawn(options, options.seed)[3]
    middle, codes = 2.0 ** (options.bits - 1), 2.0**options.bits
    amps = options.current_range or 1.5 * options.preset.stall_current_a
    volts = options.voltage_range or 1.25 * options.supply_v or 1.0
    aperture, delay = _current_window(options)

    def converter(index: int, channel: Channel, full_scale: float, low: float) -> Converter:
        is_current = channel == Channel.CURRENT
        given = options.gain_error if is_current else options.voltage_gain_error
        spread = options.gain_uncertainty if is_current else options.voltage_gain_uncertainty
        shift = options.offset_error
        error = spread * float(gains[index]) if given is None else given
        drawn = options.offset_uncertainty * float(offsets[index]) if shift is None else shift
        declared = delay if is_current else options.voltage_delay
        filter_s = options.current_filter if is_current else options.voltage_filter
        second = options.current_filter2 if is_current else 0.0
        wrong = 1 + options.filter_error
        poles = filter_s * wrong, second * wrong or (options.hidden_filter if is_current else 0.0)
        return Converter(
            channel=channel,
            unit=Unit.AMPERE if is_current else Unit.VOLT,
            scale=full_scale / (codes - low),
            offset=low,
            gain=1 + error,
            true_offset=low + drawn,
            noise=options.noise,
            aperture_s=aperture if is_current else options.voltage_aperture,
            delay_s=declared,
            true_delay_s=max(declared + float(late[index]), 0.0),
            poles_s=poles,
            phase=options.phase if is_current else None,
            gain_uncertainty=spread if given is None else abs(given),
            offset_uncertainty=options.offset_uncertainty,
            bits=options.bits,
            slope_s=filter_s + second,
            root_s=(filter_s * second) ** 0.5,
            raw_end=int(codes) - 1,
        )

    return Chain(
        current=converter(0, Channel.CURRENT, amps, middle),
        voltage=converter(1, Channel.TERMINAL_VOLTAGE, volts, middle),
        supply=converter(2, Channel.SUPPLY_VOLTAGE, volts, 0.0),
        clock_ppm=float(ppm) if options.clock_ppm is None else options.clock_ppm,
        encoder_angle=float(angle),
    )


def _drawn(options: Options, seed: int) -> tuple[Floats, Floats, float, float, Floats]:
    """Gains, offsets, clock in 1e-6, the encoder's angle in rad, delays in s, by one seed."""
    rng = np.random.default_rng([seed, 1])
    gains, offsets = rng.standard_normal(3), rng.standard_normal(3)
    ppm = rng.uniform(-options.clock_uncertainty, options.clock_uncertainty)
    angle = rng.uniform(0.0, 2 * np.pi)
    return gains, offsets, ppm, angle, options.delay_uncertainty * rng.standard_normal(3)


def shortest_period(options: Options, chain: Chain) -> int:
    """Least sample period in ticks: every window fits two of them, every delay one."""
    pwm_ticks = CLOCK_HZ // options.pwm
    longest = max(
        max(late, (c.aperture_s + late) / 2) * CLOCK_HZ
        for c in chain.converters
        for late in (c.delay_s, c.true_delay_s)
    )
    return pwm_ticks * max(1, int(-(-longest // pwm_ticks)))


def burst_samples(options: Options, chain: Chain) -> int:
    """Samples of a fast burst in the shortest period, so that they are whole ticks apart; or 0."""
    shortest = shortest_period(options, chain)
    fit = next(n for n in range(options.burst, 0, -1) if shortest % n == 0)
    return fit if fit > 1 else 0


def idle_period(options: Options, chain: Chain) -> int:
    """Ticks between the samples that a board takes for itself before it is configured."""
    return max(IDLE_TICKS, shortest_period(options, chain))


def _current_window(options: Options) -> tuple[float, float]:
    """Aperture and delay of the current channel; a phase makes it an instant."""
    if options.phase is None:
        return options.aperture, options.delay
    return 0.0, (1 - options.phase) % 1 / options.pwm
