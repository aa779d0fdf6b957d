"""What a wider model may add to the six parameters: terms, their parameters, and how those move."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from motorid.errors import UsageError, nearest
from motorid.estimate.effects.influence_quantity import InfluenceQuantity
from motorid.estimate.effects.state.cogging_phase import COGGING_PHASE
from motorid.estimate.effects.state.initial_warmth import INITIAL_WARMTH
from motorid.estimate.effects.state.ripple_phase import RIPPLE_PHASE
from motorid.estimate.results.estimate import AUTO, PARAMETERS, SIX
from motorid.estimate.solver.problem import Unknown

NO_RISE_S = 1e-3
COPPER_PER_K = 0.00393  # at 20 to 25 °C (IEC 60228)


@dataclass(frozen=True)
class Added:
    """A parameter beyond the six. ``absent`` is its value where its term is left out.

    ``log``: positive, searched by its logarithm. ``scale``: which of ``Scales`` it is counted in,
    and what part of that a search begins with.
    """

    unit: str
    meaning: str
    scale: str
    part: float
    log: bool = False
    lower: float = 0.0
    upper: float = float("inf")
    absent: float = 0.0


@dataclass(frozen=True)
class Scales:
    """Typical sizes in these captures, SI: they set steps and start values, never an answer."""

    volts: float
    current: float  # at stall
    speed: float
    torque: float
    resistance: float
    inertia: float
    inductance: float
    duration: float  # s
    one: float = 1.0

    @property
    def rise(self) -> float:
        """L/R in s, of a motor without L a thousandth of a second."""
        return self.inductance / self.resistance or NO_RISE_S

    def of(self, name: str) -> float:
        """The size of an added parameter."""
        sizes = {
            "1": self.one,
            "V": self.volts,
            "A": self.current,
            "1/A": 1.0 / self.current,
            "L/R": self.rise,
            "rad/s": self.speed,
            "ohm·s/rad": self.resistance / self.speed,
            "N·m": self.torque,
            "N·m·s²/rad²": self.torque / self.speed**2,
            "K/J": 1.0 / (COPPER_PER_K * self.resistance * self.current**2 * self.duration),
            "1/s": 1.0 / self.duration,
            "N·m/rad": self.inertia * (self.speed / 10.0) ** 2,
            "N·m·s/rad": self.inertia / self.duration,
        }
        return sizes[ADDED[name].scale]


ADDED = {
    "d_Ke": Added("1", "back-EMF constant over torque constant, less 1", "1", 0.0, lower=-0.9),
    "V_b": Added("V", "brush drop at large current", "V", 0.01),
    "i_b": Added("A", "current over which the brush drop rises", "A", 0.05, log=True),
    "T_lc": Added("N·m·s²/rad²", "quadratic load", "N·m·s²/rad²", 0.1),
    "d_T0": Added("1", "Coulomb torque forwards over its mean, less 1", "1", 0.0, False, -1.0, 1.0),
    "T_s": Added("N·m", "breakaway torque above T0", "N·m", 0.2),
    "w_s": Added("rad/s", "Stribeck speed", "rad/s", 0.05, log=True),
    "T_c": Added("N·m", "cogging torque, amplitude", "N·m", 0.1),
    "N_c": Added("1", "cogging periods a turn", "1", 0.0),
    "k_K": Added("1", "commutation ripple of K, amplitude", "1", 0.01),
    "k_R": Added("1", "commutation ripple of R, amplitude", "1", 0.0, lower=-1.0, upper=1.0),
    "N_r": Added("1", "commutations a turn", "1", 0.0),
    "per_C_w": Added("K/J", "one over the heat capacity of the winding", "K/J", 0.1),
    "k_w": Added("1/s", "cooling rate of the winding", "1/s", 0.0),
    "J2_share": Added("1", "share of J behind the flexible shaft", "1", 0.5, False, 0.01, 0.99),
    "Ks": Added("N·m/rad", "stiffness of the shaft", "N·m/rad", 1.0, log=True),
    "b": Added("N·m·s/rad", "damping of the shaft", "N·m·s/rad", 1.0),
    "c_load": Added("1", "friction over the torque of the current", "1", 0.01, upper=0.9),
    "a_K": Added("1/A", "fall of K with the current, over K", "1/A", 0.01),
    "i_K": Added("A", "current over which that fall sets in", "A", 0.1, log=True),
    "d_L": Added("1", "share of L that a very large current takes", "1", 0.1, upper=0.95),
    "i_L": Added("A", "current that takes half of that share", "A", 0.4, log=True),
    "L2_share": Added("1", "share of L beside the eddy resistance", "1", 0.1, upper=0.95),
    "t_e": Added("s", "that part of L over the eddy resistance", "L/R", 1.0, log=True),
    "c_R": Added("ohm·s/rad", "rise of R with speed", "ohm·s/rad", 0.02),
    "w_R": Added("rad/s", "speed above which R rises", "rad/s", 0.3),
    "T_f": Added(
        "N·m", "T0 at the first tick less that at the last", "N·m", 0.1, False, -float("inf")
    ),
    "r_f": Added("1/s", "rate at which that goes", "1/s", 1.0),
}
"""In the order of ``motorid.motor.wide.NAMES`` after the six."""
NAMES = (*PARAMETERS, *ADDED)


@dataclass(frozen=True, eq=False)  # each is itself
class Term:
    """One effect. ``free``: the parameters that it adds; ``size``: the one that is 0 without it.

    ``shapes``: values, in units of ``Scales``, that the screen tries for a parameter which means
    nothing while the size is 0. ``phase``: the nuisance of every capture that it needs.
    """

    name: str
    title: str
    equation: str
    free: tuple[str, ...]
    size: str
    shapes: Mapping[str, tuple[float, ...]]
    phase: InfluenceQuantity | None = None
    per_turn: str = ""  # the parameter that is counted, not searched

    def phased(self, phase: float) -> dict[str, float]:
        """The unknown of every capture that it needs, at ``phase``; empty: it needs none."""
        return {} if self.phase is None else {self.phase.name: phase}

    @property
    def sizes(self) -> tuple[str, ...]:
        """Those of ``free`` that are 0 without it."""
        return self.free if self.per_turn else (self.size,)


TERMS = {
    term.name: term
    for term in (
        Term(
            "brush-drop", "voltage drop of the brushes", "v has V_b i/√(i² + i_b²) more",
            ("V_b", "i_b"), "V_b", {"i_b": (0.02, 0.05, 0.15)},
        ),
        Term(
            "quadratic-load", "load that grows with the square of speed",
            "friction has T_lc w |w| more", ("T_lc",), "T_lc", {},
        ),
        Term(
            "direction", "friction that differs with direction", "T0 is T0 (1 + d_T0 sign w)",
            ("d_T0",), "d_T0", {},
        ),
        Term(
            "stribeck", "friction that is higher at low speed",
            "friction has T_s exp(−(w/w_s)²) sign w more", ("T_s", "w_s"), "T_s",
            {"w_s": (0.01, 0.03, 0.1, 0.3)},
        ),
        Term(
            "cogging", "torque that varies with the rotor's position",
            "torque has T_c sin(N_c angle + phase) less", ("T_c",), "T_c", {},
            COGGING_PHASE, "N_c",
        ),
        Term(
            "ripple", "K and R that vary with commutation",
            "K is K (1 + k_K cos(N_r angle + phase)), R likewise with k_R", ("k_K", "k_R"), "k_K",
            {}, RIPPLE_PHASE, "N_r",
        ),
        Term(
            "heating", "a winding that warms up within a run",
            "C_w dT/dt = R i² − k_w C_w T, R rises by 0.393 %/K of T", ("per_C_w", "k_w"),
            "per_C_w", {}, INITIAL_WARMTH,
        ),
        Term(
            "two-masses", "a flexible shaft between two inertias",
            "J is J1 + J2, joined by Ks and b", ("J2_share", "Ks", "b"), "J2_share", {},
        ),
        Term(
            "ke-kt", "a back-EMF constant apart from the torque constant",
            "the back-EMF is K (1 + d_Ke) w", ("d_Ke",), "d_Ke", {},
        ),
        Term(
            "load-friction", "friction that grows with the torque of the current",
            "friction has c_load |K i| sign w more", ("c_load",), "c_load", {},
        ),
        Term(
            "armature-reaction", "a torque constant that falls with the current",
            "K is K (1 − a_K (√(i² + i_K²) − i_K))", ("a_K", "i_K"), "a_K",
            {"i_K": (0.02, 0.5)},
        ),
        Term(
            "saturation", "an inductance that falls with the current",
            "L is L (1 − d_L i²/(i² + i_L²))", ("d_L", "i_L"), "d_L", {"i_L": (0.2, 0.7)},
        ),
        Term(
            "eddy", "eddy currents in the iron",
            "L is L (1 − L2_share) in series with L L2_share beside R_c = L L2_share/t_e",
            ("L2_share", "t_e"), "L2_share", {"t_e": (0.5, 2.0, 6.0)},
        ),
        Term(
            "commutation-resistance", "a resistance that rises with speed",
            "R is R + c_R max(|w| − w_R, 0)", ("c_R", "w_R"), "c_R", {"w_R": (0.0, 0.6)},
        ),
        Term(
            "friction-drift", "dry friction that changes while the motor runs",
            "T0 is T0 + T_f (exp(−r_f t) − e)/(1 − e), e = exp(−r_f duration)",
            ("T_f", "r_f"), "T_f", {"r_f": (0.0, 2.0, 8.0)},
        ),
    )
}  # fmt: skip


def parse(model: str) -> tuple[Term, ...]:
    """The terms of NAME[+NAME]. Raises UsageError that names the nearest."""
    found = []
    for name in model.split("+"):
        if name not in TERMS:
            known = (SIX, AUTO, *TERMS)
            raise UsageError(
                f'there is no model "{name}"{nearest(name, known)}; the models are '
                f"{', '.join(known)}, and terms joined by +"
            )
        found.append(TERMS[name])
    return tuple(dict.fromkeys(found))


def unknown(name: str, start: float, scales: Scales, prior: tuple[float, float] | None) -> Unknown:
    """An added parameter as the search takes it. ``prior``: (mean, sd) in search coordinates."""
    added = ADDED[name]
    mean, sd = prior or (0.0, float("inf"))
    return Unknown(
        name, start, added.lower, added.upper, added.log, scales.of(name), mean, sd
    )  # fmt: skip
