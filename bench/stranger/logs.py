"""Logs as people keep them: good ones, and ones with a mistake; what is said to the import."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from bench.mistakes.command import Answer, fitted, say
from bench.mistakes.plant import Motor
from bench.stranger import chain
from bench.stranger.plant import Source, turn

Floats = chain.Floats
Table = dict[str, Floats]
Edit = Callable[[Table, Motor], Table]
UNITS = {"t": "time=t:s", "v": "voltage=v:V", "i": "current=i:A", "w": "speed=w:rad/s",
         "p": "position=p:counts"}  # fmt: skip
IDEAL = Source()
TICKS, MOST_TICKS = 8, 700_000  # in L/R or in a sample; of a log
FINE = 64  # where readings lie between ticks: straight lines there are off by less than 16 bits


@dataclass(frozen=True)
class Log:
    """``filters``: kind and time constant, ``means`` and ``late``: s, all by column.

    ``phase``: of a sample, by which the voltage jumps after a reading; None: by chance.
    ``counts``: the speed is counted edges over the time since the last row. ``said`` to the import.
    """

    drive: str
    rate: float
    bits: int
    noise: float
    columns: str = "viw"
    counts: int = 0
    gear: float = 1.0
    source: Source = IDEAL
    asked: bool = False  # the voltage is the one that was asked for
    drawn: bool = False  # the current is the supply's
    filters: Mapping[str, tuple[str, float]] = field(default_factory=dict)
    means: Mapping[str, float] = field(default_factory=dict)
    late: Mapping[str, float] = field(default_factory=dict)
    clock: str = "exact"
    phase: float | None = 0.0
    edit: Edit | None = None
    said: tuple[str, ...] = ()


Maker = Callable[[Motor, chain.Rng], Log]


def board(drive: str, **more: object) -> Maker:
    """A small board: 10 bits, a loop of 100 to 1000 Hz, a speed by counted edges."""

    def made(m: Motor, rng: chain.Rng) -> Log:
        rate = max(float(rng.choice((100, 200, 250, 500, 1000))), 100 * math.ceil(0.08 / m.tau_s))
        counts = int(rng.choice((1440, 2000, 4096)))
        return replace(Log(drive, rate, 10, 0.7, counts=counts, clock="4 us"), **more)  # type: ignore[arg-type]

    return made


def converter(drive: str, **more: object) -> Maker:
    """Instants by 16 bits at 1 to 50 kHz, about 5000 rows; a tachometer."""

    def made(m: Motor, rng: chain.Rng) -> Log:
        rate = min(float(rng.choice((10e3, 20e3, 50e3))), max(1e3, 180.0 / m.tau_s))
        log = Log(drive, float(f"{rate:.1g}"), 16, float(rng.uniform(2.0, 16.0)))
        return replace(log, **more)  # type: ignore[arg-type]

    return made


def scope(drive: str, **more: object) -> Maker:
    """An oscilloscope: 8 bits, 2500 rows."""

    def made(m: Motor, rng: chain.Rng) -> Log:
        log = Log(drive, float(f"{2500.0 / (20.0 * m.tau_s):.2g}"), 8, 0.5)
        return replace(log, **more)  # type: ignore[arg-type]

    return made


def behind(base: Maker, column: str, kind: str, samples: float) -> Maker:
    """The same with a low-pass in a column's chain."""

    def made(m: Motor, rng: chain.Rng) -> Log:
        log = base(m, rng)
        return replace(log, filters={column: (kind, samples / log.rate)})

    return made


def spoilt(base: Maker, change: Callable[[Log, Motor], Log]) -> Maker:
    """The same with something changed that follows from the log or the motor."""
    return lambda m, rng: change(base(m, rng), m)


def table(log: Log, m: Motor, rng: chain.Rng) -> Table:
    """The columns of the file."""
    wave, period_s = chain.wave(log.drive, m.volts, m.tau_s, log.rate, rng), 1.0 / log.rate
    fine = TICKS if log.clock in ("exact", "4 us") and not log.means else FINE
    ticks = min(max(fine, math.ceil(fine * period_s * m.R / m.L)), MOST_TICKS // len(wave))
    dt = period_s / ticks
    true = turn(m, chain.driven(wave, ticks, log.phase, rng), dt, log.source)
    real, stamps = chain.clock(log.clock, len(wave), period_s, rng)
    within = real < dt * (len(true.asked) - 1)
    real, columns = real[within], {"t": stamps[within]}
    series = {
        "v": true.asked if log.asked else true.terminal,
        "i": true.drawn if log.drawn else true.current,
        "w": true.speed / log.gear,
        "p": true.angle / log.gear,
    }
    spans = {"v": 1.25 * m.volts, "i": 1.3 * m.stall_a, "w": 1.3 * m.top_rad_s / log.gear}
    for c in log.columns:
        x, at = series[c], np.maximum(real - log.late.get(c, 0.0), 0.0)
        if c in log.filters:
            x = chain.low_pass(x, dt, log.filters[c][1], log.filters[c][0])
        if c == "p":
            columns[c] = chain.counted(chain.instants(x, dt, at, False), log.counts)
            continue
        if c == "w" and log.counts:
            edges = chain.counted(chain.instants(series["p"], dt, at, False), log.counts)
            since = np.maximum(np.diff(at, prepend=at[0] - period_s), 1e-9)
            columns[c] = np.diff(edges, prepend=edges[0]) * 2.0 * np.pi / log.counts / since
            continue
        if c in log.means:
            y = chain.means(x, dt, at, log.means[c])
        else:
            y = chain.instants(x, dt, at, c == "v" and c not in log.filters)
        columns[c] = chain.converted(y, spans[c], log.bits, log.noise, rng)
    return log.edit(columns, m) if log.edit else columns


def answer(log: Log, m: Motor, rng: chain.Rng, folder: Path) -> Answer:
    """What a user of that log is told."""
    columns = table(log, m, rng)
    rows = np.column_stack(list(columns.values()))
    lines = [",".join(columns), *(",".join(f"{x:.9g}" for x in row) for row in rows)]
    path, capture = folder / "log.csv", folder / "log.h5"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    maps = [part for c in columns for part in ("--map", UNITS[c])]
    said = [*log.said, *(("--sense", "command") if log.asked else ())]
    if "p" in columns:
        said += ["--counts-per-turn", str(log.counts)]
    if log.gear != 1.0:
        said += ["--gear-ratio", str(log.gear)]
    taken = say("import", path, *maps, *said, "-o", capture, "--force")
    return Answer(taken.code, None, taken.err) if taken.code else fitted([capture])
