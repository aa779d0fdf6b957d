"""A capture out of a journal's records, each made by hand: what counts, and what does not."""

from __future__ import annotations

import math
from typing import Any

import pytest

from motorid.acquire.assemble import AFTER_RESET, UNREAD, NoPlaceError, NoSamplesError, listed
from motorid.acquire.clock import Pair
from motorid.acquire.journal import Kind, Record
from motorid.acquire.timeline import LOST, MISSING_END, OFF_GRID
from motorid.capture.model import Gap, Phase
from motorid.errors import DataError
from motorid.wire.enums import Channel, EndReason, Fault, ResetCause, Status
from motorid.wire.framing import encode
from motorid.wire.spec import load
from tests.acquire.journals import (
    BEFORE,
    BEGUN,
    CONFIG,
    CURRENT_FACT,
    IDENTITY,
    PROGRAM,
    SAMPLES,
    asked,
    assembled,
    block,
    came,
    done,
    event,
    mark,
    reply,
    sent,
)

WHOLE = (block(0, 4, 6, 8, 10), block(4, 12, 14, 16, 18))
DAMAGED = Record(Kind.RECEIVED, 0.0, b"\x03ab\0")
BLOCK = load().events["sample_block"].code


def test_a_run_becomes_a_capture() -> None:
    phases = [event("phase", index=n, tick=tick) for n, tick in ((0, 0), (1, 2000), (2, 5000))]
    made = assembled(*BEGUN, *phases, *WHOLE, done(blocks=2, samples=8))
    run = made.capture()
    assert run.ticks.tolist() == [1000 * n for n in range(8)]
    current, position = run.channels["current"], run.channels["position"]
    assert current.values.tolist() == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]  # .5 (raw - 4)
    assert position.values == pytest.approx([2 * math.pi * n / 400 for n in range(8)])
    assert current.noise == 0.25  # of the reply to zero
    assert (run.clock_hz, run.clock_uncertainty) == (1e6, pytest.approx(3e-4 / math.sqrt(3)))
    assert (run.wiring.counts_per_turn, run.wiring.pwm_hz) == (400.0, 20_000.0)
    assert run.wiring.dead_time_s == pytest.approx(1.5e-6)
    assert run.program == PROGRAM
    assert run.phases == (Phase(0, 0), Phase(1, 2000))  # the third goes on with the second step
    assert (run.gaps, run.end_reason) == ((), "completed")
    assert (run.ambient_c, run.ambient_uncertainty_c) == (21.5, 0.5)
    kept = run.provenance
    assert (kept["rig_name"], kept["note"], "wiring" in kept) == ("bench", "by hand", False)
    assert kept["identity"]["board"] == "bench"
    assert kept["configuration"]["sample_period_ticks"] == 1000
    assert set(kept["descriptors"]) == {"current", "position"}
    assert (kept["zero"]["current_offset"], kept["check"]) == (4.0, {"duty": 0.1})
    assert kept["link"]["done"]["samples"] == 8
    assert {name: kept["link"][name] for name in ("bad_frames", "blocks", "repeated_blocks")} == {
        "bad_frames": 0, "blocks": 2, "repeated_blocks": 0,
    }  # fmt: skip
    assert not {"clock", "front_end", "supply_before_v"} & set(kept)
    assert made.remarks() == []


# -- what was answered
def test_a_reply_counts_once_where_it_was_asked_for_and_given() -> None:
    config = CONFIG | {"sample_period_ticks": 77}
    made = assembled(
        reply("read_config", 9, **config),  # nobody asked
        sent("read_config", 10),
        reply("read_config", 9, **config),  # for another one
        reply("read_config", 10, Status.BAD_STATE),
        reply("read_config", 10, **CONFIG),
        reply("read_config", 10, **config),  # a second one
        sent("describe_channel", 11),
    )
    assert made.replies["read_config"]["sample_period_ticks"] == 1000
    assert set(made.replies) == {"read_config"}


def test_what_a_run_rests_on_was_told_before_it() -> None:
    made = assembled(
        *BEGUN,
        *asked("zero", 20, current_offset=9.0),
        *asked("describe_channel", 21, channel=Channel.SUPPLY_VOLTAGE, scale=1.0),
        *asked("read_config", 22, sample_period_ticks=77),
        mark(measure=True, samples=2),  # a second beginning is none
        *WHOLE,
    )
    assert made.replies["zero"]["current_offset"] == 4.0
    assert made.replies["read_config"]["sample_period_ticks"] == 1000
    assert set(made.descriptors) == {"current", "position"}
    assert made.timeline is not None
    assert made.timeline.limit == SAMPLES
    assert "stop" not in assembled(*BEFORE, *asked("stop", 7)).replies


def test_a_tick_was_asked_for_when_its_question_first_went_out() -> None:
    def status(request: int, tick: int, at_s: float) -> Record:
        return reply("read_status", request, at_s=at_s, tick=tick)

    made = assembled(
        sent("read_status", 1, 1.0), sent("read_status", 1, 1.25), status(1, 10, 1.5),
        sent("read_status", 2, 2.0), sent("read_status", 3, 2.25), status(3, 20, 2.5),
        *BEGUN,
        sent("read_status", 4, 4.0), status(4, 40, 4.5),
        event("hello", reset_cause=ResetCause.EXTERNAL),
        sent("read_status", 5, 5.0), status(5, 50, 5.5),
    )  # fmt: skip
    assert made._ticks == (
        [Pair(10, 1.0, 1.5), Pair(20, 2.25, 2.5)],
        [Pair(40, 4.0, 4.5)],
    )


@pytest.mark.parametrize(("host", "step_s"), [({}, 0.0), ({"clock_resolution_s": 0.5}, 0.5)])
def test_a_clock_is_as_sure_as_this_computer_s(host: dict[str, float], step_s: float) -> None:
    """To 100 ppm at most, and to its own steps over the 99 s between first and last question."""

    def question(second: int) -> list[Record]:
        fields = {"tick": 1_000_000 * second, "at_s": float(second)}
        return [sent("read_status", second, float(second)), reply("read_status", second, **fields)]

    early = [one for second in range(5) for one in question(second)]
    late = [one for second in range(95, 100) for one in question(second)]
    run = assembled(*early, *BEGUN, *WHOLE, *late, host=host).capture()
    found = run.provenance["clock"]
    assert (found["rate"], found["pairs"]) == (pytest.approx(1.0), 10)
    by_steps = step_s / math.sqrt(6) / 99
    assert found["uncertainty"] == pytest.approx(math.hypot(1e-4 / math.sqrt(3), by_steps))


# -- what was damaged
def test_frames_that_cannot_be_read_are_counted_in_the_run_alone() -> None:
    unread = came(bytes([BLOCK, 1, 2]))
    other = came(bytes([0x7E, BLOCK]))
    made = assembled(*BEFORE, DAMAGED, unread, *BEGUN, DAMAGED, unread, unread, other, *WHOLE)
    assert made.bad_frames == 4
    assert made.unplaced() == {UNREAD: 2}
    found = made.capture().provenance["link"]
    assert (found["bad_frames"], found["unplaced_samples"]) == (4, {UNREAD: 2})
    (said,) = made.remarks()
    assert said.endswith("which stays as .raw: 2 blocks that this version cannot read")


def test_what_comes_after_a_reset_is_of_no_run() -> None:
    hello = event("hello", reset_cause=ResetCause.BROWN_OUT)
    made = assembled(*BEGUN, WHOLE[0], hello, block(4, 1, 2, 3), done(), mark(end="link lost"))
    assert made.unplaced() == {AFTER_RESET: 3}
    assert (made.end_reason(), made.done, made.over) == ("reset: brown_out", None, True)
    assert len(made.capture()) == 4


@pytest.mark.parametrize(
    ("records", "says", "kind"),
    [
        ([], "not one sample of the run arrived: there is nothing to keep", NoSamplesError),
        ([DAMAGED, DAMAGED], "arrived whole: 2 damaged frames came", NoPlaceError),
        (
            [block(0, 1, 2, first_tick=500), block(0, 1, 2, first_tick=1)],  # of no common grid
            "not one sample has a place in the run: ",
            NoPlaceError,
        ),
    ],
)
def test_why_there_is_no_run(records: list[Record], says: str, kind: type[DataError]) -> None:
    made = assembled(*BEGUN, *records)
    with pytest.raises(kind, match=says):
        made.capture()


def test_before_its_beginning_there_is_no_run() -> None:
    with pytest.raises(NoSamplesError, match="nothing to keep"):
        assembled(*BEFORE).capture()
    with pytest.raises(DataError, match="before a configuration was in force"):
        assembled(mark(measure=True, samples=8))
    assert listed({"a": 1, "b": 2}) == "1 a, 2 b"


# -- how it ended
FAULTED = event("fault", fault=Fault.OVER_CURRENT)


@pytest.mark.parametrize(
    ("records", "reason"),
    [
        ([], "interrupted"),
        ([FAULTED], "fault: over_current"),
        ([done(EndReason.STOPPED)], "stopped"),
        ([done()], "completed"),
        ([FAULTED, done(EndReason.FAULT)], "fault: over_current"),
        ([done(EndReason.FAULT)], "fault: unknown"),
        ([done(), FAULTED, event("hello"), done(EndReason.STOPPED)], "completed"),
        ([mark(end="link lost"), done()], "link lost"),
    ],
)
def test_why_a_run_ended(records: list[Record], reason: str) -> None:
    before = [FAULTED, event("hello"), done(EndReason.STOPPED)]  # of an earlier run
    made = assembled(*BEFORE, *before, *BEGUN, WHOLE[0], *records)
    assert made.end_reason() == reason
    assert made.capture().end_reason == reason


@pytest.mark.parametrize(
    ("records", "missing"),
    [
        ([], 0),
        ([done(samples=4)], 4),
        ([done(EndReason.STOPPED, samples=4, dropped=0)], 0),
        ([done(EndReason.STOPPED, samples=6)], 2),
        ([done(EndReason.STOPPED, samples=99)], 4),
        ([mark(end="completed")], 4),
        ([mark(end="link lost")], 0),
    ],
)
def test_what_is_missing_at_the_end(records: list[Record], missing: int) -> None:
    run = assembled(*BEGUN, WHOLE[0], *records).capture()
    assert run.gaps == ((Gap(4, missing, MISSING_END),) if missing else ())


def test_what_the_board_dropped_counts_as_taken() -> None:
    run = assembled(*BEGUN, WHOLE[0], done(EndReason.STOPPED, samples=4, dropped=3)).capture()
    assert [gap.samples for gap in run.gaps] == [3]
    assert "dropped" in run.gaps[0].reason
    lost = assembled(*BEGUN, WHOLE[1], done()).capture()
    assert lost.gaps == (Gap(0, 4, LOST),)


def test_steps_without_a_list_are_the_wire_s() -> None:
    begun = [*BEFORE, mark(measure=True, samples=8), *asked("start", 6, start_tick=0)]
    phases = [event("phase", index=n, tick=2000 * n) for n in range(3)]
    run = assembled(*begun, *phases, *WHOLE).capture()
    assert run.phases == (Phase(0, 0), Phase(1, 2000), Phase(2, 4000))


# -- what is said of it
def test_a_wrong_word_on_the_beginning_is_said() -> None:
    begun = [*BEGUN[:-2], *asked("start", 6, start_tick=77)]
    made = assembled(*begun, *WHOLE, done())
    assert len(made.capture()) == 8
    (said,) = made.remarks()
    assert said.startswith("the board named tick 77 as the run's first, which fits none of its")


def test_offsets_that_are_no_readings_are_not_used() -> None:
    bad = [*BEGUN[:8], *asked("zero", 5, current_noise=-1.0), *BEGUN[10:]]
    made = assembled(*bad, *WHOLE, done())
    run = made.capture()
    assert run.channels["current"].offset == 3.0  # the descriptor's
    assert run.provenance["zero"] == {}
    assert made.remarks() == [
        "the board's reply to zero holds no readings: the nominal offsets are used"
    ]
    without = assembled(*BEGUN[:8], *BEGUN[10:], *WHOLE, done())
    without.capture()
    assert without.remarks() == []


@pytest.mark.parametrize(
    ("fact", "says"),
    [
        (None, "the board never described its channel current"),
        (CURRENT_FACT | {"scale": 0.0}, r"describes its channel current with scale = 0\.0"),
    ],
)
def test_a_channel_needs_its_description(fact: Any, says: str) -> None:
    described = [] if fact is None else asked("describe_channel", 2, **fact)
    made = assembled(*BEGUN[:2], *described, *BEGUN[4:], *WHOLE)
    with pytest.raises(DataError, match=says):
        made.capture()


@pytest.mark.parametrize(("least", "noise"), [(1000, 0.25), (1001, 0.375)])
def test_a_fast_burst_has_the_descriptor_s_noise_where_that_is_more(
    least: int, noise: float
) -> None:
    identity = IDENTITY | {"min_sample_period_ticks": least}
    made = assembled(*asked("identify", 1, **identity), *BEGUN[2:], *WHOLE)
    assert made.capture().channels["current"].noise == noise


def test_many_readings_make_an_offset_surer() -> None:
    known = {"current": {"gain": 2.0, "offset_uncertainty": None}}
    run = assembled(*BEGUN, *WHOLE, zero_samples=1, calibration=known).capture()
    many = assembled(mark(zero_samples=25), *BEGUN, *WHOLE, calibration=known).capture()
    one, other = (found.channels["current"] for found in (run, many))
    assert one.scale == other.scale == 1.0
    assert one.offset_uncertainty == pytest.approx(5 * other.offset_uncertainty)


@pytest.mark.parametrize(
    ("facts", "kept", "follows"),
    [
        ({"front_end_hash": 7, "ratiometric": 1}, True, True),
        ({"front_end_hash": 7}, True, False),
        ({"ratiometric": 1}, False, False),  # the firmware's own
    ],
)
def test_a_front_end_s_facts_are_kept_where_they_are_stored(
    facts: dict[str, int], kept: bool, follows: bool
) -> None:
    run = assembled(*asked("read_front_end", 9, **facts), *BEGUN, *WHOLE).capture()
    assert ("front_end" in run.provenance) is kept
    assert run.channels["current"].ratiometric is follows
    assert not run.channels["position"].ratiometric


def test_a_frame_in_two_pieces_is_one() -> None:
    (first, second), data = WHOLE, b""
    data = first.data + second.data
    pieces = [Record(Kind.RECEIVED, 0.0, part) for part in (data[:9], data[9:30], data[30:])]
    assert len(assembled(*BEGUN, *pieces).capture()) == 8
    question = encode(b"\x7f\x01\x00")  # no command that is known
    odd = [Record(Kind.SENT, 0.0, question), Record(Kind.SENT, 0.0, b"\x09\0")]
    assert len(assembled(*odd, *BEGUN, *WHOLE).capture()) == 8


def test_samples_off_the_grid_stay_in_the_journal() -> None:
    made = assembled(*BEGUN, WHOLE[0], block(4, 1, 2, first_tick=4001))
    assert made.unplaced() == {OFF_GRID: 2}
    assert made.capture().provenance["link"]["impossible_blocks"] == 1
