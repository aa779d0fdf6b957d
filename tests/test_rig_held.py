"""A rig file's program for a rotor that is held, and its slow turn: what is read, what refused."""

from __future__ import annotations

import pytest

from motorid.errors import RigError
from motorid.program import Program, Rotor, StepKind
from motorid.rig_file import parse

BENCH = """
[wiring]
counts_per_turn = 2048
[limits]
current_a = 30
speed_rad_s = 1200
supply_min_v = 20
supply_max_v = 36
[nameplate]
voltage_v = 30
resistance_ohm = 1.2
torque_constant_nm_a = 0.0389
no_load_current_a = 0.12
[sampling]
rate_hz = 10000
"""


def program(*steps: str, **held: str) -> Program:
    said = "".join(f"{key} = {value}\n" for key, value in held.items())
    text = "".join(f"[[program.steps]]\n{step}\n" for step in steps)
    return parse(f"{BENCH}[program]\n{said}{text}").program


PRBS = 'kind = "prbs"\namplitude_duty = 0.2'
TONES = 'kind = "multisine"\namplitude_v = 6\nvolts = 2'
SLOW = 'kind = "slow_turn"\nvolts = 1'


def test_a_prbs_waits_for_a_person_unless_the_file_says_that_the_rotor_is_held() -> None:
    asked = program(PRBS, energy_j="2")
    assert (asked.rotor, asked.energy_j, len(asked.steps)) == (Rotor.ASK, 2.0, 8)
    assert asked.duration_s == pytest.approx(0.05)
    assert program(PRBS, energy_j="2", rotor='"clamped"').rotor is Rotor.CLAMPED


def test_the_rotor_survives_the_capture_file_and_other_programs_are_as_they_were() -> None:
    held = program(PRBS, energy_j="2", rotor='"braked"')
    assert Program.from_dict(held.to_dict()) == held
    assert held.braked() == held
    free = program(SLOW)
    assert set(free.to_dict()) == {"version", "steps"}
    assert Program.from_dict(free.to_dict()) == free


def test_a_multisine_swings_about_its_volts() -> None:
    steps = program(TONES, energy_j="2").steps
    levels = [step.level for step in steps]
    assert len(steps) == 16
    assert max(abs(level - 2.0) for level in levels) <= 6.0
    assert {step.kind for step in steps} == {StepKind.DRIVE_VOLTS}


def test_climbs_may_be_of_a_held_rotor_too() -> None:
    held = parse(f'{BENCH}[program]\nlevels_v = [[3]]\nrotor = "braked"\nenergy_j = 9\n').program
    assert (held.rotor, held.energy_j) == (Rotor.BRAKED, 9.0)


def test_a_slow_turn_takes_its_time_from_the_nameplate() -> None:
    steps = program(SLOW + "\nturns = 2").steps
    assert [step.level for step in steps] == [1.0, 0.0, -1.0, 0.0]
    at_half_speed = 2.0 * 2 * 2 * 3.14159265 * 0.0389 / (1.0 - 1.2 * 0.12)
    assert steps[0].duration_s == pytest.approx(at_half_speed + 0.5, abs=1e-3)
    assert program(SLOW + "\nduration_s = 3").steps[0].duration_s == 3.0


@pytest.mark.parametrize(
    ("steps", "held", "message"),
    [
        ((PRBS,), {}, "program.energy_j is missing: state the most I²R heat"),
        ((SLOW,), {"energy_j": "2"}, "program.energy_j goes with program.rotor"),
        ((SLOW,), {"rotor": '"ask"', "energy_j": "2"}, "a slow_turn step turns the rotor"),
        ((PRBS,), {"rotor": '"glued"', "energy_j": "2"}, "must be one of ask, clamped, braked"),
        (('kind = "prbs"',), {"energy_j": "2"}, "exactly one of amplitude_v and amplitude_duty"),
        ((PRBS + "\nvolts = 2",), {"energy_j": "2"}, "amplitude_duty goes with duty, not with"),
        ((PRBS + "\nduty = 0.9",), {"energy_j": "2"}, "0.9 ± 0.2 passes a duty of 1"),
        ((PRBS + "\nbits = 9",), {"energy_j": "2"}, "bits must lie between 2 and 8, not 9"),
        ((PRBS + "\nbits = 4.0",), {"energy_j": "2"}, "bits must be a whole number, not 4.0"),
        ((PRBS + "\ntones = 4",), {"energy_j": "2"}, "a prbs step takes no tones"),
        ((TONES + "\ntones = 9",), {"energy_j": "2"}, "9 tones need 36 points or more"),
        (('kind = "brake"\nduration_s = 1\nbits = 4',), {}, "a brake step takes no bits"),
        (('kind = "slow_turn"\nvolts = -1',), {}, "volts must be above 0"),
        (('kind = "slow_turn"\nvolts = 0.1',), {}, "may not turn the motor"),
        (('kind = "slow_turn"\nduty = 0.1',), {}, "a duty needs duration_s"),
        (('kind = "brake"',), {}, "program.steps[0].duration_s is missing"),
    ],
)  # fmt: skip
def test_what_is_refused(steps: tuple[str, ...], held: dict[str, str], message: str) -> None:
    with pytest.raises(RigError) as caught:
        program(*steps, **held)
    assert message in str(caught.value)
    assert str(caught.value).startswith("rig: ")
