"""motorid board"""

from __future__ import annotations

import click

from motorid.cli.options import example
from motorid.errors import EXIT_DONE

PORT_HELP = "The board's port; motorid ports lists them."


@click.group(
    "board",
    epilog=example(
        "motorid board list",
        "motorid board set acs712-20 --port /dev/ttyACM0",
        "motorid board show --port /dev/ttyACM0",
    ),
)
def command() -> None:
    """Show and store what a board knows of its front end: sensor, dividers, reference.

    The facts live in the board's own memory. Its readings, limits and declared uncertainties
    follow from them, and captures record them. A board whose facts are damaged refuses to drive.
    """


@command.command("show", epilog=example("motorid board show --port /dev/ttyACM0"))
@click.option("--port", required=True, help=PORT_HELP)
def show(port: str) -> None:
    """Show the facts that a board holds, and whence they are."""
    from motorid.acquire.front_end import show as told

    for line in told(port):
        click.echo(line)


@command.command("set", epilog=example("motorid board set acs712-20 --port /dev/ttyACM0"))
@click.argument("front_end", metavar="NAME|FILE")
@click.option("--port", required=True, help=PORT_HELP)
@click.option("--any-board", is_flag=True, help="Store it though it is another kind of board's.")
def set_(front_end: str, port: str, any_board: bool) -> int:
    """Store a front end in a board: one that comes with motorid, or a file of your own.

    It is stored in a board that is not yet configured, and survives resets. A loss of power
    meanwhile leaves the old facts or the new ones. The firmware's own ceiling of the current stays.
    """
    from motorid.acquire.front_end import store
    from motorid.rig_front_end import load_front_end

    for line in store(port, load_front_end(front_end), any_board):
        click.echo(line)
    return EXIT_DONE


@command.command(
    "list", epilog=example("motorid board list", "motorid board list --show ina240-2mohm")
)
@click.option("--show", "shown", metavar="NAME", help="Print this one's file, to make yours of.")
def list_(shown: str | None) -> None:
    """List the front ends that come with motorid."""
    from motorid.rig_front_end import load_front_end, presets

    if shown:
        click.echo(load_front_end(shown).text, nl=False)
        return
    for name in presets():
        click.echo(name)
