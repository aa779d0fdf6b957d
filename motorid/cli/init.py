"""motorid init"""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from motorid.cli.options import example, force_option
from motorid.cli.values import Between, Named, Whole, finite
from motorid.errors import EXIT_DONE, RigError

BOARDS = ("uno", "nano", "mega", "pico", "other")
SENSORS = {"pico": "pico-ina240"}  # that is asked for first; others: an ACS712
DRIVERS = (
    "l298n", "l6203", "bts7960", "vnh5019", "tb6612fng", "drv8871", "drv8833",
    "half-bridges", "in-in", "pwm-dir", "pwm-dir-bare",
)  # fmt: skip
MOST_FIGURE = 1e6
PULSE = (
    "Now the bridge drives short weak pulses, and the motor may turn. Is it clamped, its shaft "
    "free, and the supply on?"
)


class Part(click.ParamType[str]):
    """The name or the file of a front end."""

    name = "NAME"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        from motorid.rig_front_end import load_front_end

        try:
            load_front_end(str(value))
        except RigError as error:
            self.fail(str(error), param, ctx)
        return str(value)


class Perhaps(click.ParamType[float | None]):
    """A figure above 0, or nothing where nobody knows it."""

    name = "NUMBER"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float | None:
        if value is None or not str(value).strip():
            return None
        found = 0.0
        with contextlib.suppress(ValueError):
            found = finite(str(value))
        if not 0.0 < found <= MOST_FIGURE:
            self.fail(f"{value!r} is no number above 0, such as 3.5", param, ctx)
        return found


@click.command(
    "init",
    epilog=example(
        "motorid init",
        "motorid init --board uno --driver l298n --sensor acs712-05 --counts 64",
    ),
)
@click.option(
    "-o",
    "--output",
    type=Named(dir_okay=False, path_type=Path),
    default=Path("bench.toml"),
    show_default=True,
    help="Rig file to write.",
)
@click.option(
    "--port",
    default="auto",
    show_default=True,
    help="The board's port; auto: the one board that is plugged in.",
)
@click.option(
    "--board", type=click.Choice(BOARDS), metavar="NAME", help="uno, nano, mega, pico or other."
)
@click.option(
    "--driver",
    type=click.Choice(DRIVERS),
    metavar="NAME",
    help="l298n, bts7960, in-in ...: a wrong name lists all.",
)
@click.option("--sensor", type=Part(), help="Current sensor: of motorid board list, or a file.")
@click.option(
    "--counts",
    type=Whole(min=1, max=100_000_000),
    help="Encoder counts of a turn: four a line.",
)
@click.option(
    "--gear",
    type=Between(1e-4, 1e5),
    default=1.0,
    show_default=True,
    help="Motor turns for a turn of the encoder.",
)
@click.option("--supply", type=Between(0.5, 800.0), help="V of the motor's supply.")
@click.option("--motor", help="What the motor's label says.")
@click.option("--volts", type=Between(0.1, 800.0), help="V on the motor's label.")
@click.option("--resistance", type=Between(1e-3, 1e5), help="Ohm of the motor, if known.")
@click.option("--rpm", type=Between(1.0, 1e6), help="No-load speed on the label, a minute.")
@click.option("--most", type=Between(1e-3, 1e4), help="Largest current in A, if less is wanted.")
@click.option(
    "--reference",
    type=Between(0.5, 10.0),
    help="V by a meter at the board's reference, where that is its supply.",
)
@click.option("--offline", is_flag=True, help="Write the files, and ask no board.")
@click.option("--pulse/--no-pulse", default=None, help="Drive the check pulse, or do not ask.")
@click.option("-y", "--yes", is_flag=True, help="Ask nothing; the motor moves with --pulse only.")
@force_option
def command(
    output: Path, offline: bool, pulse: bool | None, yes: bool, force: bool, **options: Any
) -> int:
    """Set up a bench: answer what it is made of, and get its rig file.

    It finds the board, writes a commented rig file and one of the front end, and stores the front
    end's facts in the board. Weak pulses then show signs, scales and counts, if you say so.
    """
    from motorid.workflow import init

    said = _answers(options, ask=None if yes else _ask)
    if not offline:
        said = init.found_port(said)
    bench = init.prepare(said, output, force=force, ask_board=not offline)
    init.write(bench)
    click.echo(f"wrote {bench.path} and {bench.front_end_path}")
    if offline:
        click.echo(f"next: motorid board set {bench.front_end_path} --port PORT")
        return EXIT_DONE
    if bench.kit.rig.front_end:
        for line in init.store(bench):
            click.echo(line)
    if pulse is None and not yes:
        pulse = click.confirm(PULSE, default=False)
    if not pulse:
        click.echo(f"the motor was not moved; next: motorid run --rig {bench.path} -o first")
        return EXIT_DONE
    for line in init.verdict(bench, _turn_round(yes)):
        click.echo(line)
    click.echo(f"the bench is ready: motorid run --rig {bench.path} -o first")
    return EXIT_DONE


Ask = Callable[[str, Any, Any], Any]


def _ask(question: str, kind: Any, default: Any) -> Any:
    try:
        return click.prompt(question, type=kind, default=default, show_default=bool(default))
    except click.Abort:
        if sys.stdin.isatty():
            raise
        raise click.UsageError(
            "the answers on standard input end here: give options, and --yes"
        ) from None


def _turn_round(yes: bool) -> Callable[[str], bool]:
    def asked(seen: str) -> bool:
        click.echo(seen)
        return yes or click.confirm("Count the encoder the other way?", default=True)

    return asked


def _answers(given: dict[str, Any], ask: Ask | None) -> Any:
    """What the options say, and what was asked for the rest. Raises UsageError."""
    from motorid.workflow.kit import Answers

    def need(name: str, question: str, kind: Any, default: Any = None) -> Any:
        if given[name] is not None:
            return given[name]
        if ask is None:
            raise click.UsageError(f"--{name} is missing: with --yes nothing is asked")
        return ask(question, kind, default)

    def may(name: str, question: str) -> float | None:
        """A figure that may stay unknown."""
        found: float | None = given[name]
        if found is None and ask is not None:
            found = ask(f"{question} (empty: not known)", Perhaps(), "")
        return found

    board = need("board", "Board", click.Choice(BOARDS), "uno")
    driver = need("driver", "Driver", click.Choice(DRIVERS), "l298n")
    usual = SENSORS.get(board, "acs712-05")
    sensor = need("sensor", "Current sensor (motorid board list names them)", Part(), usual)
    counts = need("counts", "Encoder counts of a turn (four a line)", Whole(min=1, max=100_000_000))
    supply = need("supply", "Supply of the motor, V", Between(0.5, 800.0))
    motor = need("motor", "Motor, as its label says", str)
    volts = need("volts", "Voltage on its label, V", Between(0.1, 800.0), supply)
    return Answers(
        board=board,
        port=given["port"],
        driver=driver,
        sensor=sensor,
        counts_per_turn=counts,
        supply_v=supply,
        motor=" ".join(motor.split()),
        motor_v=volts,
        gear_ratio=given["gear"],
        no_load_rpm=may("rpm", "No-load speed on its label, turns a minute"),
        resistance_ohm=may("resistance", "Resistance by a meter at its terminals, ohm"),
        most_a=given["most"],
        reference_v=_reference(sensor, may) if given["reference"] is None else given["reference"],
    )


def _reference(sensor: str, may: Callable[[str, str], float | None]) -> float | None:
    """Asked for where it is a supply: it scales every reading."""
    from motorid.rig_front_end import load_front_end
    from motorid.workflow.kit_front_end import is_a_supply

    front_end = load_front_end(sensor)
    if not is_a_supply(front_end):
        return None
    nominal = front_end.facts["reference_v"]
    return may("reference", f"V by a meter at the board's reference, about {nominal:g}")
