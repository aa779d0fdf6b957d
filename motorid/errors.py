"""One exception tree; each class carries the exit code that the command line returns for it.

An exception means "cannot go on". Bad data that can be worked around travels as data
(gaps, rejected stretches, diagnostics) and ends in the report instead.
"""

from __future__ import annotations

from collections.abc import Iterable

EXIT_DONE = 0
EXIT_FAIL_VERDICT = 1
EXIT_USAGE = 2
EXIT_RIG = 3
EXIT_DATA = 4
EXIT_INTERNAL = 70
EXIT_INTERRUPTED = 130

MEANING_OF_EXIT = {
    EXIT_DONE: "done, or a PASS verdict",
    EXIT_FAIL_VERDICT: "a FAIL verdict, and nothing else",
    EXIT_USAGE: "usage: the request itself is wrong",
    EXIT_RIG: "rig or link: the rig file, the wiring, the motor, the board or the way to it",
    EXIT_DATA: "bad or insufficient data (INVALID, not supported; with --strict doubtful), or a "
    "file that cannot be read or written",
    EXIT_INTERNAL: "internal error: please report it",
    EXIT_INTERRUPTED: "interrupted; what was measured is kept",
}


class MotoridError(Exception):
    """Anything motorid refuses, in one sentence: what, where, what to do."""

    exit_code = EXIT_INTERNAL


class UsageError(MotoridError):
    """The request itself is wrong: an option, a unit, a method's name."""

    exit_code = EXIT_USAGE


class RigError(MotoridError):
    """The rig file or the rig is wrong: an unknown key, an unsafe program, a reversed encoder."""

    exit_code = EXIT_RIG


class LinkError(MotoridError):
    """The board cannot be reached, is not a motorid board, speaks another major, or went silent."""

    exit_code = EXIT_RIG


class DataError(MotoridError):
    """A file or a capture is bad, or holds too little to answer the question."""

    exit_code = EXIT_DATA


def nearest(name: str, known: Iterable[str]) -> str:
    """ ", did you mean 'x'?" for the known name nearest to a mistyped one, or nothing."""
    from difflib import get_close_matches

    found = get_close_matches(name, list(known), n=1)
    return f", did you mean {found[0]!r}?" if found else ""
