"""What a journal's header and marks must be: a damaged or foreign one costs one sentence."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, get_args

from motorid.capture.model import SUPPLY_BEFORE, Curve, Sense
from motorid.errors import DataError

LARGEST = 1e300
MOST_TEXT = 1 << 24
MOST_COUNT = 1 << 53


def _number(value: Any) -> bool:
    return isinstance(value, int | float) and value is not True and abs(value) < LARGEST


def _maybe(value: Any) -> bool:
    return value is None or _number(value)


def _count(value: Any) -> bool:
    return isinstance(value, int) and value is not True and 0 <= value < MOST_COUNT


def _text(value: Any) -> bool:
    if not isinstance(value, str) or len(value) > MOST_TEXT:
        return False
    try:
        value.encode()
    except UnicodeEncodeError:  # half of a surrogate pair
        return False
    return True


def _sense(value: Any) -> bool:
    return value in get_args(Sense)


def _fact(value: Any) -> bool:
    """Of a channel's calibration: a number, or the shape of its sensor's non-linearity."""
    return _maybe(value) or value in get_args(Curve)


def _plain(value: Any) -> bool:
    """JSON that can be written again."""
    if isinstance(value, Mapping):
        return all(_text(key) and _plain(one) for key, one in value.items())
    if isinstance(value, list):
        return all(map(_plain, value))
    return isinstance(value, bool) or _maybe(value) or _text(value)


def _table(holds: Callable[[Any], bool]) -> Callable[[Any], bool]:
    def holds_all(value: Any) -> bool:
        return isinstance(value, Mapping) and all(_text(k) and holds(v) for k, v in value.items())

    return holds_all


def _counts(value: Any) -> bool:
    return isinstance(value, list) and all(map(_count, value))


KINDS: Mapping[str, Callable[[Any], bool]] = {
    **dict.fromkeys(("created", "motorid", "port", "rig_name", "rig", "board_serial"), _text),
    **dict.fromkeys(("calibration_text", "serial", "note", "end"), _text),
    **dict.fromkeys(("first_request", "samples", "zero_samples"), _count),
    **dict.fromkeys(("ambient_c", "ambient_uncertainty_c"), _maybe),
    **dict.fromkeys(("wiring", "clock"), _table(_maybe)),
    **dict.fromkeys(("program", "calibration_file", "settings", "host"), _table(_plain)),
    "calibration": _table(_table(_fact)),
    "voltage_sense": _sense,
    "wire_steps": _counts,
    "check": _table(_plain),
    SUPPLY_BEFORE: _number,
    "measure": lambda value: isinstance(value, bool),
}


def check_kinds(found: Mapping[str, Any], where: str) -> None:
    """Raises DataError where a header, or a mark, holds something of another kind than it should.

    What a later version adds passes.
    """
    for key, value in found.items():
        if key in KINDS and not KINDS[key](value):
            shown = repr(value)
            shown = shown if len(shown) <= 60 else f"{shown[:60]}..."
            raise DataError(f"{where} is damaged: {key} cannot be {shown}")
