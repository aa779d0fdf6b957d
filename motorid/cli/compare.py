"""motorid compare"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import click

from motorid.cli.names import FILES
from motorid.cli.options import (
    Assignment,
    cluster_option,
    example,
    expand,
    force_option,
    jobs_option,
)
from motorid.cli.streams import paint
from motorid.cli.values import Named, Whole
from motorid.errors import EXIT_DONE


class TaskBar:
    """A line on stderr: tasks done and the time left; silent where stderr is no terminal."""

    def __init__(self) -> None:
        self.shown = sys.stderr.isatty()
        self.began = time.monotonic()
        self.first = -1

    def __call__(self, done: int, total: int) -> None:
        """Called after each task; the first call counts what an earlier run had finished."""
        if self.first < 0:
            self.first, self.began = done, time.monotonic()
        if not self.shown or not total:
            return
        ran, left = done - self.first, total - done
        wait = (time.monotonic() - self.began) * left / ran if ran else 0.0
        filled = 24 * done // total
        bar = f"[{'#' * filled}{'.' * (24 - filled)}] {done}/{total}"
        tail = f"{wait:5.0f} s left" if ran else ""
        paint(sys.stderr, f"\r{bar} {tail:<14}" + ("\n" if done == total else ""))


@click.command(
    "compare",
    epilog=example(
        "motorid compare run-1.h5 -o comparison",
        "motorid compare run-1.h5 --method jaya --method nls --truth K=0.0077 -o comparison",
        "motorid compare --table 5 -o review",
    ),
)
@click.argument("files", nargs=-1, type=FILES)
@click.option(
    "--table",
    "tables",
    type=Whole(2, 9),
    multiple=True,
    help="Rebuild a table of the review instead. Repeatable.",
)
@click.option(
    "--method", "methods", multiple=True, help="A method to compare. Repeatable; default: a choice."
)
@click.option(
    "--budget",
    type=Whole(min=100),
    default=3000,
    show_default=True,
    help="Evaluations of each search (captures only: a table has its own).",
)
@click.option("--seeds", type=Whole(1, 10_000), help="Seeds: 10 for captures, 30 for tables.")
@jobs_option
@cluster_option
@click.option(
    "--truth",
    multiple=True,
    type=Assignment("K=0.0514"),
    help="A parameter's true value, in SI units: shows errors. Repeatable.",
)
@click.option(
    "--page",
    type=Named(dir_okay=False, path_type=Path),
    help="With --table: also write all tables as one Markdown page.",
)
@click.option(
    "-o",
    "--output",
    required=True,
    type=Named(file_okay=False, path_type=Path),
    help="Folder for the HTML and CSV, and for each finished run.",
)
@force_option
def command(
    files: tuple[str, ...],
    tables: tuple[int, ...],
    methods: tuple[str, ...],
    budget: int,
    seeds: int | None,
    jobs: int,
    cluster: str | None,
    truth: tuple[tuple[str, float], ...],
    page: Path | None,
    output: Path,
    force: bool,
) -> int:
    """Run many methods on the same captures, or rebuild a table of the review.

    Equal budgets, equal seeds, all cores. Every finished run is kept in the folder, so an
    interrupted comparison goes on where it stopped.
    """
    if bool(files) == bool(tables):
        raise click.UsageError("name captures, or a table by --table: one of the two.")
    if page and not tables:
        raise click.UsageError("--page goes with --table.")
    from motorid.workflow import compare_files as workflow

    if tables:
        made = workflow.tables_to_files(
            tables,
            output,
            page=page,
            seeds=seeds,
            jobs=cluster or jobs,
            force=force,
            progress=TaskBar,
        )
    else:
        text, made = workflow.captures_to_files(
            expand(files),
            output,
            methods=methods,
            budget=budget,
            seeds=seeds,
            jobs=cluster or jobs,
            truth=dict(truth),
            force=force,
            progress=TaskBar,
        )
        click.echo(text)
    for path in made:
        click.echo(f"wrote {path}", err=True)
    return EXIT_DONE
