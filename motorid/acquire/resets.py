"""A board that was reset while in use: what its cause means for whoever stands before it."""

from __future__ import annotations

from collections.abc import Mapping

from motorid.errors import LinkError
from motorid.wire.codec import name_of
from motorid.wire.enums import ResetCause

ADVICE: Mapping[int, str] = {
    ResetCause.POWER_ON: "its power was away, or another board was plugged in: check its cable",
    ResetCause.EXTERNAL: "its reset line was pulled, or another program opened its port",
    ResetCause.BROWN_OUT: "its supply sagged: give the board a supply apart from the motor's",
    ResetCause.WATCHDOG: "the firmware hung: please report it",
    ResetCause.UNKNOWN: "it cannot tell why: as a rule another program opened its port",
    ResetCause.SOFTWARE: "its firmware restarted itself: please report it",
}


class BoardResetError(LinkError):
    """The board lost configuration, program and run. ``cause`` is a reset cause's name."""

    cause = "unknown"


def reset_error(port_name: str, cause: int, when: str) -> BoardResetError:
    """The sentence for a board that was reset, or exchanged, ``when`` it was in use."""
    error = BoardResetError(
        f"{port_name}: the board was reset {when} ({name_of(ResetCause, cause)}) and opened the "
        f"bridge: {ADVICE.get(cause, 'check its supply and its cable')}"
    )
    error.cause = name_of(ResetCause, cause)
    return error
