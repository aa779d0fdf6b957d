"""One run of instruments, step by step, with a supply and a clock made for it."""

from __future__ import annotations

from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import pytest

from motorid.acquire.live import Live
from motorid.acquire.scpi.run import _Run
from motorid.program import Decay, Program, Step, StepKind
from tests.scpi.bench import SettableClock

SLOW = Decay.SYNCHRONOUS_SLOW
UP, DOWN = Step(StepKind.DRIVE_VOLTS, 0.5, 3.0, SLOW), Step(StepKind.DRIVE_VOLTS, 0.5, -1.0, SLOW)
REST = Step(StepKind.COAST, 0.25)


class Supply:
    """Notes what it is told; ``says`` what it limits, what tripped, whether it is on."""

    def __init__(self, limited: bool = False, tripped: str = "", on: bool = True) -> None:
        self.told: list[str] = []
        self.limited, self.tripped, self.is_on = (lambda: limited), (lambda: tripped), (lambda: on)

    def set(self, volts: float) -> None:
        self.told.append(f"set {volts:g}")

    def on(self) -> None:
        self.told.append("on")

    def off(self) -> None:
        self.told.append("off")


def made(
    *steps: Step, stop: bool = False, run_time_s: float = 9.0, **says: Any
) -> tuple[_Run, Supply, list[Live]]:
    supply, told = Supply(**says), list[Live]()
    rig = SimpleNamespace(
        limits=SimpleNamespace(run_time_s=run_time_s), sampling=SimpleNamespace(rate_hz=10.0)
    )
    bench: Any = SimpleNamespace(clock=SettableClock(), rig=rig, supply=supply, recorder=None)
    asked: Any = SimpleNamespace(requested=stop)
    return _Run(bench, Program(steps), asked, told.append), supply, told


def test_levels_are_set_before_the_output_is_on_and_a_coast_has_it_off() -> None:
    run, supply, told = made(REST, UP, DOWN, REST, REST)
    run.bench.clock.sleep(64.0)  # a computer's clock began long ago
    assert run._measure(None) == "completed"
    assert supply.told == ["set 3", "on", "set -1", "off"]
    assert [(one["step"], one["kind"], one["volts"]) for one in run.commanded] == [
        (0, "coast", None), (1, "drive_volts", 3.0), (2, "drive_volts", -1.0), (3, "coast", None),
        (4, "coast", None),
    ]  # fmt: skip
    begins = [one["host_s"] for one in run.commanded]
    assert begins == pytest.approx([0.0, 0.25, 0.75, 1.25, 1.5])
    assert run.limited == []
    assert {one.total_s for one in told} == {1.75}
    assert told[0].done_s == pytest.approx(0.02)
    gaps = [b.done_s - a.done_s for a, b in pairwise(told)]
    assert min(gaps) >= 0.1 - 1e-9  # ten times a second
    assert max(gaps) < 0.13
    assert max(one.done_s for one in told) <= 1.75


def test_no_time_beyond_the_end_is_shown() -> None:
    run, _, told = made(REST)
    run._show(7.0, None)
    run._show(7.05, None)
    assert told == [Live(0.25, 0.25, None, None)]
    poller: Any = SimpleNamespace(latest=lambda: (0.5, 30.0))
    run._show(7.2, poller)
    assert told[1] == Live(0.25, 0.25, 0.5, 30.0)
    run.progress = None
    run._show(9.0, None)
    assert len(told) == 2


@pytest.mark.parametrize(
    ("says", "reason"),
    [
        ({"tripped": "over-current"}, "fault: over-current"),
        ({"on": False}, "fault: output off"),
        ({"run_time_s": 0.1}, "fault: run_time"),
        ({"stop": True}, "interrupted"),
    ],
)
def test_why_a_run_ends_in_a_step(says: dict[str, Any], reason: str) -> None:
    run, _, _ = made(UP, DOWN, **says)
    assert run._measure(None) == reason
    assert len(run.commanded) == 1


def test_an_output_that_is_off_has_not_tripped() -> None:
    run, _, _ = made(REST, tripped="over-current", on=False)
    assert run._measure(None) == "completed"


def test_steps_in_which_the_current_was_limited_are_kept_once() -> None:
    run, _, _ = made(REST, UP, DOWN, limited=True)
    assert run._measure(None) == "completed"
    assert run.limited == [1, 2]


def test_a_step_that_begins_limited_is_kept_though_it_ends_otherwise() -> None:
    run, supply, _ = made(UP)
    answers = iter((True, False))
    supply.limited = lambda: next(answers)
    assert run._measure(None) == "completed"
    assert run.limited == [0]


def test_rows_are_asked_for_at_their_rate() -> None:
    run, _, _ = made(UP)
    clock: Any = run.bench.clock
    times: list[float] = []

    def row() -> None:
        times.append(clock.now())
        clock.sleep(0.03)

    poller: Any = SimpleNamespace(row=row, latest=lambda: (None, None))
    assert run._measure(poller) == "completed"
    assert times == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4], abs=1e-6)
