"""motorid ports"""

from __future__ import annotations

import click

from motorid.cli.options import example


@click.command("ports", epilog=example("motorid ports", "motorid ports --probe"))
@click.option(
    "--probe",
    is_flag=True,
    help="Open each port: who answers, and what the link loses (resets many boards).",
)
def command(probe: bool) -> None:
    """List the serial ports, without opening them: opening one resets many boards."""
    from motorid.acquire.ports import listing

    for line in listing(probe=probe):
        click.echo(line)
