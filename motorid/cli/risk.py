"""motorid risk"""

from __future__ import annotations

import math
from typing import Any, cast

import click

from motorid.cli.options import example
from motorid.cli.values import FINITE
from motorid.errors import EXIT_DONE, UsageError


@click.command(
    "risk",
    epilog=example(
        "motorid risk --low 2.4 --high 2.8 -u 0.006 --process-mean 2.6 --process-sd 0.05",
        "motorid risk --low 2.4 --high 2.8 -u 0.006 --value 2.79",
    ),
)
@click.option("--low", type=FINITE, help="Lower limit; none: there is no lower one.")
@click.option("--high", type=FINITE, help="Upper limit; none: there is no upper one.")
@click.option("-u", "--uncertainty", type=FINITE, required=True, help="Standard uncertainty.")
@click.option(
    "--rule",
    type=click.Choice(["simple", "uncertainty", "specific_risk", "global_risk"]),
    default="uncertainty",
    show_default=True,
    help="The decision rule, as in a product file.",
)
@click.option("--r", "share", type=FINITE, default=1.0, show_default=True,
              help="Guard band over the expanded uncertainty.")  # fmt: skip
@click.option("--coverage-factor", type=FINITE, default=2.0, show_default=True,
              help="Expanded uncertainty over the standard one.")  # fmt: skip
@click.option("--consumer-risk", type=FINITE, default=0.025, show_default=True,
              help="Of the rules specific_risk and global_risk.")  # fmt: skip
@click.option("--process-mean", type=FINITE, help="Mean of the true values of all items.")
@click.option("--process-sd", type=FINITE, help="Standard deviation of the true values.")
@click.option("--value", type=FINITE, help="A measured value: the specific risks of its item.")
@click.option("--json", "as_json", is_flag=True, help="Print the risks as JSON.")
def command(
    low: float | None,
    high: float | None,
    uncertainty: float,
    rule: str,
    share: float,
    coverage_factor: float,
    consumer_risk: float,
    process_mean: float | None,
    process_sd: float | None,
    value: float | None,
    as_json: bool,
) -> int:
    """Consumer's and producer's risks of a limit, its decision rule and an uncertainty.

    The global risks are shares of all items of a normal process; the specific ones are of one item
    with a measured value (JCGM 106:2012). All figures are in one unit.
    """
    from motorid.json_text import dumps
    from motorid.quality.guard_band import Rule, RuleName, guard_band, risks, specific

    ends = (-math.inf if low is None else low, math.inf if high is None else high)
    _refuse(ends, uncertainty, process_mean, process_sd, value)
    chosen = Rule(
        cast("RuleName", rule), share, coverage_factor, consumer_risk, process_mean, process_sd
    )
    said: dict[str, Any] = {"rule": rule, "guard_band": guard_band(uncertainty, *ends, chosen)}
    if process_mean is not None:
        consumer, producer = risks(uncertainty, *ends, chosen)
        said |= {"consumer": consumer, "producer": producer}
    if value is not None:
        found = specific(value, uncertainty, *ends, chosen)
        said["specific"] = {
            "value": value,
            "accepted": found.accepted,
            "conformance": found.conformance,
            "conformance_with_process": found.with_process,
            "risk": found.risk,
            "risk_with_process": found.risk_with_process,
        }
    click.echo(dumps(said, indent=2) if as_json else _text(said))
    return EXIT_DONE


def _refuse(
    ends: tuple[float, float],
    uncertainty: float,
    mean: float | None,
    sd: float | None,
    value: float | None,
) -> None:
    if ends == (-math.inf, math.inf) or not ends[0] < ends[1]:
        raise UsageError("a risk is of a limit: give --low below --high, or one of them")
    if uncertainty < 0:
        raise UsageError("--uncertainty is a standard uncertainty, 0 or more")
    if (mean is None) != (sd is None) or (sd is not None and sd <= 0):
        raise UsageError("a process has --process-mean and a --process-sd above 0: give both")
    if mean is None and value is None:
        raise UsageError("give a process, for global risks, or a --value, for those of one item")


def _text(said: dict[str, Any]) -> str:
    lines = [f"guard band ({said['rule']})     {said['guard_band']:.6g}"]
    if "consumer" in said:
        lines += [
            f"global consumer's risk     {said['consumer']:.6g}   accepted, and does not conform",
            f"global producer's risk     {said['producer']:.6g}   rejected, and conforms",
        ]
    if "specific" in said:
        one = said["specific"]
        whose = "consumer's" if one["accepted"] else "producer's"
        outcome = "accepted" if one["accepted"] else "rejected"
        lines.append(f"{one['value']:.6g} is {outcome}")
        for key, by in (("risk", "by the measurement alone"),
                        ("risk_with_process", "with the process as prior")):  # fmt: skip
            if one[key] is not None:
                lines.append(f"specific {whose} risk   {one[key]:.6g}   {by}")
    return "\n".join(lines)
