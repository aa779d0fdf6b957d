"""What may have spoiled the measurement, in sentences: faults that were named, scales that hide."""

from __future__ import annotations

from html import escape
from typing import Any

from motorid.estimate.diagnosis.faults import scale_errors
from motorid.estimate.results.estimate import UNITS, Diagnostic, Estimate, Suspect
from motorid.json_text import plain
from motorid.report.numbers import quantity
from motorid.report.words import decisive, sentence

HIDDEN = (
    "These data cannot reveal a wrong scale of {what}: such errors leave no residual. A nameplate "
    "in the rig, or a run with a disc of known inertia, would reveal most of them."
)
SCALES = {cause.code for cause in (*scale_errors.CAUSES, scale_errors.TIME_OF_POSITION)}
BOUNDED = "These data cannot reveal a wrong scale of {what}: such errors leave no residual."


def as_sentences(estimate: Estimate, first: bool) -> list[str]:
    """Each named fault with what mends it: those that stand above the table, or the others."""
    return [_whole(s) for s in _of(estimate, "named") if decisive(estimate, s) is first]


def _whole(s: Suspect) -> str:
    """What shows it, what mends it, and the values of a fit that does not allow for it."""
    said = f"{sentence(s.evidence)} {sentence(s.action)}"
    if not s.without:
        return said
    values = ", ".join(f"{n} {quantity(v, UNITS[n])}" for n, v in s.without.items() if n in UNITS)
    return f"{said} Without that the fit gives {sentence(values)}"


def hidden(estimate: Estimate) -> str:
    """What nothing in these data can check: scales in a sentence, effects in one each; "" where
    none is listed.
    """
    found = _of(estimate, "not excluded")
    scales = [s for s in found if s.code in SCALES]
    effects = [s for s in found if s.code not in SCALES]
    said = []
    if scales:
        plated = any("nameplate" in s.evidence for s in scales)
        said.append((BOUNDED if plated else HIDDEN).format(what=_listed(scales)))
    said += [f"{sentence(s.evidence)} To reveal it, {s.action}." for s in effects]
    return " ".join(said)


def _listed(found: list[Suspect]) -> str:
    what = ", ".join(s.where for s in found[:-1]) + (" or " if len(found) > 1 else "")
    return what + found[-1].where


def as_html(estimate: Estimate) -> str:
    """A list of the named faults below the table, and what is not excluded."""
    items = items_as_html(estimate, first=False)
    named = f'<ul class="findings">{items}</ul>' if items else ""
    said = hidden(estimate)
    return named + (f'<p class="soft">{escape(said)}</p>' if said else "")


def items_as_html(estimate: Estimate, first: bool) -> str:
    """The named faults that stand above the table, or the others, as items of a list."""
    return "".join(
        f'<li class="warning"><b>{escape(s.where.capitalize())}</b>{escape(_whole(s))}</li>'
        for s in _of(estimate, "named")
        if decisive(estimate, s) is first
    )


def as_data(estimate: Estimate) -> list[dict[str, Any]]:
    """Plain data for JSON."""
    return [
        {
            "code": s.code,
            "where": s.where,
            "evidence": s.evidence,
            "action": s.action,
            "strength": s.strength,
        }
        | moves(s)
        | ({"without": plain(dict(s.without))} if s.without else {})
        for s in estimate.suspects
    ]


def moves(finding: Suspect | Diagnostic) -> dict[str, Any]:
    """What it could have moved, as entries of its JSON; none where it moves nothing."""
    said = {"moves": plain(dict(finding.moves))} if finding.moves else {}
    if isinstance(finding, Diagnostic) and finding.sides:
        said["sides"] = plain({name: list(both) for name, both in finding.sides.items()})
    return said


def _of(estimate: Estimate, strength: str) -> list[Suspect]:
    return [s for s in estimate.suspects if s.strength == strength]
