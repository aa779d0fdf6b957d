"""Two estimates laid flat, held against each other: bit for bit, or within a tolerance.

A difference of a number is counted in units of what it may be off by: a value and its interval in
the total standard uncertainty u, a line of a budget in itself or a tenth of the greatest line of
that parameter, a part of an uncertainty likewise, a correlation in 1, what a gain that nobody
stated would change of a value in that value's u, everything else in itself.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

from tests.frozen.flat import SPLIT, Flat, Value

MOST_ROWS = 40
LEAST_SHARE = 0.1  # of a parameter's greatest line, or total uncertainty
NUMBER = re.compile(r"[-+−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
COUNTED = re.compile(r"[\d,]+ (?=evaluations)")  # rounding moves these: each machine has its own
EVALUATIONS = "evaluations"
MISSING = "(none)"
MOVED = ("moves", "sides")


@dataclass(frozen=True)
class Difference:
    """One path of one case. ``size``: in the units above; infinite for words and missing paths."""

    case: str
    path: str
    recorded: Value
    found: Value
    size: float


def bits(case: str, recorded: Flat, found: Flat) -> list[Difference]:
    """What differs at all."""
    return [d for d in _each(case, recorded, found) if not identical(d.recorded, d.found)]


def beyond(
    case: str, recorded: Flat, found: Flat, tolerance: Callable[[str], float]
) -> list[Difference]:
    """What differs by more than the tolerance of its path; counts of evaluations are free."""
    return [
        d
        for d in _each(case, recorded, found)
        if _last(d.path) != EVALUATIONS and d.size > tolerance(d.path)
    ]


def sizes(recorded: Flat, found: Flat) -> dict[str, float]:
    """The greatest difference in each part of an estimate; 0 where it has none."""
    most = {part(path): 0.0 for path in recorded}
    for d in _each("", recorded, found):
        if _last(d.path) != EVALUATIONS:
            most[part(d.path)] = max(most.get(part(d.path), 0.0), d.size)
    return most


def part(path: str) -> str:
    """The part of an estimate that a path is in, such as ``parameters``."""
    return path.split(SPLIT, 1)[0]


def _each(case: str, recorded: Flat, found: Flat) -> Iterator[Difference]:
    scales = Scales(recorded)
    for path in sorted(recorded.keys() | found.keys()):
        old, new = recorded.get(path, MISSING), found.get(path, MISSING)
        yield Difference(case, path, old, new, departure(path, old, new, scales))


def identical(old: Value, new: Value) -> bool:
    """The same kind, and the same bits."""
    return type(old) is type(new) and repr(old) == repr(new)


def departure(path: str, old: Value, new: Value, scales: Scales) -> float:
    """How far two values lie apart; infinite where they are no numbers and differ."""
    if identical(old, new):
        return 0.0
    if isinstance(old, str) and isinstance(new, str):
        return 0.0 if alike(old, new) else math.inf
    numbers = all(isinstance(v, int | float) and not isinstance(v, bool) for v in (old, new))
    if not numbers or (isinstance(old, int) and _last(path) != EVALUATIONS):
        return math.inf
    assert isinstance(old, int | float)
    assert isinstance(new, int | float)
    scale = scales.of(path)
    return abs(new - old) / scale if scale else math.inf


def alike(old: str, new: str) -> bool:
    """The same words around numbers that agree to one in their last printed place."""
    old, new = COUNTED.sub("", old), COUNTED.sub("", new)
    if NUMBER.split(old) != NUMBER.split(new):
        return False
    return all(map(_close, NUMBER.findall(old), NUMBER.findall(new)))


def _close(old: str, new: str) -> bool:
    if old == new:
        return True
    places = [_place(text) for text in (old, new)]
    a, b = (float(text.replace("−", "-")) for text in (old, new))
    return abs(a - b) <= 1.001 * max(places)


def _place(text: str) -> float:
    """What 1 in the last place of a printed number is worth."""
    mantissa, _, exponent = text.partition("e")
    decimals = len(mantissa.partition(".")[2])
    return float(10.0 ** (int(exponent or 0) - decimals))


class Scales:
    """What each number of a case is measured by."""

    def __init__(self, recorded: Flat) -> None:
        self._all = recorded
        self._greatest: dict[tuple[str, ...], float] = {}
        for path, value in recorded.items():
            if isinstance(value, int | float):
                key = _kind(path)
                self._greatest[key] = max(self._greatest.get(key, 0.0), abs(value))

    def of(self, path: str) -> float:
        """A positive number, or 0 where the case has none to measure by."""
        parts = path.split(SPLIT)
        if parts[0] == "correlation":
            return 1.0
        value = self._all.get(path)
        own = abs(value) if isinstance(value, int | float) else 0.0
        if parts[0] == "budget":
            return max(own, LEAST_SHARE * self._greatest[_kind(path)])
        if parts[0] == "not_stated":
            return self._of_value(parts[-1]) or own
        for moved in MOVED:  # by a finding: a part of the parameter's uncertainty is no difference
            if moved in parts[:-1]:
                return max(own, self._of_value(parts[parts.index(moved) + 1]))
        owner = parts[:-2] if parts[-2:-1] == ["interval_95"] else parts[:-1]
        total = self._total(owner)
        if total:
            return total
        if "uncertainty" in parts:
            return max(own, LEAST_SHARE * self._greatest_part(parts))
        return own or self._greatest.get(_kind(path), 0.0)

    def _of_value(self, name: str) -> float:
        """The total uncertainty of the parameter or combination of that name; 0: it has none."""
        totals = (self._total((table, name)) for table in ("parameters", "combinations"))
        return next((u for u in totals if u), 0.0)

    def _total(self, owner: Sequence[str]) -> float:
        """The total uncertainty of a value; 0 where it has none."""
        total = self._all.get(SPLIT.join((*owner, "uncertainty", "total")))
        return total if isinstance(total, float) else 0.0

    def _greatest_part(self, parts: Sequence[str]) -> float:
        total = self._all.get(SPLIT.join((*parts[:-1], "total")))
        return abs(total) if isinstance(total, int | float) else 0.0


def _kind(path: str) -> tuple[str, ...]:
    """What numbers are alike: the lines of one parameter's budget, a column of a table."""
    parts = path.split(SPLIT)
    return (parts[0], parts[1]) if parts[0] == "budget" else (parts[0], parts[-1])


def _last(path: str) -> str:
    return path.rsplit(SPLIT, 1)[-1]


def table(found: Sequence[Difference], most: int = MOST_ROWS) -> str:
    """The greatest differences as a table, and how many there are of each kind."""
    if not found:
        return "no difference"
    shown = sorted(found, key=lambda d: (-d.size, d.case, d.path))[:most]
    head = ("case", "path", "recorded", "found", "difference")
    rows = [(d.case, d.path, _cell(d.recorded), _cell(d.found), _size(d)) for d in shown]
    widths = [max(len(row[k]) for row in (head, *rows)) for k in range(len(head))]
    lines = ["  ".join(c.ljust(w) for c, w in zip(r, widths, strict=True)).rstrip()
             for r in (head, *rows)]  # fmt: skip
    if len(found) > len(shown):
        lines.append(f".. and {len(found) - len(shown)} more")
    return "\n".join([*lines, "", *_counts(found)])


def _cell(value: Value) -> str:
    text = repr(value) if isinstance(value, float) else str(value)
    return text if len(text) <= 40 else f"{text[:37]}..."


def _size(d: Difference) -> str:
    if not math.isfinite(d.size):
        return "differs"
    unit = "u" if {"value", "interval_95"} & set(d.path.split(SPLIT)) else "of it"
    return f"{d.size:.1e} {unit}"


def _counts(found: Iterable[Difference]) -> Iterator[str]:
    cases, kinds = Counter(), Counter()  # type: ignore[var-annotated]
    for d in found:
        cases[d.case] += 1
        kinds[d.path.split(SPLIT)[0]] += 1
    for title, counts in (("case", cases), ("part", kinds)):
        yield f"by {title}: " + ", ".join(f"{name} {n}" for name, n in counts.most_common())
