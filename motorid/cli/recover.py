"""motorid recover"""

from __future__ import annotations

from pathlib import Path

import click

from motorid.cli.options import example


@click.command("recover", epilog=example("motorid recover capture.h5.journal"))
@click.argument("journal", type=click.Path(exists=True, dir_okay=False, path_type=Path))
def command(journal: Path) -> None:
    """Build the capture that an interrupted run left in its JOURNAL.

    Run bytes go to the journal as they arrive, so that a crash, a pulled cable or a full disk
    loses nothing that was read.
    """
    from motorid.acquire.record import recover

    click.echo(f"wrote {recover(journal)}", err=True)
