"""A verdict by other limits, from the values and uncertainties that a verdict has stored.

What is about the run (a condition, or a motor that did not run) stays as it was judged.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from motorid.quality.guard_band import Rule, quantile
from motorid.quality.judge import NOT_GROUND
from motorid.quality.limits import Limit
from motorid.quality.product import Product
from motorid.quality.quantities import quantity
from motorid.quality.verdict import Measurement, Outcome, Reading, Verdict, decide

WIDEST = 10.0  # standard uncertainties: no guard band of a global risk is wider
ROUNDING = 1e-9  # relative: what lies so near is decided by the rule itself


@dataclass(frozen=True)
class Stored:
    """A measurement as the history holds it."""

    name: str
    unit: str
    value: float | None
    uncertainty: float | None
    outcome: str
    reason: str


def judge_stored(stored: Sequence[Stored], limits: Product) -> Verdict:
    """The verdict by ``limits``. A quantity that was never measured makes it INVALID, or FAIL."""
    known = {one.name: one for one in stored}
    measured = [_measured(limit, known.get(name)) for name, limit in limits.limits.items()]
    return Verdict(limits.name, "", (*_kept(stored, limits), *measured))


def _measured(limit: Limit, stored: Stored | None) -> Measurement:
    found = quantity(limit.quantity)
    assert found is not None, limit.quantity  # a product file with another name was refused
    if stored is None:
        reading = Reading(limit.unit, problem="it was not measured then")
    else:
        reading = Reading(stored.unit, stored.value, stored.uncertainty, stored.reason)
    return decide(limit, reading, found.meaning)


def _kept(stored: Sequence[Stored], limits: Product) -> Iterator[Measurement]:
    """What no limit is about, as it was judged; a quantity that has no limit now counts no more."""
    for one in stored:
        if one.name in limits.limits or quantity(one.name) is not None:
            continue
        limit = Limit(one.name, one.unit, condition=one.name not in NOT_GROUND)
        reading = Reading(one.unit, one.value, one.uncertainty)
        yield Measurement(
            one.name, one.name, limit, reading, Outcome(one.outcome), reason=one.reason
        )


def surely_within(rule: Rule) -> float:
    """So many standard uncertainties inside its limits a value is accepted, whatever it is."""
    match rule.name:
        case "simple":
            return 0.0
        case "uncertainty":
            least = max(0.0, rule.r * rule.coverage_factor)
        case "specific_risk":  # half of it beyond each limit
            least = max(0.0, quantile(1.0 - 0.5 * rule.consumer_risk))
        case "global_risk":
            least = WIDEST
    return least * (1.0 + ROUNDING)
