"""Random fault schedules keep the three laws; and a capture path that broke one would be seen."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from motorid.acquire.timeline import Timeline
from motorid.sim.run import Run
from tests.faults.laws import run
from tests.faults.schedule import draw

FIRST = (11, 21, 31)  # of ten seeds each; among them is every fault
FURTHER = (1, 41, 51)
FAULTS = ("flip", "drop", "insert", "double", "silence", "deaf", "mute", "delay", "burst", "split",
          "unplug", "reset", "swap", "brownout", "stall", "kill -9", "ctrl-c", "power failure",
          "full disk")  # fmt: skip
QUIET = replace(
    draw(1),
    link="",
    board="",
    host="runs",
    long=False,
    options="seed=1&speed=max",
    rate_hz=10_000,
    channels=3,
    mode="stream",
    host_silence_s=0.5,
)


def test_a_seed_is_a_schedule() -> None:
    assert draw(7) == draw(7) != draw(8)
    drawn = [draw(seed) for seed in range(300)]
    said = " ".join(s.link + " " + s.board + " " + s.host for s in drawn)
    assert [fault for fault in FAULTS if fault not in said] == []


def test_every_fault_befalls_a_capture_in_every_run_of_the_tests() -> None:
    tried = [draw(seed) for first in FIRST for seed in range(first, first + 10)]
    said = " ".join(s.link + " " + s.board + " " + s.host for s in tried)
    assert [fault for fault in FAULTS if fault not in said] == []


@pytest.mark.slow
def test_without_faults_everything_is_kept(tmp_path: Path) -> None:
    outcome = run(QUIET, tmp_path)
    assert (outcome.exit_code, outcome.broken) == (0, [])
    assert outcome.sent == outcome.read == outcome.kept == 3800


@pytest.mark.slow
@pytest.mark.parametrize(
    "first", [*FIRST, *(pytest.param(first, marks=pytest.mark.study) for first in FURTHER)]
)
def test_the_laws_hold(first: int, tmp_path: Path) -> None:
    for seed in range(first, first + 10):
        folder = tmp_path / str(seed)
        folder.mkdir()
        outcome = run(draw(seed), folder)
        assert outcome.broken == [], f"{draw(seed)}: {outcome.says}"
        assert outcome.exit_code in (0, 3, 4, 130, -9)
        assert "\n" not in outcome.says


@pytest.mark.slow
def test_a_lost_block_is_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    add = Timeline.add
    monkeypatch.setattr(Timeline, "add", lambda s, b: add(s, b) if b.sequence != 50 else None)
    assert [law[0] for law in run(QUIET, tmp_path).broken] == ["3"]


@pytest.mark.slow
def test_a_displaced_sample_is_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    add = Timeline.add

    def displaced(self: Timeline, block: Any) -> None:
        late = replace(block, first_tick=block.first_tick + 1600 * (block.sequence == 50))
        add(self, late)

    monkeypatch.setattr(Timeline, "add", displaced)
    assert [law[0] for law in run(QUIET, tmp_path).broken] == ["2"]


@pytest.mark.slow
def test_a_motor_left_on_is_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Run, "_trip", lambda self, tick: None)
    gone = replace(QUIET, link="unplug@1.1", long=True)
    assert [law[0] for law in run(gone, tmp_path).broken] == ["1"]


@pytest.mark.slow
def test_late_writes_are_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("motorid.acquire.journal_writer.SYNC_S", 60.0)
    died = replace(QUIET, host="power failure", host_at_s=2.2, long=True)
    assert [law[0] for law in run(died, tmp_path).broken] == ["3"]
