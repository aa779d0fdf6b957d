"""motorid plan"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from motorid.cli.names import RIG
from motorid.cli.options import example, force_option, port_option
from motorid.cli.values import Between, Named
from motorid.errors import EXIT_DONE

if TYPE_CHECKING:
    from motorid.rig import Rig


@click.command(
    "plan",
    epilog=example(
        "motorid plan --rig sim --want R=1% --want J=2% -o planned.toml",
        "motorid run --rig planned.toml -o out",
        "motorid plan --rig bench.toml --capture first.h5",
        "motorid plan --rig sim-line --product sim-disc",
        "motorid plan --rig sim-re35 --iron --want L_1kHz=3% -o iron.toml",
    ),
)
@click.option(
    "--rig", "rig_name", type=RIG, required=True, help="Rig file, or a packaged rig's name."
)
@port_option
@click.option(
    "--want",
    "wants",
    multiple=True,
    metavar="NAME=SIZE",
    help="Half the 95 % interval of R, L, K, B, J or T0: 1%, or a number in SI units. Repeatable. "
    " [default: R=1% L=5% K=1% B=20% J=2% T0=10%]",
)
@click.option("--product", "product_name", help="Reach what this product's limits need instead.")
@click.option(
    "--capture",
    "first",
    type=Named(exists=True, dir_okay=False, path_type=Path),
    help="A first run of this motor on this rig: narrower than the nameplate.",
)
@click.option(
    "--iron",
    is_flag=True,
    help="A PRBS for a rotor that is held: R, L at no current, L_1kHz, L_rated, L_pwm. "
    "[default: R=1% L=2% L_1kHz=3%]",
)
@click.option(
    "--energy",
    "energy_j",
    type=Between(1e-6, 1e6),
    metavar="J",
    help="Most I²R heat of one run of a held rotor. [default: 10]",
)
@click.option("--explain", is_flag=True, help="Only say what channels and program can tell.")
@click.option(
    "-o",
    "--output",
    type=Named(dir_okay=False, path_type=Path),
    help="Write the rig file (with --product the product file) with the planned program.",
)
@force_option
def command(
    rig_name: str,
    port: str | None,
    wants: tuple[str, ...],
    product_name: str | None,
    first: Path | None,
    iron: bool,
    energy_j: float | None,
    explain: bool,
    output: Path | None,
    force: bool,
) -> int | None:
    """Propose the shortest program that reaches the uncertainties asked for.

    It keeps within the rig's limits and the board's, and holds for every motor that the nameplate
    (or the product's limits, or a first run) leaves possible. Nothing moves.
    """
    from motorid.capture.whole import refuse_existing, write_whole
    from motorid.quality.product import load_product
    from motorid.report import plan as render
    from motorid.rig_file import find
    from motorid.workflow import plan as planning
    from motorid.workflow import plan_file, plan_iron
    from motorid.workflow.record import bench

    rig = bench(rig_name, port=port)
    product = load_product(product_name) if product_name else None
    if explain:
        program = product.program if product else rig.program
        click.echo(render.explain(planning.excitation(rig, program)), nl=False)
        return None
    if output:
        refuse_existing(output, force)
    asked = [w for text in wants for w in text.split()]
    if iron or plan_iron.asks_for_iron(asked):
        if product or first:
            raise click.UsageError("--product and --capture do not go with a plan for the iron.")
        return _iron(rig, rig_name, asked, energy_j, output, force)
    if energy_j is not None:
        raise click.UsageError("--energy goes with --iron.")
    plan = planning.plan_run(rig, asked, first=first, product=product)
    click.echo(render.render(plan, rig.sampling.channels, len(plan.predictions)), nl=False)
    if output:
        text = (
            plan_file.product_text(product, plan, output)
            if product
            else plan_file.rig_text(rig, find(rig_name), plan, output)
        )
        write_whole(output, text.encode(), force=force)
        click.echo(f"wrote {output}", err=True)
    return EXIT_DONE if output else None


def _iron(
    rig: Rig,
    rig_name: str,
    wants: Sequence[str],
    energy_j: float | None,
    output: Path | None,
    force: bool,
) -> int | None:
    from motorid.capture.whole import write_whole
    from motorid.report.plan_iron import render
    from motorid.rig_file import find
    from motorid.workflow import plan_iron

    plan = plan_iron.plan_iron(rig, wants, energy_j)
    click.echo(render(plan), nl=False)
    if output is None:
        return None
    text = plan_iron.rig_text(rig, find(rig_name), plan, output)
    write_whole(output, text.encode(), force=force)
    click.echo(f"wrote {output}", err=True)
    return EXIT_DONE
