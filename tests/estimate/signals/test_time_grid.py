"""Captures on the grid that the model walks along, and their channels as blocks of readings."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import (
    CURRENT,
    HELD,
    POSITION,
    SPEED,
    VOLTAGE,
    Capture,
    Channel,
    Phase,
    Wiring,
)
from motorid.errors import DataError
from motorid.estimate.signals import measurements, opened_voltage
from motorid.estimate.signals.source.discontinuous_current import confirmed, shows_ripple, unclear
from motorid.estimate.signals.source.pwm_bridge import ripple
from motorid.estimate.signals.standstill import starts_at_rest, with_standstill
from motorid.estimate.signals.time_grid import Part, Timeline, lay
from motorid.motor.reading import Quantity
from motorid.program import Decay, Program, Step, StepKind

Floats = NDArray[np.float64]
UNITS = {CURRENT: "A", VOLTAGE: "V", SPEED: "rad/s", POSITION: "rad"}
SLOW = Decay.SYNCHRONOUS_SLOW


def capture(ticks: Any, *steps: Step, starts: tuple[int, ...] = (), **channels: Any) -> Capture:
    """Ticks in µs, 100 of them a sample as a rule; bare arrays are in SI units."""
    made = {
        name: c if isinstance(c, Channel) else Channel(name, UNITS[name], np.asarray(c, float))
        for name, c in channels.items()
    }
    program = Program(steps) if steps else None
    phases = tuple(Phase(k, tick) for k, tick in enumerate(starts))
    return Capture(np.asarray(ticks, np.int64), 1e6, made, program=program, phases=phases)


def drive(level: float, kind: StepKind = StepKind.DRIVE_DUTY, decay: Decay = SLOW) -> Step:
    return Step(kind, 1.0, level, decay)


COAST = Step(StepKind.COAST, 1.0)
EVEN = 100 * np.arange(40)


# the grid of a program


def test_a_part_begins_with_the_interval_after_its_tick() -> None:
    line = lay(capture(EVEN, COAST, drive(0.5), COAST, starts=(0, 1000, 2500)))
    assert [(p.start, p.stop, p.kind) for p in line.parts] == [
        (0, 11, StepKind.COAST), (11, 26, StepKind.DRIVE_DUTY), (26, 40, StepKind.COAST),
    ]  # fmt: skip
    assert (line.period_s, line.count, line.lost, line.complete) == (1e-4, 40, 0, True)
    assert line.parts[1].level == 0.5
    assert line.parts[1].decay == SLOW
    assert np.flatnonzero(line.driven).tolist() == list(range(11, 26))
    assert [p.open for p in line.parts] == [True, False, True]


def test_a_capture_that_begins_amid_its_program_has_what_is_left_of_it() -> None:
    line = lay(capture(EVEN + 700, COAST, drive(0.5), COAST, starts=(0, 400, 2000)))
    assert np.flatnonzero(line.driven[1:]).tolist() == list(range(13))
    assert [(p.start, p.stop, p.kind) for p in line.parts[-2:]] == [
        (1, 14, StepKind.DRIVE_DUTY), (14, 40, StepKind.COAST),
    ]  # fmt: skip
    late = lay(capture(EVEN, COAST, drive(0.5), starts=(0, 9000)))
    assert [(p.start, p.stop) for p in late.parts] == [(0, 40)]
    assert lay(capture(EVEN, COAST, starts=())).parts == (Part(0, 40),)


def test_a_missing_sample_keeps_its_place() -> None:
    ticks = np.delete(EVEN, [7, 8, 20])
    line = lay(capture(ticks, COAST, starts=(0,)))
    assert (line.count, line.lost, line.complete) == (40, 3, False)
    spread = line.spread(np.arange(37.0))
    assert np.flatnonzero(np.isnan(spread)).tolist() == [7, 8, 20]
    assert spread[9] == 7.0


def test_stamps_of_a_program_may_miss_the_grid_by_a_quarter() -> None:
    ticks = EVEN.copy()
    ticks[9] += 24
    line = lay(capture(ticks, COAST, starts=(0,)))
    assert line.jitter == pytest.approx(0.24)
    ticks[9] += 3
    with pytest.raises(DataError, match=r"by up to 0\.27 periods"):
        lay(capture(ticks, COAST, starts=(0,)))
    twice = EVEN.copy()
    twice[9] = twice[8]
    with pytest.raises(DataError, match="miss a uniform grid"):
        lay(capture(twice, COAST, starts=(0,)))


def test_what_is_too_short_or_too_full_of_holes_is_refused() -> None:
    assert lay(capture(EVEN[:16], COAST, starts=(0,))).count == 16
    with pytest.raises(DataError, match="holds 15 samples, too few"):
        lay(capture(EVEN[:15], COAST, starts=(0,)))
    holes = np.r_[EVEN[:20], EVEN[20:] + 100 * 121]
    with pytest.raises(DataError, match="121 of 161 samples are missing"):
        lay(capture(holes, COAST, starts=(0,)))
    assert lay(capture(np.r_[EVEN[:20], EVEN[20:] + 100 * 120], COAST, starts=(0,))).lost == 120
    with pytest.raises(DataError, match="do not advance"):
        lay(capture(np.zeros(20), COAST, starts=(0,)))


# blocks of readings


def read(one: Capture, emf: bool = False) -> tuple[dict[str, measurements.Measured], list[Any]]:
    line = lay(one)
    blocks, outputs = measurements.read(one, line, line.driven, emf)
    return {m.block.name: m for m in blocks}, outputs


def test_each_channel_is_a_block_without_its_first_reading() -> None:
    current = Channel(CURRENT, "A", np.arange(40.0), kind="mean", aperture_s=5e-5, delay_s=1e-5)
    speed = Channel(SPEED, "rad/s", 2.0 * np.arange(40.0), delay_s=3e-5, filter_s=2e-5)
    one = capture(EVEN, drive(0.5), starts=(0,), current=current, speed=speed)
    one = replace(one, wiring=Wiring(gear_ratio=3.0))
    blocks, outputs = read(one)
    assert set(blocks) == {CURRENT, SPEED}
    assert blocks[CURRENT].values == pytest.approx(np.arange(1.0, 40.0))
    assert blocks[CURRENT].where == slice(1, 40)
    assert blocks[SPEED].values == pytest.approx(6.0 * np.arange(1.0, 40.0))
    assert (outputs[0].quantity, outputs[0].aperture_s) == (Quantity.CURRENT, 5e-5)
    assert outputs[0].delay_s == 1e-5
    assert outputs[1].quantity == Quantity.SPEED
    assert outputs[1].delay_s == pytest.approx(1e-5)  # its filter has the rest
    assert outputs[1].filter_s == 2e-5


def test_a_position_is_taken_before_a_speed() -> None:
    both = {POSITION: np.arange(40.0), SPEED: np.ones(40)}
    one = capture(EVEN, drive(0.5), starts=(0,), **both)
    assert set(read(one)[0]) == {POSITION}
    empty = replace(
        one, channels={**one.channels, POSITION: Channel(POSITION, "rad", np.full(40, np.nan))}
    )
    assert set(read(empty)[0]) == {SPEED}


def test_few_readings_make_no_block() -> None:
    few = np.full(40, np.nan)
    few[3:12] = 1.0
    assert read(capture(EVEN, drive(0.5), starts=(0,), current=few))[0] == {}
    few[12] = 1.0
    assert len(read(capture(EVEN, drive(0.5), starts=(0,), current=few))[0][CURRENT].values) == 10


def test_readings_at_the_end_of_a_converter_are_left_out_of_all_blocks() -> None:
    current = Channel(CURRENT, "A", np.arange(40.0), raw_max=35.0)
    one = capture(EVEN, drive(0.5), starts=(0,), current=current, speed=np.arange(40.0))
    blocks, _ = read(one)
    for name in (CURRENT, SPEED):
        assert blocks[name].keep.tolist() == list(range(1, 35))


def test_a_magnitude_is_read_while_the_motor_is_driven() -> None:
    current = Channel(CURRENT, "A", np.arange(40.0), unsigned=True)
    one = capture(EVEN, COAST, drive(0.5), starts=(0, 1500), current=current)
    blocks, _ = read(one)
    assert blocks[CURRENT].unsigned
    assert blocks[CURRENT].keep.tolist() == list(range(16, 40))


def test_an_open_bridge_shows_the_back_emf_once_the_current_has_gone() -> None:
    one = capture(EVEN, COAST, drive(0.5), COAST, starts=(0, 1000, 2000), **{VOLTAGE: np.ones(40)})
    blocks, outputs = read(one, emf=True)
    late = opened_voltage.SAMPLES
    wanted = [*range(1, 11), *range(21 + late, 40)]
    assert blocks[measurements.EMF].keep.tolist() == wanted
    assert outputs[0].quantity == Quantity.SPEED
    assert read(one, emf=False)[0] == {}


def test_a_channel_that_repeats_its_readings_is_read_where_it_is_new() -> None:
    one = capture(EVEN, drive(0.5), starts=(0,), speed=np.repeat(np.arange(21.0), 2)[1:41])
    held = replace(one, provenance={HELD: {SPEED: 2}})
    assert read(held)[0][SPEED].keep.tolist() == list(range(1, 40, 2))
    assert len(read(one)[0][SPEED].keep) == 39


def test_the_floor_of_the_noise_is_a_rounding_or_next_to_nothing() -> None:
    coarse = Channel(SPEED, "rad/s", np.arange(40.0), resolution=0.6)
    one = replace(
        capture(EVEN, drive(0.5), starts=(0,), speed=coarse), wiring=Wiring(gear_ratio=2.0)
    )
    assert read(one)[0][SPEED].block.floor == pytest.approx(2 * 0.6 / np.sqrt(12.0))
    fine = capture(EVEN, drive(0.5), starts=(0,), speed=np.arange(40.0))
    assert read(fine)[0][SPEED].block.floor == pytest.approx(1e-7 * 38.0)
    still = capture(EVEN, drive(0.5), starts=(0,), speed=np.full(40, -4.0))
    assert read(still)[0][SPEED].block.floor == pytest.approx(4e-7)
    none = capture(EVEN, drive(0.5), starts=(0,), speed=np.zeros(40))
    assert read(none)[0][SPEED].block.floor == pytest.approx(1e-7)


def test_a_run_of_equal_counts_is_worth_one_reading() -> None:
    counts = Channel(POSITION, "rad", np.repeat([0.0, 1.0, 3.0], [10, 4, 26]), resolution=1.0)
    (block,) = read(capture(EVEN, drive(0.5), starts=(0,), position=counts))[0].values()
    assert block.root_weights is not None
    assert block.root_weights**2 == pytest.approx(np.repeat([1 / 9, 1 / 4, 1 / 26], [9, 4, 26]))
    assert block.block.count == pytest.approx(3.0)
    smooth = read(capture(EVEN, drive(0.5), starts=(0,), position=np.arange(40.0)))[0][POSITION]
    assert smooth.root_weights is None
    assert smooth.block.count == 39.0


def test_a_response_is_read_at_the_moment_of_each_reading() -> None:
    ticks = EVEN.copy()
    ticks[5] += 10
    blocks, _ = read(capture(ticks, current=np.arange(40.0)))
    block = blocks[CURRENT]
    line = lay(capture(ticks))
    response = np.vstack([3.0 * np.arange(line.count)])  # 3 a tick
    assert block.of(response) == pytest.approx(3.0 * ticks[1:] * 1e-6 / line.period_s)


@pytest.mark.parametrize(
    ("order", "name", "taken", "left"),
    [(1, CURRENT, 2e-5, 1e-5), (2, CURRENT, 0.0, 3e-5 - 1.4 * 2e-5), (1, "back_emf", 2e-5, 1e-5)],
)
def test_a_filter_takes_its_part_of_the_delay(
    order: int, name: str, taken: float, left: float
) -> None:
    one = Channel(CURRENT, "A", np.zeros(2), delay_s=3e-5, filter_s=2e-5, filter_order=order,
                  filter_damping=0.7)  # fmt: skip
    assert measurements.filter_of(one, name) == pytest.approx(taken)
    assert measurements.after_filter_s(one, name) == pytest.approx(left, abs=1e-12)
    assert measurements.second_order(one, name) is (order == 2)


# parts in which the current stops, and in which the rotor stands


def line_of(*parts: Part) -> Timeline:
    return Timeline(1e-4, parts[-1].stop, np.arange(parts[-1].stop), parts, 0.0)


PULSED = Part(10, 20, StepKind.DRIVE_DUTY, 0.3, Decay.DIODE, discontinuous=True)
BEFORE, AFTER = Part(0, 10, StepKind.COAST), Part(20, 40, StepKind.COAST)


def test_a_reading_over_part_of_an_unknown_period_is_unclear_as_long_as_it_sees_pulses() -> None:
    line = line_of(BEFORE, PULSED, AFTER)
    short = Channel(CURRENT, "A", np.zeros(40), kind="mean", aperture_s=3e-5, delay_s=0.0)
    assert np.flatnonzero(unclear(short, line, 23e3)).tolist() == list(range(10, 20))
    late = replace(short, delay_s=1.5e-4)  # sees the interval before, and the one before that
    assert np.flatnonzero(unclear(late, line, 23e3)).tolist() == list(range(11, 21))
    wide = replace(short, aperture_s=1.7e-4, delay_s=1.5e-4)
    assert np.flatnonzero(unclear(wide, line, 23e3)).tolist() == list(range(11, 23))
    assert not unclear(short, line, 20e3).any()  # two whole periods a sample: it is known where
    assert not unclear(replace(short, aperture_s=2 / 23e3), line, 23e3).any()
    instant = Channel(CURRENT, "A", np.zeros(40))
    assert unclear(instant, line, 23e3).any()
    assert not unclear(replace(instant, pwm_phase=0.2), line, 23e3).any()
    assert not unclear(
        short, line_of(BEFORE, replace(PULSED, discontinuous=False), AFTER), 23e3
    ).any()


def test_a_reading_shows_ripple_where_its_place_is_known_and_it_is_no_whole_period() -> None:
    short = Channel(CURRENT, "A", np.zeros(4), kind="mean", aperture_s=3e-5)
    assert shows_ripple(short, 1e-4, 20e3)
    assert not shows_ripple(short, 1e-4, 23e3)
    assert not shows_ripple(short, 1e-4, 0.0)
    assert not shows_ripple(replace(short, aperture_s=1e-4), 1e-4, 20e3)


@pytest.mark.parametrize(("share", "stops"), [(2.9, True), (3.1, False)])
def test_a_current_larger_than_pulses_could_be_flows_on(share: float, stops: bool) -> None:
    one = replace(capture(EVEN), wiring=Wiring(pwm_hz=20e3, supply_voltage_v=12.0))
    pulse = ripple(one, PULSED, 1e-3, 2.0)[0]
    assert pulse > 0.0
    size = Channel(CURRENT, "A", np.full(40, -share * pulse))
    one = replace(one, channels={CURRENT: size})
    found = confirmed(one, line_of(BEFORE, PULSED, AFTER), 1e-3, 2.0)
    assert found.parts[1].discontinuous is stops
    none = replace(one, channels={})
    assert confirmed(none, line_of(BEFORE, PULSED, AFTER), 1e-3, 2.0).parts[1].discontinuous


def counted(position: Any, level: float = 0.5, resolution: float = 0.1) -> Capture:
    channel = Channel(POSITION, "rad", np.asarray(position, float), resolution=resolution)
    return capture(EVEN, COAST, drive(level), starts=(0, 1000), position=channel)


@pytest.mark.parametrize(("move", "still"), [(0.14, True), (0.16, False)])
def test_a_part_stands_still_within_an_edge_that_flickers(move: float, still: bool) -> None:
    place = np.zeros(40)
    place[25] = move
    one = counted(place)
    assert [p.still for p in with_standstill(one, lay(one)).parts] == [False, still]
    bare = counted(place, resolution=0.0)
    assert not any(p.still for p in with_standstill(bare, lay(bare)).parts)


def test_few_readings_or_no_level_show_no_standstill() -> None:
    place = np.zeros(40)
    place[11:17] = np.nan  # 23 of the part are left
    one = counted(place)
    assert not any(p.still for p in with_standstill(one, lay(one)).parts)
    none = counted(np.zeros(40), level=0.0)
    assert not any(p.still for p in with_standstill(none, lay(none)).parts)


def test_a_record_begins_at_rest_where_nothing_moves_or_flows() -> None:
    rng = np.random.default_rng(1)
    quiet = 1e-3 * rng.standard_normal(80)
    idle, driven = np.zeros(80, bool), np.ones(80, bool)
    ticks = 100 * np.arange(80)
    still = capture(ticks, position=Channel(POSITION, "rad", np.zeros(80), resolution=0.1))
    assert starts_at_rest(still, driven)
    creeping = capture(
        ticks, position=Channel(POSITION, "rad", 0.03 * np.arange(80.0), resolution=0.1)
    )
    assert not starts_at_rest(creeping, driven)
    assert starts_at_rest(capture(ticks, speed=quiet), idle)
    assert not starts_at_rest(capture(ticks, speed=quiet + 0.01), idle)
    flowing = capture(ticks, speed=quiet, current=quiet + 0.5)
    assert starts_at_rest(flowing, idle)
    assert not starts_at_rest(flowing, driven)
