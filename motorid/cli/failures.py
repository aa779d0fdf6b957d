"""Where every exception becomes one sentence on stderr and one exit code."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

import click

from motorid.cli import streams
from motorid.errors import (
    EXIT_DATA,
    EXIT_DONE,
    EXIT_FAIL_VERDICT,
    EXIT_INTERNAL,
    EXIT_INTERRUPTED,
    EXIT_USAGE,
    MotoridError,
    UsageError,
)
from motorid.visible import on_one_line

TRACEBACK_SWITCH = "MOTORID_TRACEBACK"
LONGEST = 2000  # characters of a sentence: one that quotes a long value ends there


def report(error: BaseException) -> int:
    """Says on stderr what went wrong, and returns the exit code that belongs to it.

    What the operating system refuses is nobody's mistake in here: a file, a disk, a device.
    """
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
        case OSError():
            return _say(_refusal(error), EXIT_DATA)
        case MemoryError():
            return _say("the memory of this computer does not hold that: give less", EXIT_DATA)
        case _:
            return _say(_internal_sentence(error), EXIT_INTERNAL)


def report_lost(problem: str, code: int | None) -> int:
    """Says that the answer could not be printed. The code of an outcome stands all the same."""
    sentence = f"standard output cannot be written ({problem})"
    if code is None:
        return _say(f"{sentence}, and the answer was to go there: send it elsewhere", EXIT_DATA)
    said = {EXIT_DONE: "done", EXIT_FAIL_VERDICT: "FAIL"}.get(code, f"exit code {code}")
    return _say(f"{sentence}; the outcome stands all the same: {said}", code)


def refuse_unprintable(args: Sequence[str]) -> None:
    """Raises UsageError for an argument that is no text: no file and no database could carry it."""
    for arg in args:
        if "\0" in arg or any("\ud800" <= character <= "\udfff" for character in arg):
            raise UsageError(
                f"the argument '{on_one_line(arg)}' is not UTF-8 text: rename the file, or write "
                "the text in UTF-8"
            )


def _refusal(error: OSError) -> str:
    said = error.strerror or str(error) or type(error).__name__
    return f"{on_one_line(str(error.filename))}: {said}" if error.filename is not None else said


def _say(sentence: str, code: int) -> int:
    one_line = " ".join(sentence.split())
    if len(one_line) > LONGEST:
        one_line = f"{one_line[:LONGEST]} ..."
    click.echo(streams.folded(f"motorid: {one_line}"), err=True, color=True)
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
