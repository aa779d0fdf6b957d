"""motorid rigs"""

from __future__ import annotations

import click

from motorid.cli.options import example


@click.command("rigs", epilog=example("motorid rigs", "motorid run --rig sim -o out"))
def command() -> None:
    """List the rigs that come with motorid; each name works as --rig NAME."""
    from motorid.rig_file import presets

    for name in presets():
        click.echo(name)
