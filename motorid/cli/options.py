"""Values parsed at the door, and the options that several commands share."""

from __future__ import annotations

import glob
from collections.abc import Callable
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from motorid.cli.names import PORT, PRODUCT, RIG
from motorid.cli.streams import folded
from motorid.cli.values import JOBS, Kept, Whole, finite

if TYPE_CHECKING:
    from motorid.rig import Rig
    from motorid.storage.place import Place, Url

EXAMPLE_WIDTH = 74  # columns, of a terminal with 80
Command = TypeVar("Command", bound=Callable[..., Any])


class Assignment(click.ParamType[tuple[str, float]]):
    """``K=0.0514`` -> ("K", 0.0514). ``such_as`` is what an error shows."""

    name = "NAME=VALUE"

    def __init__(self, such_as: str) -> None:
        self.such_as = such_as

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, float]:
        if isinstance(value, tuple):
            return value
        name, equals, number = str(value).partition("=")
        try:
            if not (name and equals):
                raise ValueError
            return name.strip(), finite(number)
        except ValueError:
            self.fail(f"{value!r} is not NAME=NUMBER, such as {self.such_as}", param, ctx)


class Statement(click.ParamType[tuple[str, str]]):
    """``current=20Hz,2`` -> ("current", "20Hz,2"). ``such_as`` is what an error shows."""

    name = "NAME=VALUE"

    def __init__(self, such_as: str) -> None:
        self.such_as = such_as

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, str]:
        if isinstance(value, tuple):
            return value
        name, equals, said = (part.strip() for part in str(value).partition("="))
        if not (name and equals and said):
            self.fail(f"{value!r} is not NAME=VALUE, such as {self.such_as}", param, ctx)
        return name, said


class Instant(click.ParamType[datetime]):
    """``2026-11-21``, ``2026-11-21T06:00`` or with a zone; without one, of this machine's clock."""

    name = "INSTANT"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> datetime:
        if isinstance(value, datetime):
            return value
        try:
            return datetime.fromisoformat(str(value)).astimezone()
        except (ValueError, OverflowError, OSError):  # years that no clock can count
            self.fail(f"{value!r} is no date or time, such as 2026-11-21T06:00", param, ctx)


INSTANT = Instant()


def expand(files: tuple[str, ...]) -> list[Path]:
    """Paths of capture files; a pattern that the shell left alone (Windows) is expanded here."""
    paths: list[Path] = []
    for file in files:
        found = [file] if Path(file).exists() else sorted(glob.glob(file))
        if not found:
            raise click.UsageError(f"there is no file {file!r}.", click.get_current_context())
        paths.extend(Path(name) for name in found)
    return paths


def places(files: tuple[str, ...]) -> list[Place]:
    """As ``expand``, with URLs of an object store and files of packs among them."""
    from motorid.storage.place import place

    found: list[Place] = []
    for file in files:
        named = place(file)
        found += expand((file,)) if isinstance(named, Path) else [named]
    return found


def warned(rig: Rig) -> Rig:
    """``rig``, after saying on stderr what a person should know of it before it drives a motor.

    It holds what the command took from the user's defaults, for its captures to record.
    """
    from motorid.cli.settings import taken
    from motorid.workflow.rig_doubts import doubts

    for sentence in doubts(rig):
        warn(sentence)
    return replace(rig, settings=taken(click.get_current_context(silent=True)))


def warn(sentence: str) -> None:
    """Says on stderr what a person should know before a motor turns."""
    click.echo(folded(f"motorid: warning: {sentence}"), err=True)


def wrote(path: Path, kept: Url | None = None, *, force: bool = False) -> None:
    """Says that a capture is in ``path``, and what is wrong with it.

    ``kept``: where it is in an object store, after it was brought there.
    """
    from motorid.workflow import record, spool

    remarks = record.remarks(path)  # reads it: nothing is said to be written that is not there
    place = spool.deliver(path, kept, force=force) if kept else path
    click.echo(f"wrote {place}", err=True)
    for remark in remarks:
        click.echo(folded(f"note: {remark}"), err=True)


def make_way(path: Path, runs: int, force: bool) -> None:
    """With ``--force``, moves aside what an earlier run left in a journal, and says so."""
    from motorid.workflow import record

    for sentence in record.make_way(path, runs) if force else ():
        click.echo(folded(f"note: {sentence}"), err=True)


def example(*lines: str) -> str:
    """The epilog of a command's help: commands to copy, those too long for a page in two lines."""
    return "\b\nExample:\n" + "\n".join(_folded(line) for line in lines)


def _folded(line: str) -> str:
    """``line`` as a shell reads it, broken before an option where it is wider than a terminal."""
    room = EXAMPLE_WIDTH
    if len(line) <= room:
        return f"  {line}"
    at = line.rfind(" -", 0, room - 2)
    return f"  {line[:at]} \\\n      {line[at + 1 :]}"


def fit_options(command: Command) -> Command:
    """--fix, --without, --method and --strict: how to fit."""
    for option in (
        click.option(
            "--strict",
            is_flag=True,
            help="End with 4 where a parameter is doubtful or not supported.",
        ),
        click.option("--method", default="ml", show_default=True, help="How to estimate."),
        click.option(
            "--without",
            "without",
            multiple=True,
            metavar="NAME",
            help="Leave a parameter out of the model (L: no inductance). Repeatable.",
        ),
        click.option(
            "--fix",
            multiple=True,
            type=Assignment("K=0.0514"),
            help="Hold a parameter at a known value, in SI units. Repeatable.",
        ),
    ):
        command = option(command)
    return command


def _cluster(_: click.Context, __: click.Parameter, value: str | None) -> str | None:
    from motorid.workflow.cluster import check_address

    return check_address(value) if value else None


nameplate_option = click.option(
    "--nameplate",
    multiple=True,
    metavar="FILE|KEY=VALUE",
    help="What is known of the motor: a file with [nameplate] and [thermal] as in a rig file, or "
    "one figure (torque_constant_nm_a=0.0514). It is compared with what is found. Repeatable.",
)
force_option = click.option("--force", is_flag=True, help="Replace files that exist.")
jobs_option = click.option(
    "--jobs", type=JOBS, default=-1, show_default=True, help="Processes; -1 is one a core."
)
cluster_option = click.option(
    "--cluster",
    metavar="ADDRESS",
    callback=_cluster,
    help="A Dask cluster in place of --jobs: tcp://HOST:PORT, or local:N for N processes here.",
)
moved_option = click.option(
    "--captures",
    "folders",
    multiple=True,
    type=Kept(exists=True, path_type=Path),
    help="Look here, by SHA-256, for captures that have moved: a folder, packs, or s3://... of "
    "either. Repeatable.",
)
port_option = click.option(
    "--port",
    type=PORT,
    help="Port to use instead of the rig file's; auto: the only board that is plugged in.",
)
product_option = click.option(
    "--product",
    "product_name",
    type=PRODUCT,
    required=True,
    help="Product file, or a packaged product's name.",
)
rig_option = click.option(
    "--rig",
    "rig_name",
    type=RIG,
    required=True,
    help="Rig file, or the name of a packaged rig.",
)
speed_option = click.option(
    "--speed",
    type=click.Choice(["realtime", "max"]),
    help="Pace of a simulated rig; a real one has its own.",
)


def search_options(command: Command) -> Command:
    """--model, and --budget and --seed of a method that searches."""
    for option in (
        click.option("--seed", type=Whole(min=0), help="Of a search's random numbers: 0."),
        click.option(
            "--budget", type=Whole(min=100), help="Evaluations of a search at most: 5000."
        ),
        click.option(
            "--model",
            metavar="auto|six|NAME[+NAME]",
            help="Model beside the six parameters: auto, where the data ask for one. A search fits "
            "six, quadratic-load or two-masses instead.",
        ),
    ):
        command = option(command)
    return command


def capture_options(command: Command) -> Command:
    """--rig, --port, --serial, --note, --repeat and --speed: what to drive and how to label it."""
    for option in (
        speed_option,
        click.option("--note", default="", help="Free text kept in the capture."),
        click.option("--serial", default="", help="Serial number of the motor."),
        click.option(
            "--repeat",
            type=Whole(1, 10_000),
            default=1,
            show_default=True,
            help="Number of runs; each is a file of its own.",
        ),
        port_option,
        rig_option,
    ):
        command = option(command)
    return command
