"""Motors identified through the real firmware, beside the simulated board and the truth."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import motorid
from motorid.estimate.results.estimate import Estimate
from motorid.program import Program
from motorid.sim.motor import find_motor
from motorid.workflow.record import bench, capture_runs

# electrical time constants of 0.28 to 1.6 ms: a window is 0.25 ms
MOTORS = ("dunkermotoren-gr42", "maxon-re35", "pittman-14204s004")
NAMES = ("R", "L", "K", "B", "J", "T0")
MOST = {"R": 0.02, "L": 0.05, "K": 0.02, "B": 0.05, "J": 0.02, "T0": 0.05}
COUNTS_PER_TURN = 256
RATE_HZ = 4000.0
SURE = 1.96
MOST_A = 50.0  # that any board accepts as a limit
EXACT = "&gain_error=0&voltage_gain_error=0&offset_error=0&clock_ppm=0&noise=0.3"


@dataclass(frozen=True)
class Figure:
    """One parameter of one run: its true value, the estimate, half of its 95 % interval."""

    truth: float
    value: float
    half: float

    @property
    def error(self) -> float:
        """Relative."""
        return self.value / self.truth - 1

    @property
    def relative_half(self) -> float:
        """The interval's half width, relative."""
        return self.half / self.truth


def rig_text(board: str, motor: str, seed: int, more: str = "", rate_hz: float = RATE_HZ) -> str:
    """A rig file: the motor does not warm up, so that R and K have one true value each.

    ``more``: further options of the URL.
    """
    name, m = find_motor(motor)
    scheme = "sim://" if board == "sim" else f"emu://{board}"
    options = f"motor={name}&heating=0&ambient=25&counts_per_turn={COUNTS_PER_TURN}&seed={seed}"
    options += f"{more}&speed=max"
    return f"""
name = "{board}-{name}"
port = "{scheme}?{options}"
[wiring]
counts_per_turn = {COUNTS_PER_TURN}
bridge_resistance_ohm = {2 * m.switch_resistance_ohm}
bridge_resistance_uncertainty_ohm = {0.2 * m.switch_resistance_ohm}
voltage_sense = "terminals"
supply_voltage_v = {m.supply_v}
[limits]
current_a = {min(1.05 * m.supply_v / m.resistance_ohm, MOST_A):.3f}
speed_rad_s = {1.05 * m.supply_v / m.torque_constant_nm_a:.1f}
supply_min_v = {0.66 * m.supply_v:.2f}
supply_max_v = {1.2 * m.supply_v:.2f}
run_time_s = 20
[nameplate]
voltage_v = {m.voltage_v}
resistance_ohm = {m.resistance_ohm}
inductance_h = {m.inductance_h}
torque_constant_nm_a = {m.torque_constant_nm_a}
inertia_kg_m2 = {m.inertia_kg_m2}
[sampling]
rate_hz = {rate_hz}
channels = ["current", "terminal_voltage", "position"]
[conditions]
ambient_c = 25
ambient_uncertainty_c = 1
"""


def shortened(program: Program, share: float) -> Program:
    """The same steps, each so much of its time: an emulated second takes about as long to run."""
    return Program(tuple(replace(s, duration_s=share * s.duration_s) for s in program.steps))


def truth(motor: str) -> dict[str, float]:
    """What the plant was given."""
    m = find_motor(motor)[1]
    values = (
        m.resistance_ohm,
        m.inductance_h,
        m.torque_constant_nm_a,
        m.viscous_nm_s,
        m.inertia_kg_m2,
        m.coulomb_nm,
    )
    return dict(zip(NAMES, values, strict=True))


def fitted(
    folder: Path,
    board: str,
    motor: str,
    seed: int = 1,
    more: str = "",
    rate_hz: float = RATE_HZ,
) -> Estimate:
    """Capture one run and fit it, as ``motorid run`` does; ``more`` as in ``rig_text``."""
    path = folder / f"{board}-{motor}.toml"
    path.write_text(rig_text(board, motor, seed, more, rate_hz), encoding="utf-8")
    (capture,) = capture_runs(bench(str(path)), folder / f"{board}-{motor}.h5")
    return motorid.fit(capture)


def figures(motor: str, estimate: Estimate) -> dict[str, Figure]:
    """Its six parameters beside the truth."""
    found = estimate.parameters
    return {
        name: Figure(true, found[name].value, SURE * found[name].total)
        for name, true in truth(motor).items()
    }


def identify(
    folder: Path,
    board: str,
    motor: str,
    seed: int = 1,
    more: str = "",
    rate_hz: float = RATE_HZ,
) -> dict[str, Figure]:
    """The same of a run, as ``fitted`` captures it."""
    return figures(motor, fitted(folder, board, motor, seed, more, rate_hz))
