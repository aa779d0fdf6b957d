"""docs/board-safety.md: every transition, and the bridge open in every state but running."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from motorid.wire.enums import Fault, ResetCause, State, Status
from motorid.wire.spec import load
from tests.conformance.client import Client, Fields, Record

LONG = 4000  # samples
SILENCE_MS = 150
ABOVE = {"supply_min_mv": 999_999, "supply_max_mv": 1_000_000}  # a range above any supply
BELOW = {"supply_min_mv": 0, "supply_max_mv": 1}
IDLE, CONFIGURED, LOADED = State.IDLE, State.CONFIGURED, State.LOADED
RUNNING, ZEROING, FAULTED = State.RUNNING, State.ZEROING, State.FAULTED


class Rig:
    """A client, and the bridge behind it."""

    def __init__(self, board: Any) -> None:
        self.board = board
        self.client = Client(board.port)
        self.client.bring_up()

    def reach(self, state: State) -> None:
        """Brings a board that was just started into a state; running drives the motor."""
        client = self.client
        if state in (CONFIGURED, ZEROING):
            client.configure()
        if state is ZEROING:
            client.send("zero", samples=4096)
            client.wait(client.seconds(3))
        if state in (LOADED, RUNNING):
            hashes = client.load([client.drive(LONG)], host_silence_ms=SILENCE_MS)
            if state is RUNNING:
                client.get("start", **hashes)
                client.wait(client.seconds(20))
        if state is FAULTED:
            client.run(client.drive(LONG), run_time_limit_ms=5)
        assert client.state is state

    def check(self, state: State) -> None:
        """The state is this, and the bridge is as it must be."""
        assert self.client.state is state
        assert self.board.is_open() == (state is not RUNNING)


def act(name: str, /, **fields: Any) -> Callable[[Rig], None]:
    """A command that must be accepted."""

    def send(rig: Rig) -> None:
        assert rig.client.ask(name, **fields).status is Status.OK

    return send


def configure(rig: Rig) -> None:
    assert rig.client.configure().status is Status.OK


def add_step(rig: Rig) -> None:
    index = 1 if rig.client.state is LOADED else 0
    rig.client.get("add_step", index=index, **rig.client.coast(10))


def start(rig: Rig) -> None:
    rig.client.get("start", **rig.client.load([rig.client.drive(LONG)]))
    rig.client.wait(rig.client.seconds(3))


def zero_begins(rig: Rig) -> None:
    rig.client.send("zero", samples=4096)
    rig.client.wait(rig.client.seconds(3))


def zero_ends(rig: Rig) -> None:
    rig.client.wait(rig.client.seconds(4200))


def motion(rig: Rig) -> None:
    """The rotor still turns after a run, so the readings cannot be of a motor at rest."""
    client = rig.client
    client.run(client.drive(1000))
    assert client.ask("zero", samples=100).status is Status.NOT_AT_REST


def last_step(rig: Rig) -> None:
    record = rig.client.follow(Record(0))
    assert record.one("done")["reason"] == 0


def silence(rig: Rig) -> None:
    rig.client.wait(SILENCE_MS * 1e-3)
    assert rig.client.fault is Fault.HOST_SILENCE


def trip(fault: Fault, **changes: int) -> Callable[[Rig], None]:
    def run(rig: Rig) -> None:
        client = rig.client
        client.run(client.drive(LONG), **changes)
        assert client.fault is fault

    return run


def reset(rig: Rig) -> None:
    rig.board.reset(int(ResetCause.EXTERNAL))
    rig.client.wait(0.05)


def hang(rig: Rig) -> None:
    rig.board.reset(int(ResetCause.WATCHDOG))
    rig.client.wait(0.05)
    assert rig.client.fault is Fault.WATCHDOG


def clear_after_hang(rig: Rig) -> None:
    hang(rig)
    act("clear_fault")(rig)


class Transition(NamedTuple):
    """A row of the table in docs/board-safety.md."""

    before: State
    event: str
    after: State
    action: Callable[[Rig], None]
    needs_reset: bool = False


TRANSITIONS = [
    *(
        Transition(state, "`configure`", CONFIGURED, configure)
        for state in (IDLE, CONFIGURED, LOADED)
    ),
    *(Transition(state, "`add_step`", LOADED, add_step) for state in (CONFIGURED, LOADED)),
    *(
        Transition(state, "`clear_program`", CONFIGURED, act("clear_program"))
        for state in (CONFIGURED, LOADED)
    ),
    Transition(CONFIGURED, "`zero` begins", ZEROING, zero_begins),
    Transition(LOADED, "`zero` begins", ZEROING, zero_begins),
    Transition(ZEROING, "readings complete", CONFIGURED, zero_ends),
    Transition(ZEROING, "`stop`", CONFIGURED, act("stop")),
    Transition(LOADED, "`zero` sees the encoder move", LOADED, motion),
    Transition(LOADED, "`start`, both hashes right", RUNNING, start),
    Transition(RUNNING, "last step over", LOADED, last_step),
    Transition(RUNNING, "`stop`", LOADED, act("stop")),
    Transition(RUNNING, "no heartbeat for `host_silence_ms`", FAULTED, silence),
    *(
        Transition(state, f"`start`, then {words}", FAULTED, trip(fault, **changes))
        for state, words, fault, changes in (
            (LOADED, "current above its limit", Fault.OVER_CURRENT, {"current_limit_ma": 120}),
            (LOADED, "speed above its limit", Fault.OVER_SPEED, {"speed_limit_counts_s": 2000}),
            (LOADED, "supply below its limit", Fault.SUPPLY_LOW, ABOVE),
            (LOADED, "supply above its limit", Fault.SUPPLY_HIGH, BELOW),
            (LOADED, "longer than the run time", Fault.RUN_TIME, {"run_time_limit_ms": 5}),
        )
    ),
    Transition(FAULTED, "`clear_fault`", CONFIGURED, act("clear_fault")),
    *(
        Transition(state, "reset", IDLE, reset, needs_reset=True)
        for state in (IDLE, CONFIGURED, LOADED, RUNNING, ZEROING, FAULTED)
    ),
    *(
        Transition(state, "reset by the watchdog", FAULTED, hang, needs_reset=True)
        for state in (IDLE, RUNNING)
    ),
    Transition(
        IDLE, "reset by the watchdog, then `clear_fault`", IDLE, clear_after_hang, needs_reset=True
    ),
]


def ident(transition: Transition) -> str:
    return f"{transition.before.name.lower()}, {transition.event.replace('`', '')}"


def take(board: Any, transition: Transition) -> None:
    rig = Rig(board)
    rig.reach(transition.before)
    rig.check(transition.before)
    transition.action(rig)
    rig.check(transition.after)


@pytest.mark.needs("bridge", "exact", "fresh")
@pytest.mark.parametrize("transition", [t for t in TRANSITIONS if not t.needs_reset], ids=ident)
def test_a_transition_and_its_bridge(board: Any, transition: Transition) -> None:
    take(board, transition)


@pytest.mark.needs("bridge", "exact", "fresh", "reset")
@pytest.mark.parametrize("transition", [t for t in TRANSITIONS if t.needs_reset], ids=ident)
def test_a_reset_and_its_bridge(board: Any, transition: Transition) -> None:
    take(board, transition)


@pytest.mark.needs("bridge", "exact", "fresh")
@pytest.mark.parametrize("state", [IDLE, CONFIGURED, LOADED, ZEROING, FAULTED])
def test_no_wrong_start_closes_the_bridge(board: Any, state: State) -> None:
    """A start with hashes of another program or configuration, in every state that has a bridge
    to close; and every other command with fields of nothing but ones."""
    rig = Rig(board)
    rig.reach(state)
    spec = load()
    for name in spec.commands:
        if name in ("stop", "clear_fault", "clear_program", "identify"):
            continue  # these change the state, and open the bridge
        fields: Fields = {
            field.name: "1" if field.type == "text16" else 1 for field in spec.commands[name].fields
        }
        rig.client.send(name, **fields)
        rig.client.wait(rig.client.seconds(3))
        assert rig.board.is_open()


def test_the_page_has_every_transition(repo_root: Path) -> None:
    page = (repo_root / "docs" / "board-safety.md").read_text(encoding="utf-8").splitlines()
    for before, event, after, *_ in TRANSITIONS:
        row = f"| {before.name.lower()} | {event} | {after.name.lower()} |"
        assert row in page
