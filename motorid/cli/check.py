"""motorid check"""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from motorid.cli.names import RIG
from motorid.cli.options import (
    example,
    places,
    port_option,
    product_option,
    speed_option,
    warn,
    warned,
)
from motorid.cli.streams import paint
from motorid.cli.values import Kept
from motorid.errors import DataError
from motorid.visible import visible

if TYPE_CHECKING:
    from motorid.storage.place import File, Url
    from motorid.workflow.check import Inspection


@click.command(
    "check",
    epilog=example(
        "motorid check --product sim-disc --rig sim-line --serial D000123",
        "motorid check --product sim-disc --capture run.h5 --json",
    ),
)
@product_option
@click.option(
    "--rig",
    "rig_name",
    type=RIG,
    help="Rig file, or the name of a packaged rig; with --capture, the one to re-analyse with.",
)
@port_option
@speed_option
@click.option("--serial", default="", help="Serial number; asked for (or scanned) where not given.")
@click.option(
    "--capture",
    "captures",
    multiple=True,
    metavar="FILE",
    help="Judge stored captures of one motor instead of measuring. Repeatable.",
)
@click.option(
    "-o",
    "--output",
    type=Kept(file_okay=False, path_type=Path),
    help="Folder (or s3://...) that gets a folder for each inspection  [default: inspections, when "
    "measuring]",
)
@click.option("--history", help="Add the verdict to this history (file, or a database's URL).")
@click.option("--json", "as_json", is_flag=True, help="Print the verdict as JSON.")
def command(
    product_name: str,
    rig_name: str | None,
    port: str | None,
    speed: str | None,
    serial: str,
    captures: tuple[str, ...],
    output: File | None,
    history: str | None,
    as_json: bool,
) -> int:
    """Measure one motor and judge it by a product file: PASS, FAIL or INVALID.

    Exit codes: 0 PASS, 1 FAIL, 4 INVALID (3 where rig or link is the reason). The capture, the
    verdict as JSON, JUnit XML and CSV, and an OpenHTF record are kept in a folder of their own.
    """
    from motorid.quality import records
    from motorid.quality.product import load_product
    from motorid.storage.place import Url
    from motorid.workflow import spool

    product = load_product(product_name)
    folder = spool.first(output) if output else None
    if captures:
        from motorid.rig import load_rig
        from motorid.workflow.check import judge_stored

        again = load_rig(rig_name) if rig_name else None
        done = judge_stored(places(captures), product, serial, folder, rig=again)
    else:
        if not rig_name:
            raise click.UsageError("name a --rig to measure, or a --capture to judge.")
        from motorid.cli.progress import ProgressLine
        from motorid.workflow.check import Line
        from motorid.workflow.record import bench

        rig = warned(bench(rig_name, port=port, speed=speed))
        scanned = serial or _scan(as_json)
        with Line(rig, product, folder or Path("inspections")) as line, ProgressLine() as progress:
            done = line.inspect(scanned, progress=progress)
    if history:
        from motorid.workflow.history import remember_inspection

        kept = output / done.folder.name if isinstance(output, Url) and done.folder else None
        remember_inspection(history, done, product, places(captures), kept=kept)
    if isinstance(output, Url) and folder:
        _upload(folder, output)
    if as_json:
        click.echo(records.to_json(done.verdict), nl=False)
    else:
        paint(sys.stdout, f"{_page(done)}\n")
    return done.exit_code


def _upload(folder: Path, to: Url) -> None:
    """What is in the spool, this inspection and earlier ones; the verdict stands anyway."""
    from motorid.workflow.uploads import Uploads

    try:
        said = Uploads(to).catch_up(folder)
    except DataError as error:
        warn(f"the inspection is safe in {folder}; it is uploaded by the next one ({error})")
    else:
        click.echo(f"{to}: {said}", err=True)


def _scan(quiet: bool) -> str:
    """One line from the scanner or the keyboard."""
    if not quiet and sys.stdin.isatty():
        click.echo("Serial number: ", nl=False)
    return sys.stdin.readline().strip()


def _page(done: Inspection) -> str:
    from motorid.report import screen

    kept = f"kept in {done.folder}" if done.folder else ""
    width = shutil.get_terminal_size().columns
    shown = screen.render(
        screen.of_verdict(done.verdict, kept),
        width=min(width, 100),
        colour=sys.stdout.isatty() and "NO_COLOR" not in os.environ,
    )
    return f"{shown}\n{visible(screen.table(done.verdict))}\n"
