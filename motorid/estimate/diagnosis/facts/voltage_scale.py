"""The scale of the motor's voltage against what drove it: a command in volts, or duty times supply.

Over all that the bridge drove in one run

    v = s c - r i - d sign(i)

c is the level, or the duty times the supply that was measured. r takes bridge, leads and the sag of
a supply that nobody read meanwhile; d what the dead time takes. So s is near 1 for any bridge, and
far from it where the scale of the voltage or of the supply is wrong, either way.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SUPPLY, VOLTAGE, Capture
from motorid.estimate.diagnosis.facts.pwm.aliasing import aliased
from motorid.estimate.results.estimate import Diagnostic, Parameter
from motorid.estimate.signals.time_grid import Part, lay
from motorid.estimate.solver.dense_products import square
from motorid.program import Decay, StepKind

Floats = NDArray[np.float64]

LEAST = 0.03  # of the scale: less is left to what else the bridge does
SURE = 3.0  # standard uncertainties of it
USUAL = 0.01  # relative standard uncertainty of a supply's reading that declares none
EDGE, BLOCK, MOST = 4, 5, 8  # samples left out after a step; of a block, at least; blocks of a part
FEWEST = 12  # blocks
UNLIKE = 1.3  # ratio of the highest level to the lowest
LOW, FULL = 0.2, 0.95  # of the supply: below, dead time is a large share; above, it may not do
SOFT = 0.02  # of the highest current, where dead time takes half


@dataclass(frozen=True)
class Scale:
    """Of the voltage's readings over what drove them, with its standard uncertainty."""

    value: float
    uncertainty: float


def findings(
    capture: Capture, parameters: Mapping[str, Parameter], where: str = ""
) -> Iterator[Diagnostic]:
    """A voltage of another scale than what drove the motor. ``where``: " in run 2", or nothing."""
    found = scale(capture)
    if found is None:
        return
    off = found.value - 1.0
    if abs(off) <= max(LEAST, SURE * found.uncertainty):
        return
    sized = {n: abs(off * p.value) for n, p in parameters.items() if p.value is not None}
    yield Diagnostic(
        "voltage_contradicted", "warning",
        f"the motor's voltage reads {found.value:.3g} times what the program gave it{where}, "
        "beside all that a bridge and a supply lose with the current: compare it, and the supply's "
        "reading, with a meter",
        sized,
    )  # fmt: skip


def scale(capture: Capture) -> Scale | None:
    """None: the voltage is not the motor's, or nobody knows what drove it."""
    channel, current = capture.get(VOLTAGE), capture.get(CURRENT)
    if channel is None or channel.sense not in ("terminals", "bridge") or aliased(capture):
        return None
    if current is None or capture.program is None:
        return None
    rows = np.array(list(_blocks(capture)))
    if len(rows) < FEWEST:
        return None
    given, read, amperes = rows.T
    size, supplied = np.abs(given), capture.supply_v
    if size.max() < max(UNLIKE * size.min(), LOW * (supplied or 0.0)):
        return None
    soft = SOFT * max(float(np.abs(amperes).max()), 1e-300)
    terms = np.column_stack([given, -amperes, -amperes / np.hypot(amperes, soft)])
    best, used, rest = _fitted(terms, read)
    if not best > 0.0:
        return None
    variance = rest / max(len(read) - used.shape[1], 1)
    spread = np.linalg.pinv(used.T @ used)[0, 0] * variance
    supply = capture.get(SUPPLY)
    known = supply.gain_uncertainty if supply is not None and supply.gain_uncertainty else USUAL
    doubt = float(np.sqrt(spread + channel.gain_uncertainty**2 + known**2))
    return Scale(best, doubt)


def _fitted(terms: Floats, read: Floats) -> tuple[float, Floats, float]:
    """The first of the coefficients that explain (n,) best, none of the others below zero; the
    terms (n, k) that are used, and the squares that they leave.

    The best of all subsets: a library's answer, which takes half a second to load.
    """
    found = []
    for others in ([1, 2], [1], [2], []):
        used = terms[:, [0, *others]]
        sizes = np.linalg.lstsq(used, read, rcond=None)[0]
        if (sizes[1:] > 0.0).all():
            found.append((float(sizes[0]), used, square(read - used @ sizes)))
    return min(found, key=lambda one: one[2])


def _blocks(capture: Capture) -> Iterator[tuple[float, float, float]]:
    """V given and read, and A, of stretches of every part that both switches hold."""
    timeline = lay(capture)
    volts, amperes = capture.channels[VOLTAGE].values, capture.channels[CURRENT].values
    for part in timeline.parts:
        first, last = (int(k) for k in np.searchsorted(timeline.index, (part.start, part.stop)))
        first += EDGE
        count = min(MOST, (last - first) // BLOCK)
        given = _given(capture, part, first, last) if count > 0 else None
        if given is None:
            continue
        for rows in np.array_split(np.arange(first, last), count):
            means = given, float(np.nanmean(volts[rows])), float(np.nanmean(amperes[rows]))
            if np.isfinite(means).all():
                yield means


def _given(capture: Capture, part: Part, first: int, last: int) -> float | None:
    """V that a part's level gives the motor; None: nobody knows, or the supply may be too low."""
    if not part.level or part.decay != Decay.SYNCHRONOUS_SLOW:
        return None
    supply, known = capture.get(SUPPLY), capture.supply_measured_v
    if part.kind == StepKind.DRIVE_VOLTS:
        return part.level if known is None or abs(part.level) <= FULL * known else None
    if part.kind != StepKind.DRIVE_DUTY or known is None:
        return None
    if supply is not None and np.isfinite(supply.values[first:last]).any():
        known = float(np.nanmean(supply.values[first:last]))
    return part.level * known
