"""The second bench's own plant and chain, by finer steps and by closed forms."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bench.bench_stranger import Kept
from bench.mistakes.plant import Motor
from bench.stranger import edits
from bench.stranger.chain import driven, low_pass
from bench.stranger.drawn import MISTAKES, cases
from bench.stranger.logs import Edit
from bench.stranger.plant import Source, draw, turn

MOTOR = Motor(0.5, 1e-4, 0.038, 7e-5, 4e-5, 14e-3, 12.0)
DT = 2e-5


@pytest.mark.slow
def test_a_motor_that_turns_round_does_so_within_a_tick() -> None:
    wave = np.repeat([12.0, -12.0], 4000)  # by its end the start is forgotten
    coarse = turn(MOTOR, wave, DT, Source()).speed[4000:]
    fine = turn(MOTOR, np.repeat(wave, 16), DT / 16, Source()).speed[::16][4000:]
    assert coarse.min() < 0.0 < coarse.max()
    tick = 12.0 / MOTOR.R * MOTOR.K / MOTOR.J * DT  # rad/s, that speed changes by in one
    assert np.abs(coarse - fine).max() < 0.01 * tick


@pytest.mark.parametrize(("kind", "late"), [("RC", 1.0), ("2 RC", 2.0), ("Butterworth", 2.0**0.5)])
def test_a_low_pass_comes_as_late_as_its_coefficients_say(kind: str, late: float) -> None:
    tau_s = 20 * DT
    ramp = np.concatenate([np.zeros(1), np.arange(4000.0)]) * DT
    shown = low_pass(ramp, DT, tau_s, kind)
    assert ramp[-1] - shown[-1] == pytest.approx(late * tau_s, rel=1e-6)


def test_rows_of_the_same_commit_are_taken_again(tmp_path: Path) -> None:
    path = tmp_path / "kept.jsonl"
    Kept(path, "a").add("one", {"end": "named"})
    Kept(path, "b").add("two", {"end": "named"})
    with path.open("a", encoding="utf-8") as out:
        out.write('{"commit": "a", "log": "half')
    assert Kept(path, "a").rows == {"one": {"end": "named"}}
    assert Kept(path, "c").rows == {}


def test_rows_of_changed_files_are_not_taken_again(tmp_path: Path) -> None:
    path = tmp_path / "kept.jsonl"
    Kept(path, "a+").add("one", {"end": "named"})
    assert Kept(path, "a+").rows == {}


def test_a_jump_comes_later_in_its_sample_by_a_phase_or_by_chance() -> None:
    volts, rng = np.array([0.0, 0.0, 5.0, 5.0, np.nan]), np.random.default_rng(3)
    assert np.array_equal(driven(volts, 4, 0.0, rng), np.repeat(volts, 4), equal_nan=True)
    later = driven(volts, 4, 0.5, rng)
    assert np.flatnonzero(later == 5.0).tolist() == list(range(10, 18))
    begins = [np.flatnonzero(driven(volts, 100, None, rng) == 5.0)[0] for _ in range(200)]
    assert 200 <= min(begins) < 210
    assert 290 < max(begins) <= 300


def test_drawn_logs_have_each_mistake_in_turn_and_differ() -> None:
    count = 2 * len(MISTAKES)
    drawn = cases(count)
    assert len(drawn) == 2 * count
    for name in MISTAKES:
        assert sum(one.endswith(name) for one in drawn) == 2
    makers = [maker for name, (maker, _) in drawn.items() if name.startswith("good")]
    logs = []
    for seed, maker in enumerate(makers):
        rng = np.random.default_rng(seed)
        logs.append(maker(draw(rng), rng))
    assert len({log.drive for log in logs}) > 4
    assert {log.clock for log in logs} == {"exact", "jitter", "4 us", "busy PC"}


@pytest.mark.parametrize("name", list(MISTAKES))
def test_a_drawn_mistake_changes_its_log(name: str) -> None:
    makers = cases(len(MISTAKES))
    spoilt = next(maker for one, (maker, _) in makers.items() if one.endswith(name))
    logs = []
    for maker in (makers["good: drawn 0"][0], spoilt):
        rng = np.random.default_rng(3)
        logs.append(maker(draw(rng), rng))
    assert logs[0] != logs[1]


@pytest.mark.parametrize(
    ("edit", "moved"),
    [
        (edits.clipped(0.5), "i"),
        (edits.offset(0.1), "i"),
        (edits.turned("v"), "v"),
        (edits.held("w", 3), "w"),
        (edits.smoothed("i", 4), "i"),
    ],
)
def test_an_edit_changes_one_column(edit: Edit, moved: str) -> None:
    rows = np.arange(1.0, 41.0)
    whole = {"t": rows * DT, "v": rows, "i": rows / 40.0 * MOTOR.stall_a, "w": 9.0 * rows}
    spoilt = edit(whole, MOTOR)
    assert [c for c in whole if not np.array_equal(whole[c], spoilt[c])] == [moved]


def test_rows_that_are_gone_leave_even_stamps() -> None:
    rows = np.arange(200.0)
    left = edits.gone({"t": rows * DT, "v": rows}, MOTOR)
    assert len(left["t"]) == len(left["v"]) < 200
    np.testing.assert_allclose(np.diff(left["t"]), DT)
    assert np.diff(left["v"]).max() > 1.0
