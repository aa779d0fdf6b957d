"""A log is cut where it pauses or its bridge opens; what is at rest beside a motion is left out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import Capture, Channel, Gap, Phase
from motorid.estimate.results.estimate import Diagnostic
from motorid.estimate.signals import log_sections
from motorid.estimate.signals.log_sections import FEWEST, PAUSE, driven, pieces, unbroken
from motorid.estimate.signals.opened_bridge import Opening
from motorid.program import Program, Step, StepKind


def log(*lengths: int, pause: float = 100.0) -> Capture:
    """Stretches of so many rows, a row a millisecond, so many periods between two of them."""
    begins = np.cumsum([0.0, *(n - 1 + pause for n in lengths[:-1])])
    rows = np.concatenate([b + np.arange(n) for b, n in zip(begins, lengths, strict=True)])
    volts = Channel("terminal_voltage", "V", np.arange(len(rows), dtype=float))
    return Capture(np.rint(1e3 * rows).astype(np.int64), 1e6, {"terminal_voltage": volts})


def test_no_piece_spans_a_pause_and_no_row_is_lost() -> None:
    capture = log(100, 80, 120)
    cut = unbroken([capture])
    assert [len(piece) for piece in cut] == [100, 80, 120]
    shown = np.concatenate([piece.channels["terminal_voltage"].values for piece in cut])
    np.testing.assert_array_equal(shown, capture.channels["terminal_voltage"].values)
    for piece in cut:
        assert np.ptp(np.diff(piece.ticks)) == 0


@pytest.mark.parametrize(("share", "count"), [(0.9, 1), (1.1, 2)])
def test_a_pause_is_of_several_periods(share: float, count: int) -> None:
    assert len(unbroken([log(100, 100, pause=share * PAUSE)])) == count


@pytest.mark.parametrize(("turns", "whole"), [(None, True), (True, False)])
def test_waiting_times_of_a_busy_computer_are_no_pauses_without_a_motion(
    turns: bool | None, whole: bool
) -> None:
    """A piece that begins while nobody sees the speed has to find that too."""
    capture = log(900) if turns is None else moving(turns, each=900)
    waits = 0.3 + np.random.default_rng(3).exponential(0.7, len(capture))
    ticks = np.rint(1e3 * np.cumsum(waits)).astype(np.int64)
    assert (len(unbroken([replace(capture, ticks=ticks)])) == 1) is whole
    ticks[450:] += round(1e3 * 5.0 * PAUSE)
    assert len(unbroken([replace(capture, ticks=ticks)])) >= 2


def test_a_stretch_too_short_for_a_beginning_of_its_own_is_left_out() -> None:
    assert [len(piece) for piece in unbroken([log(100, FEWEST - 1, 90)])] == [100, 90]
    assert [len(piece) for piece in unbroken([log(100, FEWEST, 90)])] == [100, FEWEST, 90]


def moving(*stretches: bool, each: int = 100) -> Capture:
    """Stretches in which the motor turns or rests, with a pause between two."""
    capture = log(*(each for _ in stretches))
    speed = np.concatenate([np.arange(each) * float(turns) for turns in stretches])
    channels = {**capture.channels, "speed": Channel("speed", "rad/s", speed)}
    return Capture(capture.ticks, capture.clock_hz, channels)


def test_a_rest_between_pauses_tells_nothing_beside_a_motion() -> None:
    capture = moving(True, False, True)
    assert [piece.ticks[0] for piece in unbroken([capture])] == [
        capture.ticks[0], capture.ticks[200],
    ]  # fmt: skip


@pytest.mark.parametrize(("steps", "kept"), [(1.0, 1), (1.5, 1), (1.6, 2)])
def test_a_count_that_flickers_is_at_rest(steps: float, kept: int) -> None:
    """A step of its channel, or half of one more, is no motion; without a step any change is."""
    capture = moving(True, False)
    speed = capture.channels["speed"]
    raw = speed.raw + np.where(np.arange(200) > 150, 0.5 * steps, 0.0)

    def log_of(resolution: float) -> Capture:
        channel = replace(speed, raw=raw, resolution=resolution)
        return replace(capture, channels={**capture.channels, "speed": channel})

    assert len(unbroken([log_of(0.5)])) == kept
    assert len(driven(log_of(0.5), [Opening(90, 110, 110)])) == kept
    assert len(unbroken([log_of(0.0)])) == 2


def test_a_motor_that_flickers_throughout_is_left_whole() -> None:
    capture = moving(False, False)
    flickers = replace(capture.channels["speed"], raw=np.arange(200) % 2 * 1.0, resolution=1.0)
    whole = replace(capture, channels={**capture.channels, "speed": flickers})
    assert [len(piece) for piece in unbroken([whole])] == [100, 100]


def test_a_motor_that_rests_throughout_is_left_whole() -> None:
    assert [len(piece) for piece in unbroken([moving(False, False)])] == [100, 100]


def test_a_rest_after_the_bridge_opened_is_left_out() -> None:
    capture = moving(True, True, False)
    kept = driven(capture, [Opening(110, 210, 210)])
    assert [(piece.ticks[0], len(piece)) for piece in kept] == [(0, 110)]


def opened(*openings: Opening, path: str = "") -> list[Diagnostic]:
    """What is said of a moving log of three stretches whose bridge was open there."""
    capture = replace(moving(True, True, True, each=200), path=path or None)
    capture = replace(capture, ticks=1000 * np.arange(600))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(log_sections, "openings", lambda _: list(openings))
        return log_sections.left_out([capture])


def test_what_an_open_bridge_leaves_out_is_said_with_its_times_and_its_share() -> None:
    (said,) = opened(Opening(150, 300, 270), path="run.csv")
    assert (said.code, said.severity) == ("bridge_open", "info")
    assert said.message.startswith("the bridge was open in run.csv at 0.15 to 0.269 s: no current")
    assert " motor. 20 % of the samples are left out" in said.message
    many = [Opening(60 * k + 40, 60 * k + 50, 60 * k + 50) for k in range(9)]
    (several,) = opened(*many)
    assert f" and {9 - log_sections.LISTED} more: no current" in several.message
    assert opened() == []


def test_a_bridge_that_opens_too_often_leaves_nothing_and_moves_everything() -> None:
    (said,) = opened(*(Opening(8 * k + 4, 8 * k + 8, 8 * k + 8) for k in range(74)))
    assert said.severity == "warning"
    assert "no stretch between is long enough to fit" in said.message
    assert said.moves == dict.fromkeys(("R", "L", "K", "B", "J", "T0"), np.inf)


def test_a_part_of_a_capture_keeps_the_gaps_within_it() -> None:
    capture = replace(log(100), gaps=tuple(Gap(k, 1, "lost") for k in (20, 40, 60, 80)))
    found = log_sections.part(capture, 20, 80)
    assert len(found) == 60
    assert [gap.index for gap in found.gaps] == [20, 40]
    assert found.ticks[0] == capture.ticks[20]


def test_a_rest_before_a_drive_belongs_to_it() -> None:
    capture = moving(True, True, True)
    kept = driven(capture, [Opening(110, 210, 150)])
    assert [(len(piece), int(piece.ticks[0])) for piece in kept] == [
        (110, int(capture.ticks[0])), (150, int(capture.ticks[150])),
    ]  # fmt: skip
    assert driven(capture, []) == [capture]


def test_a_short_capture_and_one_with_a_program_stay_whole() -> None:
    short = log(64, 63)
    assert unbroken([short]) == [short]
    assert len(unbroken([log(64, 64)])) == 2
    paused = log(100, 100)
    told = replace(paused, program=Program((Step(StepKind.COAST, 1.0),)), phases=(Phase(0, 0),))
    assert unbroken([told]) == [told]
    assert pieces([short, told]) == [short, told]


def bridges(patch: pytest.MonkeyPatch, *each: list[Opening]) -> list[Capture]:
    """Captures of 200 samples, and where the bridge of each was open."""
    captures = [replace(moving(True, each=200), path=f"{k}.csv") for k in range(len(each))]
    found = {one.path: openings for one, openings in zip(captures, each, strict=True)}
    patch.setattr(log_sections, "openings", lambda one: found[one.path])
    return captures


OFTEN = [Opening(8 * k, 8 * k + 4, 8 * k + 4) for k in range(25)]


def test_what_is_open_throughout_is_left_out_beside_what_is_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    captures = bridges(monkeypatch, OFTEN, [], [Opening(100, 120, 120)])
    assert [len(piece) for piece in pieces(captures)] == [200, 100, 80]
    said = log_sections.left_out(captures)
    assert [d.severity for d in said] == ["info", "info"]
    assert "open in 0.csv at" in said[0].message
    assert "open in 2.csv at 0.1 to 0.119 s" in said[1].message


def test_what_is_open_throughout_stays_where_nothing_else_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    captures = bridges(monkeypatch, OFTEN, OFTEN)
    assert pieces(captures) == captures
    assert [d.severity for d in log_sections.left_out(captures)] == ["warning"]


@pytest.mark.parametrize(("count", "more"), [(4, ""), (5, " and 1 more")])
def test_four_openings_are_listed(count: int, more: str) -> None:
    (said,) = opened(*(Opening(60 * k + 40, 60 * k + 50, 60 * k + 50) for k in range(count)))
    assert f"0.{60 * 3 + 49} s{more}: no current" in said.message
