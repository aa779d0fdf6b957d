"""A unit that was mistaken is named by the catalogue of motors, and a good motor is not accused."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bench.coverage.motors import draw_motor
from motorid.capture.model import Capture
from motorid.capture.units import alike
from motorid.estimate.diagnosis.facts import unit_mistakes
from motorid.estimate.diagnosis.facts.catalogue import (
    MOTORS,
    OTHERS,
    Figures,
    distance,
    ranges,
)
from motorid.estimate.diagnosis.facts.unit_mistakes import (
    UNUSUAL,
    explanations,
    findings,
    highest_v,
)
from motorid.estimate.results.estimate import Diagnostic, Parameter
from motorid.estimate.results.status import Status
from motorid.sim.motor import find_motor
from tests.exact_capture import FAULHABER, Plan, clean_capture

MAPS = ("time=t:s", "current=i:A", "voltage=v:V", "position=p:rad")
SHORT = Plan(count=400)
# what readings times so much do to a motor's figures: R, L, K, B, J, T0
CURRENT = (-1, -1, 0, 1, 1, 1)
VOLTAGE = (1, 1, 1, 1, 1, 1)
MOTION = (0, 0, -1, -2, -2, -1)
TIME = (0, 1, 1, 2, 3, 1)  # of a position: R, L, K, B, J, T0
RPM = 60.0 / (2.0 * math.pi)


def parameters(motor: dict[str, float]) -> dict[str, Parameter]:
    return {
        name: Parameter(name, "", value, 0.0, 0.0, 0.01 * value, None, Status.ESTIMATED)
        for name, value in motor.items()
    }


def read_wrong(powers: tuple[int, ...], factor: float) -> dict[str, Parameter]:
    moved = zip(FAULHABER.items(), powers, strict=True)
    return parameters({name: value * factor**power for (name, value), power in moved})


@cache
def exact() -> Capture:
    """A short run."""
    return clean_capture(FAULHABER, SHORT)


def log(maps: tuple[str, ...] = MAPS, volts: float = 1.0) -> Capture:
    """A short run as an import has it, its voltage times so much."""
    capture = exact()
    channels = {
        n: replace(c, raw=np.asarray(c.raw) * (volts if n == "terminal_voltage" else 1.0))
        for n, c in capture.channels.items()
    }
    return replace(capture, channels=channels, program=None, phases=(), provenance={"maps": maps})


@pytest.mark.parametrize(
    ("map_", "powers", "factor", "volts", "mend"),
    [
        ("current=i:mA", CURRENT, 1e-3, 1.0, "--map current=i:A"),
        ("current=i:A", CURRENT, 1e3, 1.0, "--map current=i:mA"),
        ("voltage=v:mV", VOLTAGE, 1e-3, 1e-3, "--map voltage=v:V"),
        ("time=t:ms", TIME, 1e-3, 1.0, "--map time=t:s"),
        ("time=t:s", TIME, 1e3, 1.0, "--map time=t:ms"),
        ("position=p:rad", MOTION, 360.0 / (2 * math.pi), 1.0, "--map position=p:deg"),
    ],
)
def test_a_unit_is_named(
    map_: str, powers: tuple[int, ...], factor: float, volts: float, mend: str
) -> None:
    others = tuple(m for m in MAPS if m.split("=")[0] != map_.split("=")[0])
    wrong = read_wrong(powers, factor)
    (said,) = findings([log((map_, *others), volts)], wrong)
    assert said.code == "unit_mistake"
    assert mend in said.message
    for name, value in FAULHABER.items():
        found = wrong[name].value or 0.0
        assert said.moves.get(name, 0.0) == pytest.approx(abs(found - value), abs=1e-9 * value)


def test_rpm_for_radians_is_named() -> None:
    capture = log((*MAPS[:3], "speed=n:rad/s"))
    position = capture.channels["position"]
    channels = {n: c for n, c in capture.channels.items() if n != "position"}
    channels["speed"] = replace(position, name="speed", unit="rad/s")
    (said,) = findings([replace(capture, channels=channels)], read_wrong(MOTION, RPM))
    assert "--map speed=n:rpm" in said.message


def test_a_good_log_is_not_accused() -> None:
    assert list(findings([log()], parameters(FAULHABER))) == []


def test_a_board_declares_its_scales_and_is_not_told_of_units() -> None:
    run = replace(log(), provenance={"identity": {}})
    found = findings([run], read_wrong(CURRENT, 1e-3))
    assert all(said.code != "unit_mistake" for said in found)


@pytest.mark.slow
def test_drawn_motors_of_all_sizes_are_not_accused() -> None:
    rng = np.random.default_rng(11)
    capture, accused = log(), []
    for _ in range(200):
        drawn = draw_motor(rng)
        m = drawn.motor
        motor = Figures(
            m.voltage_v * float(rng.uniform(0.4, 1.0)), m.resistance_ohm, m.torque_constant_nm_a,
            m.inertia_kg_m2 + drawn.load_inertia, m.inductance_h,
        )  # fmt: skip
        found = distance(motor)
        if found > UNUSUAL and explanations(capture, motor, found):
            accused.append(m.title)
    assert accused == []


# motors that the catalogue lacks: V, ohm, H, N·m/A, kg·m²
HELD_OUT = {
    # data sheets of maxon
    "RE 25, 118743": (12.0, 2.18, 238e-6, 23.4e-3, 10.3e-7),
    "RE 25, 118752": (24.0, 2.32, 240e-6, 23.4e-3, 10.3e-7),
    "RE 30, 48 V": (48.0, 2.45, 513e-6, 53.8e-3, 34.7e-7),
    "RE 40, 48 V": (48.0, 1.13, 330e-6, 60.3e-3, 137e-7),
    "A-max 32": (24.0, 3.99, 556e-6, 35.2e-3, 45.3e-7),
    # parameter files of public models
    "112 ohm": (24.0, 112.0, 11.4e-3, 69.7e-3, 7.46e-7),
    "DC054B-2": (24.0, 1.73, 2.5e-3, 55.1e-3, 1.6e-5),
    "0.43 ohm": (12.0, 0.43, 0.9e-3, 18.7e-3, 1.54e-5),
}
# stall torque (N·m) and current (A) at 12 V, as WPILib has them of the motors of robot contests
STALLED = {
    "Mini CIM": (1.41, 89.0),
    "BAG": (0.43, 53.0),
    "775pro": (0.71, 134.0),
    "RS775-125": (0.28, 18.0),
    "BaneBots RS-775": (0.72, 97.0),
    "AndyMark 9015": (0.36, 71.0),
    "BaneBots RS-550": (0.38, 84.0),
}
# as models and toys have them: V, ohm, N·m/A
SMALL = {
    "toy, .16 ohm": (6.0, 0.162, 4.94e-3),
    "toy, .22 ohm": (3.0, 0.222, 2.27e-3),
    "toy, .1 ohm": (6.0, 0.097, 6.35e-3),
    "model car": (7.4, 0.065, 5e-3),
    "model car, 12 V": (12.0, 0.065, 5e-3),
    "model car, 21 turns": (7.2, 0.03, 3.5e-3),
    "starter": (12.0, 0.008, 12e-3),
    "drone, coreless": (3.7, 0.7, 0.7e-3),
}


def all_motors() -> dict[str, Figures]:
    """Those of which no inertia is stated are up to speed in 10, or in 40 ms."""
    known = {**MOTORS, **OTHERS, **HELD_OUT}
    found = {name: Figures(V, R, K, J, L) for name, (V, R, L, K, J) in known.items()}
    bare = SMALL | {name: (12.0, 12.0 / amps, nm / amps) for name, (nm, amps) in STALLED.items()}
    for name, (V, R, K) in bare.items():
        for tau_s in (0.01, 0.04):
            found[f"{name}, {tau_s} s"] = Figures(V, R, K, tau_s * K**2 / R)
    return found


def said_of(motor: Figures, maps: tuple[str, ...] = MAPS) -> list[Diagnostic]:
    capture = log(maps, motor.top_v / highest_v(log()))
    values = {"R": motor.R, "K": motor.K, "J": motor.J, "L": motor.L or 0.0}
    return list(findings([capture], parameters(values)))


@pytest.mark.parametrize("name", all_motors())
def test_a_motor_of_any_size_is_not_accused(name: str) -> None:
    """At most a remark: few motors are like it."""
    assert all(said.severity == "info" and not said.moves for said in said_of(all_motors()[name]))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("powers", "factor", "share"),
    [
        ({"R": -1.0, "L": -1.0, "J": 1.0}, 1e3, 0.9),  # of a current
        ({"R": -1.0, "L": -1.0, "J": 1.0}, 1e-3, 0.9),
        ({"V": 1.0, "R": 1.0, "L": 1.0, "K": 1.0, "J": 1.0}, 1e3, 1.0),
        ({"V": 1.0, "R": 1.0, "L": 1.0, "K": 1.0, "J": 1.0}, 1e-3, 1.0),
        ({"L": 1.0, "K": 1.0, "J": 3.0}, 1e3, 1.0),  # of a time
        ({"L": 1.0, "K": 1.0, "J": 3.0}, 1e-3, 1.0),
    ],
)
def test_a_factor_of_1000_is_named(powers: dict[str, float], factor: float, share: float) -> None:
    """An ampere for a milliampere makes an unusual motor of most; a few ohms of a few thousand."""
    motors = [Figures(V, R, K, J, L) for V, R, L, K, J in (*MOTORS.values(), *HELD_OUT.values())]
    named = sum(bool(said_of(motor.scaled(powers, 1.0 / factor))) for motor in motors)
    assert named >= share * len(motors)


@pytest.mark.parametrize("name", ["faulhaber-2338s006s", "maxon-re35", "pittman-14204s004"])
def test_the_catalogue_says_of_a_motor_what_the_simulator_does(name: str) -> None:
    m = find_motor(name)[1]
    figures = (
        m.voltage_v,
        m.resistance_ohm,
        m.inductance_h,
        m.torque_constant_nm_a,
        m.inertia_kg_m2,
    )
    assert any(known == pytest.approx(figures) for known in MOTORS.values())


def test_units_of_a_family_are_offered() -> None:
    assert alike("current", "A")["mA"] == 1e-3
    assert alike("current", "V") == {}


@pytest.mark.parametrize(
    ("factor", "counts"), [(4.0, "2048"), (10.0, "5120"), (100.0, "51200"), (0.01, "5.12")]
)
def test_counts_per_turn_of_lines_or_past_a_gear_are_named_without_a_nameplate(
    factor: float, counts: str
) -> None:
    capture = log()
    known = replace(capture.wiring, counts_per_turn=512.0)
    run = replace(capture, wiring=known, provenance={"identity": {}})
    (said,) = findings([run], read_wrong(MOTION, factor))
    assert f"wiring.counts_per_turn were about {counts}, not 512" in said.message
    assert list(findings([run], parameters(FAULHABER))) == []


def test_a_time_column_that_counts_rows_is_called_so() -> None:
    capture = log(("time=n:s", *MAPS[1:]))
    rows = replace(capture, ticks=np.arange(len(capture)) * 10**6)
    (said,) = findings([rows], read_wrong(TIME, 1e4))
    assert "the time column, which counts the rows" in said.message
    assert "--map time=row*PERIOD:s" in said.message


def test_a_time_constant_alone_tells_of_its_unit() -> None:
    ratio = Parameter("JR/(K²+RB)", "s", 17e-6, 0.0, 0.0, 1e-8, None, Status.ESTIMATED)
    capture = log(("time=t:ms", *MAPS[1:]))
    (said,) = findings([capture], {}, {ratio.name: ratio})
    assert "perhaps the time is in s, not ms" in said.message
    assert said.moves["JR/(K²+RB)"] == pytest.approx(17e-3, rel=0.01)
    usual = replace(ratio, value=17e-3)
    assert list(findings([capture], {}, {ratio.name: usual})) == []


def test_a_constant_that_no_motor_has_makes_all_that_was_fitted_with_it_doubtful() -> None:
    """Of swapped channels J may look usual: it goes with K all the same."""
    one = Parameter("K", "N·m/A", 18.6, 0.0, 0.0, 0.1, None, Status.ESTIMATED)
    known = {
        "K": one, "J": replace(one, name="J", unit="kg·m²", value=0.34),
        "R": replace(one, name="R", value=None, status=Status.NOT_IDENTIFIABLE),
    }  # fmt: skip
    (said,) = findings([log(MAPS)], known)
    assert said.message.startswith("K is 18.6")
    assert said.moves == {"K": math.inf, "J": math.inf}
    assert list(findings([log(MAPS)], {**known, "K": replace(one, value=0.1)})) == []


@pytest.mark.parametrize("name", ["R", "L", "K", "J", "L/R", "JR/K²"])
def test_drawn_motors_lie_within_the_ranges(name: str) -> None:
    low, high = ranges()[name]
    rng = np.random.default_rng(5)
    for _ in range(300):
        m = draw_motor(rng).motor
        R, L, K, J = m.resistance_ohm, m.inductance_h, m.torque_constant_nm_a, m.inertia_kg_m2
        value = {"R": R, "L": L, "K": K, "J": J, "L/R": L / R, "JR/K²": J * R / K**2}[name]
        assert low < value < high


# a motor of 2.8 V and half an ohm, and one of 6 V and 80 milliohm: usual only among all motors
ODD = {"R": 0.506, "L": 299e-6, "K": 3.67e-3, "J": 7.2e-7, "V": 2.82}
STRONG = {"R": 0.0801, "L": 36.3e-6, "K": 12.4e-3, "J": 4.62e-5, "V": 5.94}


@pytest.mark.parametrize(
    ("motor", "map_", "powers", "factor", "mend"),
    [
        (ODD, "current=i:mA", CURRENT, 1e-3, "--map current=i:A"),
        (ODD, "time=t:s", TIME, 1e3, "--map time=t:ms"),
        (STRONG, "time=t:s", TIME, 1e3, "--map time=t:ms"),
    ],
)
def test_a_unit_of_a_motor_that_is_usual_only_among_all_is_named(
    motor: dict[str, float], map_: str, powers: tuple[int, ...], factor: float, mend: str
) -> None:
    """They were named to nobody, or it was said that no single unit explains them."""
    top = highest_v(log())
    others = tuple(m for m in MAPS if m.split("=")[0] != map_.split("=")[0])
    capture = log((map_, *others), motor["V"] / top)
    figures = {name: motor[name] for name in ("R", "L", "K", "J")}
    of = dict(zip(FAULHABER, powers, strict=True))
    moved = {name: value * factor ** of[name] for name, value in figures.items()}
    (said,) = findings([capture], parameters(moved))
    assert (said.code, said.severity) == ("unit_mistake", "warning")
    assert mend in said.message
    assert said.moves["J"] == pytest.approx(abs(moved["J"] - motor["J"]))
    assert not [one for one in findings([capture], parameters(figures)) if one.severity != "info"]


FAR = 99.0  # from all motors


@pytest.mark.parametrize(
    ("found", "distances", "named"),
    [
        (10.9, (5.0, 9.0), []),  # it brings the motor nearer by less than 6
        (11.1, (5.0, 9.0), [2.0]),
        (20.0, (8.1, 9.0), []),  # not near enough
        (20.0, (7.9, 9.0), [2.0]),
        (20.0, (7.0, 5.0), [4.0]),  # of one quantity the nearer to a usual motor,
        (20.0, (6.9, 5.0), [2.0]),  # or of those that do as well the nearer unit
    ],
)
def test_a_mistake_brings_a_motor_much_nearer_to_usual_ones(
    found: float, distances: tuple[float, float], named: list[float],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    of = dict(zip((2.0, 4.0), distances, strict=True))
    possible = [unit_mistakes.Mistake("current", factor, "", "") for factor in of]
    monkeypatch.setattr(unit_mistakes, "_possible", lambda _: possible)
    monkeypatch.setattr(unit_mistakes, "_powers", lambda _, quantity: quantity)
    monkeypatch.setattr(
        unit_mistakes, "distance", lambda factor, wide=False: FAR if wide else of[factor]
    )
    motor: Any = SimpleNamespace(scaled=lambda powers, factor: factor)
    none: Any = None
    told = unit_mistakes.explanations(none, motor, found)
    assert [one.factor for one in told] == named
    assert [one.distance for one in told] == [of[factor] for factor in named]
