"""Volts that are commanded and not measured, against what the current and the motion need of them.

A board turns its level into a duty by its reading of the supply, and so makes up for a sag while
there is duty left. A supply that limits its current, or sags further than that, leaves the motor
less than its level. Without a voltage channel nothing else shows it.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SUPPLY, VOLTAGE, Capture
from motorid.estimate.fit.block_regression import FEWEST, Blocks, blocks, squares
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS, Diagnostic
from motorid.estimate.signals.measurements import motion
from motorid.program import StepKind

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

LACKS = 0.1  # of its level, that a block must lack,
OF_HIGHEST = 0.05  # and this much of the highest level: drops and dead time take less
IN_A_ROW = 3  # blocks that must
FLAT = 0.1  # of a current, within which it stands at a limit
ROUNDS = 16  # of reweighting
TINY = 1e-4  # of the highest level: departures below it weigh alike


def findings(capture: Capture, where: str = "") -> Iterator[Diagnostic]:
    """A level that the motor's current and motion contradict; or that none does, and what that
    leaves open. ``where``: " in run 2", or nothing.
    """
    if not _by_command_alone(capture):
        return
    b = blocks([MotorRecord(capture, PARAMETERS, {})])
    lacks = None if b is None else _lacks(b)
    if b is None or lacks is None:
        return
    here = _first_stretch(b, lacks)
    if not len(here):
        yield Diagnostic(
            "volts_commanded", "info",
            f"the volts{where} are commanded, and none were measured: current and motion exclude a "
            f"supply that gives {LACKS:.0%} less for a while, and no smaller sag; record "
            "terminal_voltage",
        )  # fmt: skip
        return
    at, share = float(here[0] * b.period_s[0]), float(np.max(lacks[here] / np.abs(b.volts[here])))
    low, usual, high = np.percentile(np.abs(b.current[here]), (25, 50, 75))
    limit = f" while the current stood at {usual:.3g} A" if high - low < FLAT * usual else ""
    yield Diagnostic(
        "supply_limited", "warning",
        f"from {at:.3g} s on{where} the motor answers as if it got up to {share:.0%} less than the "
        f"volts of its command{limit}: the supply limits its current or sags; raise its limit or "
        "lower the level, and record terminal_voltage",
    )  # fmt: skip


def _by_command_alone(capture: Capture) -> bool:
    """Volts are commanded and not measured, beside a current and a motion with their signs."""
    channels, moving = capture.channels, motion(capture)
    if capture.program is None or VOLTAGE in channels or SUPPLY in channels:
        return False
    if moving is None or moving.unsigned or CURRENT not in channels:
        return False
    return {s.kind for s in capture.program.steps if s.level} == {StepKind.DRIVE_VOLTS}


def _first_stretch(b: Blocks, lacks: Floats) -> NDArray[np.intp]:
    """The first blocks in a row that lack much of their level."""
    highest = float(np.abs(b.volts).max())
    least = np.maximum(LACKS * np.abs(b.volts), OF_HIGHEST * highest)
    much = _under_a_level(b) & (lacks > least)
    begins = np.flatnonzero(np.convolve(much, np.ones(IN_A_ROW), "valid") >= IN_A_ROW)
    if not len(begins):
        return begins
    length = int(np.argmin(np.r_[much[begins[0] :], False]))
    return np.arange(begins[0], begins[0] + length)


def _under_a_level(b: Blocks) -> Bools:
    return np.asarray(b.settled & (np.abs(b.volts) > OF_HIGHEST * np.abs(b.volts).max()))


def _lacks(b: Blocks) -> Floats | None:
    """V (n,) that R i + K ω and a constant drop lack of the level, as most blocks have them: least
    absolute departures, by reweighting. None: too few blocks.
    """
    way, use = np.sign(b.volts), _under_a_level(b)
    if use.sum() < FEWEST:
        return None
    columns, weight = np.column_stack([b.current, b.speed, way]), np.ones(int(use.sum()))
    tiny = TINY * float(np.abs(b.volts).max())
    for _ in range(ROUNDS):
        _, found, _ = squares(columns[use] * weight[:, None], b.volts[use] * weight)
        lacks = (b.volts - columns @ found) * way
        weight = 1.0 / np.sqrt(np.maximum(np.abs(lacks[use]), tiny))
    return np.asarray(lacks)
