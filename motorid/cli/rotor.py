"""Whether the rotor is held, before a program that needs that: --clamped, or a question."""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import TYPE_CHECKING

import click

from motorid.cli.streams import confirm
from motorid.errors import UsageError

if TYPE_CHECKING:
    from motorid.rig import Rig

clamped_option = click.option(
    "--clamped",
    is_flag=True,
    help="The rotor is clamped, as a PRBS needs it.",
)
QUESTION = (
    "The program drives the motor to and fro while its rotor is held. A free rotor would jump. "
    "Is the rotor clamped?"
)


def confirmed(rig: Rig, clamped: bool) -> Rig:
    """``rig``, whose program's rotor is held by what a person says; as it is where nobody says it.

    Raises UsageError where ``clamped`` is said of a program that turns the rotor, or denied.
    """
    from motorid.program import Rotor

    program = rig.program
    if clamped and not program.held:
        raise UsageError(
            "--clamped goes with a program for a rotor that is held (program.rotor in the rig "
            "file), and this one turns it: leave --clamped out"
        )
    if program.rotor is not Rotor.ASK:
        return rig
    if not clamped:
        if not sys.stdin.isatty():
            return rig  # which is refused before the port is opened
        if not confirm(QUESTION, default=False):
            raise UsageError("the rotor is not clamped: clamp it, or take another program")
    return replace(rig, program=replace(program, rotor=Rotor.CLAMPED))
