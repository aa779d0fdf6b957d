"""motorid conformance"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from motorid.cli.options import example, force_option
from motorid.cli.values import FINITE, Between, Named, Whole
from motorid.errors import EXIT_DONE


@click.command(
    "conformance",
    epilog=example(
        "motorid conformance --device /dev/ttyACM0 --rig bench.toml -o uno-7.zip",
        "motorid conformance --device /dev/ttyACM0 --rig bench.toml --answers meters.toml "
        "-o uno-7.zip",
    ),
)
@click.option("--device", required=True, help="The board's port; motorid ports lists them.")
@click.option("--rig", "rig_name", required=True, help="Rig file of its bench: limits and wiring.")
@click.option(
    "-o",
    "--output",
    required=True,
    type=Named(dir_okay=False, path_type=Path),
    help="The bundle, a .zip; a folder of that name beside it holds its files.",
)
@click.option(
    "--answers",
    type=Named(exists=True, dir_okay=False, path_type=Path),
    help="Take the meter's readings and the disc from this TOML file, as calibrate does.",
)
@click.option("--simulated", is_flag=True, help="Let a sim:// bench read its own meters.")
@click.option("--no-suite", is_flag=True, help="Leave the suite out: the guided run alone.")
@click.option("--select", default="", metavar="EXPR", help="Only these cases, as pytest -k.")
@click.option("--serial", default="", help="Serial number of the motor.")
@click.option("--by", default="", help="Who is at the bench.")
@click.option("--note", default="", help="Free text kept in the bundle.")
@click.option(
    "--level", "levels_v", multiple=True, type=FINITE, metavar="VOLTS",
    help="Of the meter's readings, as calibrate has it. Repeatable.",
)  # fmt: skip
@click.option("--hold", "hold_s", type=Between(1, 60), default=4.0, help="Seconds of a level: 4.")
@click.option("--runs", type=Whole(1, 50), default=3, help="Runs with and without disc: 3.")
@force_option
def command(
    device: str,
    rig_name: str,
    output: Path,
    answers: Path | None,
    simulated: bool,
    no_suite: bool,
    select: str,
    serial: str,
    by: str,
    note: str,
    force: bool,
    **how: Any,
) -> int:
    """Prove a board: run the conformance suite and a guided run, and write one bundle to send.

    The suite sends every message, limit and trip, and turns the motor. The guided run takes
    offsets, both scales against a meter that you read, a disc of known inertia, three runs and a
    coast. Each part can be skipped; one that fails ends no other. No real board has been proven
    so far: a bundle of yours would be the first.

    Exit codes: 0, 3 where a part failed. The bundle is written in either case, and after Ctrl-C.
    """
    from motorid.cli.calibrate import person_of, said
    from motorid.cli.progress import ProgressLine
    from motorid.workflow.calibrate.bench import Settings
    from motorid.workflow.conformance import prove
    from motorid.workflow.conformance.evidence import Evidence

    if answers and simulated:
        raise click.UsageError("--answers or --simulated: one of the two.")
    path, rig = prove.open_rig(rig_name, device)
    folder = prove.make_way(output, force=force)
    with ProgressLine() as progress:
        evidence = Evidence(
            rig,
            path,
            folder,
            person_of(answers, simulated),
            Settings(captures=folder / "disc", **how),
            said,
            progress,
            with_suite=not no_suite,
            select=select,
            serial=serial,
            about={"by": by, "note": note},
        )
        written = prove.prove(evidence, output, force=force)
    click.echo(f"wrote {written}", err=True)
    prove.insist(evidence, written)
    return EXIT_DONE
