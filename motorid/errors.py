"""One exception tree; each class carries the exit code that the command line returns for it.

An exception means "cannot go on". Bad data that can be worked around travels as data
(gaps, rejected stretches, diagnostics) and ends in the report instead.
"""

from __future__ import annotations

EXIT_DONE = 0
EXIT_FAIL_VERDICT = 1
EXIT_INTERRUPTED = 130


class MotoridError(Exception):
    """Anything motorid refuses, in one sentence: what, where, what to do."""

    exit_code = 70


class UsageError(MotoridError):
    """The request itself is wrong: an option, a unit, a method's name."""

    exit_code = 2


class RigError(MotoridError):
    """The rig file or the rig is wrong: an unknown key, an unsafe program, a reversed encoder."""

    exit_code = 3


class LinkError(MotoridError):
    """The board cannot be reached, is not a motorid board, speaks another major, or went silent."""

    exit_code = 3


class DataError(MotoridError):
    """A file or a capture is bad, or holds too little to answer the question."""

    exit_code = 4
