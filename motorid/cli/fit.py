"""motorid fit"""

from __future__ import annotations

from pathlib import Path

import click

from motorid.cli.options import example, expand, fit_options, force_option


@click.command(
    "fit",
    epilog=example(
        "motorid fit run-1.h5 run-2.h5 run-3.h5 -o report",
        "motorid fit robotino.h5 --fix K=0.0514 --json",
    ),
)
@click.argument("files", nargs=-1, required=True)
@fit_options
@click.option("--json", "as_json", is_flag=True, help="Print the estimate as JSON.")
@click.option(
    "-o",
    "--output",
    type=click.Path(file_okay=False, path_type=Path),
    help="Folder for estimate.json and report.html.",
)
@force_option
def command(
    files: tuple[str, ...],
    fix: tuple[tuple[str, float], ...],
    without: tuple[str, ...],
    method: str,
    as_json: bool,
    output: Path | None,
    force: bool,
) -> None:
    """Estimate R, L, K, B, J and T0 from one or more captures of the same motor.

    Needs no start values. Prints a table with uncertainties; what these captures cannot tell is
    reported as such, with the run that would tell it.
    """
    from motorid.workflow import fit as workflow

    if output:
        workflow.check_writable(output, force=force)
    estimate = workflow.fit_files(expand(files), fix=dict(fix), without=without, method=method)
    click.echo(workflow.as_json(estimate) if as_json else workflow.as_text(estimate))
    if output:
        for path in workflow.write_report(estimate, output, force=force):
            click.echo(f"wrote {path}", err=True)
