"""Which readings of a capture the likelihood sees, where they lie, and how the model must read."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, HELD, POSITION, SPEED, VOLTAGE, Capture, Channel, Wiring
from motorid.estimate.signals import measurements as module
from motorid.estimate.signals.measurements import EMF, Measured, motion, read
from motorid.estimate.signals.time_grid import Part, Timeline
from motorid.motor.reading import Output, Quantity

Floats = NDArray[np.float64]
COUNT, PERIOD_S = 60, 1e-3
RAMP = np.linspace(-1.0, 2.0, COUNT)
GRID = Timeline(PERIOD_S, COUNT, np.arange(COUNT), (Part(0, COUNT),), 0.0)  # a tick a reading


def log(raw: dict[str, Any] | None = None, gear: float = 1.0, held: Any = None,
        **facts: dict[str, Any]) -> Capture:  # fmt: skip
    """A log of current, speed and voltage; ``facts`` of its channels."""
    units = {CURRENT: "A", SPEED: "rad/s", POSITION: "rad", VOLTAGE: "V"}
    given = {CURRENT: RAMP, SPEED: 10.0 * RAMP, VOLTAGE: 6.0 + RAMP, **(raw or {})}
    channels = {
        name: Channel(name, units[name], np.asarray(values, float), **facts.get(name, {}))
        for name, values in given.items()
    }
    provenance = {} if held is None else {HELD: held}
    return Capture(
        np.arange(COUNT) * 1000, 1e6, channels, wiring=Wiring(gear_ratio=gear),
        provenance=provenance,
    )  # fmt: skip


def blocks(capture: Capture, driven: Any = True) -> tuple[dict[str, Measured], list[Output]]:
    everywhere = np.broadcast_to(np.asarray(driven), COUNT)
    measured, outputs = read(capture, GRID, everywhere, shows_emf=False)
    return {m.block.name: m for m in measured}, outputs


def test_readings_are_compared_in_the_order_of_the_outputs() -> None:
    found, outputs = blocks(log())
    assert list(found) == [CURRENT, SPEED]
    assert [m.row for m in found.values()] == [0, 1]
    assert [one.quantity for one in outputs] == [Quantity.CURRENT, Quantity.SPEED]
    assert found[CURRENT].values == pytest.approx(RAMP[1:])  # the first window is before it
    assert found[CURRENT].keep.tolist() == list(range(1, COUNT))
    assert found[CURRENT].where == slice(1, COUNT)
    response = np.arange(2.0 * COUNT).reshape(2, COUNT)
    assert found[SPEED].of(response).tolist() == list(range(COUNT + 1, 2 * COUNT))


def test_missing_and_clipped_readings_of_either_converter_are_left_out() -> None:
    current = RAMP.copy()
    current[[5, 9]] = np.nan
    volts = 6.0 + RAMP
    volts[20] = 40.0
    speed = 10.0 * RAMP
    speed[30] = 500.0
    raw = {CURRENT: current, VOLTAGE: volts, SPEED: speed}
    ends = {CURRENT: {"raw_min": -0.9}, VOLTAGE: {"raw_max": 40.0}, SPEED: {"raw_max": 500.0}}
    found, _ = blocks(log(raw, **ends))
    low = np.flatnonzero(RAMP <= -0.9).tolist()
    gone = {0, 5, 9, 20, *low}
    assert found[CURRENT].keep.tolist() == [k for k in range(COUNT) if k not in gone]
    assert isinstance(found[CURRENT].where, np.ndarray)
    response = np.stack([np.arange(float(COUNT))] * 2)
    assert found[CURRENT].of(response).tolist() == found[CURRENT].keep.tolist()
    # an end of the encoder's range is no end of a converter; a missing current no missing speed
    assert found[SPEED].keep.tolist() == [k for k in range(COUNT) if k not in {0, 20, *low}]


@pytest.mark.parametrize(("known", "is_block"), [(9, False), (10, True)])
def test_a_few_readings_are_no_block(known: int, is_block: bool) -> None:
    current = np.full(COUNT, np.nan)
    current[1 : 1 + known] = RAMP[:known]
    found, outputs = blocks(log({CURRENT: current}))
    assert (CURRENT in found) is is_block
    assert found[SPEED].row == len(outputs) - 1 == int(is_block)


def test_a_magnitude_counts_where_the_motor_is_driven() -> None:
    driven = np.arange(COUNT) >= 40
    found, _ = blocks(log({CURRENT: np.abs(RAMP)}, **{CURRENT: {"unsigned": True}}), driven)
    assert found[CURRENT].keep.tolist() == list(range(40, COUNT))
    assert found[CURRENT].unsigned
    assert len(found[SPEED].keep) == COUNT - 1
    assert not found[SPEED].unsigned


def test_behind_a_gear_the_motor_turns_faster() -> None:
    found, _ = blocks(log(gear=4.0, **{SPEED: {"resolution": 0.6}}))
    assert found[SPEED].values == pytest.approx(40.0 * RAMP[1:])
    assert found[SPEED].block.floor == pytest.approx(4.0 * 0.6 / np.sqrt(12.0))
    assert found[CURRENT].values == pytest.approx(RAMP[1:])


def test_what_a_channel_declares_of_a_reading_is_in_the_models_unit() -> None:
    """Of the wheel's speed, and of a current, which no gear changes."""
    facts = {SPEED: {"resolution": 0.6, "noise": 0.2}, CURRENT: {"resolution": 1e-3, "noise": 0.02}}
    found, _ = blocks(log(gear=4.0, **facts))
    speed, current = found[SPEED], found[CURRENT]
    assert (speed.resolution, speed.noise) == pytest.approx((2.4, 0.8))
    assert (current.resolution, current.noise) == pytest.approx((1e-3, 0.02))
    assert (speed.channel.resolution, speed.channel.noise) == (0.6, 0.2)
    angle, _ = blocks(log({POSITION: RAMP}, gear=4.0, **{POSITION: facts[SPEED]}))
    assert (angle[POSITION].resolution, angle[POSITION].noise) == pytest.approx((2.4, 0.8))
    nothing, _ = blocks(log(gear=4.0))
    assert (nothing[SPEED].resolution, nothing[SPEED].noise) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("values", "resolution", "floor"),
    [
        (RAMP, 0.0, 1e-7 * (RAMP[-1] - RAMP[1])),
        (RAMP, 1e-3, 1e-3 / np.sqrt(12.0)),
        (np.full(COUNT, -3.0), 0.0, 3e-7),
        (np.zeros(COUNT), 0.0, 1e-7),
    ],
)
def test_noise_is_no_less_than_rounding_or_a_little_of_the_range(
    values: Floats, resolution: float, floor: float
) -> None:
    found, _ = blocks(log({CURRENT: values}, **{CURRENT: {"resolution": resolution}}))
    assert found[CURRENT].block.floor == pytest.approx(floor)
    assert found[CURRENT].block.count == COUNT - 1
    assert found[CURRENT].root_weights is None


def test_blocks_of_one_kind_of_readings_share_their_noise() -> None:
    def group(**facts: Any) -> str:
        return blocks(log(**{CURRENT: facts}))[0][CURRENT].block.group

    assert group() == group(delay_s=1e-4)
    assert len({group(), group(resolution=1e-3), group(noise=0.02)}) == 3
    assert group().startswith(CURRENT)


def test_a_geared_run_shares_its_noise_with_one_that_reads_as_finely_at_the_motor() -> None:
    """A wheel's sensor behind a gear of 4 is that many times as coarse, and as noisy."""

    def groups(gear: float, resolution: float, noise: float) -> list[str]:
        facts = {"resolution": resolution, "noise": noise}
        found, _ = blocks(log(gear=gear, **{SPEED: facts, CURRENT: facts}))
        return [found[name].block.group for name in (CURRENT, SPEED)]

    plain, geared = groups(1.0, 0.6, 0.2), groups(4.0, 0.6, 0.2)
    assert geared[0] == plain[0]  # no gear changes a current
    assert geared[1] != plain[1]
    assert groups(4.0, 0.15, 0.05)[1] == plain[1]
    assert groups(4.0, 0.15, 0.2)[1] != plain[1] != groups(4.0, 0.6, 0.05)[1]


def test_equal_counts_of_an_encoder_are_worth_one_reading() -> None:
    counts = np.repeat([0.0, 1.0, 2.0, 3.0, 4.0], 12)
    found, _ = blocks(log({POSITION: counts}, **{POSITION: {"resolution": 1.0}}))
    weights = found[POSITION].root_weights
    assert SPEED not in found  # the two are rarely independent
    assert weights is not None
    assert weights[:11] == pytest.approx(np.full(11, 11**-0.5))
    assert weights[11:] == pytest.approx(np.full(48, 12**-0.5))
    assert found[POSITION].block.count == pytest.approx(5.0)
    smooth, _ = blocks(log({POSITION: counts}))
    assert (smooth[POSITION].root_weights, smooth[POSITION].block.count) == (None, COUNT - 1)
    read_speed, _ = blocks(log(**{SPEED: {"resolution": 1.0}}))
    assert read_speed[SPEED].root_weights is None


def test_a_motion_is_a_position_where_one_was_read() -> None:
    both = log({POSITION: RAMP})
    assert motion(both) is both.channels[POSITION]
    none = log({POSITION: np.full(COUNT, np.nan)})
    assert motion(none) is none.channels[SPEED]
    still = Capture(both.ticks, 1e6, {CURRENT: both.channels[CURRENT]})
    assert motion(still) is None


def test_a_reading_that_is_repeated_counts_once() -> None:
    raw = np.repeat(np.arange(16.0), 4)[2 : COUNT + 2]  # new ones at 2, 6, 10, ...
    channel = log({SPEED: raw}).channels[SPEED]

    def fresh(held: Any) -> list[int]:
        return np.flatnonzero(module._fresh(log({SPEED: raw}, held=held), channel)).tolist()

    assert fresh({SPEED: 4}) == list(range(2, COUNT, 4))
    for none in ({CURRENT: 4}, {SPEED: 1}, {SPEED: "4"}, "speed", None):
        assert fresh(none) == list(range(COUNT))
    found, _ = blocks(log({SPEED: raw}, held={SPEED: 4}))
    assert found[SPEED].keep.tolist() == list(range(2, COUNT, 4))


def channel(**facts: Any) -> Channel:
    return Channel(CURRENT, "A", RAMP, **facts)


@pytest.mark.parametrize(
    ("facts", "name", "filter_s", "after_s", "second"),
    [
        ({"delay_s": 5e-3}, CURRENT, 0.0, 5e-3, False),
        ({"delay_s": 5e-3, "filter_s": 2e-3}, CURRENT, 2e-3, 3e-3, False),
        ({"delay_s": 1e-3, "filter_s": 2e-3}, CURRENT, 1e-3, 0.0, False),
        ({"delay_s": 5e-3, "filter_s": 2e-3}, EMF, 2e-3, 3e-3, False),
        ({"delay_s": 5e-3, "filter_s": 2e-3, "filter_order": 2}, CURRENT, 0.0, 1e-3, True),
        ({"delay_s": 3e-3, "filter_s": 2e-3, "filter_order": 2}, CURRENT, 0.0, 0.0, True),
        (
            {"delay_s": 5e-3, "filter_s": 2e-3, "filter_order": 2, "filter_damping": 0.5},
            CURRENT, 0.0, 3e-3, True,
        ),
        ({"delay_s": 5e-3, "filter_s": 2e-3, "filter_order": 2}, EMF, 0.0, 5e-3, False),
        ({"delay_s": 5e-3, "filter_order": 2}, CURRENT, 0.0, 5e-3, False),
    ],
)  # fmt: skip
def test_a_filter_has_its_part_of_the_delay(
    facts: dict[str, Any], name: str, filter_s: float, after_s: float, second: bool
) -> None:
    one = channel(**facts)
    assert module.filter_of(one, name) == pytest.approx(filter_s)
    assert module.after_filter_s(one, name) == pytest.approx(after_s)
    assert module.second_order(one, name) is second


def test_an_output_reads_as_its_channel_does() -> None:
    mean = {
        "kind": "mean",
        "aperture_s": 4e-4,
        "delay_s": 5e-4,
        "filter_s": 2e-4,
        "pwm_phase": 0.25,
    }
    _, (current, speed) = blocks(log(**{CURRENT: mean}))
    assert current == Output(Quantity.CURRENT, 4e-4, pytest.approx(3e-4), 0.25, 2e-4)
    assert speed == Output(Quantity.SPEED)


def test_a_stamp_after_its_tick_reads_between_two_ticks() -> None:
    (one, _), _ = read(log(), GRID, np.ones(COUNT, dtype=bool), shows_emf=False)
    response = np.stack([np.arange(COUNT + 1.0) ** 2] * 2)
    late = np.full(COUNT - 1, 0.25)
    found = replace(one, past=late).of(response)
    k = np.arange(1.0, COUNT)
    assert found == pytest.approx(0.75 * k**2 + 0.25 * (k + 1.0) ** 2)
