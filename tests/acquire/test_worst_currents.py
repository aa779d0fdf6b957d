"""The worst current of each step, with the back-EMF that may stand by then; by V, R and tau."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest

from motorid.acquire.safety import check_program, pulse_resistance
from motorid.errors import RigError
from motorid.program import Decay, Program, Rotor, Step, StepKind
from motorid.rig import Nameplate
from tests.acquire.rigs import sim_rig

TAU_S = 0.02  # of 2 ohm, 1e-6 kg m² and .01 V s: R J / K²
PLATE = Nameplate(resistance_ohm=2.0, inertia_kg_m2=1e-6, torque_constant_nm_a=0.01)
FAST = 1e9


def rig(current_a: float, plate: Nameplate = PLATE, **limits: Any) -> Any:
    made = sim_rig()
    limits = {
        "current_a": current_a, "speed_rad_s": FAST, "supply_max_v": 12.0, "voltage_v": None,
        "run_time_s": 60.0,
    } | limits  # fmt: skip
    return replace(
        made, nameplate=plate, supply_voltage_v=None, limits=replace(made.limits, **limits)
    )


def steps(*parts: tuple[float | None, float], rotor: Rotor | None = None) -> Program:
    """Volts for so many tau; 0 brakes, None coasts."""
    made = []
    for volts, taus in parts:
        seconds = taus * TAU_S
        if volts:
            made.append(Step(StepKind.DRIVE_VOLTS, seconds, volts, Decay.SYNCHRONOUS_SLOW))
        else:
            made.append(Step(StepKind.COAST if volts is None else StepKind.BRAKE, seconds))
    return Program(tuple(made)) if rotor is None else Program(tuple(made), rotor=rotor)


def peak(program: Program, plate: Nameplate = PLATE, **more: Any) -> tuple[float, int]:
    """The largest current that a limit must allow, and the step that needs it; by halving."""
    low, high, number = 0.0, 100.0, -1
    for _ in range(30):
        middle = (low + high) / 2
        try:
            check_program(rig(middle, plate), program, **more)
            high = middle
        except RigError as error:
            low, number = middle, int(str(error).split()[1])
    return high, number


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_back_emf_decays_by_the_time_constant(sign: float) -> None:
    assert peak(steps((sign * 6.0, 1.0))) == (pytest.approx(3.0), 0)
    assert peak(steps((sign * 6.0, 1.0), (-sign * 6.0, 1.0))) == (pytest.approx(6.0), 1)
    # a brake of one tau leaves 6 V / e, which another 5 V the other way add to
    braked = steps((sign * 6.0, 9.0), (0.0, 1.0), (-sign * 5.0, 1.0))
    assert peak(braked) == (pytest.approx((5.0 + 6.0 / math.e) / 2.0), 2)
    # a lower level of the same sign pulls it towards itself: 2 V and (6 - 2) V / e
    lower = steps((sign * 6.0, 9.0), (sign * 2.0, 1.0), (-sign * 5.0, 1.0))
    assert peak(lower) == (pytest.approx((5.0 + 2.0 + 4.0 / math.e) / 2.0), 2)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_motor_that_was_never_driven_one_way_has_no_back_emf_of_it(sign: float) -> None:
    again = steps((sign * 6.0, 9.0), (sign * 6.0, 9.0), (sign * 5.0, 1.0))
    assert peak(again)[0] == pytest.approx(3.0)
    assert peak(steps((0.0, 1.0), (sign * 4.0, 1.0))) == (pytest.approx(2.0), 1)


def test_nobody_knows_how_soon_a_coast_slows_a_motor() -> None:
    coasted = steps((6.0, 9.0), (None, 99.0), (-6.0, 1.0))
    assert peak(coasted) == (pytest.approx(6.0), 2)


@pytest.mark.parametrize(
    "unknown", ["inertia_kg_m2", "torque_constant_nm_a"], ids=["inertia", "constant"]
)
def test_without_a_time_constant_no_brake_helps(unknown: str) -> None:
    plate = replace(PLATE, **{unknown: None})
    braked = steps((6.0, 9.0), (0.0, 9.0), (-6.0, 1.0))
    assert peak(braked, plate) == (pytest.approx(6.0), 2)
    assert peak(braked)[0] == pytest.approx(3.0, rel=1e-3)


def test_the_nameplate_s_resistance_counts_before_a_measured_one() -> None:
    up = steps((6.0, 1.0))
    assert peak(up, resistance_ohm=1.0)[0] == pytest.approx(3.0)
    assert peak(up, Nameplate(), resistance_ohm=1.0)[0] == pytest.approx(6.0)
    check_program(rig(0.001, Nameplate()), up)  # it is left for later
    assert pulse_resistance(-3.0, 0.5) == pytest.approx(4.0)  # of 6 ohm, over 1.5


def test_a_held_rotor_has_no_back_emf_and_its_least_resistance_counts() -> None:
    turned = steps((6.0, 9.0), (-6.0, 1.0), rotor=Rotor.CLAMPED)
    assert peak(turned) == (pytest.approx(3.0), 0)
    assert peak(turned, resistance_ohm=1.5)[0] == pytest.approx(4.0)
    assert peak(turned, resistance_ohm=3.0)[0] == pytest.approx(3.0)
    assert peak(turned, Nameplate(), resistance_ohm=3.0)[0] == pytest.approx(2.0)
    check_program(rig(0.001, Nameplate()), turned)


@pytest.mark.parametrize(
    ("limits", "says"),
    [
        ({"voltage_v": 6.0}, ""), ({"voltage_v": 5.9}, r"step 1 .* puts 6 V on the motor, and"),
        ({"supply_max_v": 6.0}, ""), ({"supply_max_v": 5.9}, r"step 1 .* asks for -6 V, and"),
        ({"speed_rad_s": 600.0}, ""), ({"speed_rad_s": 599.0}, "6 V can turn this motor at 600"),
        ({"run_time_s": 0.08}, ""), ({"run_time_s": 0.0799}, "the program takes 0.08 s, and"),
    ],
)  # fmt: skip
def test_limits_hold_at_their_bounds(limits: dict[str, float], says: str) -> None:
    program = steps((5.0, 2.0), (-6.0, 1.0), (None, 1.0))
    if says:
        with pytest.raises(RigError, match=says):
            check_program(rig(99.0, **limits), program)
    else:
        check_program(rig(99.0, **limits), program)
