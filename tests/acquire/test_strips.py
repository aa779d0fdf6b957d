"""What a viewer is shown: the capture's own readings, on one line of time, and no gap unseen."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.acquire import record, tap
from motorid.acquire.strips import Strip, Strips, joined
from motorid.acquire.tap import RunFacts, Scale, Tap
from motorid.capture import store
from motorid.wire.codec import SampleBlock
from motorid.wire.enums import Channel
from tests.acquire.rigs import SAMPLES, sim_rig

CHANNELS = (Channel.CURRENT, Channel.POSITION)
FACTS = RunFacts(
    1e6, 250, CHANNELS, (Scale("current", "A", 0.01, 512.0), Scale("position", "rad", 0.5))
)
WRAP = 1 << 32


def block(tick: int, current: list[int], counts: list[int]) -> SampleBlock:
    """Counts beyond 16 and 32 bits are sent as a board would."""
    low = np.array(counts, np.int64).astype(np.uint16).view(np.int16)
    samples = np.column_stack([np.array(current, np.int16), low])
    return SampleBlock(0, tick % WRAP, 0, counts[0] % WRAP, CHANNELS, samples)


def taken(strips: Strips, *blocks: SampleBlock, facts: RunFacts = FACTS) -> list[Strip]:
    return [s for b in blocks if (s := strips.take(facts, b)) is not None]


def row(strip: Strip, name: str) -> NDArray[np.float64]:
    return np.asarray(strip.values[strip.names.index(name)])


@pytest.mark.slow
def test_a_viewer_sees_what_the_capture_holds(tmp_path: Path) -> None:
    """Of two runs after one another, each sample with the value and the time of its file."""
    rig, watched = sim_rig(), Tap()
    paths = [tmp_path / "1.h5", tmp_path / "2.h5"]
    record.capture_all(rig, rig.program, paths, watch=watched.begin)
    strips = Strips()
    shown = list(joined(s for f, b in watched.taken() if (s := strips.take(f, b)) is not None))
    assert [strip.run for strip in shown] == [1, 2]
    for strip, path in zip(shown, paths, strict=True):
        kept = store.load(path)
        assert strip.values.shape == (4, SAMPLES)
        for name, channel in kept.channels.items():
            offset = row(strip, name)[0] if name == "position" else 0.0
            np.testing.assert_allclose(row(strip, name) - offset, channel.values, atol=1e-9)
        times = kept.ticks / kept.clock_hz
        assert strip.period_s == pytest.approx(times[1] - times[0])
    assert shown[1].start_s > shown[0].end_s
    assert watched.lost == 0


def test_ticks_and_counts_go_on_beyond_their_bits() -> None:
    strips = Strips()
    shown = taken(
        strips,
        block(WRAP - 500, [512, 612], [WRAP // 2 - 2, WRAP // 2 - 1]),
        block(WRAP, [412, 512], [WRAP // 2, WRAP // 2 + 1]),
    )
    (one,) = joined(shown)
    np.testing.assert_allclose(row(one, "current"), [0.0, 1.0, -1.0, 0.0])
    np.testing.assert_allclose(np.diff(row(one, "position")), 0.5)
    assert one.start_s == 0.0
    assert one.end_s == pytest.approx(1e-3)


def test_a_gap_parts_two_strips_and_speed_begins_anew() -> None:
    strips = Strips()
    count = round(0.01 / 250e-6)
    first = block(0, [512] * (count + 1), list(range(count + 1)))
    late = block(250 * (count + 3), [512] * (count + 1), list(range(100, 101 + count)))
    shown = list(joined(taken(strips, first, late)))
    assert [strip.values.shape[1] for strip in shown] == [count + 1, count + 1]
    for strip in shown:  # one count a sample, half a radian each
        speed = row(strip, "speed")
        assert np.isnan(speed[:-1]).all()
        assert speed[-1] == pytest.approx(0.5 / 250e-6)
    assert shown[1].start_s - shown[0].end_s == pytest.approx(2 * 250e-6)


def test_what_is_repeated_or_of_other_channels_is_not_shown() -> None:
    strips = Strips()
    one = block(1000, [512], [0])
    other = replace(one, first_tick=2000, channels=(Channel.CURRENT, Channel.SUPPLY_VOLTAGE))
    assert len(taken(strips, one, one, other)) == 1


def test_a_board_that_was_reset_goes_on_later() -> None:
    strips = Strips()
    again = replace(FACTS, clock_hz=FACTS.clock_hz)
    (before,) = taken(strips, block(5000, [512], [0]))
    (after,) = taken(strips, block(0, [512], [0]), facts=again)
    assert after.start_s > before.end_s
    assert (before.run, after.run) == (1, 2)


def test_a_viewer_that_is_late_loses_the_oldest_blocks_and_learns_how_many(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(tap, "MOST_BLOCKS", 3)
    watched = Tap()
    give = watched.begin(FACTS)
    for tick in range(0, 5 * 250, 250):
        give(block(tick, [512], [0]))
    assert [b.first_tick for _, b in watched.taken()] == [500, 750, 1000]
    assert watched.lost == 2
    assert not watched.waiting
