"""The captures of a drawn rig, over its own wire in this process, and what was true as it ran."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bench.coverage.rigs import Bench
from motorid.acquire.record import capture_over
from motorid.capture import store
from motorid.capture.model import Capture
from motorid.sim.bench import COPPER_PER_K, MAGNET_PER_K
from motorid.sim.port import SimPort

REFERENCE_C = 25.0


@dataclass(frozen=True)
class Runs:
    """Captures, and the true R to T0 (SI) as run, with R_25 and K_25 at 25 °C."""

    captures: tuple[Capture, ...]
    truth: Mapping[str, float]
    winding_c: float


class Thermometer:
    """Watches the plant between stretches of samples: winding by I², magnets by time."""

    def __init__(self, bench: Any) -> None:
        self._bench, self._run = bench, bench.run
        self._rows: list[tuple[float, float, float]] = []
        bench.run = self._watched

    def _watched(self, samples: int) -> Any:
        before = (self._bench.plant.winding, self._bench.plant.housing)
        taken = self._run(samples)
        plant = self._bench.plant
        heat = len(taken[1]) * float(plant.current) ** 2
        winding, housing = (before[0] + plant.winding) / 2, (before[1] + plant.housing) / 2
        self._rows.append((heat, winding, housing))
        return taken

    def means(self) -> tuple[float, float]:
        """(winding, housing) in °C, each stretch by its current squared."""
        heat, winding, housing = np.array(self._rows).T
        return float(np.average(winding, weights=heat)), float(np.average(housing, weights=heat))


def record(bench: Bench, folder: Path) -> Runs:
    """Every run of the rig, one after the other. Raises what a user would meet."""
    port = SimPort(f"drawn {bench.seed}", bench.options)
    board: Any = port._device.board
    thermometer = Thermometer(board.bench)
    captures = []
    for number, rig in enumerate(bench.rigs):
        path = folder / f"rig{bench.seed}-{number}.h5"
        capture_over(port, rig, rig.program, path, force=True, checked=number > 0)
        captures.append(store.load(path))
        path.unlink()
    winding, housing = thermometer.means()
    return Runs(tuple(captures), truth_of(bench, winding, housing), winding)


def save(runs: Runs, folder: Path, seed: int) -> None:
    """Keeps the runs of a rig, so that another fit of them needs no simulation."""
    for number, capture in enumerate(runs.captures):
        store.save(capture, folder / f"{seed}-{number}.h5", force=True)
    facts = {"truth": dict(runs.truth), "winding_c": runs.winding_c, "runs": len(runs.captures)}
    (folder / f"{seed}.json").write_text(json.dumps(facts), encoding="utf-8")


def kept(folder: Path, seed: int) -> Runs | None:
    """What ``save`` kept of that rig."""
    path = folder / f"{seed}.json"
    if not path.exists():
        return None
    facts = json.loads(path.read_text(encoding="utf-8"))
    captures = tuple(store.load(folder / f"{seed}-{k}.h5") for k in range(facts["runs"]))
    return Runs(captures, facts["truth"], facts["winding_c"])


def truth_of(bench: Bench, winding_c: float, housing_c: float) -> dict[str, float]:
    """The measurands at these temperatures (SI)."""
    motor, options = bench.drawn.motor, bench.options
    R, K = motor.resistance_ohm, motor.torque_constant_nm_a
    turns = (2.0 * math.pi * options.pwm * options.eddy_time) ** 2  # L1 + L2 || Rc, at no current
    return {
        "R": R * (1 + COPPER_PER_K * (winding_c - REFERENCE_C)),
        "L": motor.inductance_h,
        "L_pwm": motor.inductance_h * (1.0 - options.eddy * turns / (1.0 + turns)),
        "K": K * (1 + MAGNET_PER_K * (housing_c - REFERENCE_C)),
        "B": motor.viscous_nm_s,
        "J": motor.inertia_kg_m2 + bench.drawn.load_inertia,
        "T0": motor.coulomb_nm,
        "R_25": R,
        "K_25": K,
    }
