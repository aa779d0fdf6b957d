"""A converter that repeats itself: stretches of equal readings where noise would part them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SUPPLY, VOLTAGE, Capture, Channel
from motorid.estimate.results.estimate import Suspect

Bools = NDArray[np.bool_]
Floats = NDArray[np.float64]

FLANK = 64  # readings on either side that show how often neighbours are equal
CHANCE = 1e-4  # of such a stretch in the whole capture, by noise alone
QUIET = 0.7  # share of equal neighbours above which nothing can be told
FLICKER = 3  # steps of the converter, by which a second difference is more than two codes in turn
LIVELY = 0.05  # share of second differences beyond that: noise of two thirds of a step or more
LONGEST_REPEAT = 8  # readings for one conversion
UNEVEN = 0.3  # between the places of a repeat, in share of equal neighbours
ANALOGUE = (CURRENT, VOLTAGE, SUPPLY)


@dataclass(frozen=True)
class Held:
    """A channel that holds: ``repeat`` readings each (0: now and then), or ``stuck`` in all."""

    channel: str
    repeat: int
    stuck: int
    first: int


def suspects(capture: Capture) -> list[Suspect]:
    """One for each channel that holds."""
    return [_said(found, capture) for found in find(capture)]


def _said(found: Held, capture: Capture) -> Suspect:
    name = found.channel.replace("_", " ")
    if found.repeat:
        evidence = f"each reading of the {name} comes {found.repeat} times over"
        action = "sample no faster than the converter converts"
    else:
        evidence = (
            f"{found.stuck} readings of the {name} repeat the one before where noise would part "
            f"them, first at {capture.time_s[found.first]:.4g} s"
        )
        action = "look for a converter that is read too early, or a bus that is too busy"
    return Suspect("readings_held", name, evidence, action, "named")


def find(capture: Capture) -> list[Held]:
    """The channels of ``capture`` that hold their readings."""
    known = capture.provenance.get("held", {}) or {}
    out = []
    for name in ANALOGUE:
        channel = capture.get(name)
        if channel is not None and channel.resolution > 0 and name not in known:
            found = _of(channel)
            if found is not None:
                out.append(found)
    return out


def _of(channel: Channel) -> Held | None:
    raw = np.asarray(channel.raw, dtype=np.float64)
    equal = (raw[1:] == raw[:-1]) & ~channel.saturated[1:]
    repeat = _repeat(equal)
    if repeat:
        return Held(channel.name, repeat, 0, 0)
    starts, lengths = _runs(equal)
    total = np.concatenate([[0], np.cumsum(equal)])
    lively = np.concatenate([[0, 0], np.cumsum(_beyond_flicker(channel))])
    again = np.concatenate([[0, 0], np.cumsum(equal[1:] & equal[:-1])])  # equal after equal
    stuck, first = 0, -1
    for start, length in zip(starts.tolist(), lengths.tolist(), strict=True):
        low, high = max(start - FLANK, 0), min(start + length + FLANK, len(equal))
        around = high - low - length
        alone = total[high] - total[low] - length
        both = again[high] - again[low] - (length - 1)
        # noise that a filter has slowed keeps readings equal for longer
        usual = max((alone + 1) / (around + 2), (both + 1) / (alone + 2))
        noisy = lively[high] - lively[low] > LIVELY * around
        if not noisy:  # less noise than a step keeps readings equal wherever the signal lies
            continue
        if around >= FLANK // 2 and usual < QUIET and len(raw) * usual**length < CHANCE:
            beside = np.concatenate([raw[low:start], raw[start + length + 1 : high + 1]])
            if len(raw) * _share(raw[start], beside) ** length >= CHANCE:
                continue
            stuck += length
            first = start if first < 0 else first
    return Held(channel.name, 0, stuck, first) if stuck else None


def _share(code: float, raw: Floats) -> float:
    """The share of readings (n,) that are that code.

    Noise of a converter's step leaves more readings at the middle code than it makes neighbours
    equal over all codes, and a stretch of equal ones is mostly one of that code.
    """
    return float((np.count_nonzero(raw == code) + 1) / (len(raw) + 2))


def _beyond_flicker(channel: Channel) -> Bools:
    """Readings (n − 2,) that stand out of both neighbours by more than two neighbouring codes can
    make, beside another that stands out; those of a signal on its way, or that turns, do not.
    """
    changes = np.diff(channel.values) / channel.resolution
    back = np.concatenate([[False], changes[1:] * changes[:-1] < 0.0, [False]])
    large = np.abs(np.diff(changes)) > FLICKER - 0.5
    return np.asarray(back[1:-1] & large & (back[:-2] | back[2:]))


def _repeat(equal: Bools) -> int:
    """The number of readings for one conversion, 0 where each is its own."""
    for repeat in range(LONGEST_REPEAT, 1, -1):
        whole = equal[: len(equal) // repeat * repeat].reshape(-1, repeat)
        if len(whole) < FLANK:
            continue
        share = np.sort(whole.mean(axis=0))
        if share[0] < QUIET and share[1] - share[0] > UNEVEN and share[1] > 1 - 0.1 * UNEVEN:
            return repeat
    return 0


def _runs(equal: Bools) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Starts and lengths of the runs of True that are longer than chance ever makes them."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], equal, [False]]).astype(np.int8)))
    starts, stops = edges[::2], edges[1::2]
    long = stops - starts >= 6
    return starts[long], (stops - starts)[long]
