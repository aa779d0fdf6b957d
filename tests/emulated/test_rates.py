"""4 kHz with the encoder at full speed on both boards: nothing lost, nothing late."""

from __future__ import annotations

import pytest

from motorid.wire.enums import Channel
from tests.conformance.boards import emulator_lacks
from tests.emulated import rates

BOARDS = ("uno", "mega")
FULL_SPEED_HZ = 39_500  # the ceiling is 40,000, where the speed limit trips
CONVERSION_JITTER = 4  # cycles; the emulator's own, which triggers between instructions
SAMPLE_JITTER = 250  # cycles from a window's end to core_sample()
ENABLE_JITTER = 160  # cycles from the tick to enable
HANDS = 3250  # cycles that core_sample() may take: until the levels' slot
LEAST_IDLE = 0.05
LEAST_STACK = 96  # bytes never used here; that all calls fit is held by firmware/test/sizes.py


@pytest.fixture(autouse=True)
def _needs_the_emulator() -> None:
    if lack := emulator_lacks():
        pytest.skip(f"no emulated board: {lack}")


@pytest.mark.slow
@pytest.mark.parametrize("board", BOARDS)
def test_the_highest_rate_with_the_encoder_at_full_speed(board: str) -> None:
    figures = rates.run(board, 4000, FULL_SPEED_HZ, 0.3)
    times = figures.times
    assert rates.sustained(figures), times["slot"]
    edges = times["edge"]["count"] * rates.CLOCK_HZ / times["cycles"]
    assert edges == pytest.approx(FULL_SPEED_HZ, rel=0.02)
    trigger = times["trigger"]
    assert max(-trigger["least"], trigger["most"]) <= CONVERSION_JITTER
    assert times["start"]["most"] - times["start"]["least"] <= SAMPLE_JITTER
    assert -4 <= times["enable"]["least"] <= times["enable"]["most"] <= ENABLE_JITTER
    assert times["sample"]["most"] < HANDS
    assert figures.share("asleep") > LEAST_IDLE
    assert figures.link_bytes_s < 0.3 * rates.LINK_BYTES_S
    assert figures.facts["stack_left"] > LEAST_STACK
    position = figures.record.channel(Channel.POSITION).view("u2")
    moved = (position[1:] - position[:-1]).view("i2")
    assert moved.min() >= 8  # 9.875 counts a sample: an edge lost or a window out of step shows
    assert moved.max() <= 12


@pytest.mark.slow
def test_edges_beyond_the_ceiling_are_not_sustained() -> None:
    """What finds 4 kHz to hold must be able to find that something does not."""
    assert not rates.sustained(rates.run("uno", 0, 60_000, 0.1))
