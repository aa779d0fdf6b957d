"""A proposal as text for a terminal of 80 columns: columns with plots, remarks, the command."""

from __future__ import annotations

import shlex
import textwrap
from collections.abc import Iterator, Sequence

from motorid.report import braille
from motorid.visible import on_one_line
from motorid.workflow.proposal.proposal import Proposal
from motorid.workflow.proposal.question import Question
from motorid.workflow.proposal.seen import Seen

WIDTH = 80
NAME, NUMBER, PLOT = 16, 9, 24
TEXT = WIDTH - 2 - NAME - 1 - NUMBER - 2 - PLOT - 2
MOST = 20  # columns that are shown; of others the names


def page(proposal: Proposal, *, plain: bool = False) -> str:
    """The columns and remarks. ``plain``: for a stream that takes no braille."""
    table = proposal.table
    count = len(table.columns) + table.more
    lines = [
        *textwrap.wrap(
            f"{on_one_line(table.path.name)}: {table.rows:,} rows, {count:,} column"
            f"{'' if count == 1 else 's'} ({table.source.layout})",
            WIDTH,
        ),
        "",
        f"  {'column':{NAME}} {'range':>{NUMBER}}  {'over the rows':{PLOT}}  read as",
    ]
    order = sorted(table.columns, key=lambda c: "left out" in proposal.readings.get(c.name, ""))
    for column in order[:MOST]:
        lines += _column(column, proposal.readings.get(column.name, ""), plain)
    if len(order) > MOST:
        lines += ["", *_folded("left out as well: " + ", ".join(c.name for c in order[MOST:]))]
    for remark in proposal.remarks:
        lines += ["", *_folded(remark)]
    return "\n".join(lines)


def _column(column: Seen, said: str, plain: bool) -> Iterator[str]:
    plot = braille.plot(column.values, PLOT, plain=plain)
    known = column.finite
    numbers = [f"{x:.5g}" for x in (known.max(), known.min())] if len(known) else ["", ""]
    names = textwrap.wrap(on_one_line(column.name), NAME) or [""]
    texts = textwrap.wrap(on_one_line(said), TEXT) or [""]
    for k in range(max(braille.LINES, len(names), len(texts))):
        parts = [numbers, plot, names, texts]
        number, dots, name, text = (part[k] if k < len(part) else "" for part in parts)
        yield f"  {name:{NAME}} {number:>{NUMBER}}  {dots:{PLOT}}  {text}".rstrip()


def _folded(sentence: str) -> list[str]:
    return textwrap.wrap(
        on_one_line(sentence), WIDTH, initial_indent="  ", subsequent_indent="    ",
        break_on_hyphens=False,
    )  # fmt: skip


def asked(question: Question) -> str:
    """A question with its answers, numbered from 1."""
    answers = [answer.text for answer in question.answers]
    if question.number is not None:
        answers.append(f"a number: {question.number}")
    lines = _folded(question.text)
    for number, text in enumerate(answers, 1):
        lines += textwrap.wrap(
            on_one_line(text), WIDTH, initial_indent=f"  {number:3}  ", subsequent_indent="       "
        )
    return "\n".join(lines)


def options(proposal: Proposal) -> list[str]:
    """What the proposal adds to a command line, as words."""
    words = [word for one in proposal.maps for word in ("--map", one)]
    if proposal.counts_per_turn:
        words += ["--counts-per-turn", f"{proposal.counts_per_turn:g}"]
    return words + (["--sense", proposal.sense] if proposal.sense else [])


def command(words: Sequence[str]) -> str:
    """A command line to copy; one that is too long goes on behind backslashes."""
    parts: list[str] = []
    for word in words:
        quoted = shlex.quote(on_one_line(word))
        if parts and not word.startswith("-") and parts[-1].startswith("-"):
            parts[-1] += f" {quoted}"
        else:
            parts.append(quoted)
    lines = ["  "]
    for part in parts:
        if len(lines[-1]) + len(part) + 3 > WIDTH and lines[-1].strip():
            lines[-1] += "\\"
            lines.append("      ")
        lines[-1] += f"{part} "
    return "\n".join(line.rstrip() for line in lines)
