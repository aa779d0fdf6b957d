"""Logs in which everything is drawn: drive, rate, converters, encoder, gear, clock, one mistake."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from bench.mistakes.plant import Motor
from bench.stranger import edits
from bench.stranger.cases import CLIPPED, FILTER, LATE, LOST, SUPPLY
from bench.stranger.chain import Rng
from bench.stranger.logs import Log, Maker
from bench.stranger.plant import Source

DRIVES = (
    "steps", "random", "stairs", "one way", "ramp", "sweep", "up and down", "coast at the end",
)  # fmt: skip
CHANGING = ("ramp", "sweep")  # each row: what is read between two changes is late, and no good log
CLOCKS = ("exact", "exact", "jitter", "4 us", "busy PC")
ROWS = 8.0, 400.0  # in a motor's time constant
SENSORS = (("viw", False), ("viw", False), ("vip", True), ("viw", True))  # and whether they count
Mistake = Callable[[Log, Motor, Rng], Log]


def good(m: Motor, rng: Rng) -> Log:
    """A log without a mistake."""
    columns, counts = SENSORS[rng.integers(len(SENSORS))]
    drive, moment = str(rng.choice(DRIVES)), rng.random()
    changes = drive in CHANGING
    return Log(
        drive=drive,
        rate=float(f"{_between(rng, *ROWS) / m.tau_s:.2g}"),
        bits=int(rng.choice((8, 10, 12, 14, 16))),
        noise=float(rng.choice((0.3, 0.7, 1.5, 3.0))),
        columns=columns,
        counts=int(rng.choice((400, 1440, 2000, 4096, 10_000))) if counts else 0,
        gear=float(rng.choice((1.0, 1.0, 1.0, 19.2, 50.0))),
        clock=str(rng.choice(("exact", "4 us") if changes else CLOCKS)),
        phase=0.0 if moment < 0.6 or changes else None if moment < 0.8 else float(rng.random()),
    )


def _between(rng: Rng, low: float, high: float) -> float:
    return math.exp(rng.uniform(math.log(low), math.log(high)))


def _filtered(log: Log, m: Motor, rng: Rng) -> Log:
    column, kind = str(rng.choice(list("viw"))), str(rng.choice(("RC", "2 RC", "Butterworth")))
    read = replace(log, columns="viw", counts=0) if column == "w" else log
    return replace(read, filters={column: (kind, _between(rng, 1.5, 15.0) / log.rate)})


def _late(log: Log, m: Motor, rng: Rng) -> Log:
    column = str(rng.choice(list(log.columns)))
    return replace(log, late={column: float(rng.integers(2, 9)) / log.rate})


def _means(log: Log, m: Motor, rng: Rng) -> Log:
    return replace(log, means={"i": float(rng.integers(2, 9)) / log.rate})


def _held(log: Log, m: Motor, rng: Rng) -> Log:
    return replace(log, edit=edits.held(str(rng.choice(list("vi"))), int(rng.integers(3, 9))))


def _limited(log: Log, m: Motor, rng: Rng) -> Log:
    most = rng.uniform(0.4, 0.7) * m.stall_a
    return replace(log, drive="steps", asked=True, source=Source(limit_a=most))


def _clipped(log: Log, m: Motor, rng: Rng) -> Log:
    return replace(log, drive="steps", edit=edits.clipped(rng.uniform(0.25, 0.45)))


MISTAKES: dict[str, tuple[Mistake, str]] = {
    "a low-pass": (_filtered, FILTER),
    "a channel is late": (_late, LATE),
    "means of the current": (_means, f"{LATE}|{FILTER}|mean"),
    "a channel is held": (_held, f"held|repeat|{LATE}"),
    "the supply limits": (_limited, SUPPLY),
    "the supply's current": (lambda log, m, rng: replace(log, drawn=True), SUPPLY),
    "the current is clipped": (_clipped, CLIPPED),
    "the current's zero": (
        lambda log, m, rng: replace(log, edit=edits.offset(rng.uniform(0.02, 0.15))),
        r"offset|zero",
    ),
    "a channel is turned": (
        lambda log, m, rng: replace(log, edit=edits.turned(str(rng.choice(list("vi"))))),
        r"sign",
    ),
    "rows are lost": (lambda log, m, rng: replace(log, edit=edits.gone), LOST),
}


def cases(count: int) -> dict[str, tuple[Maker, str]]:
    """So many good logs, and as many that have the mistakes in turn, by name."""
    out: dict[str, tuple[Maker, str]] = {f"good: drawn {k}": (good, "") for k in range(count)}
    kinds = list(MISTAKES.items())
    for k in range(count):
        name, (mistake, words) = kinds[k % len(kinds)]
        out[f"bad: drawn {k}, {name}"] = (_spoilt(mistake), words)
    return out


def _spoilt(mistake: Mistake) -> Maker:
    return lambda m, rng: mistake(good(m, rng), m, rng)
