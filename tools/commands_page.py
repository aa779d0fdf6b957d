"""Writes docs/commands.md from the commands' own help and commands.toml; ``--check`` compares."""

from __future__ import annotations

import sys
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import click

from motorid.cli.main import cli
from motorid.cli.paged import Paged
from motorid.errors import MEANING_OF_EXIT

PAGE = Path(__file__).resolve().parent.parent / "docs" / "commands.md"
FACTS = Path(__file__).resolve().parent / "commands.toml"
WIDTH = 88
ANY_COMMAND = (0, 2, 4, 70, 130)  # an answer that cannot be printed is a 4
HEAD = ("command", "defaults", "leaves", "bad input", "exit codes", "after an interruption")
INTRODUCTION = """\
One line a command. **Leaves**: the files of the example that is run for it, `*` for what varies.
**Bad input**: lines and the exit codes that they end with. Each line of this table is run by
`tests/cli/test_command_table.py`."""
PRINTING = """\
What becomes of a command does not depend on whether it can be printed. A verdict and a file stand
with their exit code when standard output or standard error is closed, full or gone. An answer that
goes to standard output only (`motorid fit run.h5 --json`, a list, a help text) ends with 4 when it
cannot be written. A sentence on standard error says so. A reader that closes a pipe early,
as `head` does, has what it wanted: the code stays, and nothing is said."""


def help_text(command: click.Command, parent: click.Context | None = None) -> str:
    """The help of a command, as wide as the page on any terminal."""
    name = command.name if parent else "motorid"
    context = click.Context(
        command,
        info_name=name,
        parent=parent,
        terminal_width=WIDTH,
        max_content_width=WIDTH,
        help_option_names=["-h", "--help"],
    )
    return command.whole_help(context) if isinstance(command, Paged) else command.get_help(context)


def page() -> str:
    """The whole document."""
    root = click.Context(cli, info_name="motorid")
    parts = [
        "# Commands",
        "Written by `make docs` from the commands' own help and `tools/commands.toml`; edit those.",
        "## At a glance",
        INTRODUCTION,
        _table(),
        _block("motorid --help", help_text(cli)),
    ]
    for name in cli.list_commands(root):
        command = cli.get_command(root, name)
        assert command is not None
        parts += [f"## motorid {name}", _block(f"motorid {name} --help", help_text(command, root))]
        parts += _subcommands(command, root)
    parts += ["## Exit codes", _exit_table(), PRINTING]
    return "\n\n".join(parts) + "\n"


def codes(facts: Mapping[str, Any]) -> list[int]:
    """The exit codes that a command may end with."""
    found = {*ANY_COMMAND, *facts["ends"].values()}
    return sorted(found | ({1} if facts.get("verdict") else set()))


def _table() -> str:
    rows = [HEAD, ("---",) * len(HEAD)]
    for name, facts in tomllib.loads(FACTS.read_text(encoding="utf-8")).items():
        ends = [f"{code}: `{line}`" for line, code in facts["ends"].items()]
        rows.append(
            (
                f"`{name}`",
                " ".join(f"`{default}`" for default in _defaults(name.split())) or "—",
                _leaves(facts),
                "<br>".join(ends),
                ", ".join(map(str, codes(facts))),
                facts["again"],
            )
        )
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def _leaves(facts: Mapping[str, Any]) -> str:
    files = [" ".join(f"`{path}`" for path in facts["leaves"]), facts.get("also", "")]
    return "; ".join(filter(None, files)) or "nothing"


def _defaults(words: list[str]) -> Iterator[str]:
    """The options of a command that have a value unless one is given."""
    command: click.Command = cli
    for word in words:
        assert isinstance(command, click.Group)
        inner = command.get_command(click.Context(command), word)
        assert inner is not None
        command = inner
    for option in command.params:
        value = option.to_info_dict().get("default")
        is_set = value not in (None, "", ()) and not isinstance(value, bool)
        if is_set and "UNSET" not in repr(value).upper():
            yield f"{option.opts[-1]} {value}" if isinstance(option, click.Option) else str(value)


def _subcommands(command: click.Command, root: click.Context) -> list[str]:
    """The help of each command of a group."""
    if not isinstance(command, click.Group):
        return []
    context = click.Context(command, info_name=command.name, parent=root)
    return [
        _block(f"motorid {command.name} {name} --help", help_text(inner, context))
        for name, inner in command.commands.items()
    ]


def _block(command: str, text: str) -> str:
    return f"```\n$ {command}\n{text}\n```"


def _exit_table() -> str:
    rows = [f"| {code} | {meaning} |" for code, meaning in MEANING_OF_EXIT.items()]
    return "\n".join(["| code | meaning |", "|---|---|", *rows])


def main(arguments: list[str]) -> int:
    """Exit code 1 where ``--check`` finds the page behind its commands."""
    if "--check" not in arguments:
        PAGE.write_text(page(), encoding="utf-8", newline="\n")
        return 0
    if PAGE.exists() and PAGE.read_text(encoding="utf-8") == page():
        return 0
    print(f"{PAGE.name} is behind the commands' help: make docs", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
