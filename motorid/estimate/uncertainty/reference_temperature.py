"""R and K at 25 °C: how warm winding and magnets were in the runs that told R and K as run.

    R_25 = R / (1 + a (T − 25 °C)),    T = ambient + self-heating

How warm I²R made the winding is winding.py's. What is unknown of that, or of the ambient, widens
R_25 by a for each kelvin. A stated ambient may be wrong by more, and no reading shows it: what 10 K
would do is said of every such estimate.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from motorid.capture.model import Capture
from motorid.estimate.effects.reference.temperature import (
    AMBIENT_TEMPERATURE,
    COPPER_COEFFICIENT,
    MAGNET_COEFFICIENT,
    SELF_HEATING,
)
from motorid.estimate.effects.registry import BY_NAME
from motorid.estimate.effects.winding_temperature import (
    BOUND,
    Coefficients,
    figures,
    self_heating,
    shown_by,
)
from motorid.estimate.results.estimate import (
    UNITS,
    Alternative,
    Estimate,
    Parameter,
    Rise,
    Suspect,
)

REFERENCE_C = 25.0
NORMAL_95 = 1.959963984540054
ROOM_C = (10.0, 35.0)  # where an ambient that nobody gave lies, evenly
COLD = {"R": "R_25", "K": "K_25"}
WARMER_K = 10.0  # than the ambient that was stated: what that would do is said
WRONG_ROOM = "ambient_temperature"


@dataclass(frozen=True)
class Warmth:
    """Above 25 °C, in K: ``winding`` and ``magnets``, and what is unknown of each by cause."""

    winding: float
    magnets: float
    ambient_uncertainty: float
    rise_uncertainty: float


def with_reference(estimate: Estimate, captures: Sequence[Capture]) -> Estimate:
    """The estimate with R, and K where the magnets' coefficient is stated, at 25 °C.

    ``captures`` are those of the estimate. It stays as it is without a measured R, and for steady
    points without a time: how long the winding carried their currents is not known.
    """
    resistance = estimate.parameters["R"]
    timeless = any(capture.provenance.get("static") for capture in captures)
    if not resistance.status.measured or not resistance.value or timeless:
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
    doubts = {own: estimate.parameters[name].note for name, own in COLD.items()}
    cold = {
        n: replace(p, note="; ".join(filter(None, (doubts[n], _joined(note, shares[n])))))
        for n, p in cold.items()
    }
    budget = dict(estimate.budget)
    for name, own in COLD.items():
        if own in cold:
            budget[own] = _scaled(estimate, name, cold[own]) | shares[own]
    return replace(
        estimate,
        at_25=cold,
        rise=rise,
        budget=budget,
        suspects=(*estimate.suspects, _wrong_room(estimate, warmth, coefficients)),
        alternative=_beside(estimate.alternative, estimate.inputs, rise, coefficients),
    )


def _wrong_room(estimate: Estimate, warmth: Warmth, coefficients: Coefficients) -> Suspect:
    """What no reading shows: an ambient that was not what somebody stated."""
    ambient, _, given = ambient_of(estimate.inputs)
    warmer = replace(warmth, winding=warmth.winding + WARMER_K, magnets=warmth.magnets + WARMER_K)
    stated, _ = at_25(estimate.parameters, warmth, coefficients)
    moved, _ = at_25(estimate.parameters, warmer, coefficients)
    said = [
        f"{name} by {100.0 * (float(moved[name].value or 0.0) / p.value - 1.0):+.2g} %"
        for name, p in stated.items()
        if p.value
    ]
    taken = "stated" if given else "taken for want of a stated one"
    return Suspect(
        WRONG_ROOM, "ambient temperature",
        "these data cannot reveal a wrong ambient temperature: a room that was "
        f"{WARMER_K:.0f} K warmer than the {ambient:.3g} °C {taken} would change {', '.join(said)}",
        "measure the temperature beside the motor, before the run", "not excluded",
    )  # fmt: skip


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
    rows = [
        ("R", COPPER_COEFFICIENT.name, c.copper_per_k, c.copper_uncertainty_per_k, warmth.winding)
    ]
    if c.magnet_per_k is not None:
        rows.append(
            (
                "K",
                MAGNET_COEFFICIENT.name,
                c.magnet_per_k,
                c.magnet_uncertainty_per_k,
                warmth.magnets,
            )
        )
    for name, cause, per_k, doubt_per_k, above in rows:
        hot = parameters[name]
        if hot.status.measured and hot.value:
            factor = 1.0 + per_k * above
            relative = {
                AMBIENT_TEMPERATURE.name: abs(per_k / factor) * warmth.ambient_uncertainty,
                SELF_HEATING.name: abs(per_k / factor) * warmth.rise_uncertainty,
                cause: abs(above / factor) * doubt_per_k,
            }
            cold = _cold(hot, COLD[name], factor, math.hypot(*relative.values()))
            found[COLD[name]] = cold
            shares[COLD[name]] = {k: u * float(cold.value or 0.0) for k, u in relative.items()}
    return found, shares


def _cold(hot: Parameter, name: str, factor: float, doubt: float) -> Parameter:
    """``hot`` divided by ``factor``, which is known to ``doubt`` (relative, standard).

    Half-widths of both parts add in squares on the logarithmic scale, on either side by itself: a
    finding may widen one alone. The second part has no degrees of freedom to lose.
    """
    assert hot.value is not None
    assert hot.interval_95 is not None
    value = hot.value / factor
    low, high = (math.log(end / hot.value) if end > 0.0 else -math.inf for end in hot.interval_95)
    below, above = (math.hypot(side, NORMAL_95 * doubt) for side in (low, high))
    instrument = math.hypot((hot.instrument or 0.0) / factor, doubt * value)
    return Parameter(
        name, UNITS[hot.name], value, (hot.statistical or 0.0) / factor, instrument,
        math.hypot((hot.total or 0.0) / factor, doubt * value),
        (value * math.exp(-below), value * math.exp(above)), hot.status,
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
    return f"{note}; to narrow it, {BY_NAME[most].remedy}" if shares[most] > 0 else note


def _scaled(estimate: Estimate, name: str, cold: Parameter) -> dict[str, float]:
    """The causes of a parameter as run, at 25 °C."""
    hot = estimate.parameters[name].value or 1.0
    factor = (cold.value or 0.0) / hot
    return {cause: u * factor for cause, u in estimate.budget.get(name, {}).items()}
