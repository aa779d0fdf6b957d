"""Lines that name each value: JSON objects, and what boards print for a serial plotter."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from datetime import datetime
from typing import Any, NamedTuple

from motorid import json_text

Record = dict[str, float | str]
STAMP = "stamp"  # the column of what a serial monitor writes before a line: s of the day

_NUMBER = r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?|[+-]?inf|nan"
_LABEL = r"[^\W\d][\w .()\[\]/°·%-]{0,63}?"  # bounded: work grows with the line alone
_PAIR = re.compile(rf"\s*({_LABEL})\s*[:=]\s*({_NUMBER})\s*(?:[,;\t]\s*|\s|$)", re.IGNORECASE)
_MONITOR = re.compile(r"(\d\d):(\d\d):(\d\d(?:\.\d+)?)\s*->\s*")
_FRACTION = re.compile(r"[.,](\d{1,15})(?=Z|[+-]\d|$)")
_DEEPEST = 6
_LONGEST_MOMENT = 48  # characters


class Moment(NamedTuple):
    """Seconds since some day, whole ones and the rest, so that no digit is lost."""

    whole: int
    part: float

    def since(self, first: Moment) -> float:
        """Seconds from another moment to this one."""
        return (self.whole - first.whole) + (self.part - first.part)


class NoRecordError(ValueError):
    """A line that is none of its kind."""


def json_record(line: str) -> Record:
    """The members of a JSON object; those of objects within it by dotted names.

    Raises NoRecordError.
    """
    try:
        value = json_text.loads(line)
    except json_text.JsonError:
        raise NoRecordError from None
    if not isinstance(value, dict):
        raise NoRecordError
    return dict(_members(value, ""))


def _members(value: Mapping[str, Any], before: str) -> Iterator[tuple[str, float | str]]:
    if before.count(".") > _DEEPEST:
        raise NoRecordError
    for key, one in value.items():
        name = f"{before}{key}"
        if isinstance(one, dict):
            yield from _members(one, f"{name}.")
        elif isinstance(one, list):
            yield from _members({f"[{k + 1}]": part for k, part in enumerate(one)}, name)
        elif isinstance(one, bool | int | float):
            yield name, float(one)
        else:
            yield name, "" if one is None else str(one)


def labelled_record(line: str) -> Record:
    """``speed:12.5 current:0.3``, with commas, tabs or blanks between. Raises NoRecordError."""
    found: Record = {}
    at = 0
    if stamp := _MONITOR.match(line):
        hours, minutes, seconds = stamp.groups()
        found[STAMP] = 3600.0 * int(hours) + 60.0 * int(minutes) + float(seconds)
        at = stamp.end()
    line = line.rstrip()
    while at < len(line):
        pair = _PAIR.match(line, at)
        if pair is None or pair[1] in found:
            raise NoRecordError
        found[pair[1]] = float(pair[2])
        at = pair.end()
    if not found.keys() - {STAMP}:
        raise NoRecordError
    return found


def moment(text: str) -> Moment | None:
    """A date and time as ISO 8601 writes them; None for another text.

    Without a zone it counts as UTC: only differences are used. Every digit of a fraction counts.
    """
    if not 10 <= len(text) <= _LONGEST_MOMENT or text[4] != "-":
        return None
    fraction = _FRACTION.search(text)
    whole = text[: fraction.start()] + text[fraction.end() :] if fraction else text
    try:
        found = datetime.fromisoformat(whole)
        offset = found.utcoffset()
    except ValueError:
        return None
    day_s = 3600 * found.hour + 60 * found.minute + found.second
    zone_s = offset.total_seconds() if offset else 0.0
    part = float(f"0.{fraction[1]}") if fraction else 0.0
    return Moment(86400 * found.toordinal() + day_s - round(zone_s), part)


Reader = Callable[[str], Record]
KINDS: Mapping[str, Reader] = {"JSON lines": json_record, "labelled lines": labelled_record}


def kind_of(lines: list[str]) -> str | None:
    """Which kind a file's first lines are: most of them are records of it; None: neither."""
    filled = [line for line in lines if line.strip()]
    for kind, read in KINDS.items():
        good = sum(_reads(read, line) for line in filled)
        if good > 0.8 * len(filled) - 1 and 2 * good > len(filled):
            return kind
    return None


def _reads(read: Reader, line: str) -> bool:
    try:
        return bool(read(line))
    except NoRecordError:
        return False
