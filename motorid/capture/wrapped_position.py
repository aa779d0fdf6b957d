"""A position whose register wraps, or whose sensor begins anew each turn, becomes continuous."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

FAR = 0.5  # of the span: a change that no rotor makes between two readings
NEAR = 0.2  # of the span, that all other changes stay within
TURNS = (360.0, 2.0 * np.pi, 1.0)  # degrees, radians, turns
BITS = range(8, 33)  # of a register


def continued(position: Floats, counts_per_turn: float, notes: list[str]) -> Floats:
    """The position (rows,) without its jumps by the range of its register, in the file's unit.

    Only jumps of a size that a register or a turn has are taken for that; NaN stays. Each is in
    ``notes``.
    """
    known = np.flatnonzero(np.isfinite(position))
    values = position[known]
    span = float(np.ptp(values)) if len(values) > 2 else 0.0
    changes = np.diff(values)
    jumps = np.abs(changes) > FAR * span
    if not span or not jumps.any() or jumps.all():
        return position
    most = float(np.abs(changes[~jumps]).max())
    if not 0.0 < most <= NEAR * span:
        return position
    found = [r for r in _ranges(counts_per_turn) if _explains(r, changes[jumps], most, span)]
    if not found:
        return position
    wrap = found[0]
    turned = np.concatenate([[0.0], np.cumsum(np.where(jumps, -np.sign(changes) * wrap, 0.0))])
    out = position.copy()
    out[known] = values + turned
    notes.append(
        f"the position jumps by {wrap:.6g} at {int(jumps.sum())} places, as a register that "
        "wraps or an angle of one turn does: it is continued there"
    )
    return out


def _ranges(counts_per_turn: float) -> Iterator[float]:
    """Ranges that positions have, the smallest first."""
    usual = {*TURNS, *(2.0**bits for bits in BITS), float(counts_per_turn)}
    yield from sorted(size for size in usual if size > 0.0)


def _explains(size: float, jumps: Floats, most: float, span: float) -> bool:
    """Without ``size`` every jump is a change as the others are, and the span is within it."""
    return span <= size * (1.0 + 1e-9) and bool(np.all(np.abs(np.abs(jumps) - size) <= 1.5 * most))
