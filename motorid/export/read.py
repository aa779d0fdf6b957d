"""Reads the motor of an estimate.json, and refuses what an export would hide."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from motorid import json_seal
from motorid.errors import DataError, UsageError, nearest
from motorid.estimate.results.estimate import PARAMETERS, UNITS
from motorid.estimate.results.status import Status
from motorid.export.motor import GIVEN, Motor, Value
from motorid.version import __version__

_LONGEST = 300  # characters of a text of the estimate
_PLAIN = re.compile(r"[^\w .,:;/+()%=°·²Ω-]")
_ABOVE_ZERO = ("R", "K", "J")  # without which there is no such motor
SURE = (Status.ESTIMATED, Status.FIXED)


def read_motor(path: Path) -> Motor:
    """The motor that the estimate in ``path`` describes, at the motor's shaft.

    Raises DataError for a file that is none, or that holds a linear axis.
    """
    document = json_seal.read(path, "an estimate that motorid wrote (estimate.json)")
    schema = document.get("schema")
    if not (isinstance(schema, str) and schema.startswith("motorid-estimate-")):
        raise DataError(f"{path} is not an estimate: name the estimate.json of a fit")
    try:
        return _motor(path, document)
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError):
        raise DataError(f"{path} is not an estimate as motorid writes it: fit again") from None


def _motor(path: Path, document: Mapping[str, Any]) -> Motor:
    given = document["parameters"]
    for name in PARAMETERS:
        if given[name]["unit"] != UNITS[name]:
            raise DataError(
                f"{path}: {name} is in {given[name]['unit']}, so this is a linear axis: "
                "the targets of an export are turning motors"
            )
    serials = {str(one.get("serial") or "") for one in document["inputs"]}
    return Motor(
        values={name: _value(given[name]) for name in PARAMETERS},
        correlation=dict(_correlation(document["correlation"])),
        source=clean(path.name),
        digest=clean(str(document.get(json_seal.MEMBER, ""))),
        serial=clean(", ".join(sorted(serials - {""}))),
        motorid=__version__,
        beside=tuple(_beside(document)),
    )


def clean(text: str) -> str:
    """A text of others, fit for a comment of any language: one line, and no mark that ends one."""
    return re.sub("-{2,}", "-", _PLAIN.sub("_", " ".join(text.split())))[:_LONGEST].rstrip("-")


def _number(value: Any) -> float | None:
    if value is None:
        return None
    if isinstance(value, bool) or not math.isfinite(number := float(value)):
        raise ValueError
    return number


def _value(said: Mapping[str, Any]) -> Value:
    interval = said["interval_95"]
    ends = None
    if interval is not None and None not in interval:
        low, high = (float(end) for end in interval)
        ends = (low, high)
    return Value(
        value=_number(said["value"]),
        u=_number(said["uncertainty"]["total"]),
        interval_95=ends,
        status=str(Status(said["status"])),
        note=clean(str(said.get("note") or "")),
    )


def _correlation(said: Mapping[str, Any]) -> Iterator[tuple[tuple[str, str], float]]:
    for a, row in zip(said["names"], said["matrix"], strict=True):
        for b, one in zip(said["names"], row, strict=True):
            if a in PARAMETERS and b in PARAMETERS and one is not None:
                yield (a, b), float(one)


def _beside(document: Mapping[str, Any]) -> Iterator[str]:
    """What the six constants do not say of that motor."""
    for name, one in document.get("at_25", {}).items():
        if one["value"] is not None:
            yield clean(f"{name} = {one['value']:.6g} {one['unit']} at 25 °C")
    if document.get("alternative"):
        yield clean(
            f"The fit also found a wider model, {document['alternative']['name']}: "
            "this file has the six constants alone"
        )


def with_given(motor: Motor, given: Mapping[str, float]) -> Motor:
    """The motor with values that a person states. Raises UsageError on a name or value."""
    for name, value in given.items():
        if name not in PARAMETERS:
            raise UsageError(f"--set {name}: no such constant{nearest(name, PARAMETERS)}")
        if value < 0 or (value == 0 and name in _ABOVE_ZERO):
            raise UsageError(f"--set {name}={value:g}: give a value above zero, in {UNITS[name]}")
    kept = {pair: one for pair, one in motor.correlation.items() if not set(pair) & given.keys()}
    values = {
        name: Value(given[name], status=GIVEN, note="stated at the export, not estimated")
        if name in given
        else one
        for name, one in motor.values.items()
    }
    return replace(motor, values=values, correlation=kept)


def insist(
    motor: Motor, held: Sequence[str], *, allow_doubtful: bool, above_zero: Sequence[str] = ()
) -> None:
    """Raises DataError where a constant of ``held`` has no value, or one that is not sure."""
    for name in held:
        one = motor.values[name]
        why = f"{one.status}: {one.note}" if one.note else one.status
        if one.value is None:
            raise DataError(
                f"{motor.source} has no {name} ({why}): state one by --set {name}=VALUE, "
                f"in {UNITS[name]}, or capture what tells it"
            )
        if one.status not in (*SURE, GIVEN) and not allow_doubtful:
            raise DataError(
                f"{name} of {motor.source} is {why}: mend what the report says of it, or export "
                "it all the same by --allow-doubtful"
            )
        if one.value < 0 or (one.value == 0 and name in (*_ABOVE_ZERO, *above_zero)):
            raise DataError(
                f"{name} of {motor.source} is {one.value:g}, which this target cannot hold: "
                f"state one by --set {name}=VALUE, in {UNITS[name]}"
            )
