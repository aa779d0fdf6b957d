"""Records of motors with effects, and without, as tables: naming, false offers, cost, doubt."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from bench.coverage.bound import NAMES
from bench.iron import TERMS
from motorid.estimate.results.status import Status

Row = dict[str, Any]
IN_PLACE = ("direction", "cogging")  # what an effect must never be taken for
DRAWN = {
    "ripple": "ripple",
    "cogging": "cogging / T0",
    "stribeck": "stiction - 1",
    "brush-drop": "brush drop / V",
    "heating": "heating at stall",
}
"""Terms that every drawn motor may have, by the figure of a record that is above 0 then."""
MOST_COST = 5.0  # times the responses of the six-parameter fit


def effect_tables(rows: Sequence[Row]) -> str:
    """What is said of records whose headline was made."""
    told = [row for row in rows if "parameters" in row.get("headline", {})]
    parts = [_named(told), _misnamed(told), _false_offers(told), _doubt(told), _cost(told)]
    return "\n".join(part for part in parts if part)


def offered(row: Row) -> set[str]:
    """Terms of the better model."""
    return set(row["better"].get("terms", ()))


def there(row: Row) -> set[str]:
    """Terms of the effects that were given to the motor."""
    return {TERMS[effect] for effect in row["effects"]}


def strange(row: Row) -> set[str]:
    """Terms of the better model that describe nothing of the motor."""
    return offered(row) - there(row) - {t for t, name in DRAWN.items() if row["feature"][name] > 0}


def matters(row: Row, effect: str) -> bool:
    """It moves a parameter by more than half of the interval that no finding has widened."""
    half = row["headline"].get("half", {})
    found = row.get("moves", {}).get(effect, {})
    return any(abs(found.get(name, 0.0)) > width for name, width in half.items())


def _named(told: Sequence[Row]) -> str:
    """How often each effect is named: in all motors that have it, and in those in which it moves
    some parameter of the six beyond its interval.
    """
    lines = ["| effect | motors | named | it matters in | named |", "|---|---|---|---|---|"]
    for effect, term in TERMS.items():
        have = [row for row in told if effect in row["effects"]]
        matter = [row for row in have if matters(row, effect)]
        named = [sum(term in offered(row) for row in of) for of in (have, matter)]
        lines.append(f"| {effect} | {len(have)} | {named[0]} | {len(matter)} | {named[1]} |")
    matter = [row for row in told if any(matters(row, effect) for effect in row["effects"])]
    found = sum(bool(there(row) & offered(row)) for row in matter)
    lines += ["", f"motors whose effects matter: {len(matter)}; an effect named in {found}"]
    return "\n".join(lines)


def _misnamed(told: Sequence[Row]) -> str:
    """Terms of models for motors with effects that these do not have."""
    wrong = [strange(row) for row in told if there(row)]
    taken_for = sum(bool(terms & set(IN_PLACE)) for terms in wrong)
    counts = Counter(term for terms in wrong for term in terms)
    said = ", ".join(f"{term} {count}" for term, count in counts.most_common()) or "nothing"
    return (
        f"named where the motor has another effect: {said}; "
        f"{' or '.join(IN_PLACE)} in {taken_for} of {len(wrong)}"
    )


def _false_offers(told: Sequence[Row]) -> str:
    """Models offered for motors without an effect."""
    plain = [row for row in told if not there(row)]
    false = [row for row in plain if strange(row)]
    each = ", ".join(f"{row['seed']} {' + '.join(sorted(strange(row)))}" for row in false)
    return f"false offers: {len(false)} of {len(plain)} motors without an effect" + (
        f" ({each})" if each else ""
    )


def _doubt(told: Sequence[Row]) -> str:
    """Intervals that hold, of all and of those that are not doubtful."""
    found = [row["headline"]["parameters"].get(name, {}) for row in told for name in NAMES]
    whole = [p for p in found if "interval" in p]
    sure = [p for p in whole if p["status"] != Status.DOUBTFUL]
    held = [sum(p["holds"] for p in of) for of in (whole, sure)]
    return (
        f"headline intervals that hold: {held[0]} of {len(whole)}; "
        f"{held[1]} of {len(sure)} that are not doubtful"
    )


def _cost(told: Sequence[Row]) -> str:
    """Responses of the fit with its search over those of the six-parameter fit."""
    ratios = [
        row["headline"]["responses"] / row["fit"]["responses"]
        for row in told
        if row["headline"].get("responses") and row.get("fit", {}).get("responses")
    ]
    if not ratios:
        return ""
    dear = sum(ratio > MOST_COST for ratio in ratios)
    return (
        f"responses over those of the six-parameter fit: median {np.median(ratios):.1f}, "
        f"at most {max(ratios):.1f}; above {MOST_COST:g} in {dear} of {len(ratios)}"
    )
