"""A group of commands that are imported only when they are called.

``motorid --help`` must not pay for numpy; the group knows each command's one-line help itself.
"""

from __future__ import annotations

import inspect
import textwrap
from collections.abc import Mapping
from importlib import import_module
from typing import Any

import click

OTHERS = "Others"


class LazyGroup(click.Group):
    """``table``: command name -> (module in ``motorid.cli``, one-line help).

    ``tasks``: the heading of a task -> the commands that serve it, in the order of the help.
    """

    def __init__(
        self,
        *args: Any,
        table: Mapping[str, tuple[str, str]],
        tasks: Mapping[str, tuple[str, ...]],
        **kwargs: Any,
    ) -> None:
        super().__init__(*args, **kwargs)
        self.table = table
        self.tasks = tasks

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(self.table)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in self.table:
            return None
        module, summary = self.table[cmd_name]
        command: click.Command = import_module(f"motorid.cli.{module}").command
        command.short_help = summary
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        name = args[0]
        if name not in self.table and not name.startswith("-"):
            from motorid.errors import UsageError, nearest

            raise UsageError(
                f"there is no command {name!r}{nearest(name, self.table)}; "
                "'motorid --help' lists them"
            )
        return super().resolve_command(ctx, args)

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[Any]:
        """Names from the table: completion must not import every command."""
        from click.shell_completion import CompletionItem

        names = [
            CompletionItem(name, help=summary)
            for name, (_, summary) in self.table.items()
            if name.startswith(incomplete)
        ]
        return names or click.Command.shell_complete(self, ctx, incomplete)

    def format_help_text(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Right below the usage: one page must hold all."""
        with formatter.indentation():
            formatter.write_text(inspect.cleandoc(self.help or ""))

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The commands by task, without empty lines between them."""
        grouped = {name for names in self.tasks.values() for name in names}
        rest = tuple(name for name in self.table if name not in grouped)
        width = max(map(len, self.table))
        for heading, names in (*self.tasks.items(), (OTHERS, rest)):
            if names:
                formatter.write_heading(heading)
            for name in names:
                formatter.write(_row(name, self.table[name][1], width, formatter.width) + "\n")


def _row(name: str, summary: str, column: int, width: int) -> str:
    first = f"  {name:{column}}  "
    room, rest = max(width, len(first) + 20), " " * len(first)
    return textwrap.fill(summary, room, initial_indent=first, subsequent_indent=rest)
