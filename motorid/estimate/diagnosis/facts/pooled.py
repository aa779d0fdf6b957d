"""Whether captures that are fitted together can be of one motor on one bench."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

from motorid.capture.model import CURRENT, SUPPLY, VOLTAGE, Capture
from motorid.errors import DataError
from motorid.estimate.results.estimate import Diagnostic, Estimate

GEOMETRY = ("counts_per_turn", "gear_ratio")  # of wiring: one encoder on one shaft has one of each
SURE = 5.0  # standard uncertainties of two gains, beyond which they are not of one sensor
LEAST_GAIN = 1e-3  # relative, by which two gains may differ whatever is stated
PLATE_OFF = 0.01  # relative, of two nameplates


def findings(
    captures: Sequence[Capture], estimate: Estimate, fit: Callable[[Sequence[Capture]], Estimate]
) -> Iterator[Diagnostic]:
    """Facts by which these captures are not of one motor, or not of one bench.

    ``fit`` fits some of them by themselves: so far may ``estimate`` be from each motor.
    """
    if len(captures) < 2:
        return
    for said in _motors(captures):
        each = _groups(captures) if said.code == "serials_differ" else []
        yield replace(said, moves=_moves(estimate, each, fit))
    yield from _benches(captures)


def _groups(captures: Sequence[Capture]) -> list[list[Capture]]:
    """Those of each serial number; what names none is of no motor in particular."""
    groups: dict[str, list[Capture]] = {}
    for capture in captures:
        groups.setdefault(_serial(capture), []).append(capture)
    return [group for name, group in groups.items() if name]


def _moves(
    estimate: Estimate,
    groups: Sequence[Sequence[Capture]],
    fit: Callable[[Sequence[Capture]], Estimate],
) -> dict[str, float]:
    """By how much each parameter differs from that of the motor that is farthest off."""
    moves: dict[str, float] = {}
    for group in groups:
        try:
            alone = fit(group).parameters
        except DataError:  # these runs of one motor tell too little by themselves
            return dict.fromkeys(estimate.parameters, math.inf)
        for name, p in estimate.parameters.items():
            own = alone[name].value if name in alone else None
            off = math.inf if own is None or p.value is None else abs(p.value - own)
            moves[name] = max(moves.get(name, 0.0), off)
    return moves


def _serial(capture: Capture) -> str:
    return str(capture.provenance.get("serial") or "").strip()


def _motors(captures: Sequence[Capture]) -> Iterator[Diagnostic]:
    said = [_serial(capture) for capture in captures]
    serials = list(dict.fromkeys(name for name in said if name))
    if len(serials) > 1:
        runs = "; ".join(f"{_runs(said, name)} of {name}" for name in serials)
        yield Diagnostic(
            "serials_differ", "error",
            f"these captures name {len(serials)} serial numbers ({runs}), and one fit is of one "
            "motor: fit those of each serial number by themselves",
        )  # fmt: skip
        return
    for name in sorted({n for c in captures for n in c.stated.nameplate}):
        values = [c.stated.nameplate.get(name) for c in captures]
        known = [v for v in values if v]
        if known and max(known) > (1.0 + PLATE_OFF) * min(known):
            yield Diagnostic(
                "nameplates_differ", "warning",
                f"these captures state nameplate.{name} as {min(known):g} and as {max(known):g}, "
                "and one fit is of one motor: fit those of each motor by themselves, or correct "
                "the rig and name it by --rig",
            )  # fmt: skip
            return


def _runs(said: Sequence[str], name: str) -> str:
    numbers = [str(k + 1) for k, one in enumerate(said) if one == name]
    return f"run{'s' if len(numbers) > 1 else ''} {', '.join(numbers)}"


def _benches(captures: Sequence[Capture]) -> Iterator[Diagnostic]:
    """Of captures that one board took. Several boards may well differ."""
    for (k, one), (m, other) in pairwise(enumerate(captures, 1)):
        if _board(one) != _board(other):
            continue
        differs = [*_geometry(one, other), *_gains(one, other)]
        if differs:
            yield Diagnostic(
                "benches_differ", "warning",
                f"runs {k} and {m} are of one board and differ in {'; '.join(differs)}: fit them "
                "by themselves, or name the rig that is right by --rig",
            )  # fmt: skip


def _board(capture: Capture) -> tuple[str, ...]:
    """What tells one board from another; an import has none."""
    known = capture.provenance
    identity = known.get("identity", {})
    name = identity.get("board", "") if isinstance(identity, dict) else ""
    return str(name), str(known.get("board_serial") or "")


def _geometry(one: Capture, other: Capture) -> Iterator[str]:
    for name in GEOMETRY:
        a, b = getattr(one.wiring, name), getattr(other.wiring, name)
        if a != b:
            yield f"wiring.{name} ({a:g} and {b:g})"


def _gains(one: Capture, other: Capture) -> Iterator[str]:
    """Scales of one board's channels; an import scales each file as its columns ask."""
    if "identity" not in one.provenance:
        return
    for name in (CURRENT, VOLTAGE, SUPPLY):
        a, b = one.get(name), other.get(name)
        if a is None or b is None or not a.scale or not b.scale:
            continue
        stated = math.hypot(a.gain_uncertainty, b.gain_uncertainty)
        ratio = abs(a.scale / b.scale)
        if abs(math.log(ratio)) > max(SURE * stated, LEAST_GAIN):
            yield f"the scale of the {name.replace('_', ' ')} (by {100 * abs(ratio - 1):.2g} %)"
