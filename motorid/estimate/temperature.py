"""R and K at 25 °C: how warm winding and magnets were in the runs that told R and K as run.

    R_25 = R / (1 + a (T − 25 °C)),    T = ambient + self-heating

The winding's energy is known, I²R over the captures; how much it warms the winding follows from the
data sheet's thermal figures, and lies between nothing and a bound where there are none. What is
unknown of either widens R_25 by a for each kelvin.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SUPPLY, VOLTAGE, Capture
from motorid.estimate.types import UNITS, Estimate, Parameter

if TYPE_CHECKING:
    from motorid.estimate.alternative import Alternative

Floats = NDArray[np.float64]

REFERENCE_C = 25.0
NORMAL_95 = 1.959963984540054
ROOM_C = (10.0, 35.0)  # where an ambient that nobody gave lies, evenly
STALL_K_S = 150.0  # no catalogue motor at hand heats up faster when stalled: the RE 65 by 95 K/s
SLOW_S = 600.0  # in which a winding without thermal figures has surely given off its heat
FIGURES = 0.2  # relative standard uncertainty of a rise: brushes and housing are left out
BLOCKS = 400  # of a capture, each of constant power
COLD = {"R": "R_25", "K": "K_25"}
THERMAL = "thermal"  # provenance: the table of a rig under which a capture is looked at again
AMBIENT, HEATING, COPPER, MAGNETS = (
    "ambient temperature", "self-heating", "copper coefficient", "magnets' coefficient",
)  # fmt: skip
BOUND = "bounded for want of thermal figures"
IMPROVE = {
    AMBIENT: "give the ambient and its uncertainty (rig file, or --ambient)",
    HEATING: "state the motor's thermal figures in the rig file's [thermal]",
    COPPER: "measure nearer to 25 °C",
    MAGNETS: "measure nearer to 25 °C",
}


@dataclass(frozen=True)
class Coefficients:
    """Relative change a kelvin, with standard uncertainties. ``magnet_per_k`` None: not stated."""

    copper_per_k: float = 0.00393
    copper_uncertainty_per_k: float = 5e-5
    magnet_per_k: float | None = None
    magnet_uncertainty_per_k: float = 0.0


@dataclass(frozen=True)
class Rise:
    """How much warmer than the ambient the winding was, in the mean of the runs by I².

    K, with its standard uncertainty; ``basis`` says what it rests on, ``heat_j`` the I²R of all.
    """

    kelvin: float
    uncertainty_k: float
    heat_j: float
    basis: str


@dataclass(frozen=True)
class Warmth:
    """Above 25 °C, in K: ``winding`` and ``magnets``, and what is unknown of each by cause."""

    winding: float
    magnets: float
    ambient_uncertainty: float
    rise_uncertainty: float


@dataclass(frozen=True)
class Body:
    """A winding: its heat capacity (J/K), the time in which it cools (s), and how it is known.

    ``doubt``: relative standard uncertainty of the capacity; None: it is the least that can be.
    """

    capacity_j_k: float
    cooling_s: float
    doubt: float | None
    basis: str


def with_reference(estimate: Estimate, captures: Sequence[Capture]) -> Estimate:
    """The estimate with R, and K where the magnets' coefficient is stated, at 25 °C.

    ``captures`` are those of the estimate. It stays as it is without a measured R, and for steady
    points without a time: how long the winding carried their currents is not known.
    """
    resistance = estimate.parameters["R"]
    timeless = any(capture.provenance.get("static") for capture in captures)
    if resistance.status != "estimated" or not resistance.value or timeless:
        return estimate
    stated = figures(captures[0])
    rise = self_heating(captures, resistance.value, stated, shown_by(estimate.alternative))
    if rise is None:
        return estimate
    coefficients = Coefficients(
        **{n: stated[n] for n in Coefficients.__dataclass_fields__ if n in stated}
    )
    warmth = warmth_of(estimate.inputs, rise)
    cold, shares = at_25(estimate.parameters, warmth, coefficients)
    note = words(estimate.inputs, rise)
    cold = {n: replace(p, note=_joined(note, shares[n])) for n, p in cold.items()}
    budget = dict(estimate.budget)
    for name, own in COLD.items():
        if own in cold:
            budget[own] = _scaled(estimate, name, cold[own]) | shares[own]
    return replace(
        estimate,
        at_25=cold,
        rise=rise,
        budget=budget,
        alternative=_beside(estimate.alternative, estimate.inputs, rise, coefficients),
    )


def _beside(
    better: Alternative | None,
    inputs: Sequence[Mapping[str, Any]],
    rise: Rise,
    coefficients: Coefficients,
) -> Alternative | None:
    """The better model's R at 25 °C; one that knows the heating has R as the first run began."""
    if better is None:
        return None
    if "heating" in better.terms:
        rise = replace(rise, kelvin=0.0, uncertainty_k=0.0)
    cold, _ = at_25(better.parameters, warmth_of(inputs, rise), coefficients)
    return replace(better, at_25=cold)


def figures(capture: Capture) -> dict[str, float]:
    """What is stated of a motor's temperature: the table [thermal] of the rig, and V of its plate.

    A rig under which a stored capture is looked at again stands before the one that took it.
    """
    known = capture.provenance
    try:
        text = known.get("rig", "")
        rig = tomllib.loads(text) if isinstance(text, str) else {}
    except tomllib.TOMLDecodeError:  # a rig in another notation states nothing that we can read
        rig = {}
    found = (rig.get("nameplate"), rig.get("thermal"), known.get(THERMAL))
    tables = [table for table in found if isinstance(table, Mapping)]
    return {
        name: float(value)
        for table in tables
        for name, value in table.items()
        if isinstance(value, int | float) and math.isfinite(value)
    }


def shown_by(better: Alternative | None) -> Body | None:
    """The winding as a better model finds it in the runs themselves, where it has heating."""
    capacity = better.parameters.get("C_w") if better is not None else None
    if better is None or capacity is None or not capacity.value:
        return None
    rate = better.parameters["k_w"]
    cooling = 1.0 / rate.value if rate.value else SLOW_S
    doubt = math.hypot((capacity.total or 0.0) / capacity.value, FIGURES)
    return Body(capacity.value, cooling, doubt, "as the runs themselves show it")


def self_heating(
    captures: Sequence[Capture],
    resistance_ohm: float,
    stated: Mapping[str, float],
    shown: Body | None = None,
) -> Rise | None:
    """What I²R has made of the winding's temperature; None where no current was measured.

    ``stated``: figures of the data sheet. Without them ``shown`` serves, and without that a bound.
    """
    volts = max([stated.get("voltage_v", 0.0), *map(_highest, captures)])
    body = by_figures(stated) or shown or _lightest(resistance_ohm, volts)
    warm, heat, above, ended = 0.0, 0.0, 0.0, -math.inf
    if body is None:
        return None
    for capture in sorted(captures, key=_began):
        current = capture.get(CURRENT)
        if current is None or len(capture) < 2:
            return None
        pause = max(_began(capture) - ended, 0.0) if math.isfinite(ended) else 0.0
        above *= math.exp(-pause / body.cooling_s)
        energy, seconds = _blocks(capture, current.values, resistance_ohm)
        for joule, step in zip(energy, seconds, strict=True):
            decay = math.exp(-step / body.cooling_s)
            after = above * decay + joule / body.capacity_j_k * (1.0 + decay) / 2.0
            warm += joule * (above + after) / 2.0
            above = after
        heat += sum(energy)
        ended = _began(capture) + sum(seconds)
    mean = warm / heat if heat > 0 else 0.0
    if body.doubt is not None:
        return Rise(mean, body.doubt * mean, heat, body.basis)
    return Rise(mean / 2.0, mean / math.sqrt(12.0), heat, body.basis)


def by_figures(stated: Mapping[str, float]) -> Body | None:
    """The winding of a motor's stated thermal figures; None where they do not tell it."""
    per_watt, seconds = stated.get("winding_k_w", 0.0), stated.get("winding_s", 0.0)
    if not (per_watt > 0 and seconds > 0):
        return None
    return Body(seconds / per_watt, seconds, FIGURES, "by the motor's thermal figures")


def _lightest(resistance_ohm: float, volts: float) -> Body | None:
    """The winding that the voltage heats up fastest when stalled."""
    if not volts > 0:
        return None
    return Body(volts**2 / resistance_ohm / STALL_K_S, SLOW_S, None, BOUND)


def _highest(capture: Capture) -> float:
    """V of the highest voltage that was surely there."""
    for name in (VOLTAGE, SUPPLY):
        channel = capture.get(name)
        if channel is not None and np.isfinite(channel.values).any():
            return float(np.nanpercentile(np.abs(channel.values), 95))
    levels = [abs(step.level) for step in capture.program.steps] if capture.program else []
    return max(levels, default=0.0)


def _blocks(
    capture: Capture, current: Floats, resistance_ohm: float
) -> tuple[list[float], list[float]]:
    """Energy (J) and length (s) of at most BLOCKS pieces of a capture; lost readings bring none."""
    steps = np.diff(capture.time_s)
    power = resistance_ohm * np.nan_to_num(current[1:]) ** 2
    edges = np.unique(np.linspace(0, len(steps), min(BLOCKS, len(steps)) + 1).astype(np.intp))[:-1]
    energy, seconds = np.add.reduceat(power * steps, edges), np.add.reduceat(steps, edges)
    return energy.tolist(), seconds.tolist()


def _began(capture: Capture) -> float:
    """When a capture was taken, in s; 0 where it does not say."""
    try:
        return datetime.fromisoformat(str(capture.provenance.get("created"))).timestamp()
    except ValueError:
        return 0.0


def ambient_of(inputs: Sequence[Mapping[str, Any]]) -> tuple[float, float, bool]:
    """Ambient of an estimate's inputs in °C, its standard uncertainty, and whether it was given."""
    given = [i for i in inputs if i.get("ambient_c") is not None]
    if not given or len(given) < len(inputs):
        return sum(ROOM_C) / 2, (ROOM_C[1] - ROOM_C[0]) / math.sqrt(12.0), False
    mean = sum(float(i["ambient_c"]) for i in given) / len(given)
    return mean, max(float(i.get("ambient_uncertainty_c") or 0.0) for i in given), True


def warmth_of(inputs: Sequence[Mapping[str, Any]], rise: Rise) -> Warmth:
    """Temperatures of the runs. Magnets are in the housing, which warms up far more slowly than a
    winding: they are taken at the ambient, with the winding's rise as what is unknown of them.
    """
    ambient, doubt, _ = ambient_of(inputs)
    above = ambient - REFERENCE_C
    return Warmth(above + rise.kelvin, above, doubt, rise.uncertainty_k)


def at_25(
    parameters: Mapping[str, Parameter], warmth: Warmth, coefficients: Coefficients
) -> tuple[dict[str, Parameter], dict[str, dict[str, float]]]:
    """R_25, and K_25 where the coefficient is stated; and what each cause adds to their u (SI)."""
    found, shares = {}, {}
    c = coefficients
    rows = [("R", COPPER, c.copper_per_k, c.copper_uncertainty_per_k, warmth.winding)]
    if c.magnet_per_k is not None:
        rows.append(("K", MAGNETS, c.magnet_per_k, c.magnet_uncertainty_per_k, warmth.magnets))
    for name, cause, per_k, doubt_per_k, above in rows:
        hot = parameters[name]
        if hot.status == "estimated" and hot.value:
            factor = 1.0 + per_k * above
            relative = {
                AMBIENT: abs(per_k / factor) * warmth.ambient_uncertainty,
                HEATING: abs(per_k / factor) * warmth.rise_uncertainty,
                cause: abs(above / factor) * doubt_per_k,
            }
            cold = _cold(hot, COLD[name], factor, math.hypot(*relative.values()))
            found[COLD[name]] = cold
            shares[COLD[name]] = {k: u * float(cold.value or 0.0) for k, u in relative.items()}
    return found, shares


def _cold(hot: Parameter, name: str, factor: float, doubt: float) -> Parameter:
    """``hot`` divided by ``factor``, which is known to ``doubt`` (relative, standard).

    Half-widths of both parts add in squares on the logarithmic scale; the second has no degrees of
    freedom to lose.
    """
    assert hot.value is not None
    assert hot.interval_95 is not None
    value = hot.value / factor
    reach = math.hypot(math.log(hot.interval_95[1] / hot.value), NORMAL_95 * doubt)
    instrument = math.hypot((hot.instrument or 0.0) / factor, doubt * value)
    return Parameter(
        name, UNITS[hot.name], value, (hot.statistical or 0.0) / factor, instrument,
        math.hypot((hot.total or 0.0) / factor, doubt * value),
        (value * math.exp(-reach), value * math.exp(reach)), "estimated",
    )  # fmt: skip


def words(inputs: Sequence[Mapping[str, Any]], rise: Rise) -> str:
    """What the temperature of the runs rests on."""
    ambient, doubt, given = ambient_of(inputs)
    low, high = ROOM_C
    room = f"{ambient:.3g} °C ± {1.96 * doubt:.2g} K" if doubt else f"{ambient:.3g} °C, as exact"
    said = room if given else f"not given, so anything from {low:.0f} to {high:.0f} °C"
    warm = f"{rise.kelvin:.2g} ± {1.96 * rise.uncertainty_k:.2g} K"
    if rise.basis == BOUND:
        warm = f"none to {2.0 * rise.kelvin:.2g} K"
    return f"ambient {said}; self-heating {warm}, {rise.basis}, from {rise.heat_j:.3g} J"


def _joined(note: str, shares: Mapping[str, float]) -> str:
    """``note``, and what to do about the largest of its own causes."""
    most = max(shares, key=lambda cause: shares[cause])
    return f"{note}; to narrow it, {IMPROVE[most]}" if shares[most] > 0 else note


def _scaled(estimate: Estimate, name: str, cold: Parameter) -> dict[str, float]:
    """The causes of a parameter as run, at 25 °C."""
    hot = estimate.parameters[name].value or 1.0
    factor = (cold.value or 0.0) / hot
    return {cause: u * factor for cause, u in estimate.budget.get(name, {}).items()}
