"""The batch kernels give the same bits with each set of instructions that the processor has."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from motorid.motor._batch import lib

from motorid.motor.batch import FRICTION, LINEAR, Model, Record, quadratic

MOTOR = {"R": 3.1363, "L": 0.01307, "K": 0.048774, "B": 1.69e-4, "J": 9e-6}
LOADED = {"R": 42.5, "L": 8e-2, "c": 0.4781, "J": 2e-5, "Ta": 1e-2, "Tb": 3.27e-5, "Tc": 8.55e-8}
CASES = {
    "linear": (LINEAR, MOTOR),
    "friction": (FRICTION, {**MOTOR, "T0": 2e-3}),
    "quadratic": (quadratic(4), LOADED),
}
SAMPLES, CANDIDATES = 700, 61  # not a whole number of lanes


@pytest.fixture(autouse=True)
def _as_found() -> Iterator[None]:
    yield
    lib.batch_instructions(1)


def case(name: str) -> tuple[Model, np.ndarray, Record]:
    """Candidates spread about a motor, and a noisy record with a reading that is missing."""
    model, values = CASES[name]
    rng = np.random.default_rng(5)
    spread = rng.uniform(0.6, 1.6, (CANDIDATES, len(values)))
    drive = np.repeat([8.0, -3.0, 0.02, 12.0, 0.0], SAMPLES // 5)
    measured = {"current": rng.normal(0, 1, SAMPLES), "speed": rng.normal(0, 50, SAMPLES)}
    measured["current"][17] = np.nan
    opened = None if name == "quadratic" else np.arange(SAMPLES) >= 6 * SAMPLES // 7
    return (
        model,
        np.array(list(values.values())) * spread,
        Record(1e-3, drive, measured, open=opened),
    )


@pytest.mark.parametrize("name", CASES)
def test_avx2_gives_the_bits_of_any_processor(name: str) -> None:
    model, candidates, record = case(name)
    assert lib.batch_instructions(0) == 0
    squares, outputs = model.squares(candidates, record), model.outputs(candidates[:9], record)
    lib.batch_instructions(1)  # where the processor has it; else the same once more
    np.testing.assert_array_equal(model.squares(candidates, record), squares)
    np.testing.assert_array_equal(model.outputs(candidates[:9], record), outputs)
    assert np.isfinite(squares).all()
    assert np.ptp(squares[:, 0]) > 0
