"""The head of a part: its first samples, in which the source follows the readings themselves."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.signals.time_grid import Part

Floats = NDArray[np.float64]

HEAD = 8  # samples after a command that are too few to smooth, and no line is drawn through
FAINT = 0.02  # of a part's largest change of current: one that tells nothing of what it does
MOST_SHARE = 1.5  # of a reading's departure that its interval may have
DOUBT = 0.25  # of the departure that an interval is taken to have more or less than its reading


def shares(current: Floats, mean: Floats, known: NDArray[np.intp], part: Part) -> Floats:
    """Of a reading's departure from the line, what its interval has of it, (HEAD,).

    A supply gives way by the current, which has only begun to flow at a command: in the first
    interval it has sagged less than in a window at that interval's end, or than in the next
    interval, whose reading stands for a first one that shows the command before.
    """
    here = slice(part.start, part.start + HEAD)
    at_command = float(np.nan_to_num(mean[part.start - 1])) if part.start else 0.0
    seen = np.interp(np.arange(HEAD), known, current[part.slice][known]) - at_command
    grown = np.nan_to_num(mean[here]) - at_command
    tells = np.abs(seen) > FAINT * np.abs(seen).max()
    return np.clip(np.where(tells, grown, 1.0) / np.where(tells, seen, 1.0), 0.0, MOST_SHARE)


def head_errors(
    known: NDArray[np.intp], share: Floats, departure: Floats, noise: float
) -> tuple[Floats, ...]:
    """V (head,): the noise of every reading that the head follows, and the doubt of its shares."""
    place = np.arange(len(share))
    own = known[: int(np.searchsorted(known, len(share))) + 1]
    reach = [np.interp(place, own, unit) for unit in np.eye(len(own))]
    return (*(noise * share * one for one in reach), DOUBT * (share - 1.0) * departure)
