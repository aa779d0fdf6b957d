"""The estimate as a table for a terminal of 80 to 100 columns."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterable, Sequence
from functools import partial

from motorid.estimate.results.estimate import Diagnostic, Estimate, Parameter
from motorid.estimate.results.status import Status
from motorid.report import alternative, suspects, unstated
from motorid.report.numbers import aligned, in_rpm, percent, relative, shown
from motorid.report.words import (
    COVERAGE,
    STATUS_WORDS,
    decisive,
    doubts,
    fit_quality,
    instruments,
    name_of,
    one_run,
    others,
    reference,
    remarks,
    sentence,
    six,
    traceability,
)

WIDTH = 96
NARROWEST = 80
Wrap = Callable[[str, str], str]
MARKS = {"info": "·", "warning": "!", "error": "✗"}
HEADER = ("", "", "value ± 95 %", "statistical", "instrument", "status")


def render(estimate: Estimate, width: int = WIDTH) -> str:
    """The whole report as text, ending in a newline; in lines of ``width`` columns, 80 at least."""
    width = max(min(width, WIDTH), NARROWEST)
    wrap = partial(_wrap, width=width)
    parts = _first(estimate, wrap)
    parts.append(_table(estimate, width))
    doubtful = doubts(estimate)
    if doubtful:
        parts.append("\n".join(wrap(note, "  ! ") for note in doubtful))
    parts += alternative.as_text(estimate)
    parts += _section("combinations", estimate.combinations.values())
    parts += _section("derived", estimate.derived.values())
    parts += _section("estimated on the way", estimate.nuisance.values())
    notes = remarks(estimate)
    if notes:
        parts.append("\n".join(wrap(note, "  ") for note in notes))
    if estimate.alternative:
        said = alternative.sentences(estimate.alternative)
        parts.append("\n".join(wrap(text, "  ") for text in said))
    if gains := unstated.lines(estimate):
        parts.append("\n".join(wrap(line, "  ") for line in gains))
    parts += [found] if (found := _findings(estimate, wrap)) else []
    parts += _suspects(estimate, wrap)
    parts.append("\n".join(wrap(line, "  ") for line in _closing(estimate)))
    return "\n\n".join(parts) + "\n"


def _first(estimate: Estimate, wrap: Wrap) -> list[str]:
    """What stands above the table: findings that moved a value, or left none."""
    lines = [
        wrap(sentence(d.message), f"  {MARKS[d.severity]} ") for d in _ordered(estimate, first=True)
    ]
    lines += [wrap(said, "  ! ") for said in suspects.as_sentences(estimate, first=True)]
    return ["\n".join(lines)] if lines else []


def _section(title: str, parameters: Iterable[Parameter]) -> list[str]:
    """A short table: name, value, and rpm where that is customary."""
    known = [p for p in parameters if p.value is not None]
    if not known:
        return []
    name = _widest(name_of(p) for p in known)
    lines = [
        f"  {name_of(p):<{name}}  {value}  {_aside(p)}".rstrip()
        for p, value in zip(known, _values(known), strict=True)
    ]
    return ["\n".join((title, *lines))]


def _aside(p: Parameter) -> str:
    status = "" if p.status is Status.ESTIMATED else STATUS_WORDS[p.status]
    return "  ".join(part for part in (in_rpm(p) and f"= {in_rpm(p)}", status) if part)


def _table(estimate: Estimate, width: int) -> str:
    """The main table: name, meaning, value, both parts of the uncertainty, status.

    A narrow one has no meanings.
    """
    parameters = six(estimate) + reference(estimate) + others(estimate)
    rows = [HEADER] + [
        (p.name, name_of(p), value, *_parts(estimate, p), STATUS_WORDS[p.status])
        for p, value in zip(parameters, _values(parameters), strict=True)
    ]
    lines = _columns(rows, "<<<>><")
    if _widest(lines) > width:
        lines = _columns([(name, *rest) for name, _, *rest in rows], "<<>><")
    lines.insert(1, "  " + "─" * (_widest(lines) - 2))
    return "\n".join(lines)


def _columns(rows: Sequence[Sequence[str]], sides: str) -> list[str]:
    """Lines of a table; ``sides``: how each column is aligned."""
    widths = [_widest(column) for column in zip(*rows, strict=True)]
    return [
        "".join(
            f"  {text:{side}{w}}" for text, side, w in zip(row, sides, widths, strict=True)
        ).rstrip()
        for row in rows
    ]


def _parts(estimate: Estimate, p: Parameter) -> tuple[str, str]:
    """The statistical and the instrument uncertainty, relative to the value."""
    share = relative(p, p.statistical)
    return (percent(share), unstated.instrument(estimate, p)) if share is not None else ("", "")


def _values(parameters: list[Parameter]) -> list[str]:
    """``value ± half unit`` of each, decimal points and signs in columns."""
    seen = [shown(p) for p in parameters]
    values, halves = aligned([s.value for s in seen]), _widest(s.half for s in seen)
    lines = []
    for p, s, value in zip(parameters, seen, values, strict=True):
        half = f"± {s.half}" if s.half else ""
        lines.append(f"{value} {half:<{halves + 2}} {s.unit if p.value is not None else ''}")
    return lines


def _widest(texts: Iterable[str]) -> int:
    return max((len(t) for t in texts), default=0)


def _findings(estimate: Estimate, wrap: Wrap) -> str:
    found = _ordered(estimate, first=False)
    if not estimate.diagnostics:
        return "  · No finding about the data or the fit."
    return "\n".join(wrap(sentence(d.message), f"  {MARKS[d.severity]} ") for d in found)


def _ordered(estimate: Estimate, first: bool) -> list[Diagnostic]:
    """The gravest first: those above the table, or the others."""
    order = {"error": 0, "warning": 1, "info": 2}
    found = [d for d in estimate.diagnostics if decisive(estimate, d) is first]
    return sorted(found, key=lambda d: order[d.severity])


def _suspects(estimate: Estimate, wrap: Wrap) -> list[str]:
    """Faults of the measuring chain that the fit names, and scales that it cannot check."""
    named = [wrap(said, "  ! ") for said in suspects.as_sentences(estimate, first=False)]
    unseen = suspects.hidden(estimate)
    lines = ["suspects", *named] if named else []
    lines += [wrap(unseen, "  ")] if unseen else []
    return ["\n".join(lines)] if lines else []


def _closing(estimate: Estimate) -> list[str]:
    sources = [
        f"{i.get('path') or 'capture'} ({i.get('samples', '?')} samples, "
        f"sha256 {str(i.get('sha256') or 'none')[:12]})"
        for i in estimate.inputs
    ]
    lines = [one_run(estimate), COVERAGE, fit_quality(estimate)]
    lines.append(f"Model {estimate.model}, method {estimate.method}.")
    taken = dict.fromkeys(sentence(instruments(i)) for i in estimate.inputs if instruments(i))
    meant = [line for line in (*taken, traceability(estimate)) if line]
    return [line for line in lines if line] + [f"From {s}" for s in sources] + meant


def _wrap(sentence: str, mark: str, width: int) -> str:
    return textwrap.fill(
        sentence, width, initial_indent=mark, subsequent_indent=" " * len(mark),
        break_long_words=False, break_on_hyphens=False,
    )  # fmt: skip
