"""motorid gauge attribute and motorid gauge stations: who agrees with whom."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

import click

from motorid.cli.options import INSTANT
from motorid.cli.values import FINITE, Between
from motorid.errors import EXIT_DONE, EXIT_FAIL_VERDICT


@click.command("attribute")
@click.argument("source")
@click.option("--rating", default="rating", show_default=True, help="Column of what was said.")
@click.option("--reference", help="Column of what each part is.")
@click.option("--bad", help="The rating that must not pass: gives misses and false alarms.")
@click.option(
    "--serial", default="", help="Of a history, only these motors; * and ? are wildcards."
)
@click.option("--product", default="", help="Of a history, only results judged by this product.")
@click.option("--min-kappa", type=Between(min=-1, max=1), help="A smaller kappa is a FAIL.")
@click.option("--json", "as_json", is_flag=True, help="Print the study as JSON.")
def attribute(
    source: str,
    rating: str,
    reference: str | None,
    bad: str | None,
    serial: str,
    product: str,
    min_kappa: float | None,
    as_json: bool,
) -> int | None:
    """Analyse an attribute study: who calls which part what, and is it right?

    SOURCE is a CSV file with columns part, operator, rating and, if known, a reference; or a
    history, whose stations' verdicts are then the ratings. Ratings are words such as PASS and FAIL.
    Kappa is judged with the reference, if there is one, else between each two operators.
    """
    from motorid.json_text import dumps
    from motorid.quality.agreement import agreement, ratings_of
    from motorid.quality.history import Query
    from motorid.quality.study_file import OPERATOR, PART, labels, read_rows, texts
    from motorid.report import agreement as report
    from motorid.workflow.stations import verdicts_from_history

    if bad is not None and reference is None:
        raise click.UsageError("--bad needs a --reference: who knows which part is bad?")
    if source.lower().endswith(".csv"):
        rows = read_rows(Path(source))
        known = None if reference is None else texts(rows, reference, source)
        parts, who = labels(rows, PART, source), labels(rows, OPERATOR, source)
        called = texts(rows, rating, source)
    elif reference is not None:
        raise click.UsageError("--reference is a column of a CSV file, and no history has it.")
    else:
        parts, who, called = verdicts_from_history(source, Query(serial, product, "", "check"))
        known = None
    ratings = ratings_of(parts, who, called, known, bad, source)
    found = agreement(ratings)
    said = report.agreement_dict(found)
    click.echo(dumps(said, indent=2) if as_json else report.agreement_text(found))
    if min_kappa is None:
        return None
    return EXIT_DONE if report.least_kappa(found) >= min_kappa else EXIT_FAIL_VERDICT


@click.command("stations")
@click.argument("source")
@click.option("--quantity", required=True, help="What to compare, by its name in the results.")
@click.option("--reference", help="Compare each station with this one; default: every pair.")
@click.option("--serial", default="", help="Only these motors; * and ? are wildcards.")
@click.option("--product", default="", help="Only results judged by this product.")
@click.option("--kind", default="check", show_default=True, help="check, rejudged, fit or golden.")
@click.option("--since", type=INSTANT, help="Only results since then, as 2026-11-21T06:00.")
@click.option("--max-difference", type=FINITE, help="A larger mean difference is a FAIL, SI units.")
@click.option("--json", "as_json", is_flag=True, help="Print the comparison as JSON.")
def stations(
    source: str,
    quantity: str,
    reference: str | None,
    serial: str,
    product: str,
    kind: str,
    since: datetime | None,
    max_difference: float | None,
    as_json: bool,
) -> int | None:
    """Compare stations that measured the same motors: differences, and whether they are real.

    SOURCE is a history (a file or a database's URL) or a CSV file with columns part, station and
    the quantity.
    """
    from motorid.json_text import dumps
    from motorid.quality.history import Query
    from motorid.quality.stations import compare
    from motorid.report import agreement as report
    from motorid.workflow import stations as workflow
    from motorid.workflow.gauge import units_known

    if source.lower().endswith(".csv"):
        readings, unit = workflow.from_csv(Path(source), quantity), units_known().get(quantity, "")
    else:
        query = Query(serial, product, "", kind, "", since)
        readings, unit = workflow.from_history(source, quantity, query)
    pairs = compare(readings, reference)
    said = report.stations_dict(pairs, quantity, unit)
    click.echo(dumps(said, indent=2) if as_json else report.stations_text(pairs, quantity, unit))
    if max_difference is None:
        return None
    far = [one for one in pairs if not abs(one.difference) <= max_difference]
    return EXIT_FAIL_VERDICT if far else EXIT_DONE
