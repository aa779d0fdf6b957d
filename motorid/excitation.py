"""Excitations that are many ordinary steps: PRBS and multisine for the iron, a slow turn. Pure.

A PRBS (pseudo-random binary sequence) of n bits is the output of a shift register with feedback by
a primitive polynomial: 2ⁿ - 1 chips, whose spectrum is flat up to about 0.4 of the chip rate. Chips
of one level are one step, so that it takes 2ⁿ⁻¹ steps.

    S. W. Golomb, Shift Register Sequences, Holden-Day 1967
    M. R. Schroeder, Synthesis of low-peak-factor signals, IEEE Trans. Inf. Theory 16, 1970
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

from motorid.errors import UsageError
from motorid.program import Decay, Step, StepKind

TAPS = {  # of primitive polynomials, by bits
    2: (2, 1), 3: (3, 2), 4: (4, 3), 5: (5, 3), 6: (6, 5), 7: (7, 6), 8: (8, 6, 5, 4),
}  # fmt: skip
POINTS_A_PERIOD = 4  # of a multisine's highest tone: fewer are no sine
GRID = 4096  # points at which a multisine's peak is sought
BRAKE_S = 0.05  # between the two directions of a slow turn


@dataclass(frozen=True)
class Levels:
    """About which level a signal swings, and how far; volts or duties, by ``kind``."""

    kind: StepKind
    centre: float
    amplitude: float
    decay: Decay = Decay.SYNCHRONOUS_SLOW

    def steps(self, shape: Sequence[float], duration_s: float) -> tuple[Step, ...]:
        """One step for each run of equal values of ``shape`` (-1 to 1), evenly in time."""
        each_s = duration_s / len(shape)
        runs = ((value, len(list(same))) for value, same in groupby(shape))
        return tuple(
            Step(self.kind, each_s * count, self.centre + self.amplitude * value, self.decay)
            for value, count in runs
        )


def chips(bits: int) -> tuple[int, ...]:
    """One period of the PRBS of so many bits: 2**bits - 1 values of 1 or -1."""
    state, out = [1] * bits, []
    for _ in range(2**bits - 1):
        out.append(2 * state[-1] - 1)
        state = [sum(state[tap - 1] for tap in TAPS[bits]) % 2, *state[:-1]]
    return tuple(out)


def prbs(levels: Levels, bits: int, duration_s: float) -> tuple[Step, ...]:
    """One period of a PRBS over ``duration_s``."""
    return levels.steps(chips(bits), duration_s)


def multisine(levels: Levels, tones: int, points: int, duration_s: float) -> tuple[Step, ...]:
    """A sum of ``tones`` sines as a staircase of ``points`` steps; its peak is the amplitude.

    The tones are harmonics of 1/``duration_s``, evenly spread in the logarithm up to the highest
    that the points show, with Schroeder's phases. Raises UsageError where they do not fit.
    """
    highest = points // POINTS_A_PERIOD
    if tones > highest:
        raise UsageError(
            f"{tones} tones need {POINTS_A_PERIOD * tones} points or more, not {points}: raise "
            "points, or lower tones"
        )
    orders = _spread(tones, highest)

    def at(turn: float) -> float:
        each = enumerate(orders)
        return sum(
            math.cos(2 * math.pi * order * turn - math.pi * k * (k + 1) / tones)
            for k, order in each
        )

    peak = max(abs(at(n / GRID)) for n in range(GRID))
    shape = [at((n + 0.5) / points) / peak for n in range(points)]
    return levels.steps(shape, duration_s)


def slow_turn(levels: Levels, duration_s: float) -> tuple[Step, ...]:
    """Forwards at the amplitude, a brake, and backwards: each way ``duration_s`` long."""
    ways = (levels.steps((sign,), duration_s)[0] for sign in (1.0, -1.0))
    forwards, backwards = ways
    brake = Step(StepKind.BRAKE, BRAKE_S)
    return forwards, brake, backwards, brake


def _spread(tones: int, highest: int) -> list[int]:
    """So many different harmonics from 1 to the highest, evenly in the logarithm if they can."""
    found: list[int] = []
    for k in range(tones):
        wished = round(highest ** (k / max(tones - 1, 1)))
        found.append(max(wished, found[-1] + 1 if found else 1))
    while found[-1] > highest:  # pushed up by those below
        found = [min(order, highest - (tones - 1 - k)) for k, order in enumerate(found)]
    return found
