"""An inductance that no reading shows: what PWM does with it tells it.

Where L/R is far below a sample and the current is a mean over whole PWM periods, no reading shows
how a current rises. How far it swings within those periods still depends on L, and with that what
brushes and dead time take. Judged by the search's own last answer, a wrong L brings a wrong loss,
and that an L which is worse: the search runs off, and takes friction with it. So one inductance
after the other is held, what drives the motor is judged by it, and the likeliest is taken. With
diode decay the size of the pulses tells it (pulses.py). How well either is foretold bounds it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np

from motorid.capture.model import CURRENT, SUPPLY, Capture
from motorid.estimate.effects.iron.eddies_in_pulses import USUAL as IRON
from motorid.estimate.effects.source.held_inductance import Foretold
from motorid.estimate.fit import discontinuous_current_inductance
from motorid.estimate.fit.alternating_fit import (
    ROUGH,
    again,
    in_turn,
    near_inductance,
    vanished,
    with_inductance,
)
from motorid.estimate.fit.multistart import whitened, with_promoted, with_repeated
from motorid.estimate.fit.parameter_bounds import merged
from motorid.estimate.model import prewhitening
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.program_parts import by_part
from motorid.estimate.solver.dense_products import square
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.covariance import statistical

Fitted = tuple[list[MotorRecord], Solution]

UNSEEN = 0.05  # standard deviation of the logarithm of an inductance that readings hardly tell
WHITE = 0.1  # of that: the least of white noise, from which correlated noise may be as much
RIPPLE, PULSES = "ripple", "pulses"  # within PWM periods
BY = {RIPPLE: 0.08, PULSES: 0.04}  # the same of one that these tell
TRUSTED = 0.15  # of the logarithm by readings: those that know it no better are no authority
APART = 3.0  # standard deviations by which a contradiction is one
NOMINAL = 0.03  # relative standard uncertainty of a supply that nobody measured
BETTER = 0.5  # of their standard deviation: what readings tell that well they should not lose
LARGEST, SMALLEST = 2.0, 0.01  # of those held: L/R in sample periods
CLOSE = 0.04  # logarithm: near enough to the likeliest; all that are held are steps of it from 1 H
COARSE, FINER = 12, (6, 3, 2, 1)  # such steps from one that is held to the next
CLEAR = 30.0  # of chi-square, by which a next one is worse than the likeliest
ROUGH_TIMES = 5.0  # the same, of what it jumps about from one to the next
JUDGED = 2  # times at most that what residuals are like is taken from the likeliest
KEPT = 0.3  # logarithm, by which a search may depart from it


def told(
    records: Sequence[MotorRecord],
    free: Sequence[str],
    fixed: Mapping[str, float],
    known: Mapping[str, float],
    seen: Solution,
) -> Fitted | None:
    """Other records of the same captures, and their solution with an inductance that ``seen``, at
    ``known`` values, hardly tells; None where it does, or where neither ripple nor pulses can.
    """
    unsure = _unsure(seen, records)
    if unsure < UNSEEN:
        return None
    search = _Search(records, free, fixed, known, seen)
    inductance_h, by = discontinuous_current_inductance.inductance(records, seen), PULSES
    if not inductance_h and any(record.ripples for record in records):
        inductance_h, by = search.by_ripple(), RIPPLE
    found = None
    if inductance_h and not _contradicted(inductance_h / known["L"], by, unsure):
        found = search.ended(inductance_h, by)
    last = found[0] if found else ()
    without, whole = search.spent(last), search.spent()
    for record in last:
        record.simulated += without
    for record in records:
        record.simulated += whole
    return found


def _contradicted(ratio: float, by: str, unsure: float) -> bool:
    """By readings that are some authority, and tell an inductance so many times smaller."""
    return unsure < TRUSTED and abs(math.log(ratio)) > APART * math.hypot(unsure, BY[by])


def _of_chain(capture: Capture) -> float:
    """What an inductance is uncertain by, as it goes with the supply over the current."""
    current, supply = capture.get(CURRENT), capture.get(SUPPLY)
    rail = NOMINAL if supply is None else supply.gain_uncertainty
    return math.hypot(rail, current.gain_uncertainty if current is not None else 0.0)


def _unsure(solution: Solution, records: Sequence[MotorRecord]) -> float:
    """Standard deviation of the logarithm of the inductance, as far as it matters; 0: held."""
    if all(unknown.name != "L" for unknown in solution.unknowns):
        return 0.0
    k = _place(solution)
    if solution.at_bound[k] or vanished(solution, records):
        return math.inf
    white = math.sqrt(max(float(solution.covariance[k, k]), 0.0))
    return white if white < WHITE * UNSEEN else _deviation(solution, records)


@dataclass(frozen=True)
class _Search:
    """Fits of captures with one inductance after the other, all from ``known`` values.

    ``before`` are records of them that have a solution with those values, ``near``.
    """

    before: Sequence[MotorRecord]
    free: Sequence[str]
    fixed: Mapping[str, float]
    known: Mapping[str, float]
    near: Solution
    trials: list[Sequence[MotorRecord]] = field(default_factory=list)

    def spent(self, but: Sequence[MotorRecord] = ()) -> int:
        """Responses of all trials but that of these records, which count their own."""
        others = (records for records in self.trials if records is not but)
        return sum(max(record.simulated for record in records) for records in others)

    def held(self, inductance_h: float) -> Fitted:
        """With that one, until what drives the motor stays."""
        return self._by(with_inductance, inductance_h)

    def compared(self, inductance_h: float) -> Fitted:
        """With that one, as far as it takes to be compared with others."""
        return self._by(near_inductance, inductance_h)

    def _by(self, fitted: Callable[..., Solution], inductance_h: float) -> Fitted:
        """In records of its own."""
        records = [
            MotorRecord(record.capture, self.free, self.fixed, record.shape)
            for record in self.before
        ]
        near = _as_of(records, self.before, self.near)
        solution = fitted(records, self.free, self.known, near, inductance_h)
        self.trials.append(records)
        return records, solution

    def by_ripple(self) -> float | None:
        """H of the likeliest where others are clearly less likely.

        Held are the same ones wherever the search ran off to before: that hangs on last digits.
        """
        tau = self.known["R"] * min(r.timeline.period_s for r in self.before)
        smallest, largest = (math.log(tau * part) / CLOSE for part in (SMALLEST, LARGEST))
        places = range(math.floor(largest / COARSE) * COARSE, math.floor(smallest), -COARSE)
        held = cache(lambda place: self.compared(math.exp(place * CLOSE)))
        likeliest = min(places, key=lambda place: held(place)[1].objective)
        for _ in range(JUDGED):
            worse = self._by_noise_of(likeliest, held)
            before, likeliest = likeliest, min(places, key=worse)
            if likeliest == before:
                break
        if likeliest in (places[0], places[-1]) or not any(_clear(likeliest, worse, CLEAR)):
            return None
        near = {likeliest: worse(likeliest)}
        for step in FINER:
            near |= {place: worse(place) for place in (likeliest - step, likeliest + step)}
            likeliest = min(near, key=near.__getitem__)
        clear = max(CLEAR, ROUGH_TIMES * _roughness(near))
        if not all(_clear(likeliest, worse, clear)):
            return None
        far = (place for place in places if abs(place - likeliest) > COARSE)
        if any(worse(place) < worse(likeliest) + clear for place in far):  # as likely elsewhere
            return None
        return math.exp(likeliest * CLOSE)

    def _by_noise_of(self, likeliest: int, held: Callable[[int], Fitted]) -> Callable[[int], float]:
        """How unlikely a place is, by residuals as slow and as coloured as those of another."""
        like, at = held(likeliest)
        prewhitening.whiten(like, at)
        prewhitening.thin(like, at)

        @cache
        def worse(place: int) -> float:
            records, solution = held(place)
            for record, other in zip(records, like, strict=True):
                record.weigh_as(other)
            solution = replace(solution, derivatives=None)
            return again(
                records, self.free, self.known, solution, held_h=math.exp(place * CLOSE)
            ).objective

        return worse

    def ended(self, inductance_h: float, by: str) -> Fitted | None:
        """With an inductance known ``by`` something, or better if its readings tell it.

        None where they would determine it better, if it were that, but do not.
        """
        unsure = max(math.hypot(BY[by], _of_chain(record.capture)) for record in self.before)
        records, held = self.held(inductance_h)
        would_tell = _deviation(held, records)
        alone = self.finished(records, held)
        if _stays(alone, held, _deviation(alone, records), unsure):
            return records, alone
        if would_tell < BETTER * unsure:
            return None
        _, larger = self.held(inductance_h * math.exp(math.hypot(unsure, IRON)))
        records, held = self.held(inductance_h)
        for record in records:
            record.foretold = Foretold(inductance_h, by, _shift(held, larger))
        return records, self.finished(records, held)

    def finished(self, records: Sequence[MotorRecord], held: Solution) -> Solution:
        """From a held one to an end like that of any other fit."""
        start = merged(self.known, held)
        for record, before in zip(records, self.before, strict=True):
            record.rivals = before.rivals
        solution = in_turn(records, self.free, start, again(records, self.free, start, held, ROUGH))
        solution = with_promoted(records, self.free, start, solution)
        solution = with_repeated(records, self.free, start, solution)
        return whitened(records, self.free, merged(start, solution), solution)


def _clear(place: int, worse: Callable[[int], float], by: float) -> list[bool]:
    """Whether the next smaller and the next larger one are so much less likely."""
    return [worse(side) >= worse(place) + by for side in (place - COARSE, place + COARSE)]


def _roughness(valley: Mapping[int, float]) -> float:
    """By how much chi-square at neighbouring places jumps about a parabola through them (rms).

    Each search makes its own choices of what drives the motor: by the readings' noise, where the
    inductance is of no account.
    """
    places, values = np.array([*valley.items()]).T
    table = np.vander(places - places.mean(), 3)
    left = values - table @ np.linalg.lstsq(table, values, rcond=None)[0]
    return float(np.sqrt(square(left) / max(len(left) - 3, 1)))


def _as_of(
    records: Sequence[MotorRecord], before: Sequence[MotorRecord], solution: Solution
) -> Solution:
    """A solution of records ``before`` with the own unknowns of others of the same captures: what
    the fit has promoted since is none of theirs yet.
    """
    known = [record.sizes(own) for record, own in zip(before, solution.own, strict=True)]
    own = (
        np.array([sizes.get(unknown.name, unknown.start) for unknown in record.unknowns])
        for record, sizes in zip(records, known, strict=True)
    )
    return replace(solution, own=tuple(own))


def _stays(alone: Solution, held: Solution, deviation: float, unsure: float) -> bool:
    """The search keeps to what it was given, and its readings tell it better."""
    k = _place(alone)
    moved = math.log(float(alone.values[k] / held.values[k]))
    return not alone.at_bound[k] and abs(moved) < KEPT and deviation < unsure


def _place(solution: Solution) -> int:
    return [unknown.name for unknown in solution.unknowns].index("L")


def _deviation(solution: Solution, records: Sequence[MotorRecord]) -> float:
    """Of the logarithm of the inductance, whatever the noise, with the spread of the parts."""
    spread = statistical(solution, parts=by_part(solution, records))
    return float(spread.deviations[_place(solution)])


def _shift(held: Solution, larger: Solution) -> dict[str, float]:
    """By name, of search coordinates."""
    each = zip(held.unknowns, held.values, larger.values, strict=True)
    return {
        u.name: math.log(float(b / a)) if u.log and a > 0 and b > 0 else float(b - a)
        for u, a, b in each
    }
