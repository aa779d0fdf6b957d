"""What a person sees of a run: its figures, by blocks made by hand."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.acquire import live, tap
from motorid.acquire.live import Live, LiveView
from motorid.acquire.strips import Strip, Strips
from motorid.acquire.tap import RunFacts, Scale, Tap
from motorid.capture.model import CURRENT, POSITION, VOLTAGE
from motorid.rig import Calibration
from motorid.wire.codec import SampleBlock
from motorid.wire.enums import Channel
from tests.acquire.rigs import sim_rig

RIG = sim_rig()
COUNT = 2 * math.pi / RIG.wiring.counts_per_turn
BOTH = (Channel.CURRENT, Channel.POSITION)
WRAP = 1 << 32


def block(tick: int, position: int = 0, current: tuple[int, ...] = (0,)) -> SampleBlock:
    low = np.full(len(current), position, np.int64).astype(np.uint16).view(np.int16)
    samples = np.column_stack([np.array(current, np.int16), low])
    return SampleBlock(0, tick % WRAP, 0, position % WRAP, BOTH, samples)


# -- facts of a run
def facts(**changes: Any) -> RunFacts:
    fact = {"scale": 0.5, "offset": 7.0, "offset_uncertainty": 1.0, "noise": 1.0}
    board: Any = SimpleNamespace(
        identity={"clock_hz": 1e6}, descriptors=dict.fromkeys((CURRENT, VOLTAGE), fact)
    )
    mask = sum(1 << one for one in (Channel.CURRENT, Channel.TERMINAL_VOLTAGE, Channel.POSITION))
    config = {"channels": mask, "sample_period_ticks": 250}
    rig = replace(RIG, **changes)
    return tap.run_facts(rig, board, config, {"current_offset": 3.0, "current_noise": 1.0})


def test_a_run_s_scales_are_the_board_s_with_the_rig_s_gain() -> None:
    found = facts(calibration={CURRENT: Calibration(gain=1.5)}, clock_rate=1.01)
    assert (found.clock_hz, found.period) == (pytest.approx(1.01e6), 250)
    by_name = {one.name: one for one in found.scales}
    assert [one.name for one in found.scales] == [one.name.lower() for one in found.channels]
    assert by_name[CURRENT] == Scale(CURRENT, "A", 0.75, 3.0)  # by the run's own zero
    assert by_name[VOLTAGE] == Scale(VOLTAGE, "V", 0.5, 7.0)
    assert by_name[POSITION] == Scale(POSITION, "rad", pytest.approx(COUNT), 0.0)


def test_a_tap_keeps_blocks_in_order_and_counts_what_went() -> None:
    one = Tap()
    give = one.begin(facts())
    assert not one.waiting
    for tick in range(tap.MOST_BLOCKS + 3):
        give(block(tick))
    assert one.waiting
    ticks = [taken.first_tick for _, taken in one.taken()]
    assert (ticks[0], ticks[-1], len(ticks)) == (3, tap.MOST_BLOCKS + 2, tap.MOST_BLOCKS)
    assert one.lost == 3
    assert list(one.taken()) == []
    give(block(9))
    assert [taken.first_tick for _, taken in one.taken()] == [9]
    assert one.lost == 3


def test_each_block_goes_to_both_where_somebody_watches() -> None:
    seen: list[tuple[str, int]] = []

    def first(one: SampleBlock) -> None:
        seen.append(("first", one.first_tick))

    assert tap.both(first, None, facts) is first
    give = tap.both(first, lambda _: lambda one: seen.append(("other", one.first_tick)), facts)
    give(block(5))
    assert seen == [("first", 5), ("other", 5)]


# -- strips
FACTS = RunFacts(1e6, 250, BOTH, (Scale("current", "A", 0.5, 2.0), Scale("position", "rad", 0.1)))


def shown(strips: Strips, one: SampleBlock, of: RunFacts = FACTS) -> Strip:
    strip = strips.take(of, one)
    assert strip is not None
    return strip


def test_a_strip_is_in_units_and_counts_from_the_first_sample_watched() -> None:
    strips = Strips()
    first = shown(strips, block(1000, 40, (2, 4, -2)))
    assert (first.names, first.units) == (("current", "position", "speed"), ("A", "rad", "rad/s"))
    assert first.values[0].tolist() == [0.0, 1.0, -2.0]
    assert first.values[1].tolist() == pytest.approx([4.0] * 3)
    assert np.isnan(first.values[2]).all()
    assert (first.run, first.start_s, first.period_s) == (1, 0.0, 250e-6)
    assert first.end_s == pytest.approx(750e-6)
    second = shown(strips, block(1750, -5))
    assert second.start_s == pytest.approx(750e-6)
    assert second.values[1].tolist() == pytest.approx([-0.5])
    assert second.follows(first)
    assert not first.follows(second)
    assert not replace(second, run=2).follows(first)


@pytest.mark.parametrize(("late_s", "follows"), [(124e-6, True), (126e-6, False)])
def test_a_strip_follows_within_half_a_sample(late_s: float, follows: bool) -> None:
    strips = Strips()
    first, second = shown(strips, block(0)), shown(strips, block(250))
    assert replace(second, start_s=second.start_s + late_s).follows(first) is follows
    assert replace(second, start_s=second.start_s - late_s).follows(first) is follows


def test_the_speed_is_over_ten_milliseconds() -> None:
    slow = replace(FACTS, period=4000)  # of which 10 ms are 2.5: two samples
    strips = Strips()
    for index, count in enumerate([0, 1, 3]):
        strip = shown(strips, block(4000 * index, count), slow)
    assert strip.values[2].tolist() == pytest.approx([0.3 / 8e-3])
    strip = shown(strips, block(12_000, 7), slow)
    assert strip.values[2].tolist() == pytest.approx([0.6 / 8e-3])


def test_a_block_that_is_late_or_empty_gives_none_and_a_gap_begins_the_speed_anew() -> None:
    rare = replace(FACTS, period=20_000)  # a sample is longer than the window: one of them
    strips = Strips()
    shown(strips, block(0, 0), rare)
    assert shown(strips, block(20_000, 1), rare).values[2].tolist() == pytest.approx([0.1 / 20e-3])
    assert strips.take(rare, block(20_000, 1)) is None
    assert strips.take(rare, block(40_000, 1, ())) is None
    assert np.isnan(shown(strips, block(60_000, 1), rare).values[2]).all()


# -- the line of progress
def view(monkeypatch: pytest.MonkeyPatch, times: list[float]) -> tuple[LiveView, list[Live]]:
    """A view whose clock shows these times, and what it told."""
    told: list[Live] = []
    board: Any = SimpleNamespace(
        identity={"clock_hz": 1000.0}, descriptors={CURRENT: {"scale": 0.5}}
    )
    program: Any = SimpleNamespace(ticks=2500)
    monkeypatch.setattr(live, "time", SimpleNamespace(monotonic=lambda: times.pop(0)))
    return LiveView(RIG, board, {"current_offset": 2.0}, program, told.append), told


def test_progress_is_told_ten_times_a_second(monkeypatch: pytest.MonkeyPatch) -> None:
    seen, told = view(monkeypatch, [5.0, 5.09, 5.11, 5.3])
    seen.consume(block(WRAP - 500, WRAP - 10, (4, 6)))
    assert told[0] == Live(0.0, 2.5, None, None)
    assert told[1] == Live(0.0, 2.5, 1.5, None)  # no time has gone yet
    seen.consume(block(0))
    assert len(told) == 2  # too soon
    seen.consume(block(500, 30, (2,)))
    assert (told[2].done_s, told[2].current_a) == (pytest.approx(1.0), 0.0)
    assert told[2].speed_rad_s == pytest.approx(40 * COUNT / 1.0)
    seen.consume(block(9000, 10, (0,)))
    assert told[3].done_s == 2.5  # never beyond the end
    assert told[3].current_a == -1.0
    assert told[3].speed_rad_s == pytest.approx(-20 * COUNT / 8.5)


def test_without_a_current_none_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    seen, told = view(monkeypatch, [5.0])
    alone = SampleBlock(0, 0, 0, 0, (Channel.POSITION,), np.zeros((1, 1), np.int16))
    seen.consume(alone)
    assert told[1].current_a is None
    seen.progress = None
    seen.consume(block(1))
    assert len(told) == 2
