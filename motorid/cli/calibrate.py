"""motorid calibrate"""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from motorid.cli.options import example, port_option, speed_option
from motorid.cli.paged import Paged
from motorid.cli.streams import confirm, prompt
from motorid.cli.values import FINITE, Between, Named, Whole
from motorid.errors import EXIT_DONE

if TYPE_CHECKING:
    from motorid.acquire.port import Port
    from motorid.calibration.disc import Disc
    from motorid.rig import Rig
    from motorid.workflow.calibrate.person import Person, Reference


@click.command(
    "calibrate",
    cls=Paged,
    common=(*("steps", "answers", "simulated", "by", "port", "speed", "note"),),
    epilog=example(
        "motorid calibrate bench.toml --by 'A. Volta'",
        "motorid calibrate bench.toml --step rest --step current",
        "motorid calibrate bench.toml --answers meters.toml",
        "motorid calibrate copy-of-sim.toml --simulated --speed max",
    ),
)
@click.argument("rig_name", metavar="RIG")
@click.option(
    "--step",
    "steps",
    multiple=True,
    metavar="NAME",
    help="Only this step: rest, terminal_voltage, current, supply_voltage, encoder, clock, disc. "
    "Repeatable; default: all, each asked for.",
)
@click.option(
    "--answers",
    type=Named(exists=True, dir_okay=False, path_type=Path),
    help="Take the answers from this TOML file and ask nothing; steps it has no table of are left.",
)
@click.option(
    "--simulated",
    is_flag=True,
    help="Let a sim:// bench read its own meters and turn its own shaft.",
)
@click.option("--by", default="", help="Who calibrates.")
@click.option("--note", default="", help="Free text kept in the file.")
@click.option("--ambient", type=FINITE, help="°C  [default: the rig file's]")
@click.option(
    "--level",
    "levels_v",
    multiple=True,
    type=FINITE,
    metavar="VOLTS",
    help="Drive this level. Repeatable  [default: up to half the current limit, both ways]",
)
@click.option("--hold", "hold_s", type=Between(1, 60), default=4.0, help="Seconds of a level: 4.")
@click.option(
    "--turns", type=Between(1, 1000), default=10.0, help="Turns of the shaft by hand: 10."
)
@click.option("--clock-time", "clock_s", type=Between(5, 3600), default=30.0, help="Seconds: 30.")
@click.option(
    "--host-ppm",
    type=Between(0, 1000),
    default=10.0,
    help="Standard uncertainty of this computer's clock: 10 parts in a million.",
)
@click.option("--runs", type=Whole(1, 50), default=3, help="Runs with and without disc: 3.")
@click.option(
    "--captures",
    type=Named(file_okay=False, path_type=Path),
    help="Folder that keeps the runs with and without the disc.",
)
@port_option
@speed_option
def command(
    rig_name: str,
    steps: tuple[str, ...],
    answers: Path | None,
    simulated: bool,
    by: str,
    note: str,
    ambient: float | None,
    host_ppm: float,
    port: str | None,
    speed: str | None,
    **how: Any,
) -> int:
    """Hold the readings of RIG, a rig file of yours, against references.

    Walks through zero, gains, the supply, the encoder, the clock and a disc of known inertia, and
    writes what it finds, with uncertainties, into NAME.calibration.toml beside the rig file, which
    holds from then on. An earlier one is kept under its date. Any step can be skipped or repeated.
    The motor moves only after a step has said so.
    """
    from motorid.cli.progress import ProgressLine
    from motorid.workflow.calibrate import walk
    from motorid.workflow.calibrate.bench import Settings

    if answers and simulated:
        raise click.UsageError("--answers or --simulated: one of the two.")
    path, rig = walk.open_rig(rig_name, port=port, speed=speed)
    about: dict[str, Any] = {"by": by, "note": note}
    if ambient is not None:
        about["ambient_c"] = ambient
    with ProgressLine() as progress:
        written = walk.calibrate(
            path,
            rig,
            person_of(answers, simulated),
            steps=steps,
            settings=Settings(host_uncertainty=host_ppm * 1e-6, **how),
            about=about,
            progress=progress,
        )
    if written.archived:
        click.echo(f"kept the earlier one as {written.archived}", err=True)
    click.echo(f"wrote {written.path}", err=True)
    return EXIT_DONE


def person_of(answers: Path | None, simulated: bool) -> Person:
    """Who answers: a file, a simulated bench, or somebody at the keyboard."""
    if simulated:
        from motorid.workflow.calibrate.simulated import Simulated

        return Simulated(say=said)
    if answers:
        from motorid.workflow.calibrate.person import Filed, read_answers

        return Filed(read_answers(answers), str(answers), said, time.sleep)
    return Typed()


class Typed:
    """A person at the keyboard, or a script that answers one line a question."""

    def say(self, text: str) -> None:
        """See Person."""
        said(text)

    def ready(self, step: str, what: str) -> bool:
        """See Person."""
        click.echo(f"\n== {step.replace('_', ' ')}\n{_wrapped(what)}")
        return confirm("Do this step?", default=True)

    def proceed(self, what: str) -> None:
        """See Person."""
        click.echo(_wrapped(f"Next: {what}."))
        prompt("Enter starts it, Ctrl-C stops", default="", show_default=False)

    def again(self, step: str, problem: str) -> bool:
        """See Person."""
        if problem:
            click.echo(_wrapped(f"That did not work: {problem}"))
        name = step.replace("_", " ")
        return confirm(f"Repeat {name}?", default=bool(problem))

    def reference(self, step: str) -> Reference:
        """See Person."""
        from motorid.workflow.calibrate.person import reference_of

        kinds = ["meter", "resistor"] if step == "current" else ["meter"]
        kind = kinds[0]
        if len(kinds) > 1:
            kind = prompt("Reference", type=click.Choice(kinds), default=kind)
        table: dict[str, Any] = {
            kind: prompt("Its name", default="", show_default=False),
            "serial": prompt("Its serial number", default="", show_default=False),
        }
        if kind == "meter":
            text = "Its limit of error, from the data sheet, such as 0.5%+0.003 (A or V)"
            table["accuracy"] = prompt(text)
        else:
            table["resistor_ohm"] = prompt("Ohm", type=FINITE)
            table["resistor_limit_ohm"] = prompt("Its limit of error, ohm", type=FINITE)
        return reference_of(table, step)

    def reading(self, step: str, number: int, what: str) -> float:
        """See Person."""
        if step == "supply_voltage":
            click.echo(_wrapped(what))
        unit = "A" if step == "current" else "V"
        return float(prompt(f"The meter shows ({unit})", type=FINITE))

    def levels(self, step: str) -> int:
        """See Person."""
        return int(prompt("How many voltages", type=Whole(2, 20), default=3))

    def turn(self, turns: float) -> None:
        """See Person."""
        way = "forwards, from the mark to the mark" if turns > 0 else "back to the mark"
        prompt(
            f"Turn the shaft {abs(turns):g} turns {way}, then Enter", default="", show_default=False
        )

    def disc(self, rig: Rig) -> Disc:
        """See Person."""
        from motorid.workflow.calibrate.person import disc_of

        asked = {
            "mass_kg": "Mass, kg",
            "mass_uncertainty_kg": "  its standard uncertainty, kg",
            "diameter_m": "Diameter, m",
            "diameter_uncertainty_m": "  its standard uncertainty, m",
            "bore_m": "Diameter of its hole, m (0: none)",
            "bore_uncertainty_m": "  its standard uncertainty, m",
        }
        figures = {key: prompt(text, type=FINITE) for key, text in asked.items()}
        return disc_of(figures, "the disc")

    def arrange(self, rig: Rig, setup: str) -> Rig:
        """See Person: it was asked for already."""
        return rig

    def meet(self, port: Port) -> None:
        """See Person."""


def said(text: str) -> None:
    """Shows a line of a guided run, folded."""
    bare = text.lstrip()
    indent = " " * (len(text) - len(bare))
    shown = click.wrap_text(bare, width=78, initial_indent=indent, subsequent_indent=indent + "  ")
    click.echo(shown)


def _wrapped(text: str) -> str:
    return str(click.wrap_text(text, width=78))
