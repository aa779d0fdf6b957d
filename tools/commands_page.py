"""Writes docs/commands.md from the commands' own help; ``--check`` only compares."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from motorid.cli.main import cli
from motorid.errors import MEANING_OF_EXIT

PAGE = Path(__file__).resolve().parent.parent / "docs" / "commands.md"
WIDTH = 88


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
    return command.get_help(context)


def page() -> str:
    """The whole document."""
    root = click.Context(cli, info_name="motorid")
    parts = [
        "# Commands",
        "Written by `make docs` from the commands' own help; edit that.",
        _block("motorid --help", help_text(cli)),
    ]
    for name in cli.list_commands(root):
        command = cli.get_command(root, name)
        assert command is not None
        parts += [f"## motorid {name}", _block(f"motorid {name} --help", help_text(command, root))]
        parts += _subcommands(command, root)
    parts += ["## Exit codes", _exit_table()]
    return "\n\n".join(parts) + "\n"


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
