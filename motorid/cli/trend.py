"""motorid trend"""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, cast

import click

from motorid.cli.options import INSTANT, example, force_option
from motorid.cli.paged import Paged
from motorid.cli.values import FINITE, Named, Whole
from motorid.errors import EXIT_DONE, EXIT_FAIL_VERDICT

if TYPE_CHECKING:
    from motorid.quality.capability import Asked
    from motorid.quality.rules import RuleSet


@click.command(
    "trend",
    cls=Paged,
    common=(
        *("quantity", "lower", "upper", "subgroup", "rules", "golden", "product"),
        *("min_ppk", "output", "force"),
    ),
    epilog=example(
        "motorid trend line.db --quantity R_25 --product sim-disc",
        "motorid trend line.db --quantity K_25 --golden GOLD-1 -o golden.html",
        "motorid trend readings.csv --quantity R --lower 2.4 --upper 2.8 --subgroup 5",
    ),
)
@click.argument("source")
@click.option("--quantity", required=True, help="What to look at, by its name in the results.")
@click.option("--lower", type=FINITE, help="Lower limit, SI units; default: the newest result's.")
@click.option("--upper", type=FINITE, help="Upper limit, SI units; default: the newest result's.")
@click.option(
    "--subgroup",
    type=Whole(1, 25),
    default=1,
    show_default=True,
    help="Consecutive readings a point: X-bar and R; 1: individuals and moving ranges.",
)
@click.option("--baseline", type=Whole(min=2), help="First points, which set the limits.")
@click.option(
    "--rules",
    type=click.Choice(["western-electric", "nelson", "limits"]),
    default="western-electric",
    show_default=True,
    help="Which patterns alarm.",
)
@click.option(
    "--small-shifts", is_flag=True, help="EWMA and CUSUM charts as well: they see small shifts."
)
@click.option("--golden", help="Serial number of the golden motor: its readings, and their drift.")
@click.option("--serial", default="", help="Only these motors; * and ? are wildcards.")
@click.option("--product", default="", help="Only results judged by this product.")
@click.option("--station", default="", help="Only this station's results.")
@click.option("--kind", default="check", show_default=True, help="check, rejudged, fit or golden.")
@click.option("--since", type=INSTANT, help="Only results since then, as 2026-11-21T06:00.")
@click.option("--last", type=Whole(min=3), help="Only so many of the newest readings.")
@click.option(
    "--shape",
    type=click.Choice(["auto", "normal", "box-cox", "percentile"]),
    default="auto",
    show_default=True,
    help="Shape of the process for its capability; auto: normal unless a test rejects it.",
)
@click.option("--power", type=FINITE, help="With --shape box-cox: λ, instead of the likeliest.")
@click.option("--min-ppk", type=FINITE, help="A smaller Ppk is an alarm.")
@click.option("--json", "as_json", is_flag=True, help="Print the trend as JSON.")
@click.option(
    "-o", "--output", type=Named(dir_okay=False, path_type=Path), help="HTML file with charts."
)
@force_option
def command(
    source: str,
    quantity: str,
    lower: float | None,
    upper: float | None,
    subgroup: int,
    baseline: int | None,
    rules: str,
    small_shifts: bool,
    golden: str | None,
    serial: str,
    product: str,
    station: str,
    kind: str,
    since: datetime | None,
    last: int | None,
    shape: str,
    power: float | None,
    min_ppk: float | None,
    as_json: bool,
    output: Path | None,
    force: bool,
) -> int:
    """Control charts, capability and drift of what was measured.

    SOURCE is a history (a file or a database's URL) or a CSV file. An alarm is a FAIL verdict on
    the process: exit code 1. In control: 0. Too few readings to say: 4.
    """
    from motorid.capture.whole import write_whole
    from motorid.json_text import dumps
    from motorid.quality.history import Query
    from motorid.quality.trend import trend
    from motorid.report import trend as report
    from motorid.workflow import trend as workflow

    if source.lower().endswith(".csv"):
        series = workflow.from_csv(Path(source), quantity)
    else:
        query = Query(golden or serial, product, "", kind, station, since)
        series = workflow.from_history(source, quantity, query, last)
    explicit = lower is not None or upper is not None
    found = trend(
        series.values,
        series.days,
        quantity=quantity,
        unit=series.unit,
        lower=lower if explicit else series.lower,
        upper=upper if explicit else series.upper,
        subgroup=subgroup,
        baseline=baseline,
        rules=cast("RuleSet", rules),
        golden=golden is not None,
        least_ppk=min_ppk,
        small_shifts=small_shifts,
        shape=cast("Asked", shape),
        power=power,
    )
    click.echo(dumps(report.to_dict(found), indent=2) if as_json else report.text(found))
    if output:
        write_whole(output, report.html(found).encode(), force=force)
        click.echo(f"wrote {output}", err=True)
    return EXIT_DONE if found.in_control else EXIT_FAIL_VERDICT
