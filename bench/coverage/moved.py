"""By how much each effect of a motor moves the six parameters of a fit that lacks it.

By straight lines at the truth, as ``bench.coverage.bound``: what an effect does to the readings is
taken for changes of all that such a fit has unknown. What is left of it then counts as noise of its
channel, as in a fit whose noise is what its residuals are. No code of ``motorid.estimate`` takes
part.
"""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence

import numpy as np

from bench.coverage.bound import NAMES, AtTruth, Floats, weights
from motorid.capture.model import Capture

FIELDS = {
    "reaction": "reaction",
    "saturation": "saturation",
    "eddy": "eddy",
    "quadratic": "windage",
    "load_friction": "load friction",
}
"""The effect of each size among the fields of ``motor.wide``."""
LEAST = 1e-12  # of the largest direction of the information: less is not told
SCALES = ("current gain", "voltage gain", "clock", "series")  # that a fit takes as they are stated
PASSES = 20  # of moves and noise in turn


def moves(
    captures: Sequence[Capture], at: AtTruth, added: Mapping[str, float]
) -> dict[str, dict[str, float]]:
    """Relative moves of R to T0, by effect. ``added``: fields of ``motor.wide`` that it has."""
    found = {}
    for field in (one for one in FIELDS if one in added):
        changes = []
        for capture, twin in zip(captures, at.twins, strict=True):
            weight, whole, less = weights(capture), twin.readings({}), twin.readings({field: -1.0})
            changes.append({n: weight[n] * (whole[n] - less[n]) for n in whole})
        steps = _taken(at, changes, {*added, *SCALES})
        each = zip(NAMES, steps, at.things, strict=False)
        found[FIELDS[field]] = {name: float(step * thing.size) for name, step, thing in each}
    return found


def _taken(at: AtTruth, changes: Sequence[Mapping[str, Floats]], without: Container[str]) -> Floats:
    """Steps (q,) of the things that are left, which best explain every run's weighed changes."""
    left = at.known(without)
    priors = np.diag(at.priors[left])
    columns = [rows[left] for rows in at.columns]
    joined = [np.concatenate(list(change.values())) for change in changes]
    noise = dict.fromkeys(changes[0], 1.0)  # in units of the declared
    for _ in range(PASSES):
        shares = [
            np.concatenate([np.full(len(part), noise[name] ** -2) for name, part in change.items()])
            for change in changes
        ]
        each = list(zip(columns, shares, joined, strict=True))
        information = priors + sum((rows * share) @ rows.T for rows, share, _ in each)
        pull = sum(rows @ (share * change) for rows, share, change in each)
        scale = 1.0 / np.sqrt(np.maximum(np.diag(information), 1e-300))
        inverse = np.linalg.pinv(information * np.outer(scale, scale), LEAST, hermitian=True)
        steps = scale * (inverse @ (scale * pull))
        noise = _noise(changes, [change - steps @ rows for rows, _, change in each])
    return np.asarray(steps)


def _noise(changes: Sequence[Mapping[str, Floats]], left: Sequence[Floats]) -> dict[str, float]:
    """Of each channel, in units of the declared: that, and what is left of the changes."""
    squares: dict[str, list[Floats]] = {name: [] for name in changes[0]}
    for change, rest in zip(changes, left, strict=True):
        ends = np.cumsum([len(part) for part in change.values()])[:-1]
        for name, part in zip(change, np.split(rest, ends), strict=True):
            squares[name].append(part**2)
    return {n: float(np.sqrt(1.0 + np.concatenate(each).mean())) for n, each in squares.items()}
