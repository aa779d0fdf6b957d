"""Where every exception becomes one sentence on stderr and one exit code."""

from __future__ import annotations

import os
import sys

import click

from motorid.errors import (
    EXIT_DATA,
    EXIT_INTERNAL,
    EXIT_INTERRUPTED,
    EXIT_USAGE,
    MotoridError,
)

TRACEBACK_SWITCH = "MOTORID_TRACEBACK"


def report(error: BaseException) -> int:
    """Says on stderr what went wrong, and returns the exit code that belongs to it."""
    if isinstance(error, click.Abort) and error.__cause__ is not None:
        error = error.__cause__  # click wraps Ctrl-C, and EOFError too
    if os.environ.get(TRACEBACK_SWITCH):
        _print_traceback(error)
    match error:
        case MotoridError():
            return _say(str(error), error.exit_code)
        case click.ClickException():
            return _say(_usage_sentence(error), EXIT_USAGE)
        case KeyboardInterrupt() | click.Abort():
            return _say(str(error) or "interrupted", EXIT_INTERRUPTED)
        case BrokenPipeError():
            _forget_stdout()
            return EXIT_INTERRUPTED
        case OSError() if error.filename is not None:
            return _say(f"{error.filename}: {error.strerror}", EXIT_DATA)
        case _:
            return _say(_internal_sentence(error), EXIT_INTERNAL)


def _say(sentence: str, code: int) -> int:
    one_line = " ".join(sentence.split())
    click.echo(f"motorid: {one_line}", err=True)
    return code


def _usage_sentence(error: click.ClickException) -> str:
    context = getattr(error, "ctx", None)
    path = context.command_path if context else "motorid"
    return f"{error.format_message().rstrip('.')}; see '{path} --help'"


def _internal_sentence(error: BaseException) -> str:
    what = f"internal error, {type(error).__name__}: {error}"
    if os.environ.get(TRACEBACK_SWITCH):
        return what
    return f"{what}. {_saved_traceback(error)} Please report it."


def _print_traceback(error: BaseException) -> None:
    import traceback

    traceback.print_exception(error, file=sys.stderr)


def _saved_traceback(error: BaseException) -> str:
    import tempfile
    import traceback

    try:
        with tempfile.NamedTemporaryFile(
            "w", prefix="motorid-traceback-", suffix=".txt", delete=False, encoding="utf-8"
        ) as file:
            traceback.print_exception(error, file=file)
    except OSError:
        return f"Run it again with {TRACEBACK_SWITCH}=1 to see where."
    return f"Where it happened is in {file.name}."


def _forget_stdout() -> None:
    """Whoever read our output has gone; keeps the interpreter's last flush from complaining."""
    sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115 - lives until exit
