"""motorid import"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from motorid.cli.options import (
    Assignment,
    Statement,
    example,
    force_option,
    nameplate_option,
)
from motorid.cli.paged import Paged
from motorid.cli.values import FINITE, Between, Named

PairsT = tuple[tuple[str, float], ...]
SaidT = tuple[tuple[str, str], ...]


@click.command(
    "import",
    cls=Paged,
    common=(
        *("maps", "look", "yes", "sense", "counts_per_turn", "start_s", "stop_s"),
        *("serial", "output", "force"),
    ),
    epilog=example(
        "motorid import log.csv",
        "motorid import log.csv --map time=t:ms --map current=i:mA --map speed=n:rpm -o log.h5",
        "motorid import drive.mat --map time=t:s --map torque=vir*gtau:N --map position=qm:m "
        "-o drive.h5",
    ),
)
@click.argument("file", type=Named(exists=True, dir_okay=False, path_type=Path))
@click.option(
    "--map",
    "maps",
    multiple=True,
    metavar="QUANTITY=COLUMN:UNIT",
    help="Which column is time, current, voltage, speed, position, torque, ... A column may be "
    "arithmetic over columns. Without time, rows are steady points. Repeatable.",
)
@click.option("--look", is_flag=True, help="Propose what no --map says; without --map always so.")
@click.option("--yes", is_flag=True, help="Take the proposal unasked, if it leaves nothing open.")
@click.option(
    "-o",
    "--output",
    type=Named(dir_okay=False, path_type=Path),
    help="Capture file to write.  [default: the name of FILE with .h5, in this folder]",
)
@click.option(
    "--aperture",
    multiple=True,
    type=Statement("current=128ms,around"),
    help="What each reading of a quantity averages over: 128ms (before its stamp), 128ms,around, "
    "128ms,after or instant. Repeatable.",
)
@click.option(
    "--delay",
    multiple=True,
    type=Statement("current=1ms"),
    help="By how much a quantity's readings are late; below 0: stamped too early. Repeatable.",
)
@click.option(
    "--delay-uncertainty",
    multiple=True,
    type=Statement("current=20us"),
    help="Standard uncertainty of that delay. Repeatable.",
)
@click.option(
    "--filter",
    "low_pass",
    multiple=True,
    type=Statement("current=20Hz,2"),
    help="Low-pass before a quantity's converter: its cut-off (20Hz) or time constant (8ms), and "
    "the order 1 or 2 (20Hz,2). Repeatable.",
)
@click.option(
    "--gain-uncertainty",
    multiple=True,
    type=Assignment("current=0.005"),
    help="Standard uncertainty of a quantity's gain, relative. Repeatable.",
)
@click.option(
    "--offset-uncertainty",
    multiple=True,
    type=Assignment("current=0.01"),
    help="Standard uncertainty of a quantity's offset, in SI units. Repeatable.",
)
@click.option(
    "--nonlinearity",
    multiple=True,
    type=Statement("current=0.003,s,20"),
    help="Of the current's sensor: standard uncertainty as a share of full scale, its course (bow, "
    "s, cubic), and the full scale in A.",
)
@click.option(
    "--reference-drift",
    metavar="SHARE,TIME",
    help="By which share the converters' reference may drift in a run (standard uncertainty), and "
    "over which time: 0.001,2s.",
)
@click.option(
    "--eccentricity",
    type=Between(0, 0.5),
    help="Amplitude of the encoder's error once a turn, in rad of its shaft.",
)
@click.option(
    "--constant",
    multiple=True,
    type=Assignment("gtau=35.15"),
    help="A number that a column's arithmetic may name. Repeatable.",
)
@click.option("--unsigned", multiple=True, help="A quantity that is a magnitude. Repeatable.")
@click.option("--sense", help="Where the voltage was measured: terminals, bridge, supply, command.")
@click.option(
    "--bridge-resistance",
    type=Between(0, 1e4),
    help="Ohms between a commanded or supply voltage and the motor: switches and leads.",
)
@click.option(
    "--bridge-resistance-uncertainty",
    type=Between(0, 1e4),
    help="Its standard uncertainty in ohms.  [default: 0]",
)
@click.option("--counts-per-turn", type=FINITE, default=0.0, help="Of the encoder, after times 4.")
@click.option(
    "--gear-ratio",
    type=FINITE,
    default=1.0,
    help="Motor turns for one of the encoder's.",
)
@click.option("--start", "start_s", type=FINITE, help="First second to keep, in the file's time.")
@click.option("--stop", "stop_s", type=FINITE, help="Last second to keep, in the file's time.")
@click.option("--drop-bad", is_flag=True, help="Leave out rows with text, gaps or sentinels.")
@click.option(
    "--missing",
    multiple=True,
    type=FINITE,
    help="A number that stands for no reading, such as 65535; it is left out. Repeatable.",
)
@click.option("--separator", help="Between columns, where it is not found by itself.")
@click.option("--decimal", help="Decimal mark, where it is not found by itself.")
@click.option("--thousands", help="Mark between groups of three digits, where the file has one.")
@click.option("--ambient", "ambient_c", type=Between(-100, 300), help="Ambient temperature in °C.")
@click.option(
    "--ambient-uncertainty",
    "ambient_uncertainty_c",
    type=Between(0, 100),
    help="Its standard uncertainty in K.  [default: 0]",
)
@nameplate_option
@click.option("--serial", default="", help="Serial number of the motor.")
@click.option("--note", default="", help="Free text kept in the capture.")
@force_option
def command(
    file: Path,
    maps: tuple[str, ...],
    look: bool,
    yes: bool,
    output: Path | None,
    aperture: SaidT,
    delay: SaidT,
    delay_uncertainty: SaidT,
    low_pass: SaidT,
    gain_uncertainty: PairsT,
    offset_uncertainty: PairsT,
    nonlinearity: SaidT,
    reference_drift: str | None,
    eccentricity: float | None,
    constant: PairsT,
    unsigned: tuple[str, ...],
    sense: str | None,
    bridge_resistance: float | None,
    bridge_resistance_uncertainty: float | None,
    counts_per_turn: float,
    gear_ratio: float,
    start_s: float | None,
    stop_s: float | None,
    drop_bad: bool,
    missing: tuple[float, ...],
    separator: str | None,
    decimal: str | None,
    thousands: str | None,
    ambient_c: float | None,
    ambient_uncertainty_c: float | None,
    nameplate: tuple[str, ...],
    serial: str,
    note: str,
    force: bool,
) -> None:
    """Turn somebody else's table or log into a capture, by naming its columns.

    Without --map it looks at the file first: it shows each column, proposes quantities and units,
    and asks. A unit that names, headers and readings leave open is asked about, never guessed.

    Reads CSV, MAT, Parquet, NPZ, XLSX, TDMS, MDF, MCAP and WPILib files, JSON lines, and the
    labelled lines of a serial plotter.

    Separators, header rows and decimal marks are found; units are converted to SI.
    """
    from motorid.capture import store, table
    from motorid.capture.table_options import TableOptions
    from motorid.capture.whole import refuse_existing
    from motorid.rig_nameplate import read_nameplate

    output = output or Path(f"{file.stem}.h5")
    refuse_existing(output, force)
    given = {
        "aperture": dict(aperture),
        "delay": dict(delay),
        "delay_uncertainty": dict(delay_uncertainty),
        "filter": dict(low_pass),
        "gain_uncertainty": dict(gain_uncertainty),
        "offset_uncertainty": dict(offset_uncertainty),
        "nonlinearity": dict(nonlinearity),
        "reference_drift": reference_drift,
        "eccentricity": eccentricity,
        "constants": dict(constant),
        "unsigned": unsigned,
        "separator": separator,
        "decimal": decimal,
        "thousands": thousands,
        "drop_bad": drop_bad,
        "missing": missing,
        "counts_per_turn": counts_per_turn,
        "gear_ratio": gear_ratio,
        "sense": sense or "terminals",
        "bridge_resistance": bridge_resistance,
        "bridge_resistance_uncertainty": bridge_resistance_uncertainty,
        "start_s": start_s,
        "stop_s": stop_s,
        "ambient_c": ambient_c,
        "ambient_uncertainty_c": ambient_uncertainty_c,
        "stated": read_nameplate(nameplate),
        "serial": serial,
        "note": note,
    }
    chosen: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
    proposed: tuple[str, ...] = ()
    if look or not maps:
        from motorid.cli.import_look import settle

        taken = settle(file, maps, TableOptions(**chosen), sense, output, yes)
        maps, proposed = taken.maps, (f"columns and units were proposed, and {taken.how}",)
        chosen["counts_per_turn"] = taken.counts_per_turn
        chosen["sense"] = taken.sense or "terminals"
    capture = table.read_table(file, maps, notes=proposed, **chosen)
    for remark in capture.provenance.get(table.NOTES, ()):
        click.echo(f"note: {remark}", err=True)
    click.echo(f"wrote {store.save(capture, output, force)}: {len(capture)} samples", err=True)
