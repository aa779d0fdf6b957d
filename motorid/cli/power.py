"""motorid power"""

from __future__ import annotations

from pathlib import Path

import click

from motorid.cli.names import RIG
from motorid.cli.options import (
    Assignment,
    cluster_option,
    example,
    force_option,
    jobs_option,
    product_option,
)
from motorid.cli.values import Named, Whole
from motorid.errors import EXIT_DONE

RESULT = "power.json"


@click.command(
    "power",
    epilog=example(
        "motorid power --product sim-disc --rig sim-line -o power",
        "motorid power --product motor.toml --rig sim.toml --motors 80 -o power",
    ),
)
@product_option
@click.option("--rig", "rig_name", type=RIG, required=True, help="A simulated rig (sim://).")
@click.option(
    "--defect", "defects", multiple=True, help="Only this one. Repeatable; default: all twelve."
)
@click.option("--motors", type=Whole(8, 100_000), default=40, show_default=True,
              help="Motors of each defect.")  # fmt: skip
@click.option("--good", type=Whole(8, 100_000), default=60, show_default=True,
              help="Motors without a defect.")  # fmt: skip
@click.option(
    "--spread",
    multiple=True,
    type=Assignment("copper=0.01"),
    help="Relative standard deviation of good motors: copper (R), magnet (K), winding, friction "
    "or load_inertia. Repeatable.",
)
@jobs_option
@cluster_option
@click.option(
    "-o",
    "--output",
    required=True,
    type=Named(file_okay=False, path_type=Path),
    help="Folder of power.json and of each finished motor; an interrupted study goes on there.",
)
@force_option
def command(
    product_name: str,
    rig_name: str,
    defects: tuple[str, ...],
    motors: int,
    good: int,
    spread: tuple[tuple[str, float], ...],
    jobs: int,
    cluster: str | None,
    output: Path,
    force: bool,
) -> int:
    """How large a defect must be to be found: simulated motors, judged as the line judges.

    For each defect the severity that half of such motors do not pass with, and that 95 of 100 do
    not, with the share of good motors that do not pass either.
    """
    from motorid.capture.whole import refuse_existing, write_whole
    from motorid.cli.compare import TaskBar
    from motorid.json_text import dumps
    from motorid.quality.product import load_product
    from motorid.report import power as report
    from motorid.rig import load_rig
    from motorid.workflow import power as workflow

    if output.is_dir():
        refuse_existing(output / RESULT, force)
    found = workflow.study(
        load_product(product_name),
        load_rig(rig_name),
        output,
        defects=defects,
        motors=motors,
        good=good,
        spread=dict(spread),
        jobs=cluster or jobs,
        progress=TaskBar(),
    )
    text = dumps(report.to_dict(found), indent=2) + "\n"
    write_whole(output / RESULT, text.encode(), force=force)
    click.echo(report.text(found))
    click.echo(f"wrote {output / RESULT}", err=True)
    return EXIT_DONE
