"""motorid sim"""

from __future__ import annotations

import sys

import click

from motorid.cli.options import example
from motorid.cli.streams import unheard
from motorid.errors import DataError


@click.command("sim", epilog=example("motorid sim --pty", "motorid sim 'sim://?seed=7' --pty"))
@click.argument("url", default="sim://?speed=realtime")
@click.option(
    "--pty", is_flag=True, required=True, help="On a pseudo terminal, whose path is printed."
)
def command(url: str, pty: bool) -> None:
    """Offer the simulated board to another program, until Ctrl-C.

    URL chooses motor, seed, noise and faults, as the port of a rig file does.
    """
    from motorid.sim.pty import serve

    serve(url, announce=_announce)


def _announce(path: str) -> None:
    """Raises DataError where the path gets nowhere: nobody could ever connect."""
    click.echo(path)
    if unheard(sys.stdout):
        raise DataError("standard output cannot be written: nobody would learn the terminal's path")
