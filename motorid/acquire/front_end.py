"""Facts of a board's front end: shown, stored, and held against what a rig says of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from motorid.acquire.board import Board, Fields
from motorid.acquire.guards import has
from motorid.acquire.port import open_port
from motorid.capture.model import CURRENT
from motorid.errors import LinkError, RigError, UsageError
from motorid.program import Program, StepKind
from motorid.rig import Rig
from motorid.rig_front_end import GAIN_UNIT, ZERO_UNIT_V, FrontEnd, load_front_end
from motorid.wire.enums import Bridge, Feature, FrontEndSource, Sensor, State

STORES_S = 1.5  # EEPROM takes 3.4 ms a byte
SOURCES = {
    FrontEndSource.NONE: "none that are valid: it refuses to drive",
    FrontEndSource.COMPILED: "the firmware's own; nothing is stored",
    FrontEndSource.STORED: "stored",
}


def check(board: Board, rig: Rig) -> Fields:
    """Field of ``configure`` for the facts that the board holds; none where it stores none.

    Raises RigError where it holds others than the rig names, or none to drive with, or shows a
    current without a sign that the rig wants to record.
    """
    told = int(board.identity.get("front_end_hash", 0))
    if rig.front_end:
        _compare(board, rig, told)
    if not told:
        _demand_facts(board)
        return {}
    facts = board.ask("read_front_end")
    board.opens = facts["bridge"] != Bridge.PWM_DIR_BARE
    if facts["sensor"] == Sensor.MAGNITUDE and CURRENT in rig.sampling.channels:
        raise RigError(
            f"the board's front end ({facts['name']}) shows how much current flows and not its "
            "sign: it guards, and no fit can use it; leave current out of sampling.channels, or "
            "measure it in a motor lead"
        )
    return {"front_end_hash": told}


def drivable(rig: Rig, program: Program) -> Program:
    """``program`` with brakes for its coasts where the rig's driver cannot open the bridge."""
    if not rig.front_end:
        return program
    named = load_front_end(rig.front_end, Path(rig.folder) if rig.folder else None)
    return program.braked() if named.facts["bridge"] == Bridge.PWM_DIR_BARE else program


def refuse_coasts(board: Board, program: Program) -> None:
    """Raises RigError where ``program`` wants a bridge opened that its driver cannot open."""
    coasts = sum(step.kind is StepKind.COAST for step in program.steps)
    if coasts and not board.opens:
        raise RigError(
            f"the board's driver (PWM and direction alone) cannot open the bridge, and {coasts} of "
            "the program's steps coast: name its front end in the rig file (front_end = "
            '"…"), and motorid brakes there instead'
        )


def _compare(board: Board, rig: Rig, told: int) -> None:
    _need(board)
    wanted = load_front_end(rig.front_end, Path(rig.folder) if rig.folder else None)
    if told != wanted.hash:
        holds = board.ask("read_front_end")["name"] or "no valid facts"
        raise RigError(
            f"the rig names the front end {wanted.name}, and the board holds {holds}"
            f"{' with other figures' if holds == wanted.name else ''}: `motorid board set "
            f"{rig.front_end}` stores it, if that is what is wired"
        )


def _demand_facts(board: Board) -> None:
    """Raises RigError where a board that keeps facts has none: its readings have no scale yet."""
    if problem := bare(board):
        raise RigError(f"{board.port.name}: {problem}; `motorid board list` names some")


def _need(board: Board) -> None:
    if not has(board.identity, Feature.FRONT_END):
        raise RigError(
            f"the board {board.identity['board']} keeps no facts of its front end: install newer "
            "firmware, or build it with those of its shield (docs/front-ends.md)"
        )


def bare(board: Board) -> str:
    """A sentence where a board that should has no valid facts of its front end; else ""."""
    if not has(board.identity, Feature.FRONT_END):
        return ""
    if board.ask("read_front_end")["source"] != FrontEndSource.NONE:
        return ""
    return (
        f"the board {board.identity['board']} has no valid facts of its front end and refuses to "
        "drive: `motorid board set NAME` stores those of the parts that are wired"
    )


def show(url: str) -> Iterator[str]:
    """What the board behind a port holds, a line each. Raises LinkError, RigError."""
    return iter(_with(url, lambda board: _told(board, board.ask("read_front_end"))))


def store(url: str, front_end: FrontEnd, any_board: bool = False) -> list[str]:
    """Stores facts in the board behind a port, and reads them back.

    ``any_board``: those of another kind of board as well. Raises RigError where they are, where the
    board keeps none or refuses them; LinkError where it is lost, or holds others afterwards.
    """

    def put(board: Board) -> list[str]:
        if not any_board and (problem := front_end.misfit(str(board.identity["board"]))):
            raise RigError(
                f"{problem}: choose one that is made for it (motorid board list), or store this "
                "with --any-board, if that is what is wired"
            )
        _ready(board)
        board.ask("write_front_end", timeout_s=STORES_S, **front_end.facts)
        facts = board.ask("read_front_end")
        if facts["front_end_hash"] != front_end.hash:
            raise LinkError(f"{url}: the board holds other facts than were sent: try again")
        board.identify()  # its descriptors follow, and must be such as can be
        return _told(board, facts)

    return _with(url, put)


def _ready(board: Board) -> None:
    """Idle and without a latched fault: facts are written in no other state."""
    board.unlatch()
    if board.ask("read_status")["state"] != State.IDLE:
        raise UsageError(
            f"{board.port.name}: the board is configured for runs, and stores facts before that "
            "alone: reset it (its button, or its plug) and try again"
        )


def _with(url: str, do: Callable[[Board], list[str]]) -> list[str]:
    port = open_port(url)
    try:
        board = Board(port)
        board.identify()
        _need(board)
        return do(board)
    finally:
        port.close()


def _told(board: Board, facts: Fields) -> list[str]:
    who = board.identity
    source = FrontEndSource(facts["source"])
    head = [f"{who['board']}: facts of the front end are {SOURCES[source]}"]
    if source is FrontEndSource.NONE:
        return [*head, "`motorid board set NAME` stores them; `motorid board list` names some"]
    kind = {Sensor.MAGNITUDE: "no sign"}.get(facts["sensor"], "signed")
    follows = ", follows the reference" if facts["ratiometric"] else ""
    shares = [facts[f"{name}_gain_uncertainty"] * GAIN_UNIT for name in ("current", "voltage")]
    return [
        *head,
        f"name               {facts['name']}  (hash {facts['front_end_hash']:08x})",
        f"reference          {facts['reference_v']:g} V",
        f"current            {facts['current_v_a']:g} V/A, {facts['current_zero_v']:g} V at 0 A, "
        f"{kind}{follows}",
        f"   uncertainty     {shares[0]:.2%} of a reading, "
        f"{facts['current_zero_uncertainty'] * ZERO_UNIT_V:g} V of the zero (standard)",
        f"voltage            terminals 1/{facts['voltage_divider']:g}, supply "
        f"1/{facts['supply_divider']:g}, lifted by {facts['lift_v']:g} V",
        f"   uncertainty     {shares[1]:.2%} of a reading (standard)",
        f"filters            current {_filter(facts, 'current')}, voltages "
        f"{_filter(facts, 'voltage')}",
        f"bridge             {Bridge(facts['bridge']).name.lower()}",
        f"largest limit      {who['max_current_ma'] / 1e3:g} A",
    ]


def _filter(facts: Fields, name: str) -> str:
    first, second = facts[f"{name}_filter"] / 10, facts[f"{name}_filter2"] / 10
    if not first:
        return "none"
    return f"{first:g} us" + (f" (second order, {second:g} us)" if second else "")
