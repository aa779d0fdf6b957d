"""Logs of a rotor that stands still: said at once, with R and L where the current tells them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bench.foreign import cases
from bench.foreign.plant import Drive, turn
from motorid.capture.model import Capture
from motorid.capture.table import read_table
from motorid.errors import DataError
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.partial.locked_rotor import is_noise
from motorid.identify import fit

HELD = replace(cases.MOTOR, T0=10.0)
MOST = 20_000  # evaluations; a fit of all six takes more


def log(folder: Path, drive: Callable[[], Drive], columns: str = "viw") -> Capture:
    """What a busy PC logs of a rotor that is held."""
    rng = np.random.default_rng(1)
    true = turn(HELD, drive(), cases.LENGTH_S)
    stamps = cases.at_random(rng)
    truths = {"v": true.volts, "i": true.current, "w": true.speed}
    table = {"t": stamps}
    for name in columns:
        noise = cases.NOISE[name] * rng.standard_normal(len(stamps))
        table[name] = true.at(truths[name], stamps) + noise
    path = folder / "log.csv"
    rows = np.column_stack(list(table.values()))
    np.savetxt(path, rows, delimiter=",", header=",".join(table), comments="", fmt="%.7g")
    return read_table(path, ["time=t:s", *(cases.MAPS[c] for c in columns)])


@pytest.fixture
def responses(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """One entry for every evaluation of a record's model."""
    seen: list[int] = []
    fitted = MotorRecord.fitted

    def counted(record: MotorRecord, *given):  # type: ignore[no-untyped-def]
        seen.append(1)
        return fitted(record, *given)

    monkeypatch.setattr(MotorRecord, "fitted", counted)
    return seen


def test_a_motor_that_was_never_driven_tells_nothing_and_soon(
    tmp_path: Path, responses: list[int]
) -> None:
    with pytest.raises(DataError, match="determine nothing: nothing shows that the rotor turned"):
        fit([log(tmp_path, lambda: lambda t, w: 0.0)], model="auto")
    assert not responses


@pytest.mark.slow
def test_a_rotor_that_is_held_tells_resistance_and_inductance(
    tmp_path: Path, responses: list[int]
) -> None:
    found = fit([log(tmp_path, cases.steps)], model="auto")
    for name in ("R", "L"):
        low, high = found.parameters[name].interval_95 or (0.0, 0.0)
        assert low < getattr(HELD, name) < high
    assert {found.parameters[n].status for n in ("K", "B", "J", "T0")} == {"not_identifiable"}
    assert found.diagnostics[0].code == "rotor_held"
    assert len(responses) < MOST


def test_motion_in_noise_shows_in_means() -> None:
    noise = np.random.default_rng(2).standard_normal(2000)
    assert is_noise(noise, origin=False)
    assert is_noise(noise + 5.0, origin=True)
    assert not is_noise(noise + 0.2, origin=False)
    assert not is_noise(noise + np.where(np.arange(2000) % 500 < 250, 0.3, -0.3), origin=False)
    assert not is_noise(np.zeros(2000), origin=False)
