"""Gains that nobody stated: never 0 %, but what 1 % of each would do."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from motorid.estimate.results.estimate import Estimate, Parameter
from motorid.report.numbers import MINUS, percent, relative
from motorid.report.words import sentence

NOT_STATED = "not stated"
LEAST = 1e-4  # of a value: a known uncertainty below it is none
AT_25 = "_25"
WORDS = (
    "Nobody stated these gains, and no ± holds them. If a channel reads 1 % too much, the values "
    "are rather"
)
REMEDY = "To state one, import with --gain-uncertainty, such as current=0.005."


def instrument(estimate: Estimate, p: Parameter) -> str:
    """The instruments' share of a value's uncertainty, or that not all of it is known."""
    share = relative(p, p.instrument)
    if share is None or not any(_moves(each, p) for each in estimate.not_stated.values()):
        return percent(share)
    return f"≥ {percent(share)}" if share > LEAST else NOT_STATED


def _moves(each: Mapping[str, float], p: Parameter) -> bool:
    """Whether a gain moves a value; one of which nothing is known may."""
    return not each or p.name.removesuffix(AT_25) in each


def lines(estimate: Estimate) -> list[str]:
    """Sentences for below the table; none where all gains are stated."""
    if not estimate.not_stated:
        return []
    told = [f"{gain}: {what}" for gain, what in _told(estimate)]
    return [f"{WORDS}:", *told, REMEDY] if told else []


def _told(estimate: Estimate) -> Iterator[tuple[str, str]]:
    values = {**estimate.parameters, **estimate.combinations}
    for gain, each in estimate.not_stated.items():
        shares = [
            f"{name} {_signed(move / value)}"
            for name, move in each.items()
            if name in values and (value := values[name].value)
        ]
        if shares:
            yield gain, ", ".join(shares)
        elif not each:
            yield gain, sentence("this model does not say what it moves")


def _signed(share: float) -> str:
    return f"{MINUS if share < 0 else '+'}{percent(abs(share))}"
