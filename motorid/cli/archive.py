"""motorid archive"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from motorid.cli.names import FILES
from motorid.cli.options import example, places
from motorid.cli.values import Kept, Whole
from motorid.errors import EXIT_DATA, EXIT_DONE

if TYPE_CHECKING:
    from motorid.storage.place import File

ARCHIVE = click.argument("archive", type=Kept(path_type=Path))


@click.group(
    "archive",
    epilog=example(
        "motorid archive pack packs shift --station line-1",
        "motorid archive list packs",
        "motorid archive find packs D000123",
        "motorid fit packs/line-1/2026-11-25.zip#D000123_20261125T060000/capture.h5",
        "motorid archive delete packs --keep 730 --history line.db",
    ),
)
def command() -> None:
    """Many captures in one zip for each station and day, with an index that seals it.

    ARCHIVE is a folder, or one in an object store (s3://...). One capture of a pack is read by
    itself: PACK.zip#NAME goes wherever a capture goes.
    """


@command.command("pack")
@ARCHIVE
@click.argument("files", nargs=-1, required=True, type=FILES)
@click.option("--station", default="", help="Of captures whose verdict names none.")
@click.option(
    "--most",
    type=Whole(1, 1000),
    default=256,
    show_default=True,
    metavar="MB",
    help="Size of a pack; what is more goes into a further one.",
)
def pack(archive: File, files: tuple[str, ...], station: str, most: int) -> int:
    """Put captures (files or folders) into packs; what is packed already is passed over.

    The captures stay where they are. A pack is read back before its index seals it, and never
    changes after that. Exit code 4 where a capture could not be packed.
    """
    from motorid.workflow.archive import pack_captures

    failed = 0
    found = pack_captures(places(files), archive, station=station, most_bytes=most << 20)
    for one in found:
        if one.failure:
            failed += 1
            click.echo(f"FAILED {one.place}: {one.failure}")
        else:
            click.echo(f"{one.place}: {one.count} captures")
    return EXIT_DATA if failed else EXIT_DONE


@command.command("list")
@ARCHIVE
def list_(archive: File) -> None:
    """The sealed packs: station, day, files, bytes."""
    from motorid.report.gauge import columns
    from motorid.workflow.archive import listed

    found = list(listed(archive))
    table = [
        [index.station, index.day, str(len(index.entries)), f"{index.bytes:,}", str(where)]
        for where, index in found
    ]
    if table:
        click.echo("\n".join(columns(["station", "day", "files", "bytes", "pack"], table)))
    click.echo(f"{len(table)} packs", err=True)


@command.command("find")
@ARCHIVE
@click.argument("what", metavar="SERIAL|SHA256")
def find(archive: File, what: str) -> int:
    """The packed captures of a motor, as names that every command reads.

    Exit code 4 where there is none.
    """
    from motorid.workflow.archive import search

    found = list(search(archive, what))
    for member, entry in found:
        click.echo(f"{member}  {entry.sha256}")
    click.echo(f"{len(found)} files", err=True)
    return EXIT_DONE if found else EXIT_DATA


@command.command("delete")
@ARCHIVE
@click.option(
    "--keep",
    "days",
    type=Whole(0, 36_500),
    required=True,
    help="Keep packs of so many days; older ones are deleted, whole.",
)
@click.option("--history", help="The history whose results may cite what is in them.")
@click.option("--no-history", is_flag=True, help="No history cites these captures.")
@click.option("--cited", is_flag=True, help="Delete packs that results cite as well.")
@click.option("--by", default="", help="Who does this, for the history's trail.")
@click.option("--dry-run", is_flag=True, help="Say what would be deleted.")
def delete(
    archive: File,
    days: int,
    history: str | None,
    no_history: bool,
    cited: bool,
    by: str,
    dry_run: bool,
) -> int:
    """Delete the packs that are older than a rule says.

    Where results of the history cite captures in them, nothing is deleted, unless --cited says so.
    The history's trail keeps who deleted which pack.
    """
    from contextlib import nullcontext
    from datetime import UTC, datetime

    from motorid.quality.history import open_history
    from motorid.workflow import retention

    if bool(history) == no_history:
        raise click.UsageError("name the --history whose results may cite them, or --no-history.")
    opened = open_history(history, create=False) if history else nullcontext()
    with opened as book:
        found = retention.old(archive, days, book, datetime.now(UTC).date())
        for one in found:
            said = f"{len(one.index.entries)} files, cited by {one.results} results"
            click.echo(f"{one.pack}: {said}")
        if not dry_run:
            if not cited:
                retention.refuse_cited(found)
            for _ in retention.delete(found, book, by):
                pass
    done = "would be deleted" if dry_run else "deleted"
    click.echo(f"{len(found)} packs {done}", err=True)
    return EXIT_DONE
