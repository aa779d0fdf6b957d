"""How much warmer than the ambient I²R made the winding of a motor, over the captures of it.

Its energy is known; how much that warms the winding follows from the data sheet's thermal figures,
and lies between nothing and a bound where there are none.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SUPPLY, VOLTAGE, Capture
from motorid.estimate.results.estimate import Alternative, Rise

Floats = NDArray[np.float64]

STALL_K_S = 150.0  # no catalogue motor at hand heats up faster when stalled: the RE 65 by 95 K/s
SLOW_S = 600.0  # in which a winding without thermal figures has surely given off its heat
FIGURES = 0.2  # relative standard uncertainty of a rise: brushes and housing are left out
BLOCKS = 400  # of a capture, each of constant power
BOUND = "bounded for want of thermal figures"


@dataclass(frozen=True)
class Coefficients:
    """Relative change a kelvin, with standard uncertainties. ``magnet_per_k`` None: not stated."""

    copper_per_k: float = 0.00393
    copper_uncertainty_per_k: float = 5e-5
    magnet_per_k: float | None = None
    magnet_uncertainty_per_k: float = 0.0


@dataclass(frozen=True)
class Body:
    """A winding: its heat capacity (J/K), the time in which it cools (s), and how it is known.

    ``doubt``: relative standard uncertainty of the capacity; None: it is the least that can be.
    """

    capacity_j_k: float
    cooling_s: float
    doubt: float | None
    basis: str


def figures(capture: Capture) -> dict[str, float]:
    """What is stated of a motor's temperature: [thermal] of its rig, and V of its plate."""
    return {**capture.stated.nameplate, **capture.stated.thermal}


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
