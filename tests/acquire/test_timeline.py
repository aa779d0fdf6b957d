"""Blocks on one line of time: wrap-rounds, gaps, repeats; every sample in its place."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motorid.acquire.timeline import (
    DROPPED,
    LOST,
    MISSING_END,
    OFF_GRID,
    OTHER_CHANNELS,
    OUTSIDE,
    TAKEN,
    Timeline,
)
from motorid.capture.model import Gap, Phase
from motorid.wire.codec import SampleBlock
from motorid.wire.enums import Channel

PERIOD = 1600
U32 = 1 << 32


def block(first: int, currents: list[int], *, dropped: int = 0, position: int = 0) -> SampleBlock:
    """A block whose position moves one count a sample from ``position``."""
    low = (position + np.arange(len(currents))) % 65536
    columns = [np.array(currents, np.int16), low.astype(np.uint16).view(np.int16)]
    channels = (Channel.CURRENT, Channel.POSITION)
    samples = np.stack(columns, axis=1)
    return SampleBlock(0, first % U32, dropped, position % U32, channels, samples)


def test_blocks_join_without_a_gap() -> None:
    line = Timeline(PERIOD)
    line.start(1000)
    line.add(block(1000, [1, 2]))
    line.add(block(1000 + 2 * PERIOD, [3], position=2))
    found = line.arrays(3)
    assert found.ticks.tolist() == [1000, 1000 + PERIOD, 1000 + 2 * PERIOD]
    assert found.columns["current"].tolist() == [1, 2, 3]
    assert found.columns["position"].tolist() == [0, 1, 2]
    assert found.gaps == ()


def test_ticks_and_positions_go_on_past_32_bits() -> None:
    line = Timeline(PERIOD)
    start, at = U32 - 2 * PERIOD, U32 - 3
    line.start(start)
    line.phase(0, start)
    for n in range(0, 8, 2):
        line.add(block(start + n * PERIOD, [n, n + 1], position=at + n))
    line.phase(1, (start + 6 * PERIOD) % U32)
    found = line.arrays(8)
    assert found.ticks.tolist() == [start + n * PERIOD for n in range(8)]
    assert found.columns["position"].tolist() == list(range(-3, 5))
    assert line.phases == [Phase(0, start), Phase(1, start + 6 * PERIOD)]
    assert found.gaps == ()


def test_a_fast_shaft_wraps_16_bits_within_a_block() -> None:
    steps = 30_000 * np.arange(8)
    samples = (steps % 65536).astype(np.uint16).view(np.int16)[:, None]
    line = Timeline(PERIOD)
    line.add(SampleBlock(0, 0, 0, 0, (Channel.POSITION,), samples))
    assert line.arrays().columns["position"].tolist() == steps.tolist()


def test_gaps_are_counted_and_named_and_never_filled() -> None:
    line = Timeline(PERIOD)
    line.start(0)
    line.add(block(2 * PERIOD, [1]))  # two lost at the start
    line.add(block(8 * PERIOD, [2], dropped=3))  # five missing, three by the board's word
    found = line.arrays(12)  # three more at the end
    assert found.columns["current"].tolist() == [1, 2]
    assert found.gaps == (
        Gap(0, 2, LOST),
        Gap(1, 3, DROPPED),
        Gap(1, 2, LOST),
        Gap(2, 3, MISSING_END),
    )


def test_repeated_and_foreign_blocks_are_left_out() -> None:
    line = Timeline(PERIOD)
    line.start(0)
    first = block(0, [1, 2])
    line.add(first)
    line.add(first)
    line.add(SampleBlock(1, 2 * PERIOD, 0, 0, (Channel.CURRENT,), np.zeros((1, 1), np.int16)))
    line.add(block(2 * PERIOD, [3]))
    assert line.arrays().columns["current"].tolist() == [1, 2, 3]
    assert line.repeated == 1
    assert line.unplaced == {OTHER_CHANNELS: 1}


def test_blocks_out_of_order_take_their_places() -> None:
    line = Timeline(PERIOD)
    line.start(0)
    for number in (0, 4, 2, 6, 2):
        line.add(block(number * PERIOD, [number, number + 1], position=number))
    found = line.arrays(8)
    assert found.columns["current"].tolist() == list(range(8))
    assert found.columns["position"].tolist() == list(range(8))
    assert found.ticks.tolist() == [n * PERIOD for n in range(8)]
    assert found.gaps == ()
    assert (line.repeated, line.unplaced) == (1, {})


def test_what_has_no_place_is_counted_by_its_reason() -> None:
    line = Timeline(PERIOD, 10)
    line.start(0)
    line.add(block(0, [1, 2]))
    line.add(block(2 * PERIOD + 1, [3, 4, 5]))
    line.add(block(9 * PERIOD, [6, 7]))
    line.add(block(-PERIOD, [8]))
    line.add(block(4 * PERIOD, [9, 10]))
    line.add(block(PERIOD, [11, 12]))  # another reading at a tick that is taken
    line.add(block(0, [13]))
    assert line.arrays().columns["current"].tolist() == [1, 2, 9, 10]
    assert line.unplaced == {OFF_GRID: 3, OUTSIDE: 3, TAKEN: 3}


@pytest.mark.parametrize("told", [7, PERIOD * 100, -PERIOD * 100, 1 << 31])
def test_a_wrong_word_on_the_beginning_costs_no_sample(told: int) -> None:
    """The samples' own ticks hold, where not one of them fits what the reply to start said."""
    line = Timeline(PERIOD, 8)
    line.start(told % U32)
    line.phase(0, 0)
    line.add(block(0, [1, 2]))
    line.phase(1, 2 * PERIOD)
    line.add(block(2 * PERIOD, [3, 4], position=2))
    found = line.arrays(4)
    assert found.columns["current"].tolist() == [1, 2, 3, 4]
    assert np.diff(found.ticks).tolist() == [PERIOD] * 3
    assert [phase.tick - int(found.ticks[0]) for phase in line.phases] == [0, 2 * PERIOD]
    assert found.gaps == ()
    assert line.wrong_start == told % U32
    assert line.unplaced == {}


@pytest.mark.slow
@given(st.permutations(range(12)), st.integers(0, U32 - 1))
def test_any_order_gives_the_same_run(order: list[int], start: int) -> None:
    line = Timeline(PERIOD, 24)
    line.start(start)
    for number in order:
        line.add(block(start + 2 * number * PERIOD, [2 * number, 2 * number + 1]))
    found = line.arrays(24)
    assert found.columns["current"].tolist() == list(range(24))
    assert found.gaps == ()
    assert not line.unplaced


@pytest.mark.slow
@given(
    st.lists(st.tuples(st.integers(1, 9), st.sampled_from(["keep", "lose", "twice"])), min_size=1),
    st.integers(0, U32 - 1),
)
def test_every_sample_is_one_that_was_sent_in_its_place(
    plan: list[tuple[int, str]], start: int
) -> None:
    """Whatever is lost or doubled, sample n of the run stands at tick start + n * PERIOD."""
    line = Timeline(PERIOD)
    line.start(start)
    sent = 0
    for count, fate in plan:
        numbers = list(range(sent, sent + count))
        made = block(start + sent * PERIOD, numbers, position=sent)
        for _ in range({"keep": 1, "lose": 0, "twice": 2}[fate]):
            line.add(made)
        sent += count
    if not line.blocks:
        return
    found = line.arrays(sent)
    numbers = (found.ticks - start) // PERIOD
    np.testing.assert_array_equal(found.columns["current"], numbers)
    np.testing.assert_array_equal(np.diff(found.columns["position"]), np.diff(numbers))
    assert len(numbers) + sum(gap.samples for gap in found.gaps) == sent
    for gap in found.gaps:
        before = int(numbers[gap.index - 1]) if gap.index else -1
        after = int(numbers[gap.index]) if gap.index < len(numbers) else sent
        assert gap.samples == after - before - 1


@pytest.mark.parametrize("lost", [65_536, 1_000_000])
def test_a_long_silence_is_one_gap(lost: int) -> None:
    line = Timeline(PERIOD)
    line.start(5)
    line.add(block(5, [1]))
    line.add(block(5 + (lost + 1) * PERIOD, [2]))
    assert line.arrays().gaps == (Gap(1, lost, LOST),)


def test_what_the_board_dropped_last_is_not_laid_on_the_link() -> None:
    line = Timeline(PERIOD)
    line.start(0)
    line.add(block(0, [1, 2]))
    line.add(block(5 * PERIOD, [3], dropped=3, position=5))
    assert line.arrays(10, 5).gaps == (
        Gap(2, 3, DROPPED),
        Gap(3, 2, DROPPED),
        Gap(3, 2, MISSING_END),
    )
    assert line.arrays(10, 0).gaps == (Gap(2, 3, DROPPED), Gap(3, 4, MISSING_END))
