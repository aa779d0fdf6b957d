"""motorid motors"""

from __future__ import annotations

from pathlib import Path

import click

from motorid.cli.names import FILES
from motorid.cli.options import cluster_option, example, force_option, jobs_option, places
from motorid.cli.values import Named
from motorid.errors import EXIT_DONE


@click.command(
    "motors",
    epilog=example(
        "motorid motors good.h5 suspect.h5 -o pair",
        "motorid motors reference.h5 batch -o batch-page",
    ),
)
@click.argument("files", nargs=-1, required=True, type=FILES)
@jobs_option
@cluster_option
@click.option(
    "-o",
    "--output",
    required=True,
    type=Named(file_okay=False, path_type=Path),
    help="Folder for motors.html, motors.csv, and each finished fit.",
)
@force_option
def command(
    files: tuple[str, ...], jobs: int, cluster: str | None, output: Path, force: bool
) -> int:
    """Show 2 to 50 motors on one page: parameters, real differences, curves.

    Each capture is a motor; a folder stands for its captures. The first is the reference.
    """
    from motorid.cli.compare import TaskBar
    from motorid.workflow.motors import said
    from motorid.workflow.motors_files import motors_to_files

    found, made = motors_to_files(
        places(files), output, jobs=cluster or jobs, force=force, progress=TaskBar
    )
    for line in said(found):
        click.echo(line)
    for path in made:
        click.echo(f"wrote {path}", err=True)
    return EXIT_DONE
