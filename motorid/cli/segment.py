"""motorid segment"""

from __future__ import annotations

from pathlib import Path

import click

from motorid.cli.options import example, force_option
from motorid.cli.values import Named
from motorid.errors import EXIT_DONE


@click.command("segment", epilog=example("motorid segment run.h5 --plot segments.html"))
@click.argument("file", type=Named(exists=True, dir_okay=False, path_type=Path))
@click.option(
    "--plot",
    type=Named(dir_okay=False, path_type=Path),
    help="Draw them into an HTML page.",
)
@force_option
def command(file: Path, plot: Path | None, force: bool) -> int | None:
    """Show where a capture accelerates, runs steadily, decelerates and rests.

    Read from the signals alone, with the reason for every stretch that is rejected.
    """
    from motorid.capture import store
    from motorid.capture.whole import refuse_existing, write_whole
    from motorid.report import segments as render
    from motorid.segment import segment

    if plot:
        refuse_existing(plot, force)
    capture = store.load(file)
    segments = segment(capture)
    click.echo(render.table(capture, segments))
    if plot:
        write_whole(plot, render.page(capture, segments).encode(), force=force)
        click.echo(f"wrote {plot}", err=True)
    return EXIT_DONE if plot else None
