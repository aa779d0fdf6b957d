"""Random fault schedules: what befalls the link, the board, the bench and the host, by a seed."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

SETUP_S = 1.0  # about when the run proper begins
RATES = ("flip", "drop", "insert", "double")
LINK_ONCE = ("unplug", "reset", "swap")
BOARD = ("reset", "brownout", "supply", "stall", "encoder_reversed", "encoder_dead",
         "encoder_drop", "current_dead", "current_reversed", "current_saturated",
         "voltage_dead", "adc_stuck")  # fmt: skip
HOSTS = ("runs", "ctrl-c", "kill -9", "power failure", "full disk")


@dataclass(frozen=True)
class Schedule:
    """One capture and what befalls it. ``link`` and ``board`` are fault options."""

    seed: int
    long: bool  # program of 1.52 s instead of 0.38 s
    link: str
    board: str
    host: str
    host_at_s: float  # by the port's clock
    options: str  # of sim://
    rate_hz: float
    channels: int
    mode: str
    host_silence_s: float

    def __str__(self) -> str:
        return json.dumps(asdict(self))


def draw(seed: int) -> Schedule:
    """The schedule of a seed."""
    rng = np.random.default_rng([seed, 2026])
    host = str(rng.choice(HOSTS, p=(0.6, 0.1, 0.15, 0.1, 0.05)))
    long = bool(rng.random() < 0.4) or host in ("kill -9", "power failure")
    end_s = SETUP_S + (1.52 if long else 0.38)
    rate = float(rng.choice((10_000, 10_000, 5_000, 1_000)))
    return Schedule(
        seed=seed,
        long=long,
        link=_link(rng, end_s),
        board=_board(rng, end_s),
        host=host,
        host_at_s=round(float(rng.uniform(0.0, end_s + 0.1)), 4),
        options=_options(rng, seed),
        rate_hz=rate,
        channels=int(rng.integers(1, 5)),
        mode="burst" if rng.random() < 0.1 else "stream",
        host_silence_s=round(float(rng.uniform(0.15, 1.0)), 3),
    )


def _window(rng: Any, end_s: float, longest_s: float) -> str:
    begin = float(rng.uniform(0, end_s))
    return f"@{begin:.4f}..{begin + float(rng.uniform(0.002, longest_s)):.4f}"


def _link(rng: Any, end_s: float) -> str:
    faults = []
    for name in RATES:
        if rng.random() < 0.25:
            window = _window(rng, end_s, end_s) if rng.random() < 0.5 else ""
            faults.append(f"{name}:{10 ** rng.uniform(-5, -2.5):.2e}{window}")
    for name, odds, longest_s in (("silence", 0.1, 0.8), ("deaf", 0.1, 0.8), ("mute", 0.1, 0.8)):
        if rng.random() < odds:
            faults.append(name + _window(rng, end_s, longest_s))
    if rng.random() < 0.1:
        faults.append(f"delay:{rng.uniform(0, 0.1):.4f}{_window(rng, end_s, end_s)}")
    if rng.random() < 0.15:
        faults.append(f"burst:{rng.uniform(0.001, 0.1):.4f}")
    if rng.random() < 0.15:
        faults.append("split")
    if rng.random() < 0.2:
        faults.append(f"{rng.choice(LINK_ONCE)}@{rng.uniform(0, end_s):.4f}")
    return ",".join(faults)


def _board(rng: Any, end_s: float) -> str:
    if rng.random() < 0.6:
        return ""
    return f"{rng.choice(BOARD)}@{rng.uniform(0, end_s - 0.4):.4f}"


def _options(rng: Any, seed: int) -> str:
    options: dict[str, Any] = {"seed": seed, "speed": "max"}
    options["baud"] = int(rng.choice((1_000_000, 1_000_000, 0, 230_400)))
    options["buffer"] = int(rng.choice((64, 2048, 20_000)))
    if rng.random() < 0.3:  # wraps somewhere in the run
        options["first_tick"] = int(2**32 - rng.uniform(0, 3) * 16e6)
    if rng.random() < 0.3:
        options["clock_ppm"] = round(float(rng.uniform(-500, 500)), 1)
    if rng.random() < 0.2:
        options["supply_limit"] = round(float(rng.uniform(0.3, 3)), 2)
    return "&".join(f"{name}={value}" for name, value in options.items())
