"""Logs such as other people make, each with one awkward habit, and what is true of the motor."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.foreign.plant import Drive, Motor, Trace, turn

Floats = NDArray[np.float64]
Rng = np.random.Generator

MOTOR = Motor()
LENGTH_S, PERIOD_S = 2.0, 1e-3
NOISE = {"v": 0.01, "i": 5e-3, "w": 0.1}  # V, A, rad/s
ALL = ("R", "L", "K", "B", "J", "T0")
MOTIONLESS = ("R", "L", "J/K²", "B/K²", "T0/K")
MAPS = {
    "v": "voltage=v:V", "i": "current=i:A", "w": "speed=w:rad/s", "u": "command=u:V",
}  # fmt: skip


@dataclass(frozen=True)
class Case:
    """One log: how the motor was driven, when it was read, and what was done to the readings.

    ``options`` are those of the import; ``fix`` of the fit; ``told`` the parameters or combinations
    that the fit must give.
    """

    name: str
    drive: Callable[[], Drive]
    columns: str = "viw"
    stamps: Callable[[Rng], Floats] = lambda rng: regular(PERIOD_S)
    spoil: Callable[[dict[str, Floats], Rng], None] = lambda table, rng: None
    options: Mapping[str, Any] = field(default_factory=dict)
    fix: Mapping[str, float] = field(default_factory=dict)
    told: Sequence[str] = ALL
    begins: float = 0.0  # rad/s
    runs: int = 1
    behind_ohm: float = 0.0  # between the voltage that is logged and the motor
    late_s: float = 0.0  # by which every column but the voltage is logged late, run by run more


def regular(period_s: float) -> Floats:
    """Stamps of a good clock."""
    return np.arange(0.005, LENGTH_S - 0.05, period_s)


def steps() -> Drive:
    """Rest, levels both ways, and a stop."""
    levels = (0.0, 6.0, 3.0, -6.0, -3.0, 4.5, 0.0)
    return lambda t, w: levels[min(int(t / 0.3), 6)]


def prbs() -> Drive:
    """Two levels that alternate at random, every 7 ms."""
    bits = np.random.default_rng(7).integers(0, 2, 1000)
    return lambda t, w: 6.0 if bits[int(t / 7e-3)] else -4.0


def ramp() -> Drive:
    """Up, down, and the other way."""
    return lambda t, w: 7.0 * math.sin(2 * math.pi * 0.6 * t) * abs(math.sin(0.7 * t + 0.4))


def chirp() -> Drive:
    """A sweep from 0.5 to 60 Hz about a level."""
    return lambda t, w: 2.0 + 5.0 * math.sin(2 * math.pi * (0.5 * t + 15.0 * t * t))


def closed_loop() -> Drive:
    """A speed loop at 1 kHz that follows steps, with a voltage held between its ticks."""
    state = {"tick": -1, "sum": 0.0, "v": 0.0}
    targets = (0.0, 80.0, 30.0, -60.0, -90.0, 50.0, 0.0)

    def volts(t: float, w: float) -> float:
        tick = round(t / 2e-5) // 50
        if tick != state["tick"]:
            error = targets[min(int(t / 0.3), 6)] - w
            state["sum"] += 2.0 * error * 1e-3
            state["tick"], state["v"] = tick, min(max(0.12 * error + state["sum"], -9.0), 9.0)
        return float(state["v"])

    return volts


def then_open() -> Drive:
    """Nothing drives the motor."""
    return lambda t, w: None


def jittered(share: float) -> Callable[[Rng], Floats]:
    """Stamps that miss a uniform grid by up to that share of a period either way."""

    def stamps(rng: Rng) -> Floats:
        grid = regular(PERIOD_S)
        return np.sort(grid + PERIOD_S * share * rng.uniform(-1, 1, len(grid)))

    return stamps


def two_rates(rng: Rng) -> Floats:
    """A logger that slows down to a fifth after a while."""
    grid = regular(PERIOD_S)
    return np.concatenate([grid[grid < 0.9], grid[grid >= 0.9][::5]])


def at_random(rng: Rng) -> Floats:
    """Waiting times as of a busy operating system."""
    return 0.005 + np.cumsum(0.3e-3 + rng.exponential(0.7e-3, round(1.9 / PERIOD_S)))


def drop_outs(rng: Rng) -> Floats:
    """One sample in ten is missing, and twice a stretch of 30."""
    grid = regular(PERIOD_S)
    keep = rng.random(len(grid)) > 0.1
    keep[620:650] = keep[1205:1235] = False
    return grid[keep]


def sentinels(table: dict[str, Floats], rng: Rng) -> None:
    """-9999 for a current that was not read."""
    table["i"][rng.random(len(table["i"])) < 0.03] = -9999.0


def held_speed(table: dict[str, Floats], rng: Rng) -> None:
    """A speed that is renewed every fifth sample."""
    fresh = np.arange(len(table["w"])) // 5 * 5
    table["w"] = table["w"][fresh]


def unsigned(table: dict[str, Floats], rng: Rng) -> None:
    """A magnitude for a current."""
    table["i"] = np.abs(table["i"])


def quantised(table: dict[str, Floats], rng: Rng) -> None:
    """Readings of 10 bits."""
    table["i"], table["w"] = np.round(table["i"] / 0.01) * 0.01, np.round(table["w"] / 0.2) * 0.2


CASES = (
    Case("steps, regular stamps", steps),
    Case("PRBS", prbs),
    Case("slow reversals", ramp),
    Case("chirp", chirp),
    Case("closed loop", closed_loop),
    Case("stamps off by up to a fifth of a period", steps, stamps=jittered(0.2)),
    Case("stamps off by up to 0.9 periods", prbs, stamps=jittered(0.9),
         options={"drop_bad": True, "offset_uncertainty": {"current": 1e-6}}),
    Case("stamps at random, as of a busy PC", steps, stamps=at_random),
    Case("a logger that slows down", steps, stamps=two_rates),
    Case("drop-outs, single and of 30 samples", prbs, stamps=drop_outs),
    Case("sentinels", prbs, spoil=sentinels, options={"drop_bad": True}),
    Case("a speed held for 5 samples", prbs, spoil=held_speed),
    Case("10-bit readings", steps, spoil=quantised),
    Case("a magnitude for a current", steps, spoil=unsigned, options={"unsigned": ("current",)}),
    Case("an onset delay of its own in each of 3 files", steps, runs=3, late_s=2.5e-3),
    Case(
        "the commanded voltage, behind a bridge of 0.2 ± 0.01 ohm", closed_loop, behind_ohm=0.195,
        options={"sense": "command", "bridge_resistance": 0.2,
                 "bridge_resistance_uncertainty": 0.01},
    ),
    Case("no voltage", closed_loop, "iw", told=("J/K", "B/K", "T0/K")),
    Case("no voltage, stamps off by 0.9 periods", closed_loop, "iw", jittered(0.9),
         options={"drop_bad": True}, told=("J/K", "B/K", "T0/K")),
    Case("no current", ramp, "vw", told=("JR/(K²+RB)", "K/(K²+RB)", "T0·R/K")),
    Case("no current, stamps at random", ramp, "vw", at_random,
         told=("JR/(K²+RB)", "K/(K²+RB)", "T0·R/K")),
    Case("no motion, steps", steps, "vi", told=MOTIONLESS),
    Case("no motion, PRBS", prbs, "vi", told=MOTIONLESS),
    Case("no motion, closed loop", closed_loop, "vi", told=MOTIONLESS),
    Case("no motion, stamps at random", steps, "vi", at_random, told=MOTIONLESS),
    Case("no motion, with its K", closed_loop, "vi", fix={"K": MOTOR.K},
         told=("R", "L", "B", "J", "T0")),
    Case("a coast-down, speed alone", then_open, "w", told=("B/J", "T0/J"), begins=120.0),
    Case("a coast-down, stamps at random", then_open, "w", at_random, told=("B/J", "T0/J"),
         begins=120.0),
    Case("a coast-down, voltage as tachometer", then_open, "v", told=("B/J", "K·T0/J"),
         begins=120.0),
    Case("the same with its K", then_open, "v", fix={"K": MOTOR.K}, told=("B/J", "T0/J"),
         begins=120.0),
)  # fmt: skip


@cache
def trace(drive: Callable[[], Drive], begins: float, behind_ohm: float) -> Trace:
    """The motor under that drive."""
    motor = replace(MOTOR, R=MOTOR.R + behind_ohm)
    return turn(motor, drive(), LENGTH_S, begins)


def logs(case: Case, seed: int = 0) -> list[str]:
    """The case's CSV files, one for each run."""
    return [_log(case, seed, k) for k in range(case.runs)]


def _log(case: Case, seed: int, run: int) -> str:
    rng = np.random.default_rng([seed, run])
    true = trace(case.drive, case.begins, case.behind_ohm)
    stamps = case.stamps(rng)
    late = case.late_s * run
    table = {"t": stamps}
    truths = {"v": true.volts, "i": true.current, "w": true.speed}
    for name in case.columns:
        at = stamps if name == "v" else stamps - late
        table[name] = true.at(truths[name], at) + NOISE[name] * rng.standard_normal(len(stamps))
    case.spoil(table, rng)
    rows = np.column_stack(list(table.values()))
    lines = [",".join(table), *(",".join(f"{x:.7g}" for x in row) for row in rows)]
    return "\n".join(lines) + "\n"
