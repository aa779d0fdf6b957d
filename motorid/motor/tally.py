"""How many responses this process has computed: for a person who waits, and for nothing else."""

from __future__ import annotations


class Tally:
    """A count. Nothing is decided by it."""

    responses = 0
