"""motorid fit"""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from motorid.cli.names import FILES, RIG
from motorid.cli.options import (
    INSTANT,
    cluster_option,
    example,
    fit_options,
    force_option,
    nameplate_option,
    places,
    search_options,
)
from motorid.cli.paged import Paged
from motorid.cli.streams import paged
from motorid.cli.values import JOBS, Between, Named
from motorid.errors import EXIT_DONE

if TYPE_CHECKING:
    from motorid.capture.model import Stated
    from motorid.rig import Rig
    from motorid.storage.place import Place


@click.command(
    "fit",
    cls=Paged,
    common=(
        *("rig_name", "fix", "strict", "model", "jobs", "history"),
        *("as_json", "output", "force"),
    ),
    epilog=example(
        "motorid fit run-1.h5 run-2.h5 run-3.h5 -o report",
        "motorid fit robotino.h5 --fix K=0.0514 --json",
        "motorid fit run-1.h5 --method pso-ci --model quadratic-load --budget 20000",
        "motorid fit run-1.h5 --rig bench.toml --json",
        "motorid fit captures --jobs -1 -o fits",
        "motorid fit --history line.db --serial 'SN-1*' -o fits",
    ),
)
@click.argument("files", nargs=-1, type=FILES)
@click.option(
    "--rig",
    "rig_name",
    type=RIG,
    help="Re-analyse the captures under this rig, with its calibration, in place of their own.",
)
@click.option(
    "--ambient",
    type=Between(-100, 300),
    help="Ambient in °C, in place of what the captures hold of it.",
)
@click.option(
    "--ambient-uncertainty",
    type=Between(0, 100),
    help="Its standard uncertainty in K.  [default: 0]",
)
@nameplate_option
@fit_options
@search_options
@click.option(
    "--jobs",
    type=JOBS,
    help="Fit each capture by itself, on so many processes; -1 is one a core.",
)
@cluster_option
@click.option(
    "--history", help="Fit the captures that this history knows, each by itself, in place of FILES."
)
@click.option(
    "--serial", default="", help="With --history: of these motors; * and ? are wildcards."
)
@click.option("--since", type=INSTANT, help="With --history: captured since, as 2026-11-21T06:00.")
@click.option("--json", "as_json", is_flag=True, help="Print the estimate as JSON.")
@click.option(
    "-o",
    "--output",
    type=Named(file_okay=False, path_type=Path),
    help="Folder for estimate.json and report.html; for fits.csv with --jobs.",
)
@force_option
def command(
    files: tuple[str, ...],
    rig_name: str | None,
    ambient: float | None,
    ambient_uncertainty: float | None,
    nameplate: tuple[str, ...],
    fix: tuple[tuple[str, float], ...],
    without: tuple[str, ...],
    method: str,
    strict: bool,
    model: str | None,
    budget: int | None,
    seed: int | None,
    jobs: int | None,
    cluster: str | None,
    history: str | None,
    serial: str,
    since: datetime | None,
    as_json: bool,
    output: Path | None,
    force: bool,
) -> int | None:
    """Estimate R, L, K, B, J and T0 from one or more captures of the same motor.

    Needs no start values. Prints a table with uncertainties; what these captures cannot tell is
    reported as such, with the run that would tell it.

    With --jobs, --cluster, a folder among FILES, or --history, every capture is fitted by itself,
    into fits.csv, a row a capture. Finished fits are kept, so an interrupted run goes on where it
    stopped; captures that cannot be fitted are listed and stop nothing. --model six does without
    the search for a better model, which adds findings to the table and no values.

    A parameter is doubtful where a finding could have moved it by more than half of its interval's
    half-width. Where the captures contradict the model, no parameter is supported: no values, and
    exit code 4.

    With --rig, stored captures are given the meaning that a corrected rig file and its calibration
    give them: their raw readings and their files stay as they are, and the estimate cites both.
    """
    options: dict[str, Any] = {
        "fix": dict(fix),
        "without": without,
        "method": method,
        "rig": _rig(rig_name),
    }
    if not (files or history):
        raise click.UsageError("Missing argument 'FILES...': name captures, or a --history.")
    if files and history:
        raise click.UsageError("name captures or a --history: one of the two.")
    room = _ambient(ambient, ambient_uncertainty)
    given = {
        "model": model,
        "budget": budget,
        "seed": seed,
        "ambient": room,
        "nameplate": _stated(nameplate),
    }
    search: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
    if history or cluster or jobs is not None or _has_many(files):
        if as_json or output is None:
            raise click.UsageError("many fits go to a folder: give -o, and no --json.")
        alone = next((name for name in search if name != "model"), "")
        if alone:
            raise click.UsageError(f"--{alone} goes with one fit, not with many.")
        captures = _of_history(history, serial, since) if history else places(files)
        if strict:
            raise click.UsageError("--strict goes with one fit: fits.csv has each one's status.")
        _fit_many(captures, output, force, {**options, **search, "jobs": cluster or jobs or 1})
        return EXIT_DONE
    from motorid.cli.progress import Working
    from motorid.workflow import fit as workflow

    if output:
        workflow.check_writable(output, force=force)
    with Working("fitting"):
        estimate = workflow.fit_files(places(files), **options, **search)
    click.echo(workflow.as_json(estimate) if as_json else paged(workflow.as_text(estimate)))
    if output:
        for path in workflow.write_report(estimate, output, force=force):
            click.echo(f"wrote {path}", err=True)
    code = workflow.exit_code(estimate, strict=strict)
    return code if output or code != EXIT_DONE else None


def _has_many(files: tuple[str, ...]) -> bool:
    from motorid.storage.captures import is_many
    from motorid.storage.place import place

    return any(is_many(place(name)) for name in files)


def _rig(name: str | None) -> Rig | None:
    from motorid.rig import load_rig

    return load_rig(name) if name else None


def _stated(nameplate: tuple[str, ...]) -> Stated | None:
    from motorid.rig_nameplate import read_nameplate

    return read_nameplate(nameplate) if nameplate else None


def _ambient(degrees: float | None, uncertainty: float | None) -> tuple[float, float] | None:
    """°C and K as given. Raises click.UsageError for the second without the first."""
    if degrees is None and uncertainty is not None:
        raise click.UsageError("--ambient-uncertainty goes with --ambient: give both.")
    return None if degrees is None else (degrees, uncertainty or 0.0)


def _of_history(history: str, serial: str, since: datetime | None) -> list[Place]:
    from motorid.workflow.many import captures_of_history

    return captures_of_history(history, serial=serial, since=since)


def _fit_many(places: list[Place], output: Path, force: bool, options: Mapping[str, Any]) -> None:
    from motorid.cli.compare import TaskBar
    from motorid.workflow import many

    fits, table = many.fit_to_files(places, output, force=force, progress=TaskBar, **options)
    click.echo(many.summary(fits))
    click.echo(f"wrote {table}", err=True)
