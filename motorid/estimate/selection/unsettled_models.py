"""Models that the data half support, and that are not offered: no value may exclude theirs.

The likelihood may rise by far more than a term costs while its size stays open, by what else is
lacking or by what instruments leave. Such a term is no answer. But the values beside it are as
possible as those without it. So are those beside a term that the search had no room for.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from motorid.estimate.assembly.doubt import settled
from motorid.estimate.effects.influence_quantity import Use
from motorid.estimate.effects.registry import used
from motorid.estimate.model.extended_terms import Term
from motorid.estimate.results.estimate import PARAMETERS, Diagnostic, Estimate, Parameter

USUAL = "record more levels of speed"  # of a term whose effect has no remedy of its own
REACHED = 1.0  # of half an interval: nearer values it does not exclude


@dataclass(frozen=True)
class Unsettled:
    """A term, and the ``values`` of the parameters (SI) of the model that it was the last of."""

    term: Term
    values: Mapping[str, float]


def with_unsettled(
    estimate: Estimate, models: Sequence[Unsettled], nameable: bool = True
) -> Estimate:
    """The estimate, whose intervals and whose better model's reach to the values of these.

    ``nameable``: a person may ask for one of them by its name.
    """
    if not models:
        return estimate
    said = _said(estimate.parameters, models, nameable)
    if estimate.alternative is not None:
        better = estimate.alternative
        beside = _said(better.parameters, models, nameable)
        alone = replace(estimate, parameters=better.parameters, combinations={}, derived={},
                        budget={}, alternative=None)  # fmt: skip
        better = replace(better, parameters=settled(alone, beside).parameters)
        estimate = replace(estimate, alternative=better)
        said = said or [replace(one, moves={}, sides={}) for one in beside]
    whole = settled(estimate, said)
    return replace(whole, diagnostics=(*said, *whole.diagnostics))


def with_left_out(
    estimate: Estimate,
    untried: Sequence[Term],
    offered: Sequence[Term] = (),
    not_revised: Sequence[Term] = (),
    settled_model: bool = True,
) -> Estimate:
    """The estimate, with a remark on what a bounded search left out: terms that were ``untried``;
    of the model that is ``offered``, those that may stand for others, and its last passes.
    """
    names, older = (list(dict.fromkeys(t.name for t in terms)) for terms in (untried, not_revised))
    left = [f"it tried {', '.join(names)}"] if names else []
    left += [f"it asked whether another effect takes the place of {', '.join(older)}"] * bool(older)
    left += [] if settled_model else ["the last passes of the better model were done"]
    if not left:
        return estimate
    model = names[0] if names else "+".join(term.name for term in offered)
    what = "name one of them" if names else "a model that is named has no such bound"
    said = Diagnostic(
        "search_ended", "info",
        f"the search for a better model ended before {' and before '.join(left)}: {what}, as by "
        f"--model {model}",
    )  # fmt: skip
    return replace(estimate, diagnostics=(*estimate.diagnostics, said))


def _said(
    parameters: Mapping[str, Parameter], models: Sequence[Unsettled], nameable: bool
) -> list[Diagnostic]:
    """One finding of all models; none where no interval excludes theirs."""
    sides: dict[str, tuple[float, float]] = {}
    for name in PARAMETERS:
        p = parameters.get(name)
        if p is None or p.value is None or p.interval_95 is None:
            continue
        moved = [one.values[name] - p.value for one in models]
        below, above = max(0.0, -min(moved)), max(0.0, max(moved))
        if max(below, above) > REACHED * (p.interval_95[1] - p.interval_95[0]) / 2.0:
            sides[name] = below, above
    if not sides:
        return []
    titles = " or ".join(dict.fromkeys(one.term.title for one in models))
    name = models[0].term.name
    return [
        Diagnostic(
            "model_unsettled",
            "warning",
            f"the data speak for {titles}, but do not settle how much: that can move "
            f"{', '.join(sides)}; {_remedy(name)}"
            + (f", or name it, as by --model {name}" if nameable else ""),
            {name: max(pair) for name, pair in sides.items()},
            sides,
        )
    ]


def _remedy(term: str) -> str:
    """What tells the effect, as of one that was not found."""
    return next((one.remedy for one in used(Use.UNDETECTED) if one.term == term), USUAL)
