"""The ``motorid`` command."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import NoReturn

import click

from motorid.acquire import interrupt
from motorid.cli import streams
from motorid.cli.failures import refuse_unprintable, report, report_lost
from motorid.cli.lazy import LazyGroup
from motorid.errors import EXIT_DONE, EXIT_INTERNAL, EXIT_INTERRUPTED
from motorid.version import __version__

COMPLETING = "_MOTORID_COMPLETE"  # a shell sets it where it asks for completions
COMMANDS = {
    "run": ("run", "Capture, fit and report in one go."),
    "plan": ("plan", "Propose the shortest program for the uncertainties asked for."),
    "capture": ("capture", "Drive the motor of a rig and record the run."),
    "scope": ("scope", "Watch a rig live, on a page or in the terminal."),
    "recover": ("recover", "Build the capture that an interrupted run left in its journal."),
    "import": ("import_", "Turn somebody else's table or log into a capture."),
    "segment": ("segment", "Show where a capture accelerates, runs, coasts and rests."),
    "fit": ("fit", "Estimate R, L, K, B, J and T0 from captures."),
    "export": (
        "export",
        "Write an estimate for MuJoCo, SPICE, FMI and others.",
    ),
    "calibrate": (
        "calibrate",
        "Compare a rig with meters and a disc, and correct it.",
    ),
    "check": ("check", "Measure and judge one motor by a product's limits."),
    "station": ("station", "Inspect motor after motor, by an operator or a line."),
    "product": ("product", "Sign a product's limits with a named key."),
    "token": ("token", "Tokens of a station's users: add, list, remove; with roles."),
    "gauge": ("gauge", "Study the gauge itself: R&R, golden motor, verdicts, stations."),
    "trend": ("trend", "Control charts, capability and drift of measurements; alarms."),
    "risk": ("risk", "Consumer's and producer's risks of a limit and its rule."),
    "power": ("power", "How large a defect must be to be found, by simulation."),
    "history": ("history", "The database of results: trace, judge again, export."),
    "archive": ("archive", "Captures in packs, by day and station: pack, find, delete."),
    "dashboard": ("dashboard", "Show a line's history on a page: yield, reasons, charts."),
    "verify": ("verify", "Say of each file whether it is still what was written."),
    "compare": ("compare", "Many methods on the same captures; the review's tables."),
    "motors": ("motors", "Several motors on one page: what differs, and all curves."),
    "ports": ("ports", "List the serial ports, without opening them."),
    "rigs": ("rigs", "List the rigs that come with motorid."),
    "board": ("board", "Show and store what a board knows of its sensors and dividers."),
    "conformance": ("conformance", "Prove a board by suite and bench: one bundle to send."),
    "init": ("init", "Set up a bench: rig file, front end, and a first weak pulse."),
    "flash": ("flash", "Put the firmware on an Arduino Uno, Nano or Mega, by avrdude."),
    "sim": ("sim", "Offer the simulated board to another program."),
    "config": ("config", "Show and set the defaults of options, in one file."),
    "completion": ("completion", "Let the shell complete commands, options and files."),
}
TASKS = {
    "Measure": ("run", "plan", "capture", "scope", "recover", "calibrate"),
    "Look and fit": ("import", "segment", "fit", "motors", "compare", "export", "verify"),
    "Inspect motors": (
        "check",
        "station",
        "product",
        "token",
        "gauge",
        "trend",
        "risk",
        "power",
        "history",
        "archive",
        "dashboard",
    ),
    "Set up": (
        "init",
        "ports",
        "rigs",
        "board",
        "flash",
        "conformance",
        "sim",
        "config",
        "completion",
    ),
}


@click.command(
    cls=LazyGroup,
    table=COMMANDS,
    tasks=TASKS,
    options_metavar="[-h | --version]",
    subcommand_metavar="COMMAND [-h | ARGS...]",
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.version_option(__version__, prog_name="motorid")
def cli() -> None:
    """\b
    Identify a brushed DC motor on a bench: motorid run --rig sim -o out
    Exit: 0 done, 1 FAIL, 2 usage, 3 rig or link, 4 data, 70 bug, 130 stopped.
    """


def _answer() -> int:
    """What a shell asked for: its script, or the words that may follow."""
    from motorid.cli.completion import answer

    return answer(cli, os.environ[COMPLETING])


def run(args: Sequence[str]) -> int:
    """Runs one command line and returns its exit code; never raises.

    A command returns the code of an outcome that stands whether or not it could be printed: a
    verdict, or what it left in a file. One that returns None has given its answer on standard
    output, and fails where that could not be written.
    """
    with streams.shown():
        try:
            refuse_unprintable(args)
            code = _invoke(args)
            problem = streams.lost(sys.stdout)
            return report_lost(problem, code) if problem else code or EXIT_DONE
        except BaseException as error:
            return report(error)


def _invoke(args: Sequence[str]) -> int | None:
    try:
        # color: click would drop escape sequences of others unseen, where ``Shown`` shows them
        words = list(args) or ["--help"]
        with cli.make_context("motorid", words, color=True, default_map=_set(words)) as context:
            code: int | None = cli.invoke(context)
            return code
    except click.exceptions.Exit as end:  # after --help and --version
        return end.exit_code or None


def _set(words: Sequence[str]) -> dict[str, dict[str, object]]:
    """The defaults that the user has set, where there may be any: most have no such file."""
    if words[0].startswith("-") or words[0] in ("config", "completion"):
        return {}
    from motorid.cli import settings

    return settings.defaults()


def main() -> NoReturn:
    """The entry point of the installed command."""
    code = EXIT_INTERNAL
    try:
        interrupt.heed()
        streams.sturdy()
        code = _answer() if COMPLETING in os.environ else run(sys.argv[1:])
        interrupt.heed_no_more()  # the outcome is settled
    except KeyboardInterrupt:  # a second one, while the first was reported
        code = EXIT_INTERRUPTED
    except BaseException:
        code = EXIT_INTERNAL
    _forget_interruption()
    sys.exit(code)


def _forget_interruption() -> None:
    """Lets ``sys.exit`` end with its own code after an interruption that was answered.

    CPython marks a KeyboardInterrupt that leaves compiled text, as of a dataclass that is made at
    an import, and then ends by SIGINT whatever the code. The next such text clears the mark.
    """
    exec("")  # noqa: S102 - nothing


if __name__ == "__main__":
    main()
