"""A log's voltage that cannot be the motor's: a supply's while PWM drives, or another column.

At the terminals V = R i + K ω + L di/dt. Means over blocks
are compared with that, and with the voltage some samples earlier or later: a lag is no such thing.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture
from motorid.estimate.results.estimate import PARAMETERS, Diagnostic
from motorid.estimate.signals.log_sections import pieces
from motorid.estimate.signals.measurements import motion

Floats = NDArray[np.float64]

BLOCKS, SHORTEST = 120, 4  # of a log; samples of a block
FEWEST = 24  # blocks
LAGS = (0, 3, -3, 8, -8, 20, -20, 50, -50)  # samples of the voltage
FAR = 0.25  # of the highest voltage, by which a block departs
MANY = 0.13  # of the blocks, that must
CHANCE = 4.0  # standard deviations of a block's mean, that it departs by besides
STILL = 0.1  # of the highest voltage, within which one that is a supply's stays


def remarks(captures: Sequence[Capture]) -> list[Diagnostic]:
    """Of the logs whose voltage, current and motion contradict each other."""
    return [said for capture in captures for said in _of(capture)]


def _of(capture: Capture) -> Iterator[Diagnostic]:
    moving = motion(capture)
    if capture.program is not None or moving is None or moving.unsigned:
        return
    if not {VOLTAGE, CURRENT} <= set(capture.channels) or capture.channels[CURRENT].unsigned:
        return
    parts = [found for piece in pieces([capture]) if (found := _columns(piece)) is not None]
    if not parts:
        return
    share = min(_departs(parts, lag) for lag in LAGS)
    if share < MANY:
        return
    volts = np.concatenate([v for v, _, _ in parts])
    highest = float(np.percentile(np.abs(volts), 98))
    constant = float(np.percentile(volts, 98) - np.percentile(volts, 2)) < STILL * highest
    which = (
        f"it stays near {np.median(volts):.3g} V whatever current and speed do, as a supply does: "
        "if PWM drives the motor, log the voltage at its terminals, or supply times duty"
        if constant
        else "log the voltage at the motor's terminals, and check which column is mapped to it"
    )
    where = f" of {capture.path}" if capture.path else ""
    yield Diagnostic(
        "foreign_voltage", "warning",
        f"the voltage{where} cannot be the motor's: in {100 * share:.0f} % of the log it departs "
        f"from R i + K ω by more than {100 * FAR:.0f} % of its highest value; {which}",
        dict.fromkeys(PARAMETERS, np.inf),
    )  # fmt: skip


def _columns(piece: Capture) -> tuple[Floats, Floats, Floats] | None:
    """Voltage, current and speed, (n,) each; None where too little was read."""
    moving = motion(piece)
    if moving is None or len(piece) < FEWEST * SHORTEST:
        return None
    speed = moving.values
    if moving.name != SPEED:
        speed = np.gradient(speed, piece.time_s)
    columns = piece.channels[VOLTAGE].values, piece.channels[CURRENT].values, speed
    known = np.isfinite(np.array(columns)).all(axis=0)
    if known.sum() < FEWEST * SHORTEST:
        return None
    return columns[0][known], columns[1][known], columns[2][known]


def _departs(parts: Sequence[tuple[Floats, Floats, Floats]], lag: int) -> float:
    """Share of blocks that no R and K explain, the voltage taken so many samples earlier."""
    width = max(sum(len(v) for v, _, _ in parts) // BLOCKS, SHORTEST)
    rows = np.vstack([_blocks(part, lag, width) for part in parts])
    if len(rows) < FEWEST:
        return 0.0
    scale = np.sqrt((rows[:, 1:] ** 2).sum(axis=0)) + 1e-300
    found = np.linalg.lstsq(rows[:, 1:] / scale, rows[:, 0], rcond=1e-9)[0] / scale
    left = np.abs(rows[:, 0] - rows[:, 1:] @ found)
    chance = np.concatenate([_chance(_cut(part, lag, width), found) for part in parts])
    least = FAR * float(np.percentile(np.abs(rows[:, 0]), 98))
    return float(np.mean(left > np.maximum(least, CHANCE * chance)))


def _blocks(part: tuple[Floats, Floats, Floats], lag: int, width: int) -> Floats:
    """(m, 4): means over blocks of voltage, current, speed, and how much the current rises."""
    return np.asarray(_cut(part, lag, width).mean(axis=2).T)


def _cut(part: tuple[Floats, Floats, Floats], lag: int, width: int) -> Floats:
    """(4, m, width): the readings of each block, and how much the current rises at them."""
    volts, current, speed = part
    place = np.clip(np.arange(len(volts)) + lag, 0, len(volts) - 1)
    count = len(volts) // width
    each = volts[place], current, speed, np.gradient(current)
    return np.array([y[: count * width].reshape(count, width) for y in each])


def _chance(cut: Floats, found: Floats) -> Floats:
    """(m,): standard deviation of what a block departs by because of its speed, as neighbouring
    readings differ there, or usually do: one that counts few edges from row to row says little.
    """
    emf = found[1] * cut[2]
    each = (np.diff(emf, axis=1) ** 2).mean(axis=1) / 2.0 / emf.shape[1]
    return np.asarray(np.sqrt(np.maximum(each, each.mean())))
