"""The study's linearised bound against the simulated plant, and a whole record of a rig."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.coverage.bound import BRUSH, Brush, Twin, linearised
from bench.coverage.rigs import NEUTRAL, Bench, draw_bench
from bench.coverage.runs import record
from bench.coverage.score import How, score
from motorid.capture.model import CURRENT, POSITION

SEED = 20  # synchronous decay, voltage at the terminals, L/R of several samples
CHANGE = {"R": 0.02, "K": 0.02, "J": 0.02, "T0": 0.1}  # well above a count of the converter
FIELDS = {
    "R": "resistance_ohm",
    "K": "torque_constant_nm_a",
    "J": "inertia_kg_m2",
    "T0": "coulomb_nm",
}


def quiet(bench: Bench, **motor: float) -> Bench:
    """The same rig without noise or errors, around a changed motor."""
    own = replace(bench.drawn.motor, **motor)
    options = replace(
        bench.options, own=own, noise=0.0, gain_error=0.0, voltage_gain_error=0.0,
        offset_error=0.0, clock_ppm=0.0, bits=15, delay_uncertainty=0.0, load_inertia=0.0,
        supply_resistance=0.0, supply_capacitance=0.0, ambient=25.0,
    )  # fmt: skip
    return replace(bench, options=options, drawn=replace(bench.drawn, motor=own, load_inertia=0.0))


@pytest.mark.slow
@pytest.mark.parametrize("name", list(FIELDS))
def test_the_bounds_derivatives_are_the_plants(name: str, tmp_path: Path) -> None:
    bench = draw_bench(SEED, tuple(NEUTRAL))
    value, change = getattr(bench.drawn.motor, FIELDS[name]), CHANGE[name]
    up = record(quiet(bench, **{FIELDS[name]: value * (1 + change)}), tmp_path)
    down = record(quiet(bench, **{FIELDS[name]: value * (1 - change)}), tmp_path)
    middle = record(quiet(bench), tmp_path)
    capture = middle.captures[0]
    bridge = bench.options.bridge_resistance or 0.0
    twin = Twin(capture, middle.truth, bridge, Brush(), {})
    high, low = twin.readings({name: change}), twin.readings({name: -change})
    for channel in (CURRENT, POSITION):
        plant = up.captures[0].channels[channel].values - down.captures[0].channels[channel].values
        model = high[channel] - low[channel]
        plant = plant - plant[0]
        scale = float(plant @ model) / float(model @ model)
        left = plant - model
        assert scale == pytest.approx(1.0, abs=0.05), (name, channel)
        assert np.sqrt(np.mean(left**2)) < 0.1 * np.sqrt(np.mean(plant**2)), (name, channel)


@pytest.mark.slow
def test_a_prior_that_is_wider_never_narrows_the_bound(tmp_path: Path) -> None:
    runs = record(draw_bench(SEED), tmp_path)
    sharp = linearised(runs.captures, runs.truth).bound(without=BRUSH)
    current = [replace(c.channels[CURRENT], gain_uncertainty=0.05) for c in runs.captures]
    loose_captures = [
        replace(c, channels={**c.channels, CURRENT: i})
        for c, i in zip(runs.captures, current, strict=True)
    ]
    at = linearised(loose_captures, runs.truth)
    loose, with_drop = at.bound(without=BRUSH), at.bound()
    assert all(loose[name] >= sharp[name] * (1 - 1e-3) for name in sharp)
    assert all(with_drop[name] >= loose[name] * (1 - 1e-3) for name in loose)
    # torque, and so inertia and friction, scale with the current's gain as a whole
    assert loose["J"] == pytest.approx(0.05, rel=0.02)
    assert loose["T0"] == pytest.approx(0.05, rel=0.05)


@pytest.mark.slow
def test_a_record_says_what_was_true_and_what_was_said(tmp_path: Path) -> None:
    row = score(SEED, How(tmp_path))
    json.dumps(row, allow_nan=False)
    assert "crashed" not in row
    assert "refused" not in row
    for which in ("fit", "naive"):
        parameters: dict[str, Any] = row[which]["parameters"]
        low, high = parameters["J"]["interval"]
        assert parameters["J"]["holds"] == (low <= 0 <= high)
        assert abs(parameters["J"]["off"]) < 0.2
    naive, fitted = (row[which]["parameters"]["J"]["instrument"] for which in ("naive", "fit"))
    assert 0 <= naive < fitted  # what no instrument causes is in both: effects that were not found
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_kept_captures_are_fitted_as_new_ones(tmp_path: Path) -> None:
    how = How(tmp_path, ("fit",), keep=True)
    new, again = score(SEED, how), score(SEED, how)
    assert len(list(tmp_path.iterdir())) == 4
    for row in (new, again):
        del row["fit"]["seconds"]
    assert new == again
    assert "bound" not in new
