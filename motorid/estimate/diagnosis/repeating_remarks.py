"""What the fit allowed for that repeats with the rotor's angle: how often a turn, and how large."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motorid.estimate.effects.influence_quantity import InfluenceQuantity
from motorid.estimate.effects.rotor.repeating import of_order, order
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import Diagnostic, Repeats
from motorid.estimate.solver.problem import Solution

SEEN = 3.0  # standard deviations of an amplitude: less is not worth its name
PERCENT = {"1": (100.0, "%")}  # of a relative size


def allowed_for(records: Sequence[MotorRecord], solution: Solution) -> list[Diagnostic]:
    """One remark for all runs; none where nothing repeats."""
    found = repeating(records, solution)
    orders = sorted({one.per_turn for one in found})
    said = [
        f"{n} a turn ({', '.join(_said([one for one in found if one.per_turn == n]))})"
        for n in orders
    ]
    if not said:
        return []
    return [
        Diagnostic(
            "repeats_with_angle", "info",
            "the readings repeat with the rotor's angle, as of every brushed motor; the fit allows "
            f"for it: {'; '.join(said)}",
        )
    ]  # fmt: skip


def _said(found: Sequence[Repeats]) -> list[str]:
    """Amplitudes that stand out of their noise."""
    said = []
    for one in found:
        if one.amplitude > SEEN * one.uncertainty:
            factor, unit = PERCENT.get(one.unit, (1.0, one.unit))
            said.append(f"{one.quantity} {factor * one.amplitude:.2g} {unit}")
    return said or ["each size within its noise"]


def repeating(records: Sequence[MotorRecord], solution: Solution) -> tuple[Repeats, ...]:
    """Every quantity of every order that is among the unknowns, by order and name."""
    found: dict[tuple[int, InfluenceQuantity], list[tuple[float, float]]] = {}
    for k, record in enumerate(records):
        places = {one: j for j, one in enumerate(record.instances)}
        for periods, quantity in {(order(one), one.quantity) for one in record.repeating.slopes}:
            pair = [places[one] for one in of_order(quantity, periods) if one in places]
            if pair:
                square = float((solution.own[k][pair] ** 2).sum())
                noise = float(solution.own_covariance[k][pair, pair].mean())
                found.setdefault((periods, quantity), []).append((square, noise))
    said = []
    for (periods, quantity), runs in sorted(found.items(), key=lambda f: (f[0][0], f[0][1].name)):
        amplitude, u = np.sqrt(np.mean(runs, axis=0)).tolist()
        said.append(Repeats(quantity.name, periods, amplitude, u, quantity.unit))
    return tuple(said)
