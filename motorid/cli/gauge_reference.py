"""motorid gauge golden and motorid gauge linearity: the gauge against known motors."""

from __future__ import annotations

from pathlib import Path

import click

from motorid.cli.values import FINITE, Between, Named
from motorid.errors import EXIT_DONE, EXIT_FAIL_VERDICT

FILE = click.argument("file", type=Named(exists=True, dir_okay=False, path_type=Path))


@click.command("golden")
@FILE
@click.option("--quantity", required=True, help="Column of the readings.")
@click.option("--reference", type=FINITE, required=True, help="The golden motor's value, SI units.")
@click.option(
    "--uncertainty",
    type=Between(min=0),
    default=0.0,
    help="Standard uncertainty of the reference.",
)
@click.option("--tolerance", type=FINITE, help="Width of the tolerance: gives Cg and Cgk.")
@click.option("--share", type=FINITE, default=0.2, show_default=True, help="Of it, for the gauge.")
@click.option(
    "--spread", type=FINITE, default=6.0, show_default=True, help="Standard deviations set against."
)
@click.option("--min-cgk", type=FINITE, help="A smaller Cg or Cgk is a FAIL.")
def golden(
    file: Path,
    quantity: str,
    reference: float,
    uncertainty: float,
    tolerance: float | None,
    share: float,
    spread: float,
    min_cgk: float | None,
) -> int | None:
    """Repeated readings of one golden motor: bias, Cg and Cgk."""
    import numpy as np

    from motorid.quality.reference import golden as analyse
    from motorid.quality.study_file import column, read_rows
    from motorid.report.gauge import golden_text
    from motorid.workflow.gauge import units_known

    if min_cgk is not None and tolerance is None:
        raise click.UsageError("--min-cgk needs a --tolerance.")
    result = analyse(
        np.array(column(read_rows(file), quantity, str(file))),
        reference,
        tolerance=tolerance,
        reference_uncertainty=uncertainty,
        share=share,
        spread=spread,
    )
    click.echo(golden_text(result, quantity, units_known().get(quantity, "")))
    if min_cgk is None or result.cg is None or result.cgk is None:
        return None
    return EXIT_DONE if min(result.cg, result.cgk) >= min_cgk else EXIT_FAIL_VERDICT


@click.command("linearity")
@FILE
@click.option("--quantity", required=True, help="Column of the readings.")
@click.option("--reference-column", required=True, help="Column of each motor's reference value.")
def linearity(file: Path, quantity: str, reference_column: str) -> None:
    """Bias over motors of different, known values: a line and its band."""
    import numpy as np

    from motorid.quality.reference import linearity as analyse
    from motorid.quality.study_file import column, read_rows
    from motorid.report.gauge import linearity_text

    rows = read_rows(file)
    at = column(rows, reference_column, str(file))
    values = np.array(column(rows, quantity, str(file)))
    motors = sorted(set(at))
    result = analyse(motors, [values[np.array(at) == one] for one in motors])
    click.echo(linearity_text(result, quantity))
