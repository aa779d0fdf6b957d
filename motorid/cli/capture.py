"""motorid capture"""

from __future__ import annotations

from pathlib import Path

import click

from motorid.cli.options import capture_options, example, force_option, make_way, warned, wrote


@click.command(
    "capture",
    epilog=example(
        "motorid capture --rig sim -o run.h5",
        "motorid capture --rig bench.toml -o m17.h5 --serial M17 --repeat 3",
    ),
)
@capture_options
@click.option(
    "-o",
    "--output",
    required=True,
    type=click.Path(dir_okay=False, path_type=Path),
    help="Capture file; --repeat 3 writes NAME-1.h5 to NAME-3.h5.",
)
@force_option
def command(
    rig_name: str,
    port: str | None,
    repeat: int,
    serial: str,
    note: str,
    speed: str | None,
    output: Path,
    force: bool,
) -> None:
    """Drive the motor of a rig through its program and record the run.

    Begins with a short weak pulse that checks signs, encoder and current. Ctrl-C stops the motor
    and keeps what was measured.
    """
    from motorid.cli.progress import ProgressLine
    from motorid.workflow import record

    make_way(output, repeat, force)
    with ProgressLine() as progress:
        paths = record.capture_runs(
            warned(record.bench(rig_name, port=port, speed=speed)),
            output,
            repeat=repeat,
            force=force,
            serial=serial,
            note=note,
            progress=progress,
        )
    for path in paths:
        wrote(path)
