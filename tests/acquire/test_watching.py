"""A scope's turns, each by itself: what it looks at, what it obeys, and what it says of either."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from motorid.acquire import scope as room
from motorid.acquire.controls import BUSY, Controls, Press
from motorid.acquire.scope import DONE, DRIVING, REFUSED, STOPPED, WATCHING, Scope
from motorid.errors import LinkError, RigError, UsageError
from motorid.program import Decay, Program, Rotor, Step, StepKind
from tests.acquire.rigs import sim_rig

RIG = sim_rig()
PROGRAM = Program((Step(StepKind.DRIVE_VOLTS, 0.2, 3.0, Decay.SYNCHRONOUS_SLOW),))
ZERO = {"current_offset": 4.0}
CONFIG = {"sample_period_ticks": 1000}


class Made(Scope):
    """A scope whose board, runs and settings are noted."""

    def __init__(self, patch: pytest.MonkeyPatch, rig: Any = RIG) -> None:
        self.did: list[Any] = []
        self.time, self.heard = 10.0, list[Any]()
        self.ends: list[Any] = []  # of the runs to come: a reason, or an error
        patch.setattr(room, "Board", self._board)
        patch.setattr(room, "streaming", lambda given, board: given)
        patch.setattr(room, "check_zero", lambda zero, known: self.did.append(("zero of", known)))
        patch.setattr(room, "configure", self._configure)
        super().__init__("port", rig, self._watch, Controls(), self._said)  # type: ignore[arg-type]

    def _board(self, port: Any) -> Any:
        self.did.append(port)
        named = {
            name: lambda *words, name=name: self.did.append((name, *words))
            for name in ("identify", "make_ready", "unlatch", "check_same")
        }
        return SimpleNamespace(
            **named, identity={"clock_hz": 1_000_000}, descriptors="known", trip="told",
            port=SimpleNamespace(now=lambda: self.time), wait=self._wait, zero=self._zero,
        )  # fmt: skip

    def _wait(self, seconds: float) -> None:
        self.did.append(("wait", seconds))

    def _zero(self, samples: int) -> Any:
        self.did.append(("zero", samples))
        return ZERO

    def _configure(self, board: Any, rig: Any, **more: int) -> Any:
        assert board is self.board
        self.did.append(("configure", rig.sampling.mode, more))
        return CONFIG

    def _watch(self, facts: Any) -> Any:
        self.heard.append(facts)
        return lambda block: self.heard.append(block)

    def _said(self, state: str, text: str) -> None:
        self.heard.append((state, text))


class Run(Made):
    """One whose runs end as told."""

    def _run(self, program: Any, stop: Any, seen: Any = None) -> str:
        self.did.append((program, stop.requested))
        self.seen = seen
        end = self.ends.pop(0)
        if isinstance(end, Exception):
            raise end
        return str(end)


@pytest.fixture
def scope(monkeypatch: pytest.MonkeyPatch) -> Run:
    made = Run(monkeypatch)
    made.did.clear()
    return made


def until(asked: bool = False) -> Any:
    return SimpleNamespace(requested=asked)


def test_it_begins_ready_with_limits_and_offsets(monkeypatch: pytest.MonkeyPatch) -> None:
    burst = replace(RIG, sampling=replace(RIG.sampling, mode="burst"))
    for rig in (RIG, burst):
        made = Made(monkeypatch, rig)
        assert made.did == [
            "port", ("identify",), ("make_ready",), ("configure", "stream", {}), ("zero", 200),
            ("zero of", "known"),
        ]  # fmt: skip
        assert (made.zero, made.config) == (ZERO, CONFIG)


@pytest.mark.parametrize(("period", "samples"), [(40, 4096), (1000, 200), (62_500, 16)])
def test_its_zero_is_of_a_fifth_of_a_second(period: int, samples: int, scope: Run) -> None:
    scope.config = {"sample_period_ticks": period}
    scope._zeroed()
    assert scope.did[0] == ("zero", samples)


# -- looking
@pytest.mark.parametrize(("limit_s", "seconds"), [(100.0, 60.0), (10.0, 9.0)])
def test_a_look_is_a_coast_within_the_rig_s_time(
    limit_s: float, seconds: float, scope: Run
) -> None:
    scope.rig = replace(RIG, limits=replace(RIG.limits, run_time_s=limit_s))
    scope.ends = ["completed"]
    scope._look(until())
    assert scope.did == [(Program((Step(StepKind.COAST, seconds),)), False)]
    assert scope.heard == []


@pytest.mark.parametrize("asked", [True, False])
def test_a_look_ends_for_a_press_or_with_the_scope(asked: bool, scope: Run) -> None:
    scope.ends = ["completed"]
    if not asked:
        assert scope.controls.offer(Press(PROGRAM, 60.0)) == ""
    scope._look(until(asked))
    assert scope.did[0][1] is True


def test_a_trouble_is_said_once_and_waited_out(scope: Run) -> None:
    scope.ends = ["fault: supply_low", "fault: supply_low", RigError("wrong")]
    scope._look(until())
    assert scope.did[1:] == [("wait", 1.0), ("unlatch",), ("configure", "stream", {})]
    ((state, said),) = scope.heard
    assert state == STOPPED
    assert said.startswith("the board tripped (supply_low: told)")
    scope._look(until())
    assert scope.heard == [(STOPPED, said)]
    scope._look(until())
    assert scope.heard[1:] == [(STOPPED, "wrong")]
    assert scope.did.count(("wait", 1.0)) == 3
    scope.ends = [LinkError("lost")]
    with pytest.raises(LinkError):
        scope._look(until())


def test_samples_say_that_it_watches(scope: Run) -> None:
    scope.ends, scope.latest = ["completed"] * 3, "stopped: x; "
    scope._look(until())
    scope.seen()
    scope.seen()
    assert scope.heard == [(WATCHING, "stopped: x; the bridge is open")]
    scope.trouble = scope.said = "wrong"
    scope._look(until())
    for scope.time in (10.0, 10.25):  # after a trouble for half a second
        scope.seen()
        assert (scope.trouble, len(scope.heard)) == ("wrong", 1)
    scope.time = 10.5
    scope.seen()
    assert (scope.trouble, len(scope.heard)) == ("", 2)


# -- obeying
def obeyed(scope: Run, end: Any, *, stop: str = "", asked: bool = False) -> list[Any]:
    """What is said of a press whose program ends so."""
    press = Press(PROGRAM, 60.0)

    def drive(program: Any, stopping: Any) -> str:
        assert program is PROGRAM
        if stop:
            press.stop(stop)
        assert stopping.requested is (asked or bool(stop))
        if isinstance(end, Exception):
            raise end
        return str(end)

    scope._drive = drive  # type: ignore[method-assign]
    scope._obey(press, until(asked))
    assert scope.did == [("unlatch",), ("configure", "stream", {})]
    assert (scope.said, scope.latest) == (scope.heard[0][1], f"{scope.heard[0][1]}; ")
    return scope.heard


def test_what_comes_of_a_press_is_said(scope: Run) -> None:
    assert obeyed(scope, "completed") == [(DONE, "the program is over")]


def test_a_press_that_is_stopped_says_by_whom(scope: Run) -> None:
    assert obeyed(scope, "stopped", stop="a hand") == [(STOPPED, "stopped: a hand")]


def test_a_scope_that_ends_stops_its_press(scope: Run) -> None:
    assert obeyed(scope, "stopped", asked=True) == [(STOPPED, "stopped: the scope ends")]


def test_a_press_that_trips_is_refused(scope: Run) -> None:
    ((state, said),) = obeyed(scope, "fault: over_current")
    assert (state, said[:41]) == (REFUSED, "the board tripped (over_current: told) an")


def test_a_press_that_cannot_be_driven_is_refused(scope: Run) -> None:
    assert obeyed(scope, RigError("too much")) == [(REFUSED, "too much")]


def test_a_board_that_is_lost_ends_the_scope(scope: Run) -> None:
    with pytest.raises(LinkError):
        obeyed(scope, LinkError("lost"))
    assert scope.heard == scope.did == []


def test_presses_are_taken_in_turn_and_their_place_is_free_again(scope: Run) -> None:
    turns: list[Any] = []
    press = Press(PROGRAM, 60.0)

    def look(end: Any) -> None:
        turns.append("look")
        if len(turns) == 1:
            assert scope.controls.offer(press) == ""

    def obey(found: Any, end: Any) -> None:
        turns.append(found)
        assert scope.controls.offer(Press(PROGRAM, 60.0)) == BUSY

    scope._look, scope._obey = look, obey  # type: ignore[method-assign]
    scope.run(until(), lambda: len(turns) == 3)
    assert turns == ["look", press, "look"]
    assert scope.controls.offer(press) == ""
    scope._obey = lambda found, end: 1 // 0  # type: ignore[method-assign, assignment]
    with pytest.raises(ZeroDivisionError):
        scope.run(until())
    assert scope.controls.offer(press) == ""
    turns.clear()
    scope.run(until(True))
    assert turns == []


# -- driving
def test_a_press_goes_through_the_checks_of_a_capture(
    scope: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    def note(name: str, result: Any = None) -> None:
        def called(*words: Any, **more: Any) -> Any:
            scope.did.append((name, *words, *more.items()))
            return result

        monkeypatch.setattr(room, name, called)

    for name in ("refuse_held", "check_program", "check_inputs"):
        note(name)
    note("check_supply", 7.0)
    note("check_signs", {"resistance_bound_ohm": 2.0})
    note("signs", {"sign_check_ms": 5})
    scope.ends = ["completed"]
    assert scope._drive(PROGRAM, until()) == "completed"
    board, rig = scope.board, scope.rig
    assert scope.did == [
        ("refuse_held", PROGRAM, "the scope"), ("check_program", rig, PROGRAM), ("make_ready",),
        ("configure", "stream", {}), ("check_inputs", board, rig), ("zero", 200),
        ("zero of", "known"), ("check_supply", board, rig),
        ("check_signs", board, rig, CONFIG, ZERO, 7.0, until()),
        ("check_program", rig, PROGRAM, ("resistance_ohm", 2.0), ("supply_v", 7.0)),
        ("signs", rig, board.identity, "known"), ("configure", "stream", {"sign_check_ms": 5}),
        ("check_same",), (PROGRAM, False),
    ]  # fmt: skip
    assert scope.heard == [(DRIVING, "checks, then the program")]
    scope.did.clear()
    assert scope._drive(PROGRAM, until(True)) == "stopped"
    assert scope.did[-1][0] == "check_signs"
    monkeypatch.undo()
    with pytest.raises(UsageError, match="the scope does not stop one that moves"):
        scope._drive(replace(PROGRAM, rotor=Rotor.CLAMPED), until())


def test_a_run_is_loaded_and_each_of_its_blocks_is_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    made = Made(monkeypatch)
    made.did.clear()
    stop = until()

    def drive(board: Any, wire: Any, config: Any, asked: Any, consume: Any) -> str:
        assert (board, wire, config, asked) == (made.board, "wire", CONFIG, stop)
        consume("block")
        return "completed"

    def wired(program: Any, identity: Any, period: int) -> str:
        assert (program, identity, period) == (PROGRAM, made.board.identity, 1000)
        return "wire"

    monkeypatch.setattr(room, "sample_period", lambda rig, identity: 1000)
    monkeypatch.setattr(room, "wire_program", wired)
    monkeypatch.setattr(room, "load", lambda *words: made.did.append(("load", *words)))
    monkeypatch.setattr(room, "run_facts", lambda *words: words)
    monkeypatch.setattr(room, "drive", drive)
    assert made._run(PROGRAM, stop, lambda: made.heard.append("seen")) == "completed"
    assert made.did == [("load", made.board, "wire")]
    assert made.heard == [(made.rig, made.board, CONFIG, ZERO), "block", "seen"]
