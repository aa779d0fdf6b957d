"""Each defect that a line looks for is found, by the limit that is meant to find it."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from typing import Any

import pytest

import motorid
from motorid.quality.judge import judge
from motorid.quality.product import Product
from motorid.quality.quantities import QUANTITIES, Context
from motorid.quality.ripple import segment_ripple, turn_torque, windows
from motorid.quality.verdict import Outcome
from motorid.rig import load_rig
from motorid.workflow.check import judge_files

six = partial(motorid.fit, model="six")  # as a station fits

DEFECTS = [
    ("magnet=0.93", {"K_25"}, {"R_25", "T0"}),
    ("friction=1.6", {"T0"}, {"R_25", "K_25", "J"}),
    ("shorted_turn=0.05", {"ripple_segment", "B"}, {"K_25", "J"}),
    ("winding=1.06", {"R_25", "K_25"}, {"T0", "J"}),
    ("unbalance=1e-4", {"unbalance"}, {"R_25", "K_25", "J", "ripple_segment"}),
    ("cogging=4e-3", {"cogging"}, {"R_25", "K_25", "J", "ripple_segment"}),
    ("brush_bounce=0.5", {"brush_noise"}, {"K_25", "J"}),
    ("coupling=1e-3", {"shape_position", "friction_turn"}, {"R_25", "K_25"}),
    ("copper=1.1", {"R_25"}, {"K_25", "T0", "J"}),
    ("asymmetry=0.1", {"direction_current"}, {"R_25", "K_25", "J", "ripple_segment"}),
    ("asymmetry=-0.3", {"direction_current", "direction_speed"}, {"R_25", "K_25"}),
]


QUICK = DEFECTS[:2]  # the same course as the others'
CASES = [
    pytest.param(*one, id=one[0], marks=() if one in QUICK else pytest.mark.slow) for one in DEFECTS
]


@pytest.mark.slow
@pytest.mark.parametrize(("options", "found", "good"), CASES)
def test_a_defect_is_found(
    measure: Any, product: Product, options: str, found: set[str], good: set[str]
) -> None:
    verdict, _ = judge_files([measure(options)], product)
    assert verdict.outcome is Outcome.FAIL
    failed = {m.quantity for m in verdict.measurements if m.outcome is Outcome.FAIL}
    assert found <= failed
    assert not good & failed


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 3, 4])
def test_good_motors_pass_whatever_the_noise(measure: Any, product: Product, seed: int) -> None:
    verdict, _ = judge_files([measure(f"seed={seed}")], product)
    assert verdict.outcome is Outcome.PASS, verdict.reasons


@pytest.mark.slow
def test_the_unbalance_is_measured_right(measure: Any) -> None:
    estimate = six(measure("unbalance=1e-4"))
    K, J = (estimate.parameters[n].value for n in ("K", "J"))
    assert K is not None
    assert J is not None
    found = turn_torque(windows(estimate), K, J)
    assert found.unbalance == pytest.approx(1e-4, abs=4 * found.unbalance_sd)
    assert found.unbalance_sd < 1e-5


@pytest.mark.slow
def test_commutation_ripple_is_measured_right(measure: Any, product: Product) -> None:
    estimate = six(measure("ripple=0.02"))
    verdict = judge(estimate, product)
    value = verdict["ripple_commutation"].reading.value
    # K and R ripple together, so all of the voltage does, and drives a current through winding and
    # bridge; what that does to dead time and supply is the rig's, not the motor's
    speed = max(abs(row.speed_rad_s or 0.0) for row in estimate.steady)
    ohms = 2.6 + (load_rig("sim-line").wiring.bridge_resistance_ohm or 0.0)
    impedance = math.hypot(ohms, speed * product.commutations_per_turn * 180e-6)
    assert value == pytest.approx(0.02 * 2.6 / impedance, rel=0.02)
    assert verdict["ripple_segment"].outcome is Outcome.PASS


@pytest.mark.slow
def test_the_short_is_in_its_segment(measure: Any) -> None:
    """The ripple of a fifth of a turn, found as such: other divisions see it less."""
    estimate = six(measure("shorted_turn=0.05"))
    found, R = windows(estimate), estimate.parameters["R"].value
    assert R is not None
    ripple, deviation, _ = segment_ripple(found, R, 5)
    assert ripple > 10 * deviation
    assert segment_ripple(found, R, 2)[0] < ripple


@pytest.mark.slow
def test_a_warm_up_is_kept_and_not_judged(product: Product, line_rig: Any, tmp_path: Path) -> None:
    from dataclasses import replace

    from motorid.workflow.check import Line

    warm = replace(product, warm_up=product.program)
    with Line(line_rig, warm, tmp_path) as line:
        done = line.inspect("D000009")
    assert done.verdict.outcome is Outcome.PASS, done.verdict.reasons
    assert done.folder is not None
    assert (done.folder / "warm-up.h5").exists()
    assert len(done.verdict.inputs) == 1


@pytest.mark.slow
@pytest.mark.parametrize("size", [3e-3, 4e-3])
def test_cogging_is_measured_right(measure: Any, product: Product, size: float) -> None:
    estimate = six(measure(f"cogging={size}"))
    (found,) = estimate.repeating
    assert (found.quantity, found.per_turn) == ("cogging torque", 10)
    read = QUANTITIES["cogging"].read(Context(estimate, product))
    assert read.uncertainty is not None
    assert read.value == found.amplitude == pytest.approx(size, abs=2 * read.uncertainty)
    assert read.uncertainty < 0.02 * size
    assert "10 times a turn" in read.note
