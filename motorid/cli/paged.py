"""Help of a command with many options: a page that fits a terminal, and all of it if asked."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import click

ALL = "help_all"


class Paged(click.Command):
    """``--help`` shows the options named in ``common``; ``--help-all`` shows the whole."""

    def __init__(self, *args: Any, common: Sequence[str], **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.common = (*common, ALL)
        self.params.append(
            click.Option(
                ["--help-all", ALL],
                is_flag=True,
                is_eager=True,
                expose_value=False,
                help="Show every option and all that is to know.",
                callback=_show_all,
            )
        )

    def format_help_text(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The first paragraph alone."""
        whole = self.help
        self.help = (whole or "").partition("\n\n")[0]
        try:
            super().format_help_text(ctx, formatter)
        finally:
            self.help = whole

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        shown = [p for p in self.get_params(ctx) if p not in self.params or p.name in self.common]
        rows = [row for param in shown if (row := param.get_help_record(ctx)) is not None]
        with formatter.section("Options"):
            formatter.write_dl(rows)

    def whole_help(self, ctx: click.Context) -> str:
        """The text of ``--help-all``."""
        formatter = ctx.make_formatter()
        self.format_usage(ctx, formatter)
        super().format_help_text(ctx, formatter)
        super().format_options(ctx, formatter)
        self.format_epilog(ctx, formatter)
        return formatter.getvalue().rstrip("\n")


def _show_all(ctx: click.Context, _: click.Parameter, asked: bool) -> None:
    if asked and isinstance(ctx.command, Paged):
        click.echo(ctx.command.whole_help(ctx))
        ctx.exit()
