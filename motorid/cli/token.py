"""motorid token"""

from __future__ import annotations

from pathlib import Path

import click

from motorid.cli.options import example
from motorid.cli.values import Named
from motorid.workflow.access import ROLES


@click.group(
    "token",
    epilog=example(
        "motorid token add tokens.json --role operator --name line-1",
        "motorid token list tokens.json",
        "motorid token remove tokens.json --name line-1",
    ),
)
def command() -> None:
    """Tokens of a station's users: add, list, remove.

    An operator may start inspections, an engineer may also read the history and end a shift, an
    auditor may only look and read. The file holds salted digests.
    """


FILE = click.argument("path", metavar="FILE", type=Named(dir_okay=False, path_type=Path))
NAME = click.option("--name", required=True, help="Whose token: a person or a machine.")


@command.command("add")
@FILE
@click.option("--role", required=True, type=click.Choice(list(ROLES)), help="What it allows.")
@NAME
def add(path: Path, role: str, name: str) -> None:
    """Make a token and print it, this once. The file is made if need be, for its owner alone."""
    from motorid.workflow.access import Tokens

    click.echo(Tokens(path).add(name, role))


@command.command("list")
@FILE
def list_(path: Path) -> None:
    """Names, roles and when each was added."""
    from motorid.report.gauge import columns
    from motorid.workflow.access import Tokens

    rows = [[one.name, one.role, one.added] for one in Tokens(path).all()]
    if rows:
        click.echo("\n".join(columns(["name", "role", "added"], rows)))
    click.echo(f"{len(rows)} tokens", err=True)


@command.command("remove")
@FILE
@NAME
def remove(path: Path, name: str) -> None:
    """Remove a token: it opens no further connection."""
    from motorid.workflow.access import Tokens

    Tokens(path).remove(name)
