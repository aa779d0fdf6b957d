"""Mistakes in logs, a second set: of time bases, couplings, counters and labels."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from scipy.signal import lfilter

from bench.mistakes.log_cases import LOST, SPEED_FILTER, Mistake, clock_in
from bench.mistakes.logs import Chain, Floats, Log, Rng, Station, Table
from bench.mistakes.plant import Trace

COUNTS, WRAP = 4096, 65536
TIME = (r"clock", r"time.?(base|scale|stamps?)", r"unit_mistake", r"\bJ\b[^.]*times the nameplate")


def ac_coupled(hertz: float) -> Chain:
    """An oscilloscope's input that blocks a mean value."""

    def chain(x: Floats, s: Station) -> Floats:
        keep = np.exp(-2 * np.pi * hertz * s.period_s / 20)
        return np.asarray(lfilter([1.0, -1.0], [1.0, -keep], x))

    return chain


def held(name: str, rows: int) -> Callable[[Table, Station, Rng], Table]:
    """A channel that is read every so many rows and stands in between."""

    def spoil(table: Table, station: Station, rng: Rng) -> Table:
        return {**table, name: table[name][np.arange(len(table["t"])) // rows * rows]}

    return spoil


def turning(true: Trace, station: Station) -> Mapping[str, Floats]:
    """The angle beside the others."""
    return {"p": true.angle}


def counted(table: Table, station: Station, rng: Rng) -> Table:
    """Counts of an encoder in place of the speed, in a register that overflows."""
    counts = np.floor(table["p"] * COUNTS / (2 * np.pi)) + WRAP // 2
    return {**{n: c for n, c in table.items() if n not in "wp"}, "n": counts % WRAP}


def rounded_stamps(table: Table, station: Station, rng: Rng) -> Table:
    """Stamps in whole tens of samples, as a slow clock prints them."""
    return {**table, "t": np.floor(table["t"] / (10 * station.period_s)) * 10 * station.period_s}


def jittered(table: Table, station: Station, rng: Rng) -> Table:
    """Rows that a busy PC read when it had time, under stamps of its timer."""
    moments = table["t"] + rng.uniform(0.0, 0.8, len(table["t"])) * station.period_s
    rest = {n: np.interp(moments, table["t"], c) for n, c in table.items() if n != "t"}
    return {"t": table["t"], **rest}


def middle(table: Table, station: Station, rng: Rng) -> Table:
    """From the middle of one pulse to the middle of another, time begun anew."""
    n = len(table["t"])
    cut = {name: c[round(0.2 * n) : round(0.8 * n)] for name, c in table.items()}
    return {**cut, "t": table["t"][: len(cut["t"])]}


def twice(table: Table, station: Station, rng: Rng) -> Table:
    """Two parts of the log in the wrong order, under stamps that go on."""
    half = round(0.45 * len(table["t"]))
    turned = {n: np.concatenate([c[half:], c[:half]]) for n, c in table.items()}
    return {**turned, "t": table["t"]}


MORE = (
    Mistake("time base twice as fast", TIME, Log(spoil=clock_in(0.5), plate=True),
            traceless=("clock", "time_scale")),
    Mistake("current AC-coupled", (r"AC.coupl", r"high.pass", r"current\b[^.]*(offset|zero|mean)"),
            Log(chain={"i": ac_coupled(2.0)})),
    Mistake("speed held for 10 rows", (r"readings_held", r"\bheld\b", r"times over", *SPEED_FILTER,
            r"speed_lag"), Log(spoil=held("w", 10))),
    Mistake("counts in a register of 16 bits", (r"wrap", r"overflow", r"roll"),
            Log(source=turning, spoil=counted, maps={"speed": "", "position": "n:counts"},
                options=lambda s: ("--counts-per-turn", str(COUNTS)))),
    Mistake("stamps rounded to ten samples", (r"stamps?", r"time.?base"),
            Log(spoil=rounded_stamps)),
    Mistake("readings jitter under even stamps", (r"jitter", r"stamps?"), Log(spoil=jittered)),
    Mistake("cut from pulse to pulse", LOST, Log(spoil=middle)),
    Mistake("halves in the wrong order", (*LOST, r"jump", r"cut"), Log(spoil=twice)),
    Mistake("rev/s mapped as rad/s", (r"speed_scale", r"speed\b[^.]*unit", r"unit_mistake"),
            Log(maps={"speed": "w/6.2831853:rad/s"}, plate=True)),
)  # fmt: skip
