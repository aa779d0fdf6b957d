"""A unit that was mistaken is named by the catalogue of motors, and a good motor is not accused."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from bench.coverage.motors import draw_motor
from motorid.capture.model import Capture
from motorid.capture.units import alike
from motorid.estimate.diagnosis.facts.catalogue import MOTORS, Figures, distance, ranges
from motorid.estimate.diagnosis.facts.unit_mistakes import (
    FOREIGN,
    UNUSUAL,
    explanations,
    findings,
)
from motorid.estimate.results.estimate import Parameter
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


@pytest.mark.parametrize(
    "motor",
    [
        Figures(6.0, 0.162, 4.94e-3, 5.87e-6, 25e-6),
        Figures(3.0, 0.222, 2.27e-3, 2.06e-7, 48e-6),
        Figures(6.0, 0.097, 6.35e-3, 3.71e-6, 109e-6),
    ],
)
def test_small_motors_of_many_amperes_are_not_accused(motor: Figures) -> None:
    """As toys and models have them: no catalogue of precision motors does."""
    found = distance(motor)
    assert found < FOREIGN  # at most a remark
    assert found > UNUSUAL


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


def test_counts_per_turn_of_lines_are_named_without_a_nameplate() -> None:
    capture = log()
    known = replace(capture.wiring, counts_per_turn=512.0)
    run = replace(capture, wiring=known, provenance={"identity": {}})
    (said,) = findings([run], read_wrong(MOTION, 4.0))
    assert "wiring.counts_per_turn were about 2048, not 512" in said.message
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


@pytest.mark.parametrize("name", ["R", "L", "K", "J", "L/R", "JR/K²"])
def test_drawn_motors_lie_within_the_ranges(name: str) -> None:
    low, high = ranges()[name]
    rng = np.random.default_rng(5)
    for _ in range(300):
        m = draw_motor(rng).motor
        R, L, K, J = m.resistance_ohm, m.inductance_h, m.torque_constant_nm_a, m.inertia_kg_m2
        value = {"R": R, "L": L, "K": K, "J": J, "L/R": L / R, "JR/K²": J * R / K**2}[name]
        assert low < value < high
