"""Scale errors, which leave no residual: told by a nameplate or by a disc of known inertia.

Readings v' = h v, i' = g i, w' = c w of a motor obey the same laws with other parameters:

    R' = R h/g    L' = L h/g      K' = K h/c       I0' = g I0
    J' = J h g/c²  B' = B h g/c²  T0' = T0 h g/c

(power is the test: v' i' = h g v i, and so is every torque times its speed.) A resistance in series
adds to R alone; a load on the shaft adds to J alone, and is no fault. So the departures from a
nameplate say which factor is wrong, and a disc of inertia D, fitted as h g/c² D, that one is.

A clock that reads f times the true time gives L' = f L. From readings of a speed J' = f J; from
those of a position every speed is 1/f of what it is besides: K' = f K, J' = f³ J. A clock so wrong
by a divider or by another crystal is named where it explains a nameplate far better than any other
scale; L tells it from wrong counts. A speed's J and L alone are too vague for that. A wrong ambient
temperature moves R and K at 25 °C alone, and is not looked for.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from motorid.estimate.results.estimate import Parameter, Suspect

NO_LOAD = "I0"
# standard relative deviations of motors, runs and temperatures from what a nameplate says
TOLERANCE = {"R": 0.08, "L": 0.30, "K": 0.08, "J": 0.15, NO_LOAD: 0.40, "V": 1.0}
KEYS = {
    "R": "resistance_ohm",
    "L": "inductance_h",
    "K": "torque_constant_nm_a",
    "J": "inertia_kg_m2",
    NO_LOAD: "no_load_current_a",
    "V": "voltage_v",
}
CLEAR = 12.0  # chi-square that a wrong scale must explain
ALONE = 4.0  # and by how much more than any other cause does
ABSURD = math.log(30.0)
PAIR = 2  # causes that may be named together
LOAD = 2.0  # chi-square of an inertia above the nameplate's, at most: a load is no fault
ODD = 9.0  # of any one figure, at most: nameplates are wrong too
ROUGHLY = 0.1  # of a large factor's logarithm: a fit of such readings is none too good
NEAR = 0.15  # of the logarithm, within which a factor is taken for a usual one
RPM, DEGREES, TURNS = 60 / (2 * math.pi), 180 / math.pi, 1 / (2 * math.pi)


@dataclass(frozen=True)
class Cause:
    """A scale that may be wrong: powers of its factor in each parameter, and the usual factors."""

    code: str
    where: str
    powers: Mapping[str, int]
    usual: Mapping[float, str]
    action: str
    rises_only: bool = False  # the factor cannot be below 1

    def words(self, factor: float) -> str:
        """What is wrong, with its usual name where it has one."""
        for value, name in self.usual.items():
            if abs(math.log(factor / value)) < NEAR:
                return name
        return f"the {self.where} reads {factor:.3g} times what is true"


SPEED = Cause(
    "speed_scale", "encoder or speed", {"K": -1, "J": -2, "B": -2, "T0": -1},
    {
        2.0: "the encoder's counts per turn are set two times too low",
        4.0: "the encoder's counts per turn are set four times too low: lines for counts",
        0.5: "the encoder's counts per turn are set two times too high",
        0.25: "the encoder's counts per turn are set four times too high",
        RPM: "the speed is in rpm, read as rad/s",
        1 / RPM: "the speed is in rad/s, read as rpm",
        DEGREES: "the position is in degrees, read as rad",
        TURNS: "the position is in turns, read as rad",
    },
    "check counts_per_turn by turning the shaft once by hand, and the unit of the speed",
)  # fmt: skip
AMPERES = Cause(
    "current_scale", "current", {"R": -1, "L": -1, "J": 1, "B": 1, "T0": 1, NO_LOAD: 1},
    {1e3: "the current is in mA, read as A", 1e-3: "the current is in A, read as mA"},
    "compare the current with a meter, or with a known resistor in the motor's place",
)  # fmt: skip
VOLTS = Cause(
    "voltage_scale", "voltage", {"R": 1, "L": 1, "K": 1, "J": 1, "B": 1, "T0": 1, "V": 1},
    {1e3: "the voltage is in mV, read as V", 1e-3: "the voltage is in V, read as mV"},
    "compare the voltage with a meter at the motor's terminals",
)  # fmt: skip
SERIES = Cause(
    "series_resistance", "wiring", {"R": 1}, {},
    "sense the voltage at the motor's terminals, or state the leads' resistance in the rig", True,
)  # fmt: skip
WINDING = Cause(  # n times the turns of a thinner wire in the same slots
    "other_winding", "nameplate", {"R": 2, "L": 2, "K": 1, NO_LOAD: -1}, {},
    "check the nameplate against the motor: one frame comes with several windings",
)  # fmt: skip
COMPARE_CLOCKS = "time a long run of the board, or of the logger, with another clock"
TIME_OF_SPEED = Cause("time_scale", "time", {"L": 1, "J": 1}, {}, COMPARE_CLOCKS)
TIME_OF_POSITION = Cause(
    "time_scale", "time", {"L": 1, "K": 1, "J": 3, "B": 2, "T0": 1},
    {
        factor: f"the clock runs {factor:g} times too fast, as of another crystal or divider"
        for factor in (0.125, 0.25, 0.5, 0.8, 1.25, 2.0, 4.0, 8.0)
    },
    COMPARE_CLOCKS,
)  # fmt: skip
CAUSES = (SPEED, AMPERES, VOLTS, SERIES)
ALL_CAUSES = (*CAUSES, WINDING)


@dataclass(frozen=True)
class Verdict:
    """A cause with its best factor; ``left`` is the chi-square that it cannot explain."""

    cause: Cause
    factor: float
    left: float


def suspects(
    parameters: Mapping[str, Parameter],
    nameplate: Mapping[str, float],
    highest_v: float = 0.0,
    turned: bool = True,
    stated: Mapping[str, Parameter] | None = None,
) -> tuple[Suspect, ...]:
    """The wrong scale that a nameplate shows; else those that these data do not exclude.

    ``nameplate`` has R, L, K, J, I0 and V, as far as known (SI; ``read_nameplate``);
    ``highest_v`` is the highest voltage that drove the motor; ``turned``: a position was read;
    ``stated``: the values that such a scale moves, where they are others than those it is seen by.
    """
    known = departures(parameters, nameplate, highest_v)
    named = by_nameplate(known, turned)
    others = " or ".join(v.cause.where for v in named)
    either = f"; these figures do not separate {others}" if len(named) > 1 else ""
    if named:
        return tuple(
            replace(_said(v, known, nameplate, either), moves=_moves(v, stated or parameters))
            for v in named
        )
    return tuple(
        Suspect(c.code, c.where, _unseen(c, known), c.action, "not excluded")
        for c in (*CAUSES, TIME_OF_POSITION if turned else TIME_OF_SPEED)
    )


def _moves(verdict: Verdict, parameters: Mapping[str, Parameter]) -> dict[str, float]:
    """By how much (SI) each parameter is off if its cause has that factor."""
    each = verdict.cause.powers.items()
    known = ((n, power, p) for n, power in each if (p := parameters.get(n)) is not None and p.value)
    return {n: abs((p.value or 0.0) * (1.0 - verdict.factor**-power)) for n, power, p in known}


def _said(
    verdict: Verdict,
    known: Mapping[str, tuple[float, float]],
    nameplate: Mapping[str, float],
    either: str,
) -> Suspect:
    cause = verdict.cause
    said = cause.words(verdict.factor)
    if cause is SERIES:
        said = f"about {nameplate['R'] * (verdict.factor - 1):.2g} ohm are in series with the motor"
    if cause is WINDING:
        said = f"another winding than the label's, with about {verdict.factor:.2g} times its turns"
    departs = ", ".join(f"{math.exp(d):.3g} times its {n}" for n, (d, _) in known.items())
    evidence = f"{said}: of the nameplate's figures the fit gives {departs}{either}"
    return Suspect(cause.code, cause.where, evidence, cause.action, "named")


def read_nameplate(table: Mapping[str, object]) -> dict[str, float]:
    """R, L, K, J, I0 and the voltage V of a rig's ``nameplate`` table, as far as it has them."""
    found = {name: table.get(key) for name, key in KEYS.items()}
    return {n: float(v) for n, v in found.items() if isinstance(v, int | float) and v > 0}


def departures(
    parameters: Mapping[str, Parameter], nameplate: Mapping[str, float], highest_v: float = 0.0
) -> dict[str, tuple[float, float]]:
    """Logarithm of fit over nameplate, and its standard deviation, for what both know.

    A motor may be run below its voltage, hardly at many times that.
    """
    fitted: dict[str, tuple[float, float]] = {}
    if highest_v > nameplate.get("V", math.inf):
        fitted["V"] = highest_v, 0.0
    for name, p in parameters.items():
        if p.value and p.value > 0 and p.total is not None and p.status.measured:
            fitted[name] = p.value, p.total / p.value
    if {"K", "B", "T0", "R"} <= fitted.keys() and "V" in nameplate:
        K, B, T0, R = (fitted[n][0] for n in ("K", "B", "T0", "R"))
        speed = (K * nameplate["V"] - R * T0) / (K * K + R * B)
        fitted[NO_LOAD] = max((T0 + B * speed) / K, 1e-12), fitted["T0"][1]
    return {
        name: (math.log(fitted[name][0] / value), math.hypot(TOLERANCE[name], fitted[name][1]))
        for name, value in nameplate.items()
        if name in fitted and name in TOLERANCE
    }


def absurd(
    parameters: Mapping[str, Parameter], nameplate: Mapping[str, float], highest_v: float = 0.0
) -> bool:
    """No motor departs so far from its nameplate, whatever else is wrong with its capture."""
    return any(abs(d) > ABSURD for d, _ in departures(parameters, nameplate, highest_v).values())


def by_nameplate(
    known: Mapping[str, tuple[float, float]], turned: bool = False
) -> tuple[Verdict, ...]:
    """The cause that explains the departures, with one that does so as well; empty: none.

    A label of another winding stands beside a scale that does as well, and never in its place. A
    clock is named alone: of readings of a position (``turned``), and by a usual factor.
    """
    without = sum(_cost(name, d, s, math.inf) for name, (d, s) in known.items())
    found = sorted((v for c in ALL_CAUSES if (v := _best(c, known))), key=lambda v: v.left)
    clock = _best(TIME_OF_POSITION, known) if turned else None
    if clock is not None and _stands_alone(clock, found) and without - clock.left >= CLEAR:
        return (clock,)
    if not found or without - found[0].left < CLEAR:
        return ()
    alike = tuple(v for v in found if v.left - found[0].left < ALONE)
    if len(alike) > PAIR:
        alike = tuple(v for v in alike if v.cause is not WINDING)
    return alike if len(alike) <= PAIR else ()


def _stands_alone(verdict: Verdict, others: Sequence[Verdict]) -> bool:
    """Its factor is a usual one, and no other cause does as well."""
    usual = any(math.isclose(verdict.factor, factor) for factor in verdict.cause.usual)
    return usual and all(other.left - verdict.left >= ALONE for other in others)


def _best(cause: Cause, known: Mapping[str, tuple[float, float]]) -> Verdict | None:
    """The factor of ``cause`` that leaves least unexplained; a usual one where it does as well."""
    tried = []
    for x, usual in _factors(cause, known):
        left = 0.0
        for name, (d, s) in known.items():
            due = cause.powers.get(name, 0) * x
            left += _cost(name, d - due, math.hypot(s, ROUGHLY * due), ODD)
        tried.append(Verdict(cause, math.exp(x), left + (0.0 if usual else 1.0)))
    return min(tried, key=lambda v: v.left, default=None)


def _factors(
    cause: Cause, known: Mapping[str, tuple[float, float]]
) -> Iterator[tuple[float, bool]]:
    """Logarithms of the factors worth trying, and whether each is a usual one."""
    for factor in cause.usual:
        yield math.log(factor), True
    weight = total = 0.0
    for name, (d, s) in known.items():
        power = cause.powers.get(name, 0)
        if power:
            weight, total = weight + power**2 / s**2, total + power * d / s**2
            if not cause.rises_only or d / power > 0:
                yield d / power, False
    if weight and (not cause.rises_only or total > 0):
        yield total / weight, False


def _cost(name: str, departure: float, deviation: float, most: float) -> float:
    """Chi-square of one figure, bounded; the voltage was read, no fit can have got it wrong."""
    cost = (departure / deviation) ** 2
    if name == "V":
        return cost
    return min(cost, LOAD if name == "J" and departure > 0 else most)


def _unseen(cause: Cause, known: Mapping[str, tuple[float, float]]) -> str:
    """How large an error of this scale would go unseen."""
    weight = sum(cause.powers.get(n, 0) ** 2 / s**2 for n, (_, s) in known.items() if n != "J")
    if not weight:
        return "it would leave no residual, and nothing here says what the figures should be"
    factor = math.exp(math.sqrt(CLEAR / weight))
    return f"an error below a factor of {factor:.2g} would not stand out against the nameplate"


def by_disc(
    without: Parameter, with_disc: Parameter, disc_kg_m2: float, disc_uncertainty: float = 0.0
) -> tuple[Suspect, ...]:
    """The scale error that the fitted inertia of a known disc shows; empty: none.

    ``without`` and ``with_disc`` are J of two fits. What they give, h g/c², is 1 where all scales
    are right; what several causes may share is said so.
    """
    if without.value is None or with_disc.value is None:
        return ()
    found = with_disc.value - without.value
    if not found > 0:
        return ()
    u = math.hypot(without.statistical or 0.0, with_disc.statistical or 0.0) / found
    u = math.hypot(u, disc_uncertainty / disc_kg_m2)
    x = math.log(found / disc_kg_m2)
    if abs(x) < max(3 * u, 0.01):
        return ()
    reach = max(3 * u, NEAR)
    usual = [
        (c, name)
        for c in CAUSES
        for factor, name in c.usual.items()
        if abs(x - c.powers.get("J", 0) * math.log(factor)) < reach
    ]
    said = f"a disc of {disc_kg_m2:.3g} kg·m² is fitted as {found:.3g} kg·m²"
    if usual:
        causes = {c.code: c for c, _ in usual}
        where = " or ".join(c.where for c in causes.values())
        names = ", or ".join(name for _, name in usual)
        action = "; ".join(c.action for c in causes.values())
        return (Suspect(" or ".join(causes), where, f"{names}: {said}", action, "named"),)
    evidence = (
        f"current times voltage over the square of the speed is {math.exp(x):.3g} of it: {said}"
    )
    return (
        Suspect(
            "gain", "current, voltage or encoder", evidence,
            "calibrate the current first: its gain is the least sure as a rule", "named",
        ),
    )  # fmt: skip
