"""motorid recover"""

from __future__ import annotations

from pathlib import Path

import click

from motorid.cli.options import example
from motorid.cli.values import Named


@click.command("recover", epilog=example("motorid recover run.h5"))
@click.argument("path", type=Named(dir_okay=False, path_type=Path))
def command(path: Path) -> None:
    """Build the capture that an interrupted run left in its journal, and say what it lacks.

    PATH is the journal, or the capture that it was meant for. What the board sends goes to the
    journal as it arrives, so that a crash, a pulled cable or a full disk loses nothing that was
    read.
    """
    from motorid.acquire.record import recover, remarks
    from motorid.capture.store import load
    from motorid.workflow.verify import journal_remark

    damage = journal_remark(path)
    capture = load(recover(path))
    click.echo(f"wrote {capture.path}: {len(capture)} samples", err=True)
    for remark in (*damage, *remarks(capture)):
        click.echo(f"note: {remark}", err=True)
