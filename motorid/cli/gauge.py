"""motorid gauge"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from motorid.cli import gauge_agreement, gauge_reference
from motorid.cli.options import Assignment, cluster_option, example, force_option
from motorid.cli.streams import prompt
from motorid.cli.values import FINITE, JOBS, Between, Named, Whole
from motorid.errors import EXIT_DONE, EXIT_FAIL_VERDICT

if TYPE_CHECKING:
    from motorid.quality.gauge import GaugeResult, Method
    from motorid.quality.product import Product
    from motorid.workflow.gauge import Run


@click.group(
    "gauge",
    epilog=example(
        "motorid gauge run --rig sim --part M1 --part M2 --operator anna --operator ben -o study",
        "motorid gauge crossed readings.csv --tolerance R=0.4 -o study",
        "motorid gauge golden readings.csv --quantity R --reference 2.6 --tolerance 0.4",
        "motorid gauge attribute verdicts.csv --bad FAIL",
        "motorid gauge stations line.db --quantity R_25",
    ),
)
def command() -> None:
    """Study the gauge itself: R&R, a golden motor, linearity, verdicts, stations (AIAG MSA).

    Exit code 1 only where a limit that was asked for (--max-grr, --min-cgk, --min-kappa,
    --max-difference) is missed.
    """


for study in (
    gauge_reference.golden,
    gauge_reference.linearity,
    gauge_agreement.attribute,
    gauge_agreement.stations,
):
    command.add_command(study)


FILE = click.argument("file", type=Named(exists=True, dir_okay=False, path_type=Path))
OUTPUT = click.option(
    "-o", "--output", type=Named(file_okay=False, path_type=Path), help="Folder of the report."
)
TOLERANCES = click.option(
    "--tolerance",
    "tolerances",
    multiple=True,
    type=Assignment("R=0.4"),
    help="Width of a quantity's tolerance, in SI units: %GRR is then of it. Repeatable.",
)
QUANTITIES = click.option(
    "--quantity", "quantities", multiple=True, help="Study this one. Repeatable; default: all."
)
METHOD = click.option(
    "--method",
    type=click.Choice(["anova", "range"]),
    default="anova",
    show_default=True,
    help="Analysis of variance, or average and range.",
)
MAX_GRR = click.option(
    "--max-grr", type=FINITE, metavar="PERCENT", help="A larger %GRR of any quantity is a FAIL."
)
ALPHA = click.option(
    "--alpha",
    type=Between(min=0, max=1),
    default=0.25,
    show_default=True,
    help="Pool an interaction of a larger p into EV: 0 always, 1 never.",
)
PRODUCT = click.option(
    "--product", "product_name", help="Study a product's quantities, by its program and tolerances."
)


@command.command("crossed")
@FILE
@QUANTITIES
@TOLERANCES
@METHOD
@ALPHA
@MAX_GRR
@OUTPUT
@force_option
def crossed(
    file: Path,
    quantities: tuple[str, ...],
    tolerances: tuple[tuple[str, float], ...],
    method: str,
    alpha: float,
    max_grr: float | None,
    output: Path | None,
    force: bool,
) -> int | None:
    """Analyse a crossed study: CSV with columns part, operator, and one a quantity."""
    how: Method = "range" if method == "range" else "anova"
    results = _analysed(file, quantities, tolerances, method=how, alpha=alpha)
    return _report(results, output, f"Gauge study {file.stem}", force, max_grr)


@command.command("nested")
@FILE
@QUANTITIES
@TOLERANCES
@MAX_GRR
@OUTPUT
@force_option
def nested(
    file: Path,
    quantities: tuple[str, ...],
    tolerances: tuple[tuple[str, float], ...],
    max_grr: float | None,
    output: Path | None,
    force: bool,
) -> int | None:
    """Analyse a nested study: each operator has parts that nobody else measures."""
    results = _analysed(file, quantities, tolerances, method="nested")
    return _report(results, output, f"Nested gauge study {file.stem}", force, max_grr)


def _analysed(
    file: Path,
    quantities: tuple[str, ...],
    tolerances: tuple[tuple[str, float], ...],
    *,
    method: Method,
    alpha: float | None = None,
) -> list[GaugeResult]:
    from motorid.quality.study_file import read_rows
    from motorid.workflow import gauge as workflow

    return workflow.analyse_rows(
        read_rows(file),
        str(file),
        quantities=quantities,
        tolerances=dict(tolerances),
        units=workflow.units_known(),
        method=method,
        alpha=alpha,
    )


@command.command("run")
@click.option(
    "--rig", "rig_names", multiple=True, help="Rig of every operator. Repeatable, see -f."
)
@click.option(
    "-f",
    "--fixture",
    "fixtures",
    multiple=True,
    metavar="NAME=RIG",
    help="A fixture with a rig of its own, instead of --rig and --operator. Repeatable.",
)
@click.option("--operator", "operators", multiple=True, help="Who measures. Repeatable.")
@click.option(
    "--part",
    "parts",
    multiple=True,
    required=True,
    metavar="NAME[=OPTIONS]",
    help="A motor, by its serial number; OPTIONS tell a simulated rig what it is. Repeatable.",
)
@click.option("--repeats", type=Whole(2, 1000), default=3, show_default=True, help="Rounds.")
@click.option("--yes", is_flag=True, help="Do not wait for each part to be mounted.")
@click.option("--jobs", type=JOBS, default=1, show_default=True, help="Processes that fit.")
@cluster_option
@PRODUCT
@TOLERANCES
@METHOD
@ALPHA
@MAX_GRR
@click.option(
    "-o",
    "--output",
    required=True,
    type=Named(file_okay=False, path_type=Path),
    help="Folder of captures, readings and report; an interrupted study goes on there.",
)
@force_option
def run(
    rig_names: tuple[str, ...],
    fixtures: tuple[str, ...],
    operators: tuple[str, ...],
    parts: tuple[str, ...],
    repeats: int,
    yes: bool,
    jobs: int,
    cluster: str | None,
    product_name: str | None,
    tolerances: tuple[tuple[str, float], ...],
    method: str,
    alpha: float,
    max_grr: float | None,
    output: Path,
    force: bool,
) -> int | None:
    """Measure a crossed study on the rig, then analyse it.

    Every operator measures every part in every round, in a shuffled order.
    """
    from motorid.capture.whole import refuse_existing, write_whole
    from motorid.cli.compare import TaskBar
    from motorid.quality.study_file import read_rows
    from motorid.rig import load_rig
    from motorid.workflow import gauge as workflow

    rigs = {name: load_rig(rig) for name, rig in _fixtures(rig_names, fixtures, operators).items()}
    options = {name: text for name, _, text in (part.partition("=") for part in parts)}
    product = _product(product_name)
    table = output / workflow.READINGS
    for name in (workflow.READINGS, workflow.JSON_FILE, workflow.REPORT):
        if output.is_dir():
            refuse_existing(output / name, force)
    runs = workflow.plan(list(options), list(rigs), repeats, output)
    workflow.measure(runs, rigs, options, product=product, ask=None if yes else _ask)
    text = workflow.readings(
        runs, output, product=product, jobs=cluster or jobs, progress=TaskBar()
    )
    write_whole(table, text.encode(), force=force)
    known = workflow.tolerances_of(product) if product else {}
    results = workflow.analyse_rows(
        read_rows(table),
        str(table),
        tolerances=known | dict(tolerances),
        units=workflow.units_known(product),
        method="range" if method == "range" else "anova",
        alpha=alpha,
    )
    return _report(results, output, "Gauge study", force, max_grr)


def _fixtures(
    rig_names: Sequence[str], fixtures: Sequence[str], operators: Sequence[str]
) -> dict[str, str]:
    """Rig by operator or fixture. Raises UsageError where the options do not say one."""
    if fixtures:
        pairs = [one.partition("=") for one in fixtures]
        if rig_names or operators or not all(name and rig for name, _, rig in pairs):
            raise click.UsageError("--fixture is NAME=RIG, without --rig and --operator.")
        return {name: rig for name, _, rig in pairs}
    if len(rig_names) != 1 or not operators:
        raise click.UsageError("give one --rig and each --operator, or each --fixture NAME=RIG.")
    return dict.fromkeys(operators, rig_names[0])


def _product(name: str | None) -> Product | None:
    if name is None:
        return None
    from motorid.quality.product import load_product

    return load_product(name)


def _ask(run: Run) -> None:
    said = f"round {run.repeat}: {run.operator}, mount motor {run.part}, then press Enter"
    prompt(said, default="", show_default=False, prompt_suffix=" ", err=True)


def _report(
    results: list[GaugeResult], output: Path | None, title: str, force: bool, most: float | None
) -> int | None:
    from motorid.report import gauge
    from motorid.workflow.gauge import write

    click.echo(gauge.text(results))
    if output:
        for path in write(results, output, title=title, force=force):
            click.echo(f"wrote {path}", err=True)
    if most is None:
        return EXIT_DONE if output else None
    late = [r.study.quantity for r in results if not gauge.judged_percent(r)[0] <= most]
    for name in late:
        click.echo(f"FAIL: {name} has a %GRR above {most:g}")
    return EXIT_FAIL_VERDICT if late else EXIT_DONE
