"""What a bridge makes of its duty: ripple against the exact periodic current, shares and swings."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import CURRENT, Capture, Channel, Wiring
from motorid.estimate.signals.source import pwm_bridge
from motorid.estimate.signals.source.pwm_bridge import (
    DIODE_DROPS_V,
    bridge_prior,
    clamp_voltage,
    driven_share,
    pwm_shape,
    ripple,
    signed_duty,
    stretch_of,
    swings,
    switched_late,
)
from motorid.estimate.signals.time_grid import Part
from motorid.program import Decay, StepKind

SLOW, DIODE, FAST = Decay.SYNCHRONOUS_SLOW, Decay.DIODE, Decay.FAST
PWM_HZ, RAIL = 20e3, 12.0


def part(level: float, decay: Decay = SLOW, kind: StepKind = StepKind.DRIVE_DUTY) -> Part:
    return Part(0, 20, kind, level, decay)


def capture(**wiring: float) -> Capture:
    facts = {"pwm_hz": PWM_HZ, "supply_voltage_v": RAIL, **wiring}
    channels = {CURRENT: Channel(CURRENT, "A", np.zeros(20))}
    return Capture(100 * np.arange(20), 1e6, channels, wiring=Wiring(**facts))  # type: ignore[arg-type]


def periodic(volts: float, duty: float, L: float, R: float) -> tuple[float, float]:
    """Below and above its mean: the current of a square wave of ``volts``, stepped finely until it
    repeats itself.
    """
    n, period_s = 4000, 1.0 / PWM_HZ
    h = period_s / n
    on = np.arange(n) < duty * n
    keep = math.exp(-R * h / L) if R else 1.0
    gain = (1.0 - keep) / R if R else h / L
    mean_v = duty * volts
    i, ran = 0.0, np.zeros(n)
    for _ in range(1 if not R else 1 + int(12 * L / R * PWM_HZ)):
        for k in range(n):
            i = keep * i + gain * ((volts if on[k] else 0.0) - mean_v)
            ran[k] = i
    ran = ran - ran.mean()
    return -float(ran.min()), float(ran.max())


@pytest.mark.parametrize(("duty", "R"), [(0.3, 0.0), (0.5, 4.0), (0.2, 15.0), (0.8, 15.0)])
def test_ripple_is_that_of_a_square_wave_on_a_winding(duty: float, R: float) -> None:
    L = 3e-4
    below, above = swings(RAIL, duty, PWM_HZ, L, R)
    wanted = periodic(RAIL, duty, L, R)
    assert (below, above) == pytest.approx(wanted, rel=3e-3)


def test_ripple_of_hardly_any_resistance_is_that_of_none() -> None:
    L = 3e-4
    for duty in (0.2, 0.7):
        none = swings(RAIL, duty, PWM_HZ, L, 0.0)
        assert swings(RAIL, duty, PWM_HZ, L, 1.1e-3 * L * PWM_HZ) == pytest.approx(none, rel=1e-3)
        assert none[0] == none[1] == pytest.approx(RAIL * duty * (1 - duty) / (2 * L * PWM_HZ))


@pytest.mark.parametrize(
    ("volts", "duty", "hz", "henry"),
    [(12.0, 0.0, PWM_HZ, 1e-3), (12.0, 1.0, PWM_HZ, 1e-3), (12.0, 0.5, 0.0, 1e-3),
     (12.0, 0.5, PWM_HZ, 0.0)],
)  # fmt: skip
def test_where_nothing_switches_nothing_swings(
    volts: float, duty: float, hz: float, henry: float
) -> None:
    assert swings(volts, duty, hz, henry, 1.0) == (0.0, 0.0)


def test_a_duty_is_stated_or_is_volts_over_the_supply() -> None:
    assert signed_duty(part(-0.4), None) == -0.4
    volts = StepKind.DRIVE_VOLTS
    assert signed_duty(part(-3.0, kind=volts), RAIL) == -0.25
    assert signed_duty(part(30.0, kind=volts), RAIL) == 1.0
    assert signed_duty(part(-30.0, kind=volts), RAIL) == -1.0
    assert signed_duty(part(3.0, kind=volts), None) == 0.0
    assert signed_duty(part(0.0, kind=StepKind.COAST), RAIL) == 0.0


@pytest.mark.parametrize(
    ("decay", "share", "volts"),
    [(SLOW, 0.4, 12.0), (DIODE, 0.4, 24.0 + DIODE_DROPS_V), (FAST, 0.7, 24.0)],
)
def test_the_share_that_drives_and_what_the_rest_differs_by(
    decay: Decay, share: float, volts: float
) -> None:
    for level in (0.4, -0.4):
        assert driven_share(part(level, decay), RAIL) == pytest.approx((share, volts))
    assert driven_share(part(0.0, FAST), RAIL) == (0.0, 0.0)
    assert driven_share(part(0.4, Decay.NONE), RAIL) == (0.0, 0.0)


def test_the_swing_has_the_mean_that_the_part_has() -> None:
    """share · swing (+ the rest) is the level's voltage."""
    assert pwm_shape(part(0.4), 4.5, RAIL) == pytest.approx((0.4, 4.5 / 0.4))
    assert pwm_shape(part(-0.4), -4.5, RAIL) == pytest.approx((0.4, -4.5 / 0.4))
    assert pwm_shape(part(0.4, FAST), 4.8, RAIL) == pytest.approx((0.7, 24.0))
    assert pwm_shape(part(-0.4, FAST), -4.8, RAIL) == pytest.approx((0.3, 24.0))  # forward first
    assert pwm_shape(part(-0.4, DIODE), 0.0, RAIL) == pytest.approx((0.4, -24.0 - DIODE_DROPS_V))
    assert pwm_shape(part(0.0), 0.0, RAIL) == (0.0, 0.0)


def test_ripple_is_that_of_the_parts_share() -> None:
    one = capture()
    assert ripple(one, part(0.4), 3e-4, 2.0) == swings(12.0, 0.4, PWM_HZ, 3e-4, 2.0)
    assert ripple(one, part(-0.4, FAST), 3e-4, 2.0) == swings(24.0, 0.7, PWM_HZ, 3e-4, 2.0)
    assert ripple(capture(supply_voltage_v=0.0), part(0.4), 3e-4, 2.0) == (0.0, 0.0)


def test_the_on_part_is_late_until_ripple_first_turns_the_current_for_good() -> None:
    one = capture(dead_time_s=1e-6)
    below = ripple(one, part(0.4), 3e-4, 2.0)[0]
    current = np.r_[np.full(9, 3 * below), 0.5 * below, 2 * below, np.full(9, 0.5 * below)]
    assert switched_late(one, part(0.4), current, 3e-4, 2.0) == 11
    assert switched_late(one, part(0.4), -current, 3e-4, 2.0) == 11
    assert switched_late(one, part(0.4), 0.1 * current, 3e-4, 2.0) == 0
    assert switched_late(one, replace(part(0.4, DIODE), start=3), current, 3e-4, 2.0) == 3
    assert switched_late(one, replace(part(0.0), start=3), current, 3e-4, 2.0) == 3
    assert switched_late(capture(pwm_hz=0.0), replace(part(0.4), start=3), current, 3e-4) == 3


@pytest.mark.parametrize("decay", [SLOW, FAST])
@pytest.mark.parametrize("level", [0.4, -0.4])
@pytest.mark.parametrize("in_time", [True, False])
def test_dead_time_moves_the_on_part_and_keeps_the_mean(
    decay: Decay, level: float, in_time: bool
) -> None:
    dead = 1e-6
    wiring = Wiring(pwm_hz=PWM_HZ, dead_time_s=dead)
    known = part(level, decay)
    made = stretch_of(wiring, RAIL, 13.4, known, 7, 0.3, np.full(4, level * RAIL), in_time)
    duty, swing = pwm_shape(known, level * RAIL, RAIL)
    drops = DIODE_DROPS_V if decay == FAST else DIODE_DROPS_V / 2
    early = dead * drops / abs(swing)
    whole = (dead + 2 * early) * PWM_HZ
    assert (made.start, made.open, made.series_ohm, made.clamp_v) == (7, False, 0.3, 13.4)
    if in_time:
        assert made.late_s == pytest.approx(-early)
        assert made.duty == pytest.approx(duty)
    elif decay == FAST and level < 0:
        assert made.late_s == pytest.approx(-early)
        assert made.duty == pytest.approx(duty + whole)
    else:
        assert made.late_s == pytest.approx(dead + early)
        assert made.duty == pytest.approx(duty - whole)
    if decay == SLOW:
        assert made.duty * made.swing_v == pytest.approx(duty * swing)
    else:
        assert made.swing_v == pytest.approx(swing)


def test_a_dead_time_that_would_leave_nothing_is_left_out() -> None:
    wiring = Wiring(pwm_hz=PWM_HZ, dead_time_s=5e-6)
    made = stretch_of(wiring, RAIL, 13.4, part(0.09), 0, 0.3, np.full(4, 0.09 * RAIL))
    assert (made.late_s, made.duty) == pytest.approx((0.0, 0.09))
    diodes = stretch_of(wiring, RAIL, 13.4, part(0.4, DIODE), 0, 0.3, np.full(4, 1.0))
    assert (diodes.late_s, diodes.duty) == pytest.approx((0.0, 0.4))


def test_a_freewheeling_current_runs_against_the_supply_and_two_diodes() -> None:
    assert clamp_voltage(capture(), 5.0) == RAIL + DIODE_DROPS_V
    assert clamp_voltage(capture(supply_voltage_v=0.0), 5.0) == 5.0 + DIODE_DROPS_V


def test_a_bridges_resistance_is_known_as_declared_or_to_a_tenth() -> None:
    assert bridge_prior(capture()) == (0.0, np.inf)
    assert bridge_prior(capture(bridge_resistance_ohm=0.5)) == pytest.approx((0.5, 0.05))
    both = capture(bridge_resistance_ohm=0.5, bridge_resistance_uncertainty_ohm=0.2)
    assert bridge_prior(both) == pytest.approx((0.5, 0.2))


def test_two_diodes_drop_what_diodes_drop() -> None:
    """Two alike, each anywhere from 0.5 to 0.9 V."""
    assert pytest.approx(0.5 + 0.9) == DIODE_DROPS_V
    assert pytest.approx((1.8 - 1.0) / math.sqrt(12.0), abs=0.005) == pwm_bridge.DIODE_DROPS_SD_V
