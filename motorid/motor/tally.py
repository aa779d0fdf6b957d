"""How many responses were computed: by this process, for a person who waits; and in a stretch of
work, for what may cost no more than so many.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass


class Tally:
    """A count of the process. Nothing is decided by it."""

    responses = 0


@dataclass
class Count:
    """Responses (evaluations of the motor) since it was opened, of this thread."""

    responses: int = 0


_open: ContextVar[tuple[Count, ...]] = ContextVar("counts", default=())


def add(responses: int) -> None:
    """So many were computed."""
    Tally.responses += responses
    for count in _open.get():
        count.responses += responses


@contextmanager
def counting() -> Iterator[Count]:
    """Counts what is computed in between, whatever else counts it too."""
    count = Count()
    token = _open.set((*_open.get(), count))
    try:
        yield count
    finally:
        _open.reset(token)
