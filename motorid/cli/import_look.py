"""The dialogue of ``motorid import FILE`` without maps: look, propose, ask, confirm."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from motorid.cli.streams import confirm, plain, prompt
from motorid.cli.values import finite
from motorid.errors import UsageError

if TYPE_CHECKING:
    from motorid.capture.table_options import TableOptions
    from motorid.workflow.proposal.proposal import Proposal
    from motorid.workflow.proposal.question import Known, Question
    from motorid.workflow.proposal.seen import Table

PROPOSED = ("maps", "look", "yes", "counts_per_turn", "sense", "output", "force")


@dataclass(frozen=True)
class Settled:
    """What was proposed and taken. ``how``: "confirmed" or "taken by --yes"."""

    maps: tuple[str, ...]
    counts_per_turn: float
    sense: str | None
    how: str


def settle(
    file: Path,
    maps: tuple[str, ...],
    chosen: TableOptions,
    sense: str | None,
    output: Path,
    yes: bool,
) -> Settled:
    """Shows what the file's columns are, and asks.

    Raises UsageError where nobody answers: no terminal, an open question under --yes, a no.
    """
    from motorid.workflow.proposal import proposal as proposals
    from motorid.workflow.proposal.question import Known, of_maps

    stated = Known(
        counts_per_turn=chosen.counts_per_turn, sense=sense or "", geared=chosen.gear_ratio != 1.0
    )
    said = of_maps(maps).and_(stated)
    table = proposals.look(file, chosen)
    asks = sys.stdin.isatty() and sys.stdout.isatty() and not yes
    found = _answered(table, said) if asks else proposals.propose(table, said)
    words = _words(file, found, output)
    _show(found, words)
    if found.questions:
        raise UsageError(_open(found.questions))
    if not yes and not asks:
        raise UsageError(
            "nothing is imported yet: there is no terminal to ask; run the command above, or give "
            "--yes to take the proposal"
        )
    if asks and not confirm("Import it so?", default=False):
        raise UsageError("nothing was imported: change the command above as needed, and run it")
    return Settled(
        found.maps, found.counts_per_turn, found.sense or None,
        "confirmed" if asks else "taken by --yes",
    )  # fmt: skip


def _answered(table: Table, known: Known) -> Proposal:
    """Asks question after question, until none is open."""
    from motorid.workflow.proposal.page import page
    from motorid.workflow.proposal.proposal import propose

    found = propose(table, known)
    if found.questions:
        click.echo(page(found, plain=plain(sys.stdout)))
    while found.questions:
        known = known.and_(_ask(found.questions[0]))
        found = propose(table, known)
    return found


def _ask(question: Question) -> Known:
    from motorid.workflow.proposal.page import asked

    click.echo(f"\n{asked(question)}")
    count = len(question.answers) + (question.number is not None)
    choice: int = prompt("Which", type=click.IntRange(1, count))
    if choice <= len(question.answers):
        return question.answers[choice - 1].known
    while True:
        try:
            return question.of_number(finite(prompt(f"Number ({question.number})")))
        except ValueError:
            click.echo("That is no number.")
        except UsageError as error:
            click.echo(f"{error}.")


def _show(found: Proposal, words: list[str]) -> None:
    from motorid.workflow.proposal.page import asked, command, page

    click.echo(page(found, plain=plain(sys.stdout)))
    for question in found.questions:
        click.echo(f"\nOpen:\n{asked(question)}")
    click.echo(f"\n{command(words)}\n")


def _open(questions: tuple[Question, ...]) -> str:
    said = questions[0]
    answers = ", or ".join(said.options) or "a --map for each quantity"
    others = len(questions) - 1
    more = f" ({others} more question{'s are' if others > 1 else ' is'} above)" if others else ""
    return (
        f"the file leaves open: {said.text.rstrip('?.:')}; answer with --look and {answers}{more}"
    )


def _words(file: Path, found: Proposal, output: Path) -> list[str]:
    from motorid.workflow.proposal.page import options

    ctx = click.get_current_context()
    return [
        "motorid", "import", str(file), *options(found), *_given(ctx), "-o", str(output),
        *(["--force"] if ctx.params.get("force") else []),
    ]  # fmt: skip


def _given(ctx: click.Context) -> list[str]:
    """The other options, as they were given."""
    words = []
    for param in ctx.command.params:
        if not isinstance(param, click.Option) or param.name in PROPOSED or param.name is None:
            continue
        source = ctx.get_parameter_source(param.name)
        if source is not click.core.ParameterSource.COMMANDLINE:
            continue
        value = ctx.params[param.name]
        if param.is_flag:
            words.append(param.opts[-1])
            continue
        for one in value if param.multiple else (value,):
            words += [param.opts[-1], _text(one)]
    return words


def _text(value: Any) -> str:
    return "=".join(map(str, value)) if isinstance(value, tuple) else str(value)
