"""What the fit allowed for that repeats with the rotor's angle: how often a turn, and how large."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motorid.estimate.effects.rotor.repeating import of_order, order
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import Diagnostic
from motorid.estimate.solver.problem import Solution

SEEN = 3.0  # standard deviations of an amplitude: less is not worth its name
PERCENT = {"1": (100.0, "%")}  # of a relative size


def allowed_for(records: Sequence[MotorRecord], solution: Solution) -> list[Diagnostic]:
    """One remark for all runs; none where nothing repeats."""
    said = [f"{n} a turn ({', '.join(_sizes(records, solution, n))})" for n in _orders(records)]
    if not said:
        return []
    return [
        Diagnostic(
            "repeats_with_angle", "info",
            "the readings repeat with the rotor's angle, as of every brushed motor; the fit allows "
            f"for it: {'; '.join(said)}",
        )
    ]  # fmt: skip


def _orders(records: Sequence[MotorRecord]) -> list[int]:
    return sorted({order(one) for record in records for one in record.repeating.slopes})


def _sizes(records: Sequence[MotorRecord], solution: Solution, periods: int) -> list[str]:
    """Amplitudes that stand out of their noise, root mean square over the runs."""
    found: dict[str, list[tuple[float, float]]] = {}
    units = {}
    for k, record in enumerate(records):
        places = {one: j for j, one in enumerate(record.instances)}
        for quantity in {one.quantity for one in record.repeating.slopes}:
            pair = [places[one] for one in of_order(quantity, periods) if one in places]
            if pair:
                square = float((solution.own[k][pair] ** 2).sum())
                noise = float(solution.own_covariance[k][pair, pair].mean())
                found.setdefault(quantity.name, []).append((square, noise))
                units[quantity.name] = quantity.unit
    said = []
    for name in sorted(found):
        square, noise = np.mean(found[name], axis=0)
        if square > SEEN**2 * noise:
            factor, unit = PERCENT.get(units[name], (1.0, units[name]))
            said.append(f"{name} {factor * np.sqrt(square):.2g} {unit}")
    return said or ["each size within its noise"]
