"""A board that is watched: the bridge open, but for what is asked for within the rig's limits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from motorid.acquire import scope as scopes
from motorid.acquire.board import Board
from motorid.acquire.controls import BUSY, Controls, Press
from motorid.acquire.interrupt import Stop
from motorid.acquire.link import Port
from motorid.acquire.port import open_port
from motorid.acquire.scope import DONE, DRIVING, REFUSED, STOPPED, WATCHING, Scope
from motorid.acquire.strips import Strips
from motorid.acquire.tap import Tap
from motorid.errors import LinkError
from motorid.program import Decay, Program, Step, StepKind
from motorid.rig import Rig
from tests.acquire.rigs import sim_rig


def drive(volts: float, seconds: float = 0.2) -> Program:
    return Program((Step(StepKind.DRIVE_VOLTS, seconds, volts, Decay.SYNCHRONOUS_SLOW),))


class Watched:
    """A scope of a simulated rig, and what it did: kinds of steps loaded, sentences said."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, rig: Rig | None = None) -> None:
        self.tap, self.controls = Tap(), Controls()
        self.kinds: list[StepKind] = []
        self.said: list[tuple[str, str]] = []
        ask = Board.ask

        def spied(board: Board, name: str, /, *args: Any, **fields: Any) -> Any:
            if name == "add_step":
                self.kinds.append(StepKind(fields["kind"]))
            return ask(board, name, *args, **fields)

        monkeypatch.setattr(Board, "ask", spied)
        rig = rig or sim_rig()
        self.port: Port = open_port(rig.port)
        self.scope = Scope(self.port, rig, self.tap.begin, self.controls, self.say)
        self.on_say: Callable[[str], None] = lambda state: None

    def say(self, state: str, text: str) -> None:
        self.said.append((state, text))
        self.on_say(state)

    def run(self, seconds: float) -> None:
        until = self.port.now() + seconds
        self.scope.run(Stop(), lambda: self.port.now() >= until)

    @property
    def states(self) -> list[str]:
        return [state for state, _ in self.said]


def patient(program: Program) -> Press:
    return Press(program, 60.0)


@pytest.mark.slow
def test_without_a_press_the_bridge_never_closes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Beyond the longest run that the rig allows, so that one run follows another."""
    rig = sim_rig()
    rig = replace(rig, limits=replace(rig.limits, run_time_s=0.5))
    watched = Watched(monkeypatch, rig)
    watched.run(1.2)
    assert watched.states == [WATCHING]
    assert len(watched.kinds) >= 3
    assert set(watched.kinds) == {StepKind.COAST}
    strips = Strips()
    shown = [s for f, b in watched.tap.taken() if (s := strips.take(f, b)) is not None]
    assert shown[-1].end_s > 1.0
    assert max(abs(s.values[s.names.index("current")]).max() for s in shown) < 0.05


@pytest.mark.slow
def test_a_press_drives_once_after_the_checks_of_a_capture(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    watched = Watched(monkeypatch)
    assert watched.controls.offer(patient(drive(3.0))) == ""
    assert watched.controls.offer(patient(drive(3.0))) == BUSY
    watched.run(3.0)
    assert watched.states == [DRIVING, DONE, WATCHING]
    assert watched.kinds.count(StepKind.DRIVE_VOLTS) == 1
    assert StepKind.DRIVE_DUTY in watched.kinds  # the weak pulse before it
    assert watched.controls.offer(patient(drive(3.0))) == ""  # the desk is free


@pytest.mark.parametrize(
    ("program", "why"),
    [
        (drive(6.9), "limits.current_a"),
        (drive(100.0), "the supply has"),
        (drive(1.0, 100.0), "limits.run_time_s"),
    ],
)
def test_what_could_pass_a_limit_is_refused_before_anything_turns(
    program: Program, why: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig = sim_rig()
    rig = replace(rig, limits=replace(rig.limits, current_a=2.4))
    watched = Watched(monkeypatch, rig)
    watched.controls.offer(patient(program))
    watched.run(0.5)
    assert watched.said[0][0] == REFUSED
    assert why in watched.said[0][1]
    assert set(watched.kinds) == {StepKind.COAST}
    assert why in watched.said[1][1]  # and stays to be read


@pytest.mark.slow
@pytest.mark.parametrize("after", [0, 1], ids=["in the checks", "in the program"])
def test_a_stop_ends_the_program(after: int, monkeypatch: pytest.MonkeyPatch) -> None:
    watched = Watched(monkeypatch)
    rest = watched.scope._run

    def stopping(*args: Any) -> str:
        watched.controls.stop("the page asked for it")
        return rest(*args)

    if after:
        monkeypatch.setattr(watched.scope, "_run", stopping)
    else:
        watched.on_say = lambda state: watched.controls.stop("a hand") if state == DRIVING else None
    watched.controls.offer(patient(drive(3.0, 5.0)))
    watched.run(2.5)
    assert watched.states[:2] == [DRIVING, STOPPED]
    assert watched.port.now() < 5.0


def test_a_silent_viewer_is_a_stop() -> None:
    now = 10.0
    press = Press(drive(1.0), 0.5, clock=lambda: now)
    now += 0.4
    assert not press.requested
    press.hear()
    now += 0.4
    assert not press.requested
    now += 0.2
    assert press.requested
    press.hear()  # too late
    assert press.requested
    assert press.why == "the page was silent for 0.5 s"


def test_a_rig_that_cannot_run_is_said_once_and_tried_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Its supply is off: the board trips on each run, and the scope goes on."""
    rig = sim_rig("supply=3.0")
    monkeypatch.setattr(scopes, "AGAIN_S", 0.1)
    watched = Watched(monkeypatch, rig)
    watched.run(1.0)
    assert watched.states == [WATCHING, STOPPED]  # samples come before the trip
    assert "supply" in watched.said[1][1]
    assert len(watched.kinds) >= 3


@pytest.mark.slow
def test_a_lost_board_ends_the_scope(monkeypatch: pytest.MonkeyPatch) -> None:
    watched = Watched(monkeypatch, sim_rig("fault=unplug@1.0"))
    with pytest.raises(LinkError):
        watched.run(3.0)
