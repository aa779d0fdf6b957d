"""motorid rigs"""

from __future__ import annotations

import click

from motorid.cli.options import example


@click.command(
    "rigs",
    epilog=example(
        "motorid rigs", "motorid run --rig sim -o out", "motorid rigs --show sim > bench.toml"
    ),
)
@click.option("--show", metavar="NAME", help="Print this rig's file, to make one of your own of.")
def command(show: str | None) -> None:
    """List the rigs that come with motorid; each name works as --rig NAME."""
    from motorid.errors import RigError
    from motorid.rig_file import find, presets
    from motorid.toml_file import read_text

    if show:
        click.echo(read_text(find(show), "a rig file", RigError), nl=False)
        return
    for name in presets():
        click.echo(name)
