"""motorid sim"""

from __future__ import annotations

import click

from motorid.cli.options import example


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

    serve(url, announce=click.echo)
