"""motorid completion"""

from __future__ import annotations

import click

from motorid.cli.options import example

VARIABLE = "_MOTORID_COMPLETE"
SHELLS = ("bash", "zsh", "fish")


@click.command(
    "completion",
    epilog=example(
        'eval "$(motorid completion bash)"',
        "motorid completion fish > ~/.config/fish/completions/motorid.fish",
    ),
)
@click.argument("shell", type=click.Choice(SHELLS))
def command(shell: str) -> None:
    """Print the lines that let SHELL complete commands, options, rigs and files.

    To have it always, keep them where the shell looks: for bash
    ~/.local/share/bash-completion/completions/motorid, for zsh a file _motorid in a folder of
    $fpath, for fish ~/.config/fish/completions/motorid.fish.
    """
    click.echo(script(shell), nl=False)


def script(shell: str) -> str:
    """What a shell reads to ask motorid for completions, by click's own template for it."""
    from click.shell_completion import get_completion_class

    kind = get_completion_class(shell)
    if kind is None:
        raise click.UsageError(f"there is no completion for {shell}.")
    asked = kind(click.Command("motorid"), {}, "motorid", VARIABLE)
    return (kind.source_template % asked.source_vars()).strip() + "\n"


def answer(cli: click.Command, asked: str) -> int:
    """Prints what a shell asked for, such as ``bash_complete``. Returns the exit code.

    It never fails with words: they would land in what the user types.
    """
    from click.shell_completion import shell_complete

    shell, _, what = asked.partition("_")
    if what == "source" and shell in SHELLS:
        click.echo(script(shell), nl=False)
        return 0
    try:
        return shell_complete(cli, {}, "motorid", VARIABLE, asked)
    except Exception:  # a rig file that cannot be read, an option that is half typed
        return 1
