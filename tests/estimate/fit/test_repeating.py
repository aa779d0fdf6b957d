"""Ripple, cogging and an encoder's error in the ordinary fit: found, harmless, and at no cost."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from motorid.acquire.record import capture as record
from motorid.capture import store
from motorid.capture.model import POSITION, Capture
from motorid.estimate.effects.influence_quantity import InfluenceQuantity
from motorid.estimate.effects.rotor.cogging import COGGING
from motorid.estimate.effects.rotor.encoder_error import ENCODER_ERROR
from motorid.estimate.effects.rotor.k_ripple import K_RIPPLE
from motorid.estimate.effects.rotor.r_ripple import R_RIPPLE
from motorid.estimate.effects.rotor.repeating import of_order, order
from motorid.estimate.fit.joint_fit import solved
from motorid.estimate.fit.repeating import is_heavy, with_repeating
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS, Estimate
from motorid.estimate.solver.problem import Solution
from motorid.program import Decay, Program, Step, StepKind
from motorid.rig import Sampling, load_rig
from motorid.sim import truth
from tests.six_parameters import fit

SLOW = Decay.SYNCHRONOUS_SLOW
DRIVES = tuple(Step(StepKind.DRIVE_VOLTS, 0.08, volts, SLOW) for volts in (2.0, 5.0))
PROGRAM = Program((Step(StepKind.COAST, 0.02), *DRIVES, Step(StepKind.COAST, 0.2)))
CHANNELS = ("current", "terminal_voltage", "position")
BARS = 10  # commutations a turn of the preset
T0_NM = 4.3e-4


def url(options: str) -> str:
    return f"{load_rig('sim').port}&speed=max&heating=0&stiction=1&{options}"


@cache
def taken(folder: Path, options: str) -> Capture:
    """A capture of the simulated rig."""
    rig = load_rig("sim")
    rig = replace(rig, port=url(options), program=PROGRAM, sampling=Sampling(5000.0, CHANNELS))
    return store.load(record(rig, rig.program, folder / "run.h5", force=True))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("repeating")


@cache
def found(folder: Path, options: str) -> tuple[MotorRecord, Solution]:
    records, solution = solved([taken(folder, options)], {}, ())
    return records[0], solution


def amplitude(
    record: MotorRecord, solution: Solution, quantity: InfluenceQuantity, periods: int, k: int = 0
) -> float:
    """Of a quantity; 0 where it is no unknown."""
    sizes = dict(zip(record.instances, solution.own[k].tolist(), strict=True))
    return math.hypot(*(sizes.get(one, 0.0) for one in of_order(quantity, periods)))


def missed(estimate: Estimate, options: str) -> list[str]:
    """Parameters whose intervals do not hold the truth."""
    true = truth(url(options))
    ends = {n: p.interval_95 for n, p in estimate.parameters.items()}
    return [n for n, pair in ends.items() if pair and not pair[0] <= true[n] <= pair[1]]


@pytest.mark.slow
def test_commutation_ripple_is_found_by_its_size(folder: Path) -> None:
    record, solution = found(folder, "seed=4&ripple=0.02")
    assert {order(one) for one in record.repeating.slopes} == {BARS}
    assert amplitude(record, solution, K_RIPPLE, BARS) == pytest.approx(0.02, rel=0.03)
    assert amplitude(record, solution, R_RIPPLE, BARS) == pytest.approx(0.02, rel=0.15)
    assert amplitude(record, solution, COGGING, BARS) < 0.05 * T0_NM
    assert not is_heavy([record], solution)


@pytest.mark.slow
def test_ripple_neither_warns_nor_biases(folder: Path) -> None:
    options = "seed=6&ripple=0.02"
    estimate = fit([taken(folder, options)], model="auto")
    assert [d for d in estimate.diagnostics if d.severity != "info"] == []
    assert [s.code for s in estimate.suspects if s.strength == "named"] == []
    assert estimate.alternative is None
    assert missed(estimate, options) == []
    said = next(d.message for d in estimate.diagnostics if d.code == "repeats_with_angle")
    assert f"{BARS} a turn" in said
    assert "ripple of K 2 %" in said


@pytest.mark.slow
def test_ripple_moves_no_interval(folder: Path) -> None:
    """Beside the same capture without it: neither values nor widths know of it."""
    (_, rippled), (_, still) = (found(folder, f"seed=4&ripple={k}") for k in (0.02, 0.0))
    wide, narrow = (np.sqrt(np.diag(s.covariance)) for s in (rippled, still))
    assert wide == pytest.approx(narrow, rel=0.3)
    relative = [unknown.log for unknown in still.unknowns]  # R, L, K, J
    moved = np.log(rippled.values[relative] / still.values[relative])
    assert np.abs(moved / narrow[relative]).max() < 5.0


@pytest.mark.slow
def test_cogging_is_found_by_its_size(folder: Path) -> None:
    torque = 0.5 * T0_NM
    record, solution = found(folder, f"seed=4&cogging={torque}&cogging_per_turn=7")
    places = [record.instances.index(one) for one in of_order(COGGING, 7)]
    deviation = float(np.sqrt(np.diag(solution.own_covariance[0])[places].mean()))
    assert deviation < 0.1 * torque
    assert amplitude(record, solution, COGGING, 7) == pytest.approx(torque, abs=4.0 * deviation)
    assert amplitude(record, solution, K_RIPPLE, 7) < 2e-3


@pytest.mark.slow
def test_an_eccentric_encoder_is_found_by_its_size(folder: Path) -> None:
    clean = taken(folder, "seed=4&ripple=0.0")
    position, error = clean.channels[POSITION], 0.03  # rad
    turned = position.values + error * np.cos(position.values + 1.0)
    raw = np.round(turned / position.scale + position.offset).astype(np.asarray(position.raw).dtype)
    capture = replace(clean, channels={**clean.channels, POSITION: replace(position, raw=raw)})
    records, solution = solved([capture], {}, ())
    assert amplitude(records[0], solution, ENCODER_ERROR, 1) == pytest.approx(error, rel=0.03)
    _, still = found(folder, "seed=4&ripple=0.0")
    assert solution.values[:5] == pytest.approx(still.values[:5], rel=5e-3)


@pytest.mark.slow
def test_nothing_is_simulated_where_nothing_repeats(folder: Path) -> None:
    record, solution = found(folder, "seed=4&ripple=0.0")
    assert not record.repeating.slopes
    before = record.simulated
    assert with_repeating([record], solution) is None
    assert record.simulated <= before + 1  # where the rotor is


@pytest.mark.slow
def test_each_run_has_a_phase_of_its_own(folder: Path) -> None:
    captures = [taken(folder, f"seed={seed}&ripple=0.02") for seed in (4, 5)]
    records, solution = solved(captures, {}, ())
    for k, run in enumerate(records):
        size = amplitude(run, solution, K_RIPPLE, BARS, k)
        assert size == pytest.approx(0.02, rel=0.03)


@pytest.mark.slow
def test_a_heavy_ripple_is_for_a_wider_model_too(folder: Path) -> None:
    run, solution = found(folder, "seed=4&ripple=0.08")
    assert amplitude(run, solution, K_RIPPLE, BARS) == pytest.approx(0.08, rel=0.05)
    assert is_heavy([run], solution)


@pytest.mark.slow
def test_a_model_that_is_asked_for_still_finds_its_ripple(folder: Path) -> None:
    options = "seed=4&ripple=0.02"
    estimate = fit([taken(folder, options)], model="ripple")
    assert estimate.alternative is not None
    assert estimate.alternative.parameters["k_K"].value == pytest.approx(0.02, rel=0.05)
    assert set(PARAMETERS) <= set(estimate.alternative.parameters)
