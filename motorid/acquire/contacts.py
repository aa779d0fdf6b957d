"""Contacts that a rig requires, by the pins of its board: looked at before anything turns."""

from __future__ import annotations

from motorid.acquire.board import Board
from motorid.acquire.guards import INPUTS
from motorid.errors import RigError
from motorid.rig import Rig


def check_inputs(board: Board, rig: Rig) -> None:
    """Raises RigError naming the first contact that the rig requires and that is open."""
    if not rig.limits.inputs:
        return
    closed = board.ask("read_status")["inputs"]
    for name in rig.limits.inputs:
        if not closed >> INPUTS[name] & 1:
            pin = board.ask("describe_input", input=INPUTS[name])["pin"]
            raise RigError(
                f"the contact {name} is open (pin {pin} of {board.identity['board']}): close it; "
                "limits.inputs requires it"
            )
