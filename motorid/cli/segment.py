"""motorid segment"""

from __future__ import annotations

from pathlib import Path

import click

from motorid.cli.options import example


@click.command("segment", epilog=example("motorid segment run.h5 --plot segments.html"))
@click.argument("file", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option(
    "--plot",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Draw them into an HTML page.",
)
def command(file: Path, plot: Path | None) -> None:
    """Show where a capture accelerates, runs steadily, decelerates and rests.

    Read from the signals alone, with the reason for every stretch that is rejected.
    """
    from motorid.capture import store
    from motorid.report import segments as render
    from motorid.segment import segment

    capture = store.load(file)
    segments = segment(capture)
    click.echo(render.table(capture, segments))
    if plot:
        plot.write_text(render.page(capture, segments), encoding="utf-8", newline="\n")
        click.echo(f"wrote {plot}", err=True)
