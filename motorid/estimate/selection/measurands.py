"""K and L at stated currents and frequencies, where iron makes them differ.

    K_rated, L_rated    at nameplate.rated_current_a and low frequency; L incremental
    L_1kHz, L_pwm       at no current, as an inductance meter shows it: Im Z/ω

``K`` and ``L`` of the model are those at no current and low frequency.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from motorid.estimate.results.estimate import Parameter
from motorid.estimate.selection.extended_fit import Fitted
from motorid.estimate.uncertainty import intervals
from motorid.estimate.uncertainty.intervals import Findings

Values = Mapping[str, float]

IRON = ("armature-reaction", "saturation", "eddy")
METER_HZ = 1000.0  # of the usual inductance meter
STEP = 1e-5  # of a derivative, in units of the parameters' search
NO_CURRENT = "give nameplate.rated_current_a in the rig file"
NO_PWM = "the captures state no PWM frequency"


def torque_constant(values: Values, amperes: float) -> float:
    """K (N·m/A) at a current."""
    bend = values.get("i_K", 0.0)
    return values["K"] * (1.0 - values.get("a_K", 0.0) * (math.hypot(amperes, bend) - bend))


def inductance(values: Values, amperes: float = 0.0, frequency_hz: float = 0.0) -> float:
    """Incremental L (H) at a current, seen at a frequency."""
    turns = (2.0 * math.pi * frequency_hz * values.get("t_e", 0.0)) ** 2
    shielded = values.get("L2_share", 0.0) * turns / (1.0 + turns)
    knee = values.get("i_L", 1.0)
    lost = values.get("d_L", 0.0) * amperes**2 / (amperes**2 + knee**2)
    return values["L"] * (1.0 - shielded) * (1.0 - lost)


def stated(found: Findings, fitted: Fitted) -> dict[str, Parameter]:
    """Each with its uncertainty; none where the model has no iron."""
    if not {term.name for term in fitted.terms} & set(IRON):
        return {}
    capture = fitted.records[0].capture
    rated, pwm = capture.stated.nameplate.get("rated_current_a"), capture.wiring.pwm_hz
    return {
        "K_rated": _at(found, fitted, "K_rated", "N·m/A", rated, torque_constant, NO_CURRENT),
        "L_rated": _at(found, fitted, "L_rated", "H", rated, inductance, NO_CURRENT),
        "L_1kHz": _at(found, fitted, "L_1kHz", "H", METER_HZ, _metered, ""),
        "L_pwm": _at(found, fitted, "L_pwm", "H", pwm or None, _metered, NO_PWM),
    }


def _metered(values: Values, frequency_hz: float) -> float:
    return inductance(values, 0.0, frequency_hz)


def _at(
    found: Findings,
    fitted: Fitted,
    name: str,
    unit: str,
    where: float | None,
    of: Callable[[Values, float], float],
    lacking: str,
) -> Parameter:
    if where is None:
        return intervals.unknown(name, unit, lacking)

    def value(search: np.ndarray) -> float:
        pairs = zip(found.solution.unknowns, search, strict=True)
        moved = {u.name: float(np.exp(x)) if u.log else float(x) for u, x in pairs}
        return of({**fitted.values, **moved}, where)

    at = found.search
    best, gradient = value(at), np.empty(len(at))
    for k, one in enumerate(found.solution.unknowns):
        step = np.zeros(len(at))
        step[k] = STEP if one.log else STEP * one.scale
        gradient[k] = (value(at + step) - best) / step[k]
    deviation, known, freedom = found.propagate(gradient)
    total = float(np.hypot(deviation, known))
    if not (best > 0.0 and total <= intervals.UNKNOWN * best):
        return intervals.unknown(name, unit, "these data do not determine it")
    return intervals.of_ratio(name, unit, best, deviation, known, freedom)
