"""motorid history"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from motorid.cli.options import (
    INSTANT,
    cluster_option,
    example,
    force_option,
    moved_option,
    places,
    product_option,
)
from motorid.cli.values import JOBS, Named, Whole
from motorid.errors import EXIT_DATA, EXIT_DONE, UsageError

if TYPE_CHECKING:
    from motorid.quality.history import Query
    from motorid.quality.product import Product
    from motorid.storage.place import Place
    from motorid.workflow.rejudge import Judged
    from motorid.workflow.tasks import Workers

Command = TypeVar("Command", bound=Callable[..., Any])


@click.group(
    "history",
    epilog=example(
        "motorid history add line.db captures --product sim-disc",
        "motorid history list line.db --outcome FAIL",
        "motorid history trace line.db D000123",
        "motorid history rejudge line.db --product sim-disc",
        "motorid history export line.db -o line.parquet",
        "motorid history forget line.db --keep 365 --by 'A. Volta'",
        "motorid history verify line.db --inspections shift",
    ),
)
def command() -> None:
    """The database of results: make, add, list, trace, judge again, export, verify, forget names.

    A history is a file (SQLite) or the URL of a database that SQLAlchemy knows.
    """


WHERE = click.argument("where", metavar="HISTORY")


def query_options(command: Command) -> Command:
    """Which results."""
    for option in (
        click.option("--until", type=INSTANT, help="Results before then."),
        click.option("--since", type=INSTANT, help="Results since then, as 2026-11-21T06:00."),
        click.option("--station", default="", help="Of this station."),
        click.option("--kind", default="", help="check, rejudged, fit or golden."),
        click.option("--outcome", default="", help="PASS, FAIL or INVALID."),
        click.option("--serial", default="", help="Of these motors; * and ? are wildcards."),
    ):
        command = option(command)
    return command


def _query(fields: dict[str, Any], product: str = "") -> Query:
    from motorid.quality.history import Query

    return Query(product=product, **fields)


@command.command("init")
@WHERE
def init(where: str) -> None:
    """Make the tables of a new history: a file, or an empty database on a server.

    Where there is a history already, nothing happens.
    """
    _brought(where, create=True)


@command.command("upgrade")
@WHERE
def upgrade(where: str) -> None:
    """Bring the tables of an older history up to date, once for all who use it.

    A file is copied first (.before-STEP beside it). Back up a server yourself.
    """
    _brought(where, create=False)


def _brought(where: str, *, create: bool) -> None:
    """Opens it, and says from which step of the tables to which."""
    from motorid.quality.history import open_history

    with open_history(where, create=create, upgrade=not create) as history:
        before, after = history.stepped
    if before == after:
        click.echo(f"{where} has tables of step {after} already")
    else:
        click.echo(f"{where} has tables of step {after} now (before: {before or 'none'})")


@command.command("recount")
@WHERE
def recount(where: str) -> None:
    """Make the counts of each day anew from the results, where verify says that they differ."""
    from motorid.quality.history import open_history

    with open_history(where) as history:
        history.recount()
    click.echo(f"{where}: the counts of each day are those of its results")


@command.command("add")
@WHERE
@click.argument("files", nargs=-1, required=True)
@product_option
@click.option("--station", default="", help="Name of the station that measured.")
@click.option("--operator", default="", help="Who measured.")
def add(where: str, files: tuple[str, ...], product_name: str, station: str, operator: str) -> int:
    """Judge captures (files or folders) and add their verdicts; what is there already stays.

    A folder may be a shift's inspections: warm-up runs among them are passed over.
    """
    from motorid.quality.history import open_history
    from motorid.quality.product import load_product
    from motorid.storage.captures import captures_in
    from motorid.workflow.check import WARM_UP
    from motorid.workflow.rejudge import judge_into

    product = load_product(product_name)
    found = [place for place in captures_in(places(files)) if place.name != WARM_UP]
    with open_history(where) as history:
        return _say(judge_into(history, product, found, station=station, operator=operator))


@command.command("rejudge")
@WHERE
@product_option
@moved_option
@click.option("--jobs", type=JOBS, default=1, show_default=True, help="Processes that fit.")
@cluster_option
@click.option(
    "--stored",
    is_flag=True,
    help="Judge stored values and uncertainties; say what would change, and add nothing.",
)
@click.option(
    "-o",
    "--output",
    type=Named(dir_okay=False, path_type=Path),
    help="With --stored: CSV file of the results that would change.",
)
@force_option
@query_options
def rejudge(
    where: str,
    product_name: str,
    folders: tuple[Place, ...],
    jobs: int,
    cluster: str | None,
    stored: bool,
    output: Path | None,
    force: bool,
    **fields: Any,
) -> int:
    """Judge the captures of old results by today's limits; the old results stay.

    What is judged is in the history at once, so an interrupted command goes on where it stopped.
    With --stored no capture is read: what a change of limits would change, of millions of results.
    """
    from motorid.cli.compare import TaskBar
    from motorid.quality.history import open_history
    from motorid.quality.product import load_product
    from motorid.workflow import rejudge as workflow

    product, query = load_product(product_name), _query(fields)
    if stored:
        if folders:
            raise UsageError("--captures has no meaning with --stored, which reads none")
        return _say_stored(where, product, query, cluster or jobs, output, force)
    if output:
        raise UsageError("--output goes with --stored")
    bar = None if sys.stdout.isatty() else TaskBar()  # where each motor's line is not to be seen
    with open_history(where, create=False) as history:
        return _say(
            workflow.rejudge(
                history, product, query, folders=folders, jobs=cluster or jobs, progress=bar
            )
        )


def _say_stored(
    where: str, product: Product, query: Query, jobs: Workers, output: Path | None, force: bool
) -> int:
    """Exit code 4 where there is no such result."""
    from motorid.capture.whole import refuse_existing, write_whole
    from motorid.cli.compare import TaskBar
    from motorid.quality.history import open_history
    from motorid.workflow import rejudge_stored as workflow

    if output:
        refuse_existing(output, force)
    with open_history(where, create=False) as history:
        found = workflow.rejudge_stored(history, product, query, jobs=jobs, progress=TaskBar())
    click.echo(workflow.summary(found))
    if output:
        write_whole(output, workflow.table(found).encode(), force=force)
        click.echo(f"wrote {output}", err=True)
    return EXIT_DONE if found.judged else EXIT_DATA


def _say(judged: Iterable[Judged]) -> int:
    """A line each; exit code 4 where nothing could be judged."""
    every = []
    for one in judged:
        every.append(one)
        if one.failure:
            click.echo(f"FAILED {one.path}: {one.failure}")
            continue
        change = f"{one.before} -> {one.after}" if one.before else one.after
        known = "" if one.new else " (known already)"
        why = f": {one.reasons[0]}" if one.reasons else ""
        click.echo(f"{one.serial or one.path}  {change}{known}{why}")
    failed = sum(bool(one.failure) for one in every)
    changed = sum(one.before not in ("", one.after) for one in every if not one.failure)
    click.echo(f"{len(every) - failed} judged, {changed} changed, {failed} failed", err=True)
    return EXIT_DATA if failed == len(every) else EXIT_DONE


@command.command("list")
@WHERE
@click.option("--product", default="", help="Judged by this product.")
@click.option("--last", type=Whole(min=1), default=50, show_default=True, help="So many.")
@query_options
def list_(where: str, product: str, last: int, **fields: Any) -> None:
    """Results, oldest first."""
    from motorid.quality.history import open_history
    from motorid.report.gauge import columns

    with open_history(where, create=False) as history:
        query = _query(fields, product)
        rows, count = history.results(query, last=last), history.count(query)
    table = [
        [str(r.id), _time(r.at), r.serial, r.outcome or "-", r.kind, r.product or "-", r.station]
        for r in rows
    ]
    if table:
        head = ["id", "time", "serial", "outcome", "kind", "product", "station"]
        click.echo("\n".join(columns(head, table)))
    click.echo(f"{len(rows)} of {count} results", err=True)


def _time(at: datetime) -> str:
    return f"{at:%Y-%m-%d %H:%M:%S}Z"


@command.command("trace")
@WHERE
@click.argument("what", metavar="SERIAL|SHA256|FILE")
def trace(where: str, what: str) -> None:
    """From a serial number to its captures and results, or from a capture back."""
    from motorid.quality.history import open_history
    from motorid.workflow import history as workflow

    with open_history(where, create=False) as history:
        click.echo(workflow.trace(history, what))


@command.command("export")
@WHERE
@click.option(
    "-o",
    "--output",
    required=True,
    type=Named(dir_okay=False, path_type=Path),
    help="File to write; .csv or .parquet says the format.",
)
@click.option("--product", default="", help="Judged by this product.")
@query_options
@force_option
def export(where: str, output: Path, product: str, force: bool, **fields: Any) -> None:
    """One flat table, a row a measurement."""
    from motorid.quality.history import open_history
    from motorid.quality.history.export import export as write

    with open_history(where, create=False) as history:
        count = write(history, output, _query(fields, product), force=force)
    click.echo(f"wrote {output}: {count} rows", err=True)


@command.command("trail")
@WHERE
@click.option("--serial", default="", help="Of this motor; * and ? are wildcards.")
@click.option("--station", default="", help="Of this station.")
@click.option("--last", type=Whole(min=1), default=50, show_default=True, help="So many.")
def trail(where: str, serial: str, station: str, last: int) -> None:
    """Who ordered what and was refused what, and which names were forgotten; oldest first."""
    from motorid.quality.history import open_history
    from motorid.report.gauge import columns

    with open_history(where, create=False) as history:
        found = history.trail(station=station, serial=serial, last=last)
    words = ("station", "action", "outcome", "subject", "who", "reason")
    table = [[_time(one["at"]), *(one[word] or "-" for word in words)] for one in found]
    if table:
        click.echo("\n".join(columns(["time", *words], table)))
    click.echo(f"{len(found)} entries", err=True)


@command.command("forget")
@WHERE
@click.option(
    "--keep",
    "days",
    type=Whole(0, 36_500),
    help="Keep names for so many days from now on; 0: for ever. Default: as the rule is.",
)
@click.option("--by", default="", help="Who does this, for the trail.")
def forget(where: str, days: int | None, by: str) -> None:
    """Forget the names of operators that are older than the history's rule says (365 days).

    Results, their seals and the trail stay whole: they hold a salted digest in place of a name.
    Each shift of a station does the same when it begins.
    """
    from motorid.quality.history import open_history

    with open_history(where, create=False) as history:
        done, sealed = history.forget_names(by, days), history.sealed_names()
    rule = f"for {done.days} days" if done.days else "for ever"
    click.echo(f"{done.names} names forgotten; names are kept {rule}")
    if sealed:
        click.echo(
            f"{sealed} results from before step 0003 of the tables hold a name in their "
            "seal: it stays"
        )


@command.command("verify")
@WHERE
@click.option(
    "--inspections",
    "folders",
    multiple=True,
    type=Named(exists=True, file_okay=False, path_type=Path),
    help="Folders of inspections, which keep the heads of the chain. Repeatable.",
)
@click.option(
    "--trusted",
    type=Named(exists=True, dir_okay=False, path_type=Path),
    help="File of trusted keys: name results whose limits none of them signed.",
)
def verify(where: str, folders: tuple[Path, ...], trusted: Path | None) -> int:
    """Find edited, deleted and inserted results, by the chain of digests.

    With --inspections also a tail that was cut off, or a chain that was written anew. Exit code 4
    where anything is found. Results from before there were seals are counted as unsealed.
    """
    from motorid.quality.history import open_history
    from motorid.quality.signed import read_trusted
    from motorid.workflow.shift_history import anchors

    keys = read_trusted(trusted) if trusted else None
    heads = [head for folder in folders for head in anchors(folder)]
    with open_history(where, create=False) as history:
        found = history.verify(heads)
        unsigned = list(history.unsigned(keys)) if keys else []
    click.echo(f"{found.sealed} sealed results, {found.unsealed} unsealed, {len(heads)} anchors")
    for head in found.heads:
        click.echo(f"head of {head.station or 'no station'}: {head.position} {head.chain}")
    for problem in found.problems:
        click.echo(f"DAMAGED {problem}")
    for problem in unsigned:
        click.echo(f"UNSIGNED {problem}")
    return EXIT_DATA if found.problems or unsigned else EXIT_DONE
