"""The ``motorid`` command."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from io import TextIOWrapper
from typing import NoReturn

import click

from motorid import __version__
from motorid.acquire.interrupt import heed
from motorid.cli.failures import report
from motorid.cli.lazy import LazyGroup

COMMANDS = {
    "run": ("run", "Capture, fit and report in one go."),
    "plan": ("plan", "Propose the shortest program that reaches asked-for uncertainties."),
    "capture": ("capture", "Drive the motor of a rig and record the run."),
    "recover": ("recover", "Build the capture that an interrupted run left in its journal."),
    "import": ("import_", "Turn somebody else's CSV or MAT file into a capture."),
    "segment": ("segment", "Show where a capture accelerates, runs steadily, coasts and rests."),
    "fit": ("fit", "Estimate R, L, K, B, J and T0 from captures."),
    "calibrate": (
        "calibrate",
        "Hold a rig against meters, a resistor and a disc; keep what they say.",
    ),
    "check": ("check", "Measure and judge one motor by a product's limits."),
    "station": ("station", "Inspect motor after motor, for an operator or a line controller."),
    "gauge": ("gauge", "Study the gauge itself: crossed R&R, a golden motor, linearity."),
    "trend": ("trend", "Control charts, capability and drift of what was measured; alarms."),
    "history": ("history", "The database of results: trace, judge again, export."),
    "compare": ("compare", "Many methods on the same captures; the review's tables, rebuilt."),
    "ports": ("ports", "List the serial ports, without opening them."),
    "rigs": ("rigs", "List the rigs that come with motorid."),
    "flash": ("flash", "Put the firmware on an Arduino Uno or Mega, by avrdude."),
    "sim": ("sim", "Offer the simulated board to another program."),
}


@click.command(
    cls=LazyGroup,
    table=COMMANDS,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog="\b\nExample:\n  motorid run --rig sim -o out",
)
@click.version_option(__version__, prog_name="motorid")
def cli() -> None:
    """Identify a brushed DC motor on a bench: R, L, K, B, J and T0, with honest uncertainty.

    Exit codes: 0 done, 1 a FAIL verdict, 2 usage, 3 rig or link, 4 bad or insufficient data, 70
    internal error, 130 interrupted.
    """


def run(args: Sequence[str]) -> int:
    """Runs one command line and returns its exit code; never raises."""
    try:
        with cli.make_context("motorid", list(args) or ["--help"]) as context:
            return int(cli.invoke(context) or 0)
    except click.exceptions.Exit as end:  # after --help and --version
        return end.exit_code
    except BaseException as error:
        return report(error)


def main() -> NoReturn:
    """The entry point of the installed command."""
    heed()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without Ω still gets its table
    sys.exit(run(sys.argv[1:]))


if __name__ == "__main__":
    main()
