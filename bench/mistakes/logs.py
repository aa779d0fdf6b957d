"""Logs as an engineer takes them of three motors, and the commands that read them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.mistakes.command import Answer, fitted, offers, say
from bench.mistakes.plant import Drive, Motor, Trace, turn

Floats = NDArray[np.float64]
Table = dict[str, Floats]
Rng = np.random.Generator
FINE = 20  # ticks of the plant in a sample
BOTH_WAYS = (0.0, 0.5, 1.0, 0.3, -0.8, -0.4, 0.0)  # of the nominal voltage, one after another
ONE_WAY = (0.0, 0.5, 1.0, 0.3, 0.7, 0.2, 0.0)
NOISE = {"v": 3e-4, "i": 1e-3, "w": 5e-4}  # of nominal voltage, stall current, top speed
MAPS = {"time": "t:s", "voltage": "v:V", "current": "i:A", "speed": "w:rad/s"}


@dataclass(frozen=True)
class Station:
    """A motor and the logger at it."""

    name: str
    motor: Motor
    rate_hz: float
    settles: float = 5.0  # mechanical time constants of each level

    @property
    def period_s(self) -> float:
        """Of a sample."""
        return 1 / self.rate_hz

    @property
    def scales(self) -> Mapping[str, float]:
        """Nominal voltage, stall current, top speed."""
        return {"v": self.motor.volts, "i": self.motor.stall_a, "w": self.motor.top_rad_s}

    @property
    def level_s(self) -> float:
        """How long each level lasts."""
        return round(self.settles * self.motor.tau_s * self.rate_hz) / self.rate_hz


STATIONS = (
    Station("small", Motor(4.1, 0.32e-3, 9.1e-3, 5e-7, 4e-7, 5e-4, 6.0), 10_000, 3.0),
    Station("medium", Motor(1.6, 1.5e-3, 0.052, 4e-5, 6e-5, 8e-3, 24.0), 2_000),
    Station("big", Motor(0.35, 1.4e-3, 0.21, 8e-4, 4e-3, 0.12, 48.0), 1_000),
)
Chain = Callable[[Floats, Station], Floats]  # a channel's truth on the fine grid -> what is shown


def levels(station: Station, shares: Sequence[float]) -> Drive:
    """Levels of the nominal voltage, one after another."""
    volts, level_s, last = station.motor.volts, station.level_s, len(shares) - 1
    return lambda t, i, w: volts * shares[min(int(t / level_s + 1e-9), last)]


def steps(station: Station) -> Drive:
    """Rest, levels both ways and a short circuit; the bridge never opens."""
    return levels(station, BOTH_WAYS)


def one_way(station: Station) -> Drive:
    """The same without a reversal."""
    return levels(station, ONE_WAY)


@dataclass(frozen=True)
class Log:
    """How a log is taken: the drive, each channel's chain, the rows' fate, and the words said.

    ``spoil`` changes the sampled columns; ``write`` makes the file's text of them. ``maps``
    replaces entries of MAPS. ``options`` go to the import, ``fit`` to the fit.
    """

    drive: Callable[[Station], Drive] = steps
    chain: Mapping[str, Chain] = field(default_factory=dict)
    source: Callable[[Trace, Station], Mapping[str, Floats]] | None = None
    spoil: Callable[[Table, Station, Rng], Table] = lambda table, station, rng: table
    write: Callable[[Table], str] | None = None
    maps: Mapping[str, str] = field(default_factory=dict)
    options: Callable[[Station], Sequence[str]] = lambda station: ()
    plate: bool = False  # the user also types the motor's label, where a command takes one
    every_tau: float = 0.0  # mechanical time constants between rows; 0: the usual rate


@cache
def traced(drive: Callable[[Station], Drive], station: Station) -> Trace:
    """The motor under that drive."""
    length = len(BOTH_WAYS) * station.level_s
    return turn(station.motor, drive(station), length, station.period_s / FINE)


def table(log: Log, station: Station, seed: int) -> Table:
    """The columns of the file."""
    rng = np.random.default_rng([seed, 17])
    true = traced(log.drive, station)
    shown = dict(log.source(true, station)) if log.source else {}
    shown = {"v": true.volts, "i": true.current, "w": true.speed} | shown
    tau_rows = log.every_tau * station.motor.tau_s * station.rate_hz
    every = FINE * max(round(tau_rows), 1)
    columns = {"t": true.time_s[::every]}  # the first tick of each sample
    for name, values in shown.items():
        chain = log.chain.get(name)
        seen = chain(values, station) if chain else values
        sd = NOISE[name] * station.scales[name] if name in NOISE else 0.0  # an angle has none
        columns[name] = seen[::every] + sd * rng.standard_normal(len(columns["t"]))
    return log.spoil(columns, station, rng)


def text(columns: Table) -> str:
    """A plain CSV file."""
    rows = np.column_stack(list(columns.values()))
    lines = [",".join(columns), *(",".join(f"{x:.7g}" for x in row) for row in rows)]
    return "\n".join(lines) + "\n"


def label(station: Station) -> dict[str, float]:
    """What the maker prints, rounded as makers do."""
    m = station.motor
    idle = (m.T0 + m.B * m.top_rad_s) / m.K
    exact = {
        "voltage_v": m.volts,
        "resistance_ohm": m.R,
        "inductance_h": m.L,
        "torque_constant_nm_a": m.K,
        "inertia_kg_m2": m.J,
        "no_load_current_a": idle,
    }
    return {key: float(f"{value:.2g}") for key, value in exact.items()}


def answer(log: Log, station: Station, folder: Path, seed: int = 0) -> Answer:
    """What a user of that log is told."""
    path, capture = folder / "log.csv", folder / "log.h5"
    path.write_text((log.write or text)(table(log, station, seed)), encoding="utf-8")
    maps = [part for q, c in {**MAPS, **log.maps}.items() if c for part in ("--map", f"{q}={c}")]
    plate = [f"--nameplate={k}={v!r}" for k, v in label(station).items()] if log.plate else []
    at_import = plate if offers("import", "--nameplate") else []
    taken = say("import", path, *maps, *log.options(station), *at_import, "-o", capture, "--force")
    if taken.code:
        return Answer(taken.code, None, taken.err)
    at_fit = plate if offers("fit", "--nameplate") and not at_import else []
    return fitted([capture], *at_fit, before=taken.out + taken.err)
