"""Which cause gives which share of each parameter's variance, as a table."""

from __future__ import annotations

from motorid.estimate.results.estimate import Estimate, Parameter
from motorid.report.numbers import NOTHING, percent, shown
from motorid.report.page import paragraph, table
from motorid.report.words import reference, six

LEAST = 0.005  # of a variance: less is a dash
WORDS = (
    "Shares of each parameter's variance, the largest cause first; the last line is the standard "
    "uncertainty that they make together."
)


def as_html(estimate: Estimate) -> str:
    """Causes against parameters; nothing where no cause is known."""
    known = [p for p in (*six(estimate), *reference(estimate)) if _variance(estimate, p.name) > 0]
    if not known:
        return ""
    shares = {p.name: _shares(estimate, p.name) for p in known}
    causes = dict.fromkeys(cause for one in shares.values() for cause in one)
    by_size = sorted(causes, key=lambda c: -max(one.get(c, 0.0) for one in shares.values()))
    rows = [
        (cause, *(_percent(shares[p.name].get(cause, 0.0)) for p in known))
        for cause in by_size
        if max(one.get(cause, 0.0) for one in shares.values()) >= LEAST
    ]
    rows.append(("together", *(_size(estimate, p) for p in known)))
    head = ("cause", *(p.name for p in known))
    return table(head, rows, "budget") + paragraph(WORDS, "soft")


def _variance(estimate: Estimate, name: str) -> float:
    return sum(u**2 for u in estimate.budget.get(name, {}).values())


def _shares(estimate: Estimate, name: str) -> dict[str, float]:
    total = _variance(estimate, name)
    return {cause: u**2 / total for cause, u in estimate.budget[name].items()}


def _percent(share: float) -> str:
    return percent(share) if share >= LEAST else NOTHING


def _size(estimate: Estimate, p: Parameter) -> str:
    """The standard uncertainty, as a share of the value where there is one."""
    u = _variance(estimate, p.name) ** 0.5
    if p.value:
        return percent(u / abs(p.value))
    return f"{u * shown(p).factor:.2g} {shown(p).unit}"
