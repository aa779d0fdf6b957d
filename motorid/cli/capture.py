"""motorid capture"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from motorid.cli import live
from motorid.cli.options import (
    capture_options,
    example,
    force_option,
    make_way,
    warn,
    warned,
    wrote,
)
from motorid.cli.rotor import clamped_option, confirmed
from motorid.cli.values import Kept

if TYPE_CHECKING:
    from motorid.storage.place import File


@click.command(
    "capture",
    epilog=example(
        "motorid capture --rig sim -o run.h5",
        "motorid capture --rig bench.toml -o m17.h5 --serial M17 --repeat 3",
        "motorid capture --rig bench.toml -o m17.h5 --live",
        "motorid capture --rig emulated-uno-burst -o start.h5 --burst",
    ),
)
@capture_options
@clamped_option
@click.option(
    "-o",
    "--output",
    required=True,
    type=Kept(dir_okay=False, path_type=Path),
    help="Capture file, or its URL (s3://...); --repeat 3 writes NAME-1.h5 to NAME-3.h5.",
)
@click.option(
    "--burst",
    is_flag=True,
    help="Sample as fast as the board can, from its memory.",
)
@live.capture_option
@live.page_options
@force_option
def command(
    rig_name: str,
    port: str | None,
    repeat: int,
    serial: str,
    note: str,
    speed: str | None,
    clamped: bool,
    output: File,
    burst: bool,
    where: str | None,
    listen: str,
    allow_remote: bool,
    certificate: Path | None,
    key: Path | None,
    force: bool,
) -> None:
    """Drive the motor of a rig through its program and record the run.

    Begins with a short weak pulse that checks signs, encoder and current. Ctrl-C stops the motor
    and keeps what was measured.

    --burst samples faster than the link carries, for the inductance of a fast motor. A program that
    the board's memory does not hold is refused.
    """
    from motorid.cli.progress import ProgressLine
    from motorid.storage.place import Url
    from motorid.workflow import record, spool

    if where != live.PAGE and (allow_remote or certificate or key):
        raise click.UsageError(
            "--allow-remote, --certificate and --key are for the page of --live."
        )
    path, kept = spool.first(output), output.parent if isinstance(output, Url) else None
    if kept:
        for one in record.numbered(path, repeat):
            spool.refuse_existing(kept / one.name, force=force)
    make_way(path, repeat, force)
    rig = confirmed(warned(record.bench(rig_name, port=port, speed=speed)), clamped)
    address = live.Listen(listen, allow_remote, certificate, key)
    with live.capture_view(where, rig, address, serial) as view, ProgressLine() as progress:
        paths = record.capture_runs(
            record.bursting(rig) if burst else rig,
            path,
            repeat=repeat,
            force=force,
            serial=serial,
            note=note,
            progress=None if where == live.TERMINAL else progress,
            say=warn,
            watch=view.watch if view else None,
        )
    for path in paths:
        wrote(path, kept / path.name if kept else None, force=force)
