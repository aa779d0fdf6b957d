"""Names, and the sentence that tells a wrong one from the nearest right one."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

from motorid.errors import UsageError


def pick(name: str, known: Iterable[str], what: str) -> str:
    """``name`` itself, or the only known name that begins with it. Raises UsageError."""
    names = list(known)
    if name in names:
        return name
    starts = [n for n in names if name and n.startswith(name)]
    if len(starts) == 1:
        return starts[0]
    raise unknown(name, names, what)


def unknown(name: str, known: Iterable[str], what: str) -> UsageError:
    """The error for a name that is not known."""
    names = list(known)
    near = get_close_matches(name, names, n=1, cutoff=0.5)
    hint = f"; nearest is {near[0]!r}" if near else ""
    return UsageError(f"sim://: no {what} {name!r}{hint}; known: {', '.join(names)}")
