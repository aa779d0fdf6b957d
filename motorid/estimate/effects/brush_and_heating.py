"""What takes voltage from the motor beyond R i: brushes that drop some, and a winding that warms.

No rig file names them, but every motor has them, so that each capture has them as unknowns:

    lost(t) = V s + W ds/d ln b + w R i (q/q_end − 1/2),    s = i / sqrt(i² + b²),  q = ∫i² dt

V is the drop over both brushes, which hardly grows with the current; W, how it departs from the
usual bend b; w, by how much of itself R grows over the capture, about its mean. Taken for a
resistance, V makes R too large and K with it; w bends speeds, and with them B and T0. The current
is the model's of the pass before; s is its mean over a PWM period. A rig may declare brushes that
drop nothing (wiring.brush_drop_v) and the winding's thermal figures. Where the voltage is read
before a bipolar bridge, that bridge's own drop is lost as well, by the same s.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, VOLTAGE, Capture, Wiring
from motorid.estimate.effects.action import SourceVoltage
from motorid.estimate.effects.winding_temperature import (
    FIGURES,
    STALL_K_S,
    Coefficients,
    by_figures,
    figures,
)
from motorid.estimate.signals.source.ripple_average import Flow
from motorid.estimate.signals.time_grid import Part, Timeline

Floats = NDArray[np.float64]

DROP, BENT, WARMING = "brush drop", "brush bend", "winding warming"  # V, W, w
BRIDGE = "bridge drop"  # of bipolar switches, where the voltage is a source's
TURN, DIODES = "dead-time turn", "dead-time diodes"  # where a source is commanded
DROP_SHARE = 0.03  # of the brushes' voltage: standard deviation of a drop nobody declares
SAME_BEND = (DROP, BRIDGE)  # whose sum bends at one current
DECLARED = 0.3  # of a declared drop: its standard uncertainty where none is given
FACTOR = 0.7  # logarithm: the bend is known to a factor of 2
BEND = 0.05  # of the stall current at the brushes' voltage: the usual bend
CLEAR = 3e-3  # of the highest voltage: a drop that tells its bend
NOTHING = 1e-3  # of it: one that does not, wherever earlier passes have moved the bend
FARTHEST = 1.4  # logarithm of a bend over the usual one: two of its deviations
CAUTIOUS = 0.1  # of a bend's step as asked for: the least that is made
COOL = 1e-6  # of R: no warming is known better
HEAVIEST = 1e9  # J/K: a winding that never warms
FEWEST = 24  # readings of a driven current
HEAVY = {"winding_k_w": 1e-12, "winding_s": 1.0}  # thermal figures of a winding that never warms


def lossless(capture: Capture) -> Capture:
    """The capture as of a motor whose brushes drop nothing and whose winding stays as it is.

    For models that have these among their own parameters.
    """
    keys = (
        "brush_drop_v",
        "brush_drop_uncertainty_v",
        "bridge_drop_v",
        "bridge_drop_uncertainty_v",
    )
    none = replace(capture.wiring, **dict.fromkeys(keys, 0.0))
    heavy = replace(capture.stated, thermal={**capture.stated.thermal, **HEAVY})
    return replace(capture, wiring=none, stated=heavy)


def undropped(capture: Capture) -> Capture:
    """The capture as of a motor whose brushes drop nothing."""
    none = replace(capture.wiring, brush_drop_v=0.0, brush_drop_uncertainty_v=0.0)
    return replace(capture, wiring=none)


def brushes_made_for(capture: Capture, top_v: float) -> float:
    """V that brushes are chosen by: the nameplate's, or the highest of a run above it.

    In a run at low levels alone all currents lie below the bend, where a drop is a resistance.
    """
    return max(top_v, capture.stated.nameplate.get("voltage_v", 0.0))


def expected_drop(wiring: Wiring, brushes_v: float) -> tuple[float, float]:
    """The drop over both brushes (V) and its standard uncertainty; both 0: declared to be none."""
    drop, doubt = wiring.brush_drop_v, wiring.brush_drop_uncertainty_v
    if drop is None:
        drop, doubt = 0.0, DROP_SHARE * brushes_v
    return drop, doubt or DECLARED * drop


def bridge_drop(wiring: Wiring) -> tuple[float, float]:
    """The drop over a bridge's bipolar switches (V) and its standard uncertainty; both 0: none."""
    drop = wiring.bridge_drop_v
    return drop, (wiring.bridge_drop_uncertainty_v or DECLARED * drop) if drop else 0.0


def turn_of(part: int) -> str:
    """The unknown of a part of the program."""
    return f"{TURN} {part}"


def taken(unknown: str) -> SourceVoltage:
    """What a unit of an unknown takes from the source, by the loss of the capture."""
    return SourceVoltage(lambda subject, place: subject.loss.shapes[unknown], taken=True)


@dataclass(frozen=True)
class Bent:
    """How the last pass moved the logarithm of the bend: as ``asked`` for there, and by how much.

    A drop is no straight line in it, so that a step as asked for may go too far, and the next one
    back again, for ever.
    """

    asked: float = 0.0
    by: float = 0.0

    def step(self, asked: float) -> float:
        """The next one, by how the last one changed what is asked for."""
        changed = self.asked - asked
        share = self.by / changed if self.by and changed else 1.0
        share = min(max(share, CAUTIOUS), 1.0) if share > 0.0 else 1.0
        return min(max(share * asked, -1.0), 1.0)


@dataclass(frozen=True)
class Loss:
    """What one capture loses: ``shapes`` (count,) are the volts a unit of each unknown takes.

    ``top_v`` is its highest voltage, ``brushes_v`` the one that its brushes are made for.
    ``capacity_j_k`` is the winding's heat capacity, None where nobody stated its figures.
    """

    driven: NDArray[np.bool_]
    period_s: float
    top_v: float
    brushes_v: float
    drop: tuple[float, float]
    capacity_j_k: float | None
    bridge: tuple[float, float] = (0.0, 0.0)  # what its switches drop, and the deviation
    further: float = 0.0  # logarithm of the bend over the usual one
    bent: Bent = Bent()
    modelled: bool = False  # a model's current was followed; else the shapes are nothing yet
    rise: tuple[float, float] = (0.0, COOL)  # of R over the capture as a share of it, and its sd
    turns: Mapping[int, Part] = field(default_factory=dict)
    shapes: Mapping[str, Floats] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        capture: Capture,
        timeline: Timeline,
        driven: NDArray[np.bool_],
        volts: Floats,
        commanded: bool = False,
    ) -> Loss | None:
        """None where nothing is lost, or no signed current tells of it; and for a log without a
        program, whose voltage between its readings is known too loosely.
        """
        if any(part.kind is None for part in timeline.parts):
            return None
        channel = capture.get(CURRENT)
        top = float(np.abs(volts[driven]).max(initial=0.0))
        if channel is None or channel.unsigned or not top:
            return None
        if np.isfinite(timeline.spread(channel.values)[driven]).sum() < FEWEST:
            return None
        sensed = capture.get(VOLTAGE)
        past_bridge = commanded or (sensed is not None and sensed.sense == "supply")
        made_for = brushes_made_for(capture, top)
        drop = expected_drop(capture.wiring, made_for)
        bridge = bridge_drop(capture.wiring) if past_bridge else (0.0, 0.0)
        winding = by_figures(figures(capture))
        capacity = winding.capacity_j_k if winding is not None else None
        names = tuple(
            n for n, known in zip(SAME_BEND, (drop, bridge), strict=True) if known[1] > 0.0
        )
        names = (*names[:1], BENT, *names[1:]) if names else ()
        if capacity is None or capacity < HEAVIEST:
            names = (*names, WARMING)
        turns = {}
        if commanded and capture.wiring.dead_time_s:
            parts = timeline.parts
            turns = {k: part for k, part in enumerate(parts) if part.level}
            names = (*names, DIODES)
        names = (*names, *(turn_of(k) for k in turns))
        shapes = dict.fromkeys(names, np.zeros(len(driven)))
        blank = cls(
            driven, timeline.period_s, top, made_for, drop, capacity, bridge, turns=turns,
            shapes=shapes,
        )  # fmt: skip
        return blank if names else None

    def mixed(self, other: Loss, share: float) -> Loss:
        """This one, and of another its ``share`` of the difference to this one."""
        shapes = {n: own + share * (other.shapes[n] - own) for n, own in self.shapes.items()}
        further = self.further + share * (other.further - self.further)
        further = float(np.clip(further, -FARTHEST, FARTHEST))
        return replace(self, shapes=shapes, further=further, bent=Bent())

    def follow(
        self,
        flow: Flow,
        resistance_ohm: float,
        values: Mapping[str, float],
        turning: Floats,
        diodes: Floats,
    ) -> Loss:
        """Along the model's current, with the bend as found.

        ``turning`` (count,) of dead time; ``diodes`` (count,), what it takes for a volt that two
        diodes drop.
        """
        drop, asked = self._dropped(values), 0.0
        if self.modelled and abs(drop) > CLEAR * self.top_v:
            asked = values.get(BENT, 0.0) / drop
        further = self.further + self.bent.step(asked)
        further = float(np.clip(further, -FARTHEST, FARTHEST))
        if self.modelled and abs(drop) < NOTHING * self.top_v:
            further = 0.0  # a knee far from the usual one would look like a resistance
        bent = Bent(asked, further - self.further)
        stall_a = self.top_v / resistance_ohm
        share, bending = flow.saturation(self._bend(further, resistance_ohm))
        amperes = np.where(self.driven, flow.mean, 0.0)
        charge = np.cumsum(amperes**2) * self.period_s  # A²s
        end = float(charge[-1]) or 1.0
        known = {
            DROP: share * self.driven,
            BRIDGE: share * self.driven,
            BENT: bending * self.driven,
            WARMING: resistance_ohm * amperes * (charge / end - 0.5),
            DIODES: diodes,
        }
        for k, part in self.turns.items():
            known[turn_of(k)] = np.zeros_like(turning)
            known[turn_of(k)][part.slice] = turning[part.slice]
        shapes = {name: known[name] for name in self.shapes}
        rise = self._rise(end, stall_a)
        return replace(self, shapes=shapes, rise=rise, further=further, bent=bent, modelled=True)

    @staticmethod
    def _dropped(values: Mapping[str, float]) -> float:
        """V, of all that bends at one current."""
        return sum(values.get(name, 0.0) for name in SAME_BEND)

    @property
    def expected(self) -> float:
        """V, how large what bends may be: its means and deviations together."""
        means, deviations = zip(self.drop, self.bridge, strict=True)
        return float(np.hypot(sum(means), math.hypot(*deviations)))

    def _rise(self, charge_a2s: float, stall_a: float) -> tuple[float, float]:
        """By how much of itself R grows over the capture, and its standard uncertainty."""
        per_k = Coefficients().copper_per_k
        if self.capacity_j_k is None:  # between nothing and the bound, within two deviations
            return 0.0, max(per_k * STALL_K_S / 2 * charge_a2s / stall_a**2, COOL)
        rise = per_k * self.top_v / stall_a * charge_a2s / self.capacity_j_k
        return rise, max(FIGURES * rise, COOL)

    def bending(self, values: Mapping[str, float]) -> tuple[float, float]:
        """Standard deviation and mean (V) of the drop times the logarithm of its bend from here on.

        The bend is known to a factor from the usual one, wherever the passes have moved it.
        """
        drop = self._dropped(values)
        return FACTOR * float(np.hypot(drop, CLEAR * self.top_v)), -drop * self.further

    def drop_at(
        self, amperes: Floats, resistance_ohm: float, values: Mapping[str, float]
    ) -> Floats:
        """V (n,) that brushes drop at currents (n,) without ripple, the bend as last found."""
        share, _ = Flow(amperes).saturation(self._bend(self.further, resistance_ohm))
        return values.get(DROP, 0.0) * share

    def bend_a(self, resistance_ohm: float) -> float:
        """A at which the drop bends, as last found."""
        return self._bend(self.further, resistance_ohm)

    def _bend(self, further: float, resistance_ohm: float) -> float:
        """A at which the drop bends, by the logarithm that it is over the usual one."""
        return BEND * (self.brushes_v / resistance_ohm) * float(np.exp(further))

    def volts(self, values: Mapping[str, float]) -> Floats:
        """V (count,) that are lost."""
        return np.asarray(sum(values[name] * shape for name, shape in self.shapes.items()))
