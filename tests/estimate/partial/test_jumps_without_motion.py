"""A log of voltage and current whose voltage jumps anywhere between two rows.

The motor is integrated in small steps by a program that shares nothing with the fit.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bench.foreign.plant import STEP_S, Motor, turn
from motorid.capture.model import Capture
from motorid.capture.table import read_table
from tests.six_parameters import fit

MOTOR, PERIOD_S = Motor(), 1e-3
JUMPS_S = (0.0203, 0.2517, 0.4831, 0.7362, 0.9685)  # each elsewhere between its rows
LEVELS = (0.0, 6.0, 3.0, -6.0, -3.0, 4.5)


def logged(folder: Path) -> Capture:
    """Rows of instants; the current of nine of them shows how far it had risen."""
    true = turn(MOTOR, lambda t, w: LEVELS[int(np.searchsorted(JUMPS_S, t))], 1.2)
    rng = np.random.default_rng(7)
    stamps = np.arange(0.005, 1.19, PERIOD_S)
    at = np.rint(stamps / STEP_S).astype(int)
    table = [stamps]
    for series in (true.volts, true.current):
        table.append(series[at] + 1e-3 * np.abs(series).max() * rng.standard_normal(len(at)))
    rows = "\n".join(",".join(f"{x:.7g}" for x in row) for row in np.column_stack(table))
    path = folder / "log.csv"
    path.write_text(f"t,v,i\n{rows}\n", encoding="utf-8")
    return read_table(path, ["time=t:s", "voltage=v:V", "current=i:A"])


@pytest.mark.slow
def test_the_moments_of_jumps_are_unknowns_without_a_motion_too(tmp_path: Path) -> None:
    """One lag of all of them left L open to a fifth, and a lack of fit after each."""
    found = fit([logged(tmp_path)])
    assert "lack_of_fit" not in [d.code for d in found.diagnostics]
    for name, width in (("R", 0.005), ("L", 0.1)):
        p = found.parameters[name]
        assert p.value is not None
        assert p.total is not None
        assert abs(p.value - getattr(MOTOR, name)) < 3.0 * p.total
        assert p.total < width * p.value
    one, expected = found.combinations["J/K²"], MOTOR.J / MOTOR.K**2
    assert one.value is not None
    assert one.total is not None
    assert abs(one.value - expected) < 3.0 * one.total
