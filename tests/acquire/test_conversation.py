"""The conversation of one run with its board, from who is there to its last tick, in its order."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from motorid.acquire import record as room
from motorid.acquire.interrupt import Stop
from motorid.errors import LinkError, RigError
from motorid.program import Rotor
from motorid.wire.enums import Mode
from tests.acquire.rigs import sim_rig

RIG = sim_rig()
HELD = replace(RIG.program, rotor=Rotor.CLAMPED)
IDENTITY = {"board": "bench", "clock_hz": 1_000_000, "min_sample_period_ticks": 50}
ZERO = {"current_offset": 4.0}
CONFIG = {"sample_period_ticks": 1000}
Call = tuple[str, tuple[Any, ...], dict[str, Any]]


class Talk:
    """A recorder whose every step is noted, with what it was given, and answers as told."""

    def __init__(self, patch: pytest.MonkeyPatch, program: Any = RIG.program, **more: Any) -> None:
        self.calls: list[Call] = []
        self.stop = Stop()
        self.board: Any = SimpleNamespace(
            identity=IDENTITY, descriptors={"supply_voltage": {}, "current": {}}, trip="",
            port=SimpleNamespace(now=lambda: 7.5),
        )  # fmt: skip
        self.journal: Any = SimpleNamespace(path="J")
        self.wire = SimpleNamespace(origin=[0, 1], ticks=50_999)
        self._patch = patch
        for name in ("identify", "make_ready", "ask_ticks", "check_same", "describe"):
            self.note(name, on=self.board)
        self.note("zero", ZERO, on=self.board)
        self.note("mark", on=self.journal)
        for name in (
            "refuse_coasts", "check_inputs", "check_zero", "check_program", "check_burst", "load",
            "refuse_other_board",
        ):  # fmt: skip
            self.note(name)
        self.note("streaming", "streamed")
        self.note("configure", CONFIG)
        self.note("check_supply", 7.0)
        self.note("check_signs", {"resistance_bound_ohm": 2.0, "by": "signs"})
        self.note("check_held", {"resistance_bound_ohm": 3.0, "by": "held"})
        self.note("sample_period", 1000)
        self.note("step_ticks", 2000)
        self.note("board_limit", {"speed_limit_counts_s": 9})
        self.note("signs", {"sign_check_ms": 5})
        self.note("is_fast", False)
        self.note("wire_program", self.wire)
        self.note("LiveView", SimpleNamespace(consume="viewed"))
        self.note("run_facts", "facts")
        self.note("both", "watched")
        self.note("drive", "completed")
        self.note("contradictions", ("one", "two"))
        self.made = room._Recorder(
            SimpleNamespace(name="port"), more.pop("rig", RIG), program, self.stop, None, **more  # type: ignore[arg-type]
        )  # fmt: skip

    def note(self, name: str, result: Any = None, on: Any = room) -> None:
        def called(*words: Any, **more: Any) -> Any:
            self.calls.append((name, words, more))
            return result() if callable(result) else result

        if on is room:
            self._patch.setattr(room, name, called)
        else:
            setattr(on, name, called)

    def run(self, *, checked: bool = False) -> str:
        return self.made._measure(self.board, self.journal, checked)

    def of(self, name: str) -> list[tuple[Any, ...]]:
        return [words for called, words, _ in self.calls if called == name]

    @property
    def names(self) -> list[str]:
        return [name for name, _, _ in self.calls]


def test_a_run_goes_from_who_is_there_to_its_last_ticks(monkeypatch: pytest.MonkeyPatch) -> None:
    talk = Talk(monkeypatch)
    assert talk.run() == "completed"
    order = [
        "identify", "make_ready", "streaming", "configure", "refuse_coasts", "check_inputs", "mark",
        "zero", "check_zero", "check_supply", "check_signs", "check_program", "wire_program",
        "check_burst", "configure", "check_same", "ask_ticks", "load", "mark", "drive", "ask_ticks",
    ]  # fmt: skip
    assert [name for name in talk.names if name in order] == order
    board, program = talk.board, RIG.program
    assert talk.of("configure") == [(board, "streamed"), (board, RIG)]
    assert talk.of("refuse_coasts") == [(board, program)]
    assert talk.of("check_zero") == [(ZERO, board.descriptors)]
    assert talk.of("check_supply") == talk.of("check_inputs") == [(board, RIG)]
    assert talk.of("check_signs") == [(board, RIG, CONFIG, ZERO, 7.0, talk.stop)]
    assert talk.of("step_ticks") == [(1000, IDENTITY)]
    assert talk.of("wire_program") == [(program, IDENTITY, 2000)]
    assert talk.of("check_burst") == [(RIG, talk.wire, IDENTITY, 1000)]
    assert talk.of("load") == [(board, talk.wire)]
    assert talk.of("LiveView") == [(RIG, board, ZERO, talk.wire, None)]
    assert talk.of("drive") == [(board, talk.wire, CONFIG, talk.stop, "watched")]
    assert talk.of("ask_ticks") == [(5,), (5,)]
    assert "describe" not in talk.names
    (bound,) = (more for name, _, more in talk.calls if name == "check_program")
    assert bound == {"resistance_ohm": 2.0, "supply_v": 7.0}
    ((zeroed, zero_mark), (begun, mark)) = (
        (words, more) for name, words, more in talk.calls if name == "mark"
    )
    assert zeroed == begun == (7.5,)
    assert zero_mark == {"zero_samples": 200}  # a fifth of a second at 1 kHz
    assert mark == {
        "measure": True, "wire_steps": [0, 1], "samples": 50, "supply_before_v": 7.0,
        "check": {"resistance_bound_ohm": 2.0, "by": "signs"},
    }  # fmt: skip
    assert talk.made.measuring
    assert not {"contradictions", "board_limit", "refuse_other_board"} & set(talk.names)


def test_sign_checks_of_the_board_are_for_the_run_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    talk = Talk(monkeypatch)
    talk.run()
    more = [facts for name, _, facts in talk.calls if name == "configure"]
    assert more == [{}, {"sign_check_ms": 5}]
    assert talk.of("signs") == [(RIG, IDENTITY, talk.board.descriptors)]


def test_watchers_are_given_what_the_readings_mean(monkeypatch: pytest.MonkeyPatch) -> None:
    talk = Talk(monkeypatch, watch=repr)
    talk.run()
    ((viewed, watch, facts),) = talk.of("both")
    assert (viewed, watch, facts()) == ("viewed", repr, "facts")
    assert talk.of("run_facts") == [(RIG, talk.board, CONFIG, ZERO)]


@pytest.mark.parametrize(("period", "samples"), [(40, 4096), (1000, 200), (62_500, 16)])
def test_a_zero_is_of_sixteen_to_4096_readings(
    period: int, samples: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    talk = Talk(monkeypatch)
    talk.note("configure", {"sample_period_ticks": period})
    talk.run()
    assert talk.of("zero") == [(samples,)]


def test_a_motor_that_was_checked_is_not_pulsed_again(monkeypatch: pytest.MonkeyPatch) -> None:
    talk = Talk(monkeypatch)
    talk.run(checked=True)
    assert "check_signs" not in talk.names
    (bound,) = (more for name, _, more in talk.calls if name == "check_program")
    assert bound["resistance_ohm"] is None
    assert [more["check"] for _, _, more in talk.calls if "check" in more] == [{}]


def test_a_stop_in_the_first_pulse_ends_it(monkeypatch: pytest.MonkeyPatch) -> None:
    talk = Talk(monkeypatch)
    talk.stop.requested = True
    assert talk.run() == "interrupted"
    assert not {"load", "drive", "wire_program"} & set(talk.names)
    assert not talk.made.measuring


@pytest.mark.parametrize(
    ("asked", "reason", "end"),
    [
        (True, "stopped", "interrupted"), (False, "stopped", "stopped"),
        (True, "completed", "completed"), (False, "fault: driver", "fault: driver"),
    ],
)  # fmt: skip
def test_a_stop_that_was_asked_for_interrupts(
    asked: bool, reason: str, end: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    talk = Talk(monkeypatch)

    def drives() -> str:
        talk.stop.requested = asked
        return reason

    talk.note("drive", drives)
    assert talk.run() == end
    assert len(talk.of("ask_ticks")) == (2 if reason == "completed" else 1)


def test_a_run_that_is_whole_stays_so(monkeypatch: pytest.MonkeyPatch) -> None:
    talk = Talk(monkeypatch)
    answers = iter((None, LinkError("gone")))

    def asks() -> None:
        if error := next(answers):
            raise error

    talk.note("ask_ticks", asks, on=talk.board)
    assert talk.run() == "completed"


def test_without_a_reading_of_the_supply_none_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    talk = Talk(monkeypatch, say=lambda text: None)
    del talk.board.descriptors["supply_voltage"]
    talk.run()
    assert all("supply_before_v" not in more for _, _, more in talk.calls)
    assert talk.of("contradictions")[0][4] is None


def test_what_rig_and_board_say_otherwise_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[str] = []
    talk = Talk(monkeypatch, say=said.append)
    talk.run()
    assert said == ["one", "two"]
    known = (IDENTITY, talk.board.descriptors)
    assert talk.of("contradictions") == [(RIG, RIG.program, *known, 7.0, 1000)]
    assert talk.names.index("contradictions") < talk.names.index("check_signs")


def test_a_fast_burst_has_facts_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    talk = Talk(monkeypatch)
    talk.note("is_fast", True)
    talk.run()
    assert talk.of("describe") == [(Mode.BURST,)]


# -- a rotor that is held
def test_a_held_rotor_is_limited_from_the_first_pulse_on(monkeypatch: pytest.MonkeyPatch) -> None:
    talk = Talk(monkeypatch, HELD)
    talk.run()
    assert "check_signs" not in talk.names
    assert talk.of("check_held") == [(talk.board, RIG, CONFIG, ZERO, 7.0, talk.stop)]
    more = [facts for name, _, facts in talk.calls if name == "configure"]
    assert more == [
        {"speed_limit_counts_s": 9}, {"speed_limit_counts_s": 9, "sign_check_ms": 5},
    ]  # fmt: skip
    assert talk.of("board_limit") == [("streamed", IDENTITY, 2000), (RIG, IDENTITY, 2000)]
    assert [more["check"]["by"] for _, _, more in talk.calls if "check" in more] == ["held"]


def test_a_held_rotor_that_creeps_ends_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    talk = Talk(monkeypatch, HELD)
    taken: list[str] = []
    most = 2 * max(3, round(RIG.wiring.counts_per_turn / 400))
    talk.note("both", lambda: lambda block: taken.append(block.position))

    def drives(board: Any, wire: Any, config: Any, stop: Any, consume: Any) -> str:
        for position in (100, 100 + most):
            consume(SimpleNamespace(position=position))
            assert not stop.requested
        consume(SimpleNamespace(position=101 + most))
        assert stop.requested
        return "stopped"

    monkeypatch.setattr(room, "drive", drives)
    with pytest.raises(RigError, match=f"the rotor crept by {most + 1} counts"):
        talk.run()
    assert taken == [100, 100 + most, 101 + most]


# -- a board that was calibrated
@pytest.mark.parametrize(("stated", "serial"), [("B9", "B9"), ("", "of the port")])
def test_a_calibration_is_of_one_board(
    stated: str, serial: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    file: Any = object()
    rig = replace(RIG, calibrated=file, board_serial=stated)
    talk = Talk(monkeypatch, rig=rig)
    talk.note("serial_of", "of the port")
    talk.run()
    assert talk.of("refuse_other_board") == [(file, "bench", serial)]
    assert talk.names.index("refuse_other_board") < talk.names.index("make_ready")
    again = Talk(monkeypatch, rig=rig)
    again.made.recorded = {"note": "a replay's"}
    again.run()
    assert "refuse_other_board" not in again.names
