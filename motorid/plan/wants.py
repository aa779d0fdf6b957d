"""What a plan must reach: 95 % intervals of parameters, and steady running where that is judged."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from motorid.errors import UsageError
from motorid.estimate.results.estimate import PARAMETERS, UNITS
from motorid.estimate.uncertainty.intervals import POSITIVE
from motorid.motor.parameters import Motor

USUAL = ("R=1%", "L=5%", "K=1%", "J=2%", "B=20%", "T0=10%")
WANT = re.compile(r"(?P<name>\w+)=(?P<number>[0-9.eE+-]+)(?P<percent>%?)")


@dataclass(frozen=True)
class Want:
    """``reach``: half the 95 % interval; relative for R, L, K and J, in SI units for B and T0."""

    name: str
    reach: float

    def of(self, value: float) -> float:
        """The same, relative to a parameter's value."""
        return self.reach if self.name in POSITIVE else self.reach / value


@dataclass(frozen=True)
class Demand:
    """All that one plan must reach. ``turns`` of steady running in each direction; 0: none."""

    wants: tuple[Want, ...]
    turns: float = 0.0
    sources: Mapping[str, str] = field(default_factory=dict)  # which limit a want follows from


def wanted(texts: Sequence[str], expected: Motor) -> tuple[Want, ...]:
    """Wants such as R=1% or J=2e-8 (SI). Raises UsageError.

    A percentage of B or T0 is one of ``expected``: a motor without friction has no percent of it.
    """
    found: dict[str, Want] = {}
    for text in texts:
        match = WANT.fullmatch(text.strip())
        name = match["name"] if match else ""
        if match is None or name not in PARAMETERS:
            raise UsageError(
                f"--want {text[:60]!r} is not NAME=NUMBER% or NAME=NUMBER in SI units, with NAME "
                f"one of {', '.join(PARAMETERS)}: such as R=1%"
            )
        found[name] = _want(name, match, expected, text)
    return tuple(found[name] for name in PARAMETERS if name in found)


def _want(name: str, match: re.Match[str], expected: Motor, text: str) -> Want:
    value = float(getattr(expected, name))
    try:
        number = float(match["number"])
    except ValueError:
        raise UsageError(f"--want {text[:60]!r}: {match['number'][:40]!r} is no number") from None
    relative = number / 100.0 if match["percent"] else number / value
    if not 0 < relative < 1:
        unit = "%" if match["percent"] else f" {UNITS[name]}"
        most = "100 %" if match["percent"] else f"{value:.3g} {UNITS[name]}"
        raise UsageError(f"--want {name}={number:g}{unit} must lie between 0 and {most}")
    return Want(name, relative if name in POSITIVE else relative * value)
