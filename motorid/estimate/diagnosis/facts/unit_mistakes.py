"""Figures that go together in no motor, and the unit that would make a usual motor of them.

A wrong scale leaves no residual (``faults/scale_errors.py`` has the laws). Without a nameplate the
catalogue stands in: a factor of 1000, or rpm for rad/s, puts a motor far from all others.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture
from motorid.capture.units import TIME, alike, unit_of
from motorid.errors import UsageError
from motorid.estimate.diagnosis.facts.catalogue import Figures, distance, ranges
from motorid.estimate.diagnosis.faults.scale_errors import (
    AMPERES,
    TIME_OF_POSITION,
    TIME_OF_SPEED,
    VOLTS,
)
from motorid.estimate.diagnosis.faults.scale_errors import SPEED as SPEED_SCALE
from motorid.estimate.results.estimate import PARAMETERS, Diagnostic, Parameter
from motorid.program import StepKind

UNUSUAL = 9.0  # distance from the catalogue, above which an explanation is looked for
# the same among all motors, above which it is more than a remark: small ones of few volts and many
# amperes lie at up to 15
FOREIGN = 16.0
EXPLAINS = 6.0  # by which it must bring the motor nearer
USUAL = 8.0  # and how near at least
AS_WELL = 2.0  # another explanation, within so much of the best, is said too
NO_MOTOR = 45.0  # distance that is remarked on without an explanation
MISCOUNTED = (4.0, 10.0, 100.0, 0.01)  # lines for counts, a gear on the wrong side
NONE: Mapping[str, Parameter] = {}
ONE_ROW = 1e-6  # of a unit of time, by which a step of a row number may miss one
PERIODS = np.arange(0.5, 7.0, 0.5)  # of a logger, as powers of ten below a unit of time
HIGH = 99.0  # percentile of a log's voltages that counts as the highest
SI = {TIME: "s", CURRENT: "A", VOLTAGE: "V", SPEED: "rad/s", POSITION: "rad"}
# in proportion to a stretched clock, whatever the motion
BY_TIME = ("L", "L/R", "J/K²", "J R/K²", "JR/(K²+RB)")


@dataclass(frozen=True)
class Mistake:
    """A scale that may be wrong: readings of ``quantity`` are ``factor`` times what is true."""

    quantity: str
    factor: float
    instead: str  # what would be so, as a clause
    mend: str
    distance: float = np.inf


def findings(
    captures: Sequence[Capture],
    parameters: Mapping[str, Parameter],
    combinations: Mapping[str, Parameter] = NONE,
) -> Iterator[Diagnostic]:
    """A motor that no catalogue has anything like, and the unit that explains it.

    Where R, K and J are not all known, each figure and ratio by itself.
    """
    motor = figures(captures, parameters)
    if motor is None:
        yield from _by_themselves(captures[0], {**parameters, **combinations})
        return
    found = distance(motor)
    if found <= UNUSUAL:
        return
    mistakes = explanations(captures[0], motor, found)
    shown = f"R {motor.R:.3g} ohm, K {motor.K:.3g} N·m/A and J {motor.J:.3g} kg·m²"
    foreign = distance(motor, wide=True) > FOREIGN
    which = "no motor of the catalogues has" if foreign else "few motors have"
    where = f"{which} {shown} together, at up to {motor.top_v:.3g} V"
    if mistakes:
        instead = " or ".join(one.instead for one in mistakes)
        mends = " or ".join(dict.fromkeys(one.mend for one in mistakes))
        gear = " or if a gear is not stated," if _slower(mistakes[0]) else ""
        yield Diagnostic(
            "unit_mistake", "warning" if foreign else "info",
            f"{where}; they would be usual if {instead},{gear} so compare a reading with "
            f"an instrument, and {mends}",
            _moves(captures[0], parameters, mistakes[0]) if foreign else {},
        )  # fmt: skip
    elif foreign and found > NO_MOTOR:
        yield Diagnostic(
            "no_such_motor", "warning",
            f"{where}, and no single unit explains it: check the units, the counts per turn, the "
            "gear ratio and the gains of each channel",
        )  # fmt: skip


def _by_themselves(capture: Capture, known: Mapping[str, Parameter]) -> Iterator[Diagnostic]:
    """The first figure, or ratio, that lies beyond those of all motors."""
    measured = {n: p.value for n, p in known.items() if p.status.measured}
    values = {n: v for n, v in measured.items() if v is not None and v > 0}
    for ratio in ("JR/(K²+RB)", "J R/K²"):
        if ratio in values:
            values["JR/K²"] = values[ratio]
    if {"R", "J/K²"} <= values.keys():
        values["JR/K²"] = values["R"] * values["J/K²"]
    if {"R", "L"} <= values.keys():
        values["L/R"] = values["L"] / values["R"]
    for name, (low, high) in ranges().items():
        value = values.get(name)
        if value is None or low <= value <= high:
            continue
        unit = "s" if "/" in name else known[name].unit
        most = f"to {high:.2g} {unit}" if np.isfinite(high) else f"{unit} or more"
        clocks = [
            one
            for one in _possible(capture)
            if one.quantity == TIME and "/" in name and low <= value / one.factor <= high
        ]
        hint = "of the gains and of the gear"
        # whichever channel it is, others of them come from it too
        moves = {n: np.inf for n in PARAMETERS if n in values} if name in known else {}
        if clocks:
            hint = f"perhaps {clocks[0].instead.replace(' were ', ' is ')}"
            factor = clocks[0].factor
            timed = [n for n in BY_TIME if n in known and n in values]
            moves = {n: abs(values[n] * (1.0 - 1.0 / factor)) for n in timed}
        yield Diagnostic(
            "unit_mistake", "warning",
            f"{name} is {value:.3g} {unit}, and motors have {low:.2g} {most}: check the units "
            f"of each channel and of the time, {hint}",
            moves,
        )  # fmt: skip
        return


def _moves(
    capture: Capture, parameters: Mapping[str, Parameter], mistake: Mistake
) -> dict[str, float]:
    """How far each parameter lies from what it would be."""
    powers = _powers(capture, mistake.quantity)
    true = {n: p.value / mistake.factor ** powers.get(n, 0.0)
            for n, p in parameters.items() if p.value is not None}  # fmt: skip
    return {n: abs(v - (parameters[n].value or 0.0)) for n, v in true.items() if n in powers}


def _slower(mistake: Mistake) -> bool:
    """A gear between motor and sensor would look the same."""
    return mistake.quantity in (SPEED, POSITION) and mistake.factor < 1.0


def figures(captures: Sequence[Capture], parameters: Mapping[str, Parameter]) -> Figures | None:
    """The motor as it was fitted; None where R, K or J, or the voltage, is not known."""
    values = {n: p.value for n, p in parameters.items() if p.value is not None and p.value > 0}
    top = max(highest_v(capture) for capture in captures)
    if not {"R", "K", "J"} <= values.keys() or not top > 0:
        return None
    L = values.get("L") if parameters["L"].status == "estimated" else None
    return Figures(top, values["R"], values["K"], values["J"], L)


def highest_v(capture: Capture) -> float:
    """V, the highest that drove the motor, measured or commanded; 0: unknown."""
    channel = capture.get(VOLTAGE)
    if channel is not None and np.isfinite(channel.values).any():
        return float(np.nanpercentile(np.abs(channel.values), HIGH))
    supply = capture.supply_v or 0.0
    steps = capture.program.steps if capture.program is not None else ()
    volts = [abs(s.level) * (1.0 if s.kind == StepKind.DRIVE_VOLTS else supply) for s in steps]
    return max(volts, default=0.0)


def explanations(capture: Capture, motor: Figures, found: float) -> list[Mistake]:
    """The mistakes that make a usual motor of it, the best first; one of each quantity.

    A motor that is usual only among all motors is explained among all.
    """
    usual = _explaining(capture, motor, found, wide=False)
    return usual or _explaining(capture, motor, distance(motor, wide=True), wide=True)


def _explaining(capture: Capture, motor: Figures, found: float, wide: bool) -> list[Mistake]:
    """As ``explanations``, by the distance from all motors, or from the usual ones."""
    tried = [
        replace(
            one,
            distance=distance(motor.scaled(_powers(capture, one.quantity), one.factor), wide),
        )
        for one in _possible(capture)
    ]
    tried = sorted(tried, key=lambda one: one.distance)
    if not tried or found - tried[0].distance < EXPLAINS or tried[0].distance > USUAL:
        return []
    near = [one for one in tried if one.distance - tried[0].distance < AS_WELL]
    near.sort(key=lambda one: abs(np.log(one.factor)))  # the nearest unit that does as well
    best = {one.quantity: one for one in reversed(near)}
    return sorted(best.values(), key=lambda one: one.distance)


def _possible(capture: Capture) -> Iterator[Mistake]:
    """Each other unit that a column of a log may have been in; of a board, its encoder's counts."""
    return _counts(capture) if "identity" in capture.provenance else _units(capture)


def _counts(capture: Capture) -> Iterator[Mistake]:
    stated, gear = capture.wiring.counts_per_turn, capture.wiring.gear_ratio
    for factor in MISCOUNTED if stated and capture.get(POSITION) is not None else ():
        yield Mistake(
            POSITION, factor,
            f"wiring.counts_per_turn were about {factor * stated:g}, not {stated:g}, or "
            f"wiring.gear_ratio {gear / factor:g}, not {gear:g}",
            "turn the shaft once by hand and count, then fit again with the corrected --rig",
        )  # fmt: skip


def _units(capture: Capture) -> Iterator[Mistake]:
    maps = dict(_maps(capture))
    for quantity, si in SI.items():
        if quantity != TIME and capture.get(quantity) is None:
            continue
        expression, written = maps.get(quantity, ("", si))
        try:
            unit = unit_of(quantity, written, capture.wiring.counts_per_turn)
        except UsageError:
            continue
        name = quantity.replace("terminal_", "")
        for other, scale in alike(quantity, unit.si).items():
            if scale != unit.scale and not unit.counts:
                instead = f"the {name} were in {other}, not {written}"
                mend = f"import again with --map {name}={expression}:{other}" if expression else (
                    f"give the {name} in {si}")  # fmt: skip
                yield Mistake(quantity, unit.scale / scale, instead, mend)
        if quantity == TIME and _counts_rows(capture, unit.scale):
            for power in PERIODS:
                instead = "the time column, which counts the rows, were a clock's"
                mend = "import again with --map time=row*PERIOD:s, the logger's period in seconds"
                yield Mistake(TIME, 10.0**power, instead, mend)


def _counts_rows(capture: Capture, unit_s: float) -> bool:
    """Whether each row's stamp is one more than that of the row before."""
    steps = np.diff(capture.time_s)
    return bool(len(steps)) and bool(np.all(np.abs(steps - unit_s) < ONE_ROW * unit_s))


def _maps(capture: Capture) -> Iterator[tuple[str, tuple[str, str]]]:
    """Expression and unit of each map of an import, by quantity."""
    for text in capture.provenance.get("maps", ()):
        left, _, right = str(text).partition("=")
        expression, _, unit = right.rpartition(":")
        name = {"voltage": VOLTAGE}.get(left.strip(), left.strip())
        yield name, (expression.strip(), unit.strip())


def _powers(capture: Capture, quantity: str) -> dict[str, float]:
    """How a wrong scale of a quantity moves each figure, by its power."""
    if quantity == TIME:
        cause = TIME_OF_SPEED if capture.get(POSITION) is None else TIME_OF_POSITION
    else:
        cause = {CURRENT: AMPERES, VOLTAGE: VOLTS}.get(quantity, SPEED_SCALE)
    return {name: float(power) for name, power in cause.powers.items()}
