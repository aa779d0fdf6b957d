"""What a program or a capture will show, and the run that would tell the rest."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

from motorid.estimate.diagnosis import identifiability
from motorid.estimate.diagnosis.identifiability import (
    ADDITIONS,
    TIMES_S,
    TYPICAL,
    Excitation,
    Knowledge,
    advice,
    assess,
    of_program,
    run_to_add,
)
from motorid.program import Decay, Program, Step, StepKind

ALL = frozenset(("current", "terminal_voltage", "speed"))
ELECTRICAL = frozenset(("current", "terminal_voltage"))


def drive(level: float, kind: StepKind = StepKind.DRIVE_DUTY) -> Step:
    return Step(kind, 0.1, level, Decay.SYNCHRONOUS_SLOW)


COAST, BRAKE = Step(StepKind.COAST, 0.1), Step(StepKind.BRAKE, 0.1)


def test_a_program_shows_its_levels_its_starts_and_its_coast() -> None:
    run = of_program(Program((COAST, drive(0.3), drive(0.6), drive(0.3), COAST)), ["current"])
    assert run == Excitation(frozenset(["current"]), levels=2, transient=True, coast=True)
    coarse = of_program(Program((drive(0.3), BRAKE)), ["speed"], fine=False)
    assert coarse == Excitation(frozenset(["speed"]), levels=1, transient=False, coast=False)


def test_a_rest_before_the_first_drive_is_no_coast() -> None:
    assert not of_program(Program((COAST, drive(0.3))), ["speed"]).coast
    assert of_program(Program((COAST, drive(0.3), COAST)), ["speed"]).coast
    alone = of_program(Program((COAST,)), ["speed"])
    assert alone == Excitation(frozenset(["speed"]), levels=0, transient=False, coast=True)


def test_a_level_of_nothing_drives_nothing() -> None:
    run = of_program(Program((drive(0.0), drive(0.5), drive(-0.5))), ["speed"])
    assert run.levels == 2


def test_what_is_missing_is_what_is_not_told() -> None:
    known = Knowledge(("R", "K"), (), 4)
    assert known.missing == ("L", "B", "J", "T0")


def test_a_run_sees_motion_and_voltage_by_either_channel() -> None:
    for name, motion, volts in (
        ("speed", True, False), ("position", True, False), ("supply_voltage", False, True),
        ("terminal_voltage", False, True), ("current", False, False),
    ):  # fmt: skip
        run = Excitation(frozenset([name]))
        assert (run.sees_motion, run.sees_voltage) == (motion, volts)


@pytest.mark.parametrize("channels", [ALL, ELECTRICAL, frozenset(["speed"]), frozenset()])
@pytest.mark.parametrize("levels", [1, 3])
@pytest.mark.parametrize("transient", [True, False])
@pytest.mark.parametrize("coast", [True, False])
def test_the_advised_run_is_enough_and_no_part_of_it_can_be_spared(
    channels: frozenset[str], levels: int, transient: bool, coast: bool
) -> None:
    run = Excitation(channels, levels, transient, coast)
    said = advice(run)
    if not assess(run).missing:
        assert said == ""
        return
    parts = [name for name, words in ADDITIONS.items() if words in said]
    assert assess(identifiability._with(run, tuple(parts))).missing == ()
    for spared in parts:
        fewer = tuple(name for name in parts if name != spared)
        assert assess(identifiability._with(run, fewer)).missing


def test_a_coast_is_not_asked_for_where_something_cheaper_does() -> None:
    assert "coast-down" not in advice(Excitation(ALL, levels=1, transient=False, coast=False))


def test_more_channels_never_tell_less() -> None:
    fewer, more = assess(Excitation(ELECTRICAL)), assess(Excitation(ALL))
    assert set(fewer.parameters) <= set(more.parameters)
    assert more.null_directions <= fewer.null_directions
    assert more == Knowledge(("R", "L", "K", "B", "J", "T0"), (), 0)


def test_a_motor_without_dry_friction_is_assessed_by_a_typical_one() -> None:
    none = {**TYPICAL, "T0": 0.0}
    assert assess(Excitation(ALL), none).missing == ()


def test_an_electrical_run_changes_levels_and_a_mechanical_one_coasts() -> None:
    said = run_to_add(["R", "L"], 12.0, 0.05)
    assert said.startswith("A run such as 1.5e+02 ms at 12 V, 1.5e+02 ms at 4.8 V from rest")
    assert "determine R and L;" in said
    said = run_to_add(["J", "B", "T0"], 12.0, 0.4)
    assert "1.2 s at 6 V, 1.6 s at 12 V, 1.2 s of coasting from rest" in said
    assert "determine J, B and T0;" in said


def test_the_path_of_a_drive_is_the_matrix_exponential() -> None:
    m = TYPICAL
    steady, path = identifiability._driven(Excitation(ALL), m, m, 6.0, np.array([0.05, 10.0]))
    A = np.array([[-m["R"] / m["L"], -m["K"] / m["L"]], [m["K"] / m["J"], -m["B"] / m["J"]]])
    b = np.array([6.0 / m["L"], -m["T0"] / m["J"]])
    assert A @ steady + b == pytest.approx(0.0, abs=1e-6 * abs(b).max())
    for k in (0, 5, 20):
        wanted = steady + expm(A * TIMES_S[k]) @ (np.array([0.05, 10.0]) - steady)
        assert path[k] == pytest.approx(wanted)


def test_without_a_voltage_a_moved_motor_follows_the_true_ones_current() -> None:
    """The third state: its own K, J, B and T0, the current that was measured."""
    m, run = TYPICAL, Excitation(frozenset(["current", "speed"]))
    moved = {**m, "K": 1.3 * m["K"], "B": 2.0 * m["B"]}
    steady, path = identifiability._driven(run, m, moved, 6.0, np.zeros(3))
    assert steady[2] == pytest.approx((moved["K"] * steady[0] - m["T0"]) / moved["B"])
    assert path[0] == pytest.approx(0.0, abs=1e-9)
    torque = Excitation(frozenset(["torque", "speed"]))
    steady, _ = identifiability._driven(torque, m, moved, 6.0, np.zeros(3))
    assert steady[2] == pytest.approx((m["K"] * steady[0] - m["T0"]) / moved["B"])


def test_a_motor_breaks_away_where_its_current_overcomes_friction() -> None:
    m, moved = TYPICAL, {**TYPICAL, "T0": 2e-3}
    i, w = identifiability._breakaway(Excitation(ALL), m, moved)
    assert (i, w) == pytest.approx((2e-3 / m["K"], 0.0))
    i, w, other = identifiability._breakaway(Excitation(frozenset(["current"])), m, moved)
    assert (i, w, other) == pytest.approx((m["T0"] / m["K"], 0.0, 0.0))


def test_a_coast_is_the_law_until_the_motor_stops() -> None:
    m, start = TYPICAL, 300.0
    speed = identifiability._coasting(m, start)
    assert speed[0] == pytest.approx(start)
    stops_s = m["J"] / m["B"] * np.log1p(start * m["B"] / m["T0"])
    assert not speed[stops_s < TIMES_S].any()
    early = 0.5 * stops_s > TIMES_S
    rise = np.gradient(speed[early], TIMES_S[early])
    law = -(m["B"] * speed[early] + m["T0"]) / m["J"]
    assert rise[3:-3] == pytest.approx(law[3:-3], rel=0.02)
