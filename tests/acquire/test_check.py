"""The weak pulses before a run, and a board whose messages are not ours."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from motorid.acquire import board, check
from motorid.acquire.check import DUTIES, weak_duties
from motorid.acquire.pulse import Pulse
from motorid.errors import DataError, LinkError, RigError
from tests.acquire.rigs import run, sim_rig


def test_pulses_rise_while_a_locked_motor_could_not_reach_the_limit() -> None:
    assert tuple(weak_duties(sim_rig(), 7.0)) == DUTIES


@pytest.mark.parametrize(("current_a", "whole"), [(0.4, 1), (0.8, 2)])
def test_the_last_pulse_is_at_four_fifths_of_the_limit(current_a: float, whole: int) -> None:
    rig = sim_rig()
    rig = replace(rig, limits=replace(rig.limits, current_a=current_a))
    *before, last = weak_duties(rig, 7.0)
    assert before == list(DUTIES[:whole])
    assert last * 7.0 / 2.6 == pytest.approx(0.8 * current_a, rel=1e-12)  # 2.6 ohm by the plate


def test_a_board_of_other_messages_is_told_from_one_of_another_version(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(board, "layout_hash", lambda: 1)
    with pytest.raises(LinkError, match=r"the board's messages differ .* rebuild its firmware"):
        run("", tmp_path / "run.h5")
    assert not (tmp_path / "run.h5").exists()


def test_a_serial_that_no_journal_could_hold_stops_the_run_before_it_begins(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    started: list[str] = []
    monkeypatch.setattr(board.Board, "identify", lambda self: started.append("identify"))
    with pytest.raises(DataError, match="what is told of this run is damaged: serial cannot be 5"):
        run("", tmp_path / "run.h5", serial=5)
    assert started == []
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "says"),
    [
        ("fault=stall", r"the open terminals show no voltage of a turning motor: free the shaft"),
        ("fault=encoder_dead", r"show [\d.]+ V of a turning motor: check the encoder's wires"),
    ],
)
def test_the_open_terminals_tell_a_seized_motor_from_a_dead_encoder(
    options: str, says: str, tmp_path: Path
) -> None:
    with pytest.raises(RigError, match=says):
        run(options, tmp_path / "run.h5")
    assert not (tmp_path / "run.h5").exists()


@pytest.mark.parametrize(("current_a", "known"), [(0.2, True), (-0.2, False), (1e-4, False)])
def test_only_a_clear_current_of_the_drive_bounds_the_resistance(
    current_a: float, known: bool
) -> None:
    shown = Pulse(0.1, 0.7, 100, current_a, 1e-3, abs(current_a) + 0.05, False, None)
    assert (check._bound(shown) is not None) == known
