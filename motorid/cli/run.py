"""motorid run"""

from __future__ import annotations

from pathlib import Path

import click

from motorid.cli.options import (
    capture_options,
    example,
    fit_options,
    force_option,
    make_way,
    warn,
    warned,
    wrote,
)
from motorid.cli.rotor import clamped_option, confirmed
from motorid.cli.streams import paged
from motorid.cli.values import Named


@click.command(
    "run",
    epilog=example(
        "motorid run --rig sim",
        "motorid run --rig bench.toml --serial M17 --repeat 3 -o M17",
    ),
)
@capture_options
@clamped_option
@fit_options
@click.option(
    "-o",
    "--output",
    type=Named(file_okay=False, path_type=Path),
    help="Folder for capture.h5, estimate.json and report.html; without it a new one, named by "
    "serial number and date.",
)
@force_option
def command(
    rig_name: str,
    port: str | None,
    repeat: int,
    serial: str,
    note: str,
    speed: str | None,
    clamped: bool,
    fix: tuple[tuple[str, float], ...],
    without: tuple[str, ...],
    method: str,
    strict: bool,
    output: Path | None,
    force: bool,
) -> int:
    """Capture a run, fit it and write a report.

    The same as motorid capture, then motorid fit on the file that it wrote.
    """
    from motorid.cli.progress import ProgressLine, Working
    from motorid.workflow import fit, record

    output = output or record.dated_folder(Path(), serial)
    fit.check_writable(output, force=force)
    bench = confirmed(warned(record.bench(rig_name, port=port, speed=speed)), clamped)
    path = record.capture_into(output)
    make_way(path, repeat, force)
    with ProgressLine() as progress:
        paths = record.capture_runs(
            bench,
            path,
            repeat=repeat,
            force=force,
            serial=serial,
            note=note,
            progress=progress,
            say=warn,
        )
    with Working("fitting"):
        estimate = fit.fit_files(paths, fix=dict(fix), without=without, method=method)
    click.echo(paged(fit.as_text(estimate)))
    for path in paths:
        wrote(path)
    for path in fit.write_report(estimate, output, force=force):
        click.echo(f"wrote {path}", err=True)
    return fit.exit_code(estimate, strict=strict)
