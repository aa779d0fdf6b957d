"""Tiny captures in which, between them, every influence quantity applies."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, FACTS, POSITION, SPEED, VOLTAGE, Capture, Channel, Wiring
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Instance
from motorid.estimate.model.capture_model import Floats, MotorRecord
from motorid.estimate.model.tangent import tangent
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.signals.intersample_voltage import JOINED, Shape
from motorid.program import Decay, Program, StepKind
from tests.exact_capture import FAULHABER, Plan, clean_capture

POINT = np.array(list(FAULHABER.values()))  # the six parameters at which all is judged
PWM_HZ = 20e3
SUPPLY_V = 8.0
STEPPED_A, STEPPED_V = 2.0, 16.0  # half of a converter's range
PLAN = Plan(volts=(6.0, 3.0), count=400, aperture_s=1e-4, delay_s=1e-5)


def declared(capture: Capture) -> Capture:
    """Every uncertainty that a channel, a clock or a wiring can declare."""
    now = capture.channels
    channels = {
        CURRENT: replace(
            now[CURRENT], gain_uncertainty=0.01, offset_uncertainty=1e-3, delay_uncertainty_s=2e-6,
            filter_s=5e-6, nonlinearity=2e-3, nonlinearity_shape="s", full_scale=20.0,
        ),
        POSITION: replace(now[POSITION], gain_uncertainty=1e-3, delay_uncertainty_s=1e-6),
        VOLTAGE: replace(
            now[VOLTAGE], gain_uncertainty=5e-3, offset_uncertainty=2e-3, delay_uncertainty_s=1e-6,
            resolution=0.01,
        ),
    }  # fmt: skip
    wiring = Wiring(lead_resistance_ohm=0.1, lead_resistance_uncertainty_ohm=0.02,
                    supply_voltage_v=SUPPLY_V, pwm_hz=PWM_HZ, dead_time_s=1e-6,
                    encoder_eccentricity_rad=2e-3, reference_drift=1e-3,
                    reference_time_s=0.05)  # fmt: skip
    return replace(capture, channels=channels, wiring=wiring, clock_uncertainty=1e-4)


def driven(decay: Decay, kind: StepKind, plan: Plan = PLAN) -> Capture:
    """Rest, two levels, coast, by such commands."""
    capture = declared(clean_capture(FAULHABER, plan))
    assert capture.program is not None
    share = 1.0 if kind == StepKind.DRIVE_VOLTS else 1.0 / SUPPLY_V
    steps = tuple(
        replace(s, kind=kind, level=share * s.level, decay=decay)
        if s.kind == StepKind.DRIVE_VOLTS else s
        for s in capture.program.steps
    )  # fmt: skip
    return replace(capture, program=Program(steps))


def measured() -> Capture:
    """Means of current and terminal voltage, by volts."""
    return driven(Decay.SYNCHRONOUS_SLOW, StepKind.DRIVE_VOLTS)


def diodes() -> Capture:
    """By duty, the current freewheeling through diodes."""
    return driven(Decay.DIODE, StepKind.DRIVE_DUTY)


def pulses() -> Capture:
    """So slowly sampled that only the current's pulses through the diodes tell L."""
    capture = driven(Decay.DIODE, StepKind.DRIVE_DUTY, replace(PLAN, period_s=4e-4))
    return replace(capture, wiring=replace(capture.wiring, pwm_hz=PWM_HZ / 4))


def commanded() -> Capture:
    """No voltage was measured, its scatter stated by the supply's."""
    capture = measured()
    channels = {name: capture.channels[name] for name in (CURRENT, POSITION)}
    return replace(capture, channels=channels)


def bipolar() -> Capture:
    """The same through a bridge whose switches drop some."""
    capture = commanded()
    return replace(capture, wiring=replace(capture.wiring, bridge_drop_v=0.5))


def noisy_source() -> Capture:
    """The voltage scatters, so that its mean over a level is not known exactly."""
    capture = measured()
    volts = capture.channels[VOLTAGE]
    noise = np.random.default_rng(1).normal(0.0, 0.05, len(volts.raw))
    raw = np.where(volts.values > 2.9, volts.raw + noise, volts.raw)
    channels = {**capture.channels, VOLTAGE: replace(volts, raw=raw)}
    return replace(capture, channels=channels)


def log() -> Capture:
    """No program is known: the voltage is what was logged."""
    capture = measured()
    volts = replace(capture.channels[VOLTAGE], kind="instant", aperture_s=0.0)
    channels = {**capture.channels, VOLTAGE: volts}
    return replace(capture, channels=channels, program=None, phases=(), wiring=Wiring())


def held_log() -> Capture:
    """A reading is missing where the voltage stepped: nobody knows when it did."""
    capture = log()
    step = int(np.argmax(np.abs(np.diff(capture.channels[VOLTAGE].values))))
    kept = np.delete(np.arange(len(capture)), step)
    channels = {n: replace(c, raw=c.raw[kept]) for n, c in capture.channels.items()}
    return replace(capture, ticks=capture.ticks[kept], channels=channels)


def filtered() -> Capture:
    """All of the current's delay is a filter's."""
    capture = measured()
    current = capture.channels[CURRENT]
    current = replace(current, filter_s=current.delay_s)
    return replace(capture, channels={**capture.channels, CURRENT: current})


def moving() -> Capture:
    """The record begins amid a drive, and shows a speed."""
    capture = log()
    n = len(capture)
    first = n // 10
    angle = capture.channels[POSITION].values
    speed = Channel(SPEED, "rad/s", np.gradient(angle, capture.period_s), gain_uncertainty=1e-3,
                    delay_uncertainty_s=1e-6)  # fmt: skip
    kept = {n: c for n, c in capture.channels.items() if n != POSITION}
    channels = {n: replace(c, raw=c.raw[first:]) for n, c in {**kept, SPEED: speed}.items()}
    return replace(capture, ticks=capture.ticks[first:], channels=channels)


def unstated() -> Capture:
    """A log of whose channels nobody says anything."""
    capture = moving()
    names = {n: replace(c, undeclared=FACTS, delay_s=0.0) for n, c in capture.channels.items()}
    return replace(capture, channels=names)


def stepped() -> Capture:
    """The converter has wide codes, which current and voltage pass."""
    capture = measured()
    current, volts = (capture.channels[name] for name in (CURRENT, VOLTAGE))
    channels = {
        CURRENT: replace(current, step_uncertainty=2e-3, raw_min=-STEPPED_A, raw_max=STEPPED_A),
        VOLTAGE: replace(volts, step_uncertainty=5e-3, raw_min=-STEPPED_V, raw_max=STEPPED_V),
    }
    return replace(capture, channels={**capture.channels, **channels})


def sampled() -> Capture:
    """The voltage is the mean of ten conversions in a PWM period, behind a filter."""
    capture = measured()
    volts = capture.channels[VOLTAGE]
    volts = replace(volts, filter_s=10e-6, delay_s=volts.delay_s + 10e-6, pwm_phase=0.1)
    return replace(capture, channels={**capture.channels, VOLTAGE: volts})


def instants() -> Capture:
    """The current is read at a moment of the PWM period."""
    capture = measured()
    current = replace(capture.channels[CURRENT], kind="instant", aperture_s=0.0, pwm_phase=0.3)
    return replace(capture, channels={**capture.channels, CURRENT: current})


def loaded() -> Capture:
    """A resistor lies across the motor, behind the current's sensor."""
    capture = measured()
    return replace(capture, wiring=replace(capture.wiring, terminal_load_ohm=500.0))


BENCHES = {
    f.__name__: f
    for f in (measured, diodes, pulses, commanded, noisy_source, log, held_log, filtered, moving,
              unstated, instants, stepped, sampled, bipolar, loaded)
}  # fmt: skip


@cache
def record(name: str) -> MotorRecord:
    """One of BENCHES, its source judged at POINT. Shared: whoever reads it leaves it as it is."""
    shape: Shape = "held" if name == "held_log" else JOINED
    found = MotorRecord(BENCHES[name](), PARAMETERS, {}, shape)
    found.retake_sources(POINT, start(found))
    return found


def start(of: MotorRecord) -> Floats:
    """Where its own unknowns begin."""
    return np.array([u.start for u in of.unknowns])


def moved(name: str, quantity: InfluenceQuantity, place: int = 0) -> dict[str, Floats]:
    """Change of the readings by block, (n,), for a unit of a quantity."""
    subject = record(name)
    parts = tangent(subject, POINT, start(subject), Instance(quantity, place))
    return {m.block.name: part for m, part in zip(subject.measured, parts, strict=True)}


def usual(name: str, point: Floats = POINT) -> dict[str, Floats]:
    """The model's readings by block, (n,)."""
    subject = record(name)
    parts = subject.fitted(point, start(subject))
    return {m.block.name: part for m, part in zip(subject.measured, parts, strict=True)}


def ticks(name: str, block: str) -> NDArray[np.intp]:
    """Where a block's readings lie, (n,)."""
    found = record(name).block(block)
    assert found is not None
    return found.keep


def within(name: str, block: str, part: int) -> NDArray[np.bool_]:
    """Which readings of a block (n,) lie in a part of the program."""
    here = record(name).timeline.parts[part]
    keep = ticks(name, block)
    return (keep >= here.start) & (keep < here.stop)
