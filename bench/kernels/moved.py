"""What a kernel moved: parameters by more than a hundredth of u, and words for their standing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from bench.kernels.child import Flat
from tests.frozen.compare import SPLIT, Difference, beyond

MOST_U = 0.01
HELD = ("parameters", "at_25", "combinations")  # a better model's own parameters likewise


@dataclass(frozen=True)
class Moved:
    """Of one kernel: every difference of what is held, and those that are too large."""

    kernel: str
    seen: Sequence[Difference]

    @property
    def bad(self) -> list[Difference]:
        """Statuses that changed, and parameters beyond .01 u."""
        return [d for d in self.seen if d.size > MOST_U]

    @property
    def greatest(self) -> Difference | None:
        """The parameter that moved most."""
        numbers = [d for d in self.seen if d.size < float("inf")]
        return max(numbers, key=lambda d: d.size, default=None)


def moved(kernel: str, first: Mapping[str, Flat], other: Mapping[str, Flat]) -> Moved:
    """What ``kernel``'s answers differ by from the ``first`` kernel's."""
    seen = []
    for subject, answer in first.items():
        parts = (_held(answer), _held(other[subject]))
        seen += beyond(subject, *parts, lambda path: 0.0)
    return Moved(kernel, seen)


def _held(answer: Flat) -> Flat:
    """Values with the uncertainties that they are measured by, and their standing."""
    return {path: value for path, value in answer.items() if _is_held(path.split(SPLIT))}


def _is_held(parts: list[str]) -> bool:
    if parts[0] == "alternative":
        parts = parts[1:] or ["name"]  # there is none
    if parts in (["name"], ["refused"]):
        return True
    return parts[0] in HELD and parts[-1] in ("value", "status", "total")
