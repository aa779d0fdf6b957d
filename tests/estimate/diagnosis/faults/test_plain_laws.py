"""Faults that the motor's two laws show in blocks: at the size that was put in, and not without."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from motorid.capture.model import CURRENT, POSITION, SPEED, SUPPLY, VOLTAGE, Capture, Channel
from motorid.estimate.diagnosis.faults import (
    channel_delay,
    current_limited_supply,
    encoder_bandwidth,
    load_slip,
    saturation,
)
from motorid.estimate.diagnosis.faults.zeros import current_zero
from motorid.estimate.fit import block_regression
from motorid.estimate.fit.block_regression import Blocks
from motorid.estimate.signals.time_grid import Part
from motorid.program import Decay, StepKind

Floats = NDArray[np.float64]
R, K, B, J, T0 = 2.0, 0.05, 4e-5, 2e-4, 6e-3
H = 1e-3  # s, of a block
LEVELS_V, EACH = (12.0, 5.0, 9.0, 3.0), 150  # blocks


def turned(share: float = 0.0, most: float = np.inf) -> tuple[Floats, Floats]:
    """Volts and speed (n,) of blocks; a ``share`` of the inertia follows by ``most`` rad/s²."""

    def slope(t: float, y: Floats) -> list[float]:
        w, w2 = y
        volts = LEVELS_V[min(int(t / (EACH * H)), len(LEVELS_V) - 1)]
        torque = K * (volts - K * w) / R - B * w - T0
        together = torque / J
        if not share or (abs(together) <= most and abs(w - w2) < 1e-3):
            return [together, together]
        pull = most if w > w2 else -most
        return [(torque - share * J * pull) / ((1 - share) * J), pull]

    at = H * (np.arange(EACH * len(LEVELS_V)) + 0.5)
    ran = solve_ivp(slope, (0, at[-1]), [1.0, 1.0], t_eval=at, max_step=H / 4, rtol=1e-7)
    volts = np.repeat(LEVELS_V, EACH).astype(float)
    return volts, ran.y[0]


def seen_as(volts: Floats, speed: Floats, true: Floats | None = None) -> Blocks:
    """Blocks of a motor at ``true`` speed (as it is seen, where None)."""
    n = len(speed)
    settled = np.arange(n) % EACH > 1
    emf = K * (speed if true is None else true)
    return Blocks(
        volts, (volts - emf) / R, speed, np.gradient(speed) / H, np.ones(n, dtype=bool), settled,
        (slice(0, n),), np.array([H]),
    )  # fmt: skip


@pytest.fixture(scope="module")
def sound() -> Blocks:
    """With the acceleration of the law itself: a slope over a step of the drive is none."""
    b = seen_as(*turned())
    return replace(b, acceleration=(K * b.current - B * b.speed - T0) / J)


@pytest.fixture
def shown(monkeypatch: pytest.MonkeyPatch) -> Callable[[Blocks], list[Any]]:
    """Records whose blocks are given."""

    def use(b: Blocks) -> list[Any]:
        for module in (saturation, encoder_bandwidth, current_limited_supply, load_slip):
            monkeypatch.setattr(module, "blocks", lambda _: b)
        position = SimpleNamespace(block=SimpleNamespace(name=POSITION), resolution=1e-3)
        sensed = SimpleNamespace(channel="read", shows_emf=True)
        return [SimpleNamespace(measured=[position], sensed=sensed)]

    return use


@pytest.mark.slow
def test_a_motor_without_a_fault_shows_none(sound: Blocks, shown: Any) -> None:
    records = shown(sound)
    assert saturation.seen(records) is None
    assert encoder_bandwidth.seen(records) is None
    assert load_slip.start(sound) is None
    records[0].sensed.shows_emf = False
    assert current_limited_supply.seen(records) is None


def test_the_laws_give_the_motor(sound: Blocks) -> None:
    assert block_regression.electrical(sound, sound.settled) == pytest.approx((R, K))
    assert block_regression.usual(sound) == pytest.approx((R, K))
    found = block_regression.mechanical(sound, K, sound.settled)
    assert found == pytest.approx({"J": J, "B": B, "T0": T0}, rel=0.02)
    few = np.arange(len(sound.speed)) < 7
    assert block_regression.electrical(sound, few) is None
    wrong = replace(sound, volts=-sound.volts)
    assert block_regression.electrical(wrong, wrong.settled) is None
    against = block_regression.mechanical(replace(sound, current=-sound.current), K, sound.settled)
    assert set(against.values()) == {0.0}


def test_blocks_that_depart_from_the_others_are_left_out(sound: Blocks) -> None:
    odd = sound.volts.copy()
    odd[100:140] *= 0.5
    assert block_regression.usual(replace(sound, volts=odd)) == pytest.approx((R, K), rel=1e-3)
    assert block_regression.electrical(replace(sound, volts=odd), sound.settled) != pytest.approx(
        (R, K), rel=1e-2
    )


@pytest.mark.parametrize("peak", [9.5, 11.0])
def test_a_voltage_that_stops_has_the_motor_answer_to_more(
    peak: float, sound: Blocks, shown: Any
) -> None:
    records = shown(replace(sound, volts=np.minimum(sound.volts, peak)))
    found = saturation.seen(records)
    assert found is not None
    hypothesis, start = found
    assert start.size[0] == pytest.approx(12.0 / peak, rel=1e-3)
    assert start.motor == pytest.approx({"R": R, "K": K, "J": J, "B": B, "T0": T0}, rel=0.03)
    said = hypothesis.words(np.array(start.size)).evidence
    assert f"stop at {peak:.3g} V, where the motor answers as to 12 V" in said
    records[0].sensed.shows_emf = False
    assert saturation.seen(records) is None
    assert saturation.seen(shown(replace(sound, volts=np.minimum(sound.volts, 11.85)))) is None


@pytest.mark.parametrize("share", [0.7, 0.9])
def test_an_encoder_that_stops_is_outrun_by_the_motor(
    share: float, sound: Blocks, shown: Any
) -> None:
    top = share * float(sound.speed.max())
    seen = np.minimum(sound.speed, top)
    b = seen_as(sound.volts, seen, sound.speed)
    found = encoder_bandwidth.seen(shown(b))
    assert found is not None
    hypothesis, start = found
    assert start.size[0] == pytest.approx(0.97 * top)
    assert start.motor["K"] == pytest.approx(K, rel=0.01)
    assert start.motor["R"] == pytest.approx(R, rel=0.01)
    assert hypothesis.lower[0] == pytest.approx(0.5 * top)
    assert hypothesis.upper[0] == pytest.approx(1.5 * top)
    said = hypothesis.words(np.array([200.0])).evidence
    assert "above 200 rad/s, 2e+05 counts a second" in said
    barely = np.minimum(sound.speed, 0.985 * float(sound.speed.max()))
    assert encoder_bandwidth.seen(shown(seen_as(sound.volts, barely, sound.speed))) is None


def test_an_encoder_without_a_position_is_not_suspected(sound: Blocks, shown: Any) -> None:
    records = shown(seen_as(sound.volts, np.minimum(sound.speed, 150.0), sound.speed))
    records[0].measured[0].block.name = SPEED
    assert encoder_bandwidth.seen(records) is None


@pytest.mark.parametrize("limit", [2.0, 3.5])
def test_a_supply_with_a_limit_leaves_a_commanded_voltage_unanswered(
    limit: float, sound: Blocks, shown: Any
) -> None:
    """While the speed rises the current stands at the limit, whatever was commanded."""
    current = np.minimum(sound.current, limit)
    records = shown(replace(sound, current=current))
    records[0].sensed.shows_emf, records[0].measured = False, []
    found = current_limited_supply.seen(records)
    assert found is not None
    assert found[1].size[0] == pytest.approx(limit)
    assert found[1].motor["R"] == pytest.approx(R, rel=0.02)
    assert found[1].motor["K"] == pytest.approx(K, rel=0.02)
    records[0].sensed.shows_emf = True
    assert current_limited_supply.seen(records) is None
    few = np.where(np.arange(len(current)) == 3, current, sound.current)
    rare = shown(replace(sound, current=few))
    rare[0].sensed.shows_emf = False
    assert current_limited_supply.seen(rare) is None


@pytest.mark.slow
def test_a_load_that_slips_is_seen_with_its_share_and_rate() -> None:
    volts, speed = turned(share=0.4, most=250.0)
    found = load_slip.start(seen_as(volts, speed))
    assert found is not None
    share, rate = found.size
    assert share == pytest.approx(0.4, abs=0.08)
    assert rate == pytest.approx(250.0, rel=0.3)
    assert found.motor["J"] == pytest.approx(J, rel=0.1)
    assert found.motor["R"] == pytest.approx(R, rel=0.01)


def test_what_follows_slips_behind_by_its_own_acceleration() -> None:
    b = seen_as(np.full(40, 5.0), 10.0 * H * np.arange(40.0))
    behind = load_slip._behind(b, 4.0)
    assert behind[5:35] == pytest.approx(6.0)
    assert load_slip._behind(b, 20.0) == pytest.approx(0.0, abs=1e-9)


# a limit that a measured voltage shows


def supplied(current: Floats, volts: Floats, kind: StepKind = StepKind.DRIVE_DUTY) -> Any:
    n = len(current)
    part = Part(0, n, kind, 1.0, Decay.SYNCHRONOUS_SLOW)
    measured = SimpleNamespace(
        block=SimpleNamespace(name=CURRENT), keep=np.arange(n), values=current
    )
    timeline = SimpleNamespace(count=n, parts=(part,), period_s=1e-3)
    sensed = SimpleNamespace(shows_emf=True, volts=volts)
    return SimpleNamespace(measured=[measured], timeline=timeline, sensed=sensed, capture=None)


def plateau(limit: float = 3.0, ends: float = 1.0, low: float = 4.0) -> tuple[Floats, Floats]:
    """The voltage rises from low to 12 V while the current stands, and then it falls."""
    volts = np.r_[np.full(40, low), np.linspace(low, 12.0, 200), np.full(200, 12.0)]
    fall = ends + (limit - ends) * np.exp(-np.arange(200) / 30.0)
    return np.r_[np.full(240, limit), fall], volts


def test_a_voltage_that_recovers_at_one_current_shows_a_limit() -> None:
    current, volts = plateau()
    found = current_limited_supply.sag(supplied(current, volts))
    assert found is not None
    assert found.current_a == pytest.approx(3.0)
    assert found.low_v == pytest.approx(4.0 + 0.2 * 8.0, abs=0.1)
    assert found.high_v == pytest.approx(4.0 + 0.9 * 8.0, abs=0.1)
    assert found.start_s == pytest.approx(0.04 + 0.2 * 0.2, abs=0.01)
    (said,) = current_limited_supply.suspects(supplied(-current, -volts))
    assert "while the current stood at 3 A" in said.evidence
    assert said.code == "supply_limited"


@pytest.mark.parametrize(
    ("current", "volts"),
    [
        plateau(ends=2.2),  # it hardly falls once the voltage is back
        plateau(low=11.5),  # a small sag
        (np.linspace(4.0, 1.0, 440), plateau()[1]),  # a source behind a resistance
        (plateau()[0][:60], plateau()[1][:60]),  # too short
    ],
)
def test_what_is_no_plateau_shows_none(current: Floats, volts: Floats) -> None:
    assert current_limited_supply.sag(supplied(current, volts)) is None


def test_only_a_part_that_drives_shows_a_limit() -> None:
    current, volts = plateau()
    assert current_limited_supply.sag(supplied(current, volts, StepKind.COAST)) is None
    record = supplied(current, volts)
    (part,) = record.timeline.parts
    record.timeline.parts = (replace(part, discontinuous=True),)
    assert current_limited_supply.sag(record) is None
    record.timeline.parts = (replace(part, level=0.0),)
    assert current_limited_supply.sag(record) is None


def test_without_the_motors_voltage_the_supplys_is_looked_at() -> None:
    current, volts = plateau()
    record = supplied(current, volts)
    record.sensed.shows_emf = False
    record.capture = Capture(np.arange(440) * 1000, 1e6, {})
    assert current_limited_supply.sag(record) is None
    holed = volts.copy()
    holed[10:13] = np.nan
    record.capture = replace(record.capture, channels={SUPPLY: Channel(SUPPLY, "V", holed)})
    record.timeline.spread = lambda values: values
    found = current_limited_supply.sag(record)
    assert found is not None
    assert found.current_a == pytest.approx(3.0)


# the current's zero, and its end


def rested(zero: float, declared: float = 1e-3, resolution: float = 1e-4) -> Any:
    """A drive of 2 A between two rests of 40 readings."""
    driven = np.r_[np.zeros(40), np.ones(100), np.zeros(40)] > 0
    values = np.where(driven, 2.0, 0.0) + zero
    values[140:147] += 1.5  # it flows on for a while
    channel = Channel(CURRENT, "A", values, offset_uncertainty=declared, resolution=resolution)
    measured = SimpleNamespace(
        block=SimpleNamespace(name=CURRENT), unsigned=False, channel=channel,
        resolution=resolution, keep=np.arange(180), values=values,
    )  # fmt: skip
    capture = Capture(np.arange(180), 1e3, {CURRENT: channel})
    return SimpleNamespace(measured=[measured], driven=driven, capture=capture)


@pytest.mark.parametrize("zero", [0.05, -0.05])
def test_a_zero_beyond_what_is_declared_is_named(zero: float) -> None:
    assert current_zero.seen(rested(zero)) == pytest.approx(zero)
    (said,) = current_zero.suspects(rested(zero))
    assert f"reads {zero:+.3g} A with the bridge open, 50 times" in said.evidence


def test_a_zero_that_is_declared_or_harmless_is_not() -> None:
    assert current_zero.seen(rested(0.05, declared=0.0101)) is None  # less than 5 of them
    assert current_zero.seen(rested(0.05, declared=0.0099)) == pytest.approx(0.05)
    assert current_zero.seen(rested(0.05, declared=0.0)) is None
    assert current_zero.seen(rested(0.039)) is None  # a fiftieth of what runs
    assert current_zero.seen(rested(0.05, resolution=0.06)) is None
    assert current_zero.suspects(rested(0.0)) == []
    magnitude = rested(0.05)
    magnitude.measured[0].unsigned = True
    assert current_zero.seen(magnitude) is None
    always = rested(0.05)
    always.driven[:] = False
    assert current_zero.seen(always) is None


def test_few_readings_at_rest_tell_no_zero() -> None:
    record = rested(0.05)
    record.driven[15:40] = True
    record.driven[140:] = True
    assert current_zero.seen(record) is None
    record.driven[15:17] = False
    record.driven[8:15] = False
    assert current_zero.seen(record) == pytest.approx(0.05)


def test_a_current_may_flow_for_eight_samples_after_the_bridge_opened() -> None:
    """Of rests of nine readings only the last of each tells the zero."""
    driven = np.tile(np.r_[np.ones(5), np.zeros(9)] > 0, 40)
    values = np.tile(np.r_[np.full(5, 2.0), np.linspace(1.5, 0.8, 8), 0.05], 40)
    record = rested(0.0)
    channel = replace(record.measured[0].channel, raw=values)
    record.driven, record.capture = driven, Capture(np.arange(560), 1e3, {CURRENT: channel})
    record.measured = [
        SimpleNamespace(block=SimpleNamespace(name=CURRENT), unsigned=False, channel=channel,
                        resolution=channel.resolution, keep=np.arange(560), values=values)
    ]  # fmt: skip
    assert current_zero.seen(record) == pytest.approx(0.05)


def test_a_current_is_declared_to_end_a_little_before_it_stops() -> None:
    channel = Channel(CURRENT, "A", np.zeros(4), scale=-0.01, offset=512.0, raw_max=600.0)
    capture = Capture(np.arange(4), 1e3, {CURRENT: channel})
    (found,) = saturation._declared_end(CURRENT, capture, 2.0)
    ended = found.channels[CURRENT]
    assert ended.raw_min == pytest.approx(512.0 - 0.97 * 200.0)
    assert ended.raw_max == 600.0  # what was declared is nearer


def test_a_voltage_is_tried_later_by_whole_samples_and_by_parts() -> None:
    volts = Channel(VOLTAGE, "V", np.zeros(4), delay_s=1e-4)
    capture = Capture(np.arange(4) * 1000, 1e6, {VOLTAGE: volts})
    delays = [c.channels[VOLTAGE].delay_s for c in channel_delay._declared_later(capture, 2.4e-3)]
    assert delays == pytest.approx(
        [1e-4 + d for d in (2.0e-3, 2.4e-3, 2.1e-3, 2.25e-3, 2.55e-3, 2.7e-3)]
    )
