"""Programs for a rotor that is held: who says so, what heat is allowed, and a rotor that is not."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motorid.acquire import held_rotor, record
from motorid.acquire.held_program import refuse_held
from motorid.acquire.safety import check_program
from motorid.capture import store
from motorid.errors import RigError, UsageError
from motorid.excitation import Levels, prbs
from motorid.program import Decay, Program, Rotor, Step, StepKind
from motorid.rig import Rig
from tests.acquire.rigs import sim_rig

LEVELS = Levels(StepKind.DRIVE_VOLTS, 0.0, 5.0)
HEAT_J = 25.0 / 2.6 * 0.05  # of 5 V at 2.6 ohm for 50 ms
REST = Step(StepKind.COAST, 0.005)


def held(rotor: Rotor = Rotor.CLAMPED, energy_j: float = 1.0, levels: Levels = LEVELS) -> Program:
    return Program((REST, *prbs(levels, 4, 0.05)), rotor, energy_j)


def rig(options: str = "", program: Program | None = None) -> Rig:
    return sim_rig(options, program=program or held())


def travel(path: Path) -> float:
    """Turns between the furthest positions of a capture."""
    return float(np.ptp(store.load(path).channels["position"].values)) / (2 * np.pi)


def test_nobody_said_that_the_rotor_is_held(tmp_path: Path) -> None:
    asked = held(Rotor.ASK)
    with pytest.raises(UsageError, match="nobody said that it is: clamp it and give --clamped"):
        record.capture(rig("clamped=1"), asked, tmp_path / "run.h5")
    assert not list(tmp_path.iterdir())


def test_the_heat_is_bounded() -> None:
    check_program(rig(), held(energy_j=1.001 * HEAT_J))
    with pytest.raises(RigError, match=r"could give the winding 0\.481 J .* program.energy_j is"):
        check_program(rig(), held(energy_j=0.999 * HEAT_J))


def test_the_smaller_resistance_counts() -> None:
    program = held(energy_j=1.5 * HEAT_J)
    check_program(rig(), program, resistance_ohm=2.6 / 1.4)
    with pytest.raises(RigError, match=r"through 1\.62 ohm"):
        check_program(rig(), program, resistance_ohm=2.6 / 1.6)


def test_a_reversal_draws_no_more_than_a_start() -> None:
    """A rotor that stands has no back-EMF: 5 V after -5 V are 1.92 A, within 3.2 A."""
    check_program(rig(), held())
    with pytest.raises(RigError, match="could draw"):
        check_program(rig(), replace(held(), rotor=Rotor.FREE, energy_j=None))


@pytest.mark.slow
def test_a_clamped_rotor_is_captured_and_says_so(tmp_path: Path) -> None:
    path = record.capture(rig("clamped=1"), held(), tmp_path / "run.h5")
    capture = store.load(path)
    assert capture.end_reason == "completed"
    assert capture.program == held()
    assert travel(path) == 0.0
    bound = capture.provenance["check"]["resistance_bound_ohm"]
    assert bound == pytest.approx(2.7, rel=0.1)  # R and the bridge


@pytest.mark.parametrize("seed", range(3))
def test_a_free_rotor_is_found_by_the_weak_pulse(tmp_path: Path, seed: int) -> None:
    with pytest.raises(RigError, match=r"the rotor is not held: it moves by -?\d+ counts at 10%"):
        record.capture(rig(f"seed={seed}"), held(), tmp_path / "run.h5")
    assert not list(tmp_path.iterdir())


# friction holds the weak pulse (10 % of 7 V: 0.27 A), and not the program
STICKY = "friction=7"


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_the_board_stops_a_rotor_that_breaks_loose(tmp_path: Path, seed: int) -> None:
    path = tmp_path / "run.h5"
    with pytest.raises(RigError, match="the rotor moved, and the board opened the bridge: clamp"):
        record.capture(rig(f"{STICKY}&seed={seed}"), held(), path)
    assert store.load(path).end_reason == "fault: over_speed"
    assert travel(path) < 2 * held_rotor.TRAVEL


@pytest.mark.slow
def test_the_host_stops_a_rotor_that_creeps(tmp_path: Path) -> None:
    """Slower than the board's window shows: 3 rad/s are 1 count a millisecond."""
    slow = Levels(StepKind.DRIVE_VOLTS, 0.0, 1.3)
    creep = Program((REST, slow.steps((1.0,), 3.0)[0]), Rotor.CLAMPED, 10.0)
    path = tmp_path / "run.h5"
    options = "friction=7&load_inertia=1e-4"
    with pytest.raises(RigError, match=r"the rotor crept by -?\d+ counts and the run was stopped"):
        record.capture(rig(options, creep), creep, path)
    assert travel(path) < 10 * held_rotor.TRAVEL


def test_a_dead_motor_is_no_clamped_one(tmp_path: Path) -> None:
    with pytest.raises(RigError, match="the motor draws"):
        record.capture(rig("clamped=1&fault=current_dead"), held(), tmp_path / "run.h5")


def test_the_limit_is_the_allowed_counts_in_the_board_s_window() -> None:
    bench = rig()
    identity = {"clock_hz": 16_000_000, "encoder_edge_ceiling_hz": 2_000_000}
    for period in (800, 1600, 16_000, 160_000):
        limit = held_rotor.board_limit(bench, identity, period)["speed_limit_counts_s"]
        samples = min(max(round(2e-3 * 16e6 / period), 1), 15)
        in_window = int(limit * samples * period / 16_000_000)
        assert in_window == held_rotor.allowed_counts(bench) == 5


def test_the_rig_s_own_limit_stays_where_it_is_lower() -> None:
    bench = rig()
    slow = replace(bench, limits=replace(bench.limits, speed_rad_s=2.0))
    identity = {"clock_hz": 16_000_000, "encoder_edge_ceiling_hz": 2_000_000}
    limit = held_rotor.board_limit(slow, identity, 1600)["speed_limit_counts_s"]
    assert limit == round(2.0 / (2 * np.pi) * 2048)


def test_what_has_no_limit_on_motion_refuses_such_a_program() -> None:
    with pytest.raises(UsageError, match="the scope does not stop one that moves"):
        refuse_held(held(), "the scope")
    refuse_held(Program((Step(StepKind.DRIVE_VOLTS, 1.0, 1.0, Decay.SYNCHRONOUS_SLOW),)), "it")
