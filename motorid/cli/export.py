"""motorid export"""

from __future__ import annotations

from pathlib import Path

import click

from motorid.cli.options import Assignment, example, force_option
from motorid.cli.values import FINITE, Named
from motorid.errors import EXIT_DONE


@click.command(
    "export",
    epilog=example(
        "motorid export out/estimate.json --to mujoco -o motor.xml",
        "motorid export out/estimate.json --to spice --gear-ratio 19.2 -o geared.lib",
        "motorid export out/estimate.json --to fmu --set L=0.0002 -o motor.fmu",
        "motorid export out/capture.h5 --to parquet -o run.parquet",
    ),
)
@click.argument("source", type=Named(exists=True, path_type=Path))
@click.option(
    "--to",
    required=True,
    metavar="TARGET",
    help="mujoco, spice, control, fmu, octave, urdf, json or toml; written, not run here: "
    "simulink, simscape, modelica. Of a capture: csv, parquet, mat.",
)
@click.option(
    "-o",
    "--output",
    type=Named(dir_okay=False, path_type=Path),
    help="File to write; without it a text goes to standard output.",
)
@click.option(
    "--gear-ratio",
    type=FINITE,
    default=1.0,
    help="Describe the output of a gear of so many motor turns a turn, without its losses.",
)
@click.option(
    "--set",
    "given",
    multiple=True,
    type=Assignment("L=0.0002"),
    help="A constant at the motor's shaft in SI units, in place of the estimate's. Repeatable.",
)
@click.option(
    "--allow-doubtful",
    is_flag=True,
    help="Export values that are doubtful or at a bound, and say so in the file.",
)
@force_option
def command(
    source: Path,
    to: str,
    output: Path | None,
    gear_ratio: float,
    given: tuple[tuple[str, float], ...],
    allow_doubtful: bool,
    force: bool,
) -> int | None:
    """Write an estimate, or a capture, in the form that another program takes.

    SOURCE is the estimate.json of a fit, the folder that holds it, or a capture. Constants are at
    the motor's shaft unless --gear-ratio is given. Each file has the uncertainty, in parameters
    where the target holds it and in comments elsewhere. What the target cannot hold is said.

    Exit code 4 where a constant that the target needs has no value, or a doubtful one.
    """
    from motorid.capture.whole import refuse_existing, write_whole
    from motorid.errors import UsageError
    from motorid.export.targets import BINARY, export, insist_known

    insist_known(to)
    if output is not None:
        refuse_existing(output, force)
    elif to in BINARY:
        raise UsageError(f"{to} is no text: name its file by -o")
    made = export(
        source / "estimate.json" if source.is_dir() else source,
        to,
        gear_ratio=gear_ratio,
        given=dict(given),
        allow_doubtful=allow_doubtful,
    )
    for sentence in made.said:
        click.echo(f"note: {sentence}", err=True)
    if output is None:
        click.echo(made.content.decode("utf-8"), nl=False)
        return None
    write_whole(output, made.content, force=force)
    click.echo(f"wrote {output}", err=True)
    return EXIT_DONE
