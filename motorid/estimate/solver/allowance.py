"""What a fit may cost: one allowance of responses, from which everything that it does draws.

Counted in evaluations of the motor, never by a clock: the same captures end the same way anywhere.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from motorid.motor.tally import Count, counting


class Allowance:
    """At most ``most`` responses of ``count``, of which ``kept`` are for what comes later.

    ``ended``: a search ended where it was, because it had no more; until somebody sets it back.
    """

    def __init__(self, count: Count | None = None, most: float = math.inf) -> None:
        self.count, self.most, self.kept = count or Count(), most, 0.0
        self.ended = False

    def bound(self, times: float, kept: float) -> None:
        """All shall take so many ``times`` what was spent so far; as ``kept`` of it stays."""
        self.most, self.kept = times * self.spent, kept * self.spent

    @property
    def spent(self) -> int:
        """Responses so far."""
        return self.count.responses

    @property
    def left(self) -> float:
        """Responses that are not kept for later; below 0 where those have begun."""
        return self.most - self.kept - self.spent

    def has(self, responses: float) -> bool:
        """Work that takes so many may begin."""
        return self.left >= responses

    def ends(self) -> bool:
        """Whether a search has to end where it is."""
        if self.left > 0.0:
            return False
        self.ended = True
        return True

    @contextmanager
    def keeping(self, responses: float) -> Iterator[None]:
        """In between so many more are kept."""
        before = self.kept
        self.kept = before + responses
        try:
            yield
        finally:
            self.kept = before


_now: ContextVar[Allowance | None] = ContextVar("allowance", default=None)


@contextmanager
def opened() -> Iterator[Allowance]:
    """One without an end yet, on which all searches in between draw."""
    with counting() as count:
        allowance = Allowance(count)
        token = _now.set(allowance)
        try:
            yield allowance
        finally:
            _now.reset(token)


def current() -> Allowance:
    """The one that is open; one without an end where none is."""
    return _now.get() or Allowance()


@contextmanager
def taking_none() -> Iterator[None]:
    """Searches in between take no responses: none of them ends where an allowance does."""
    token = _now.set(None)
    try:
        yield
    finally:
        _now.reset(token)


def used_up() -> bool:
    """A search has to end where it is; not where nothing was allowed or forbidden."""
    allowance = _now.get()
    return allowance is not None and allowance.ends()
