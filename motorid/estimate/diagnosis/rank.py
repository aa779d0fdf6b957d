"""Who is to blame: from cheap looks at the readings to fits with a fault's size as an unknown."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.diagnosis import misfit, reach
from motorid.estimate.diagnosis.facts.current_sense import at_supply
from motorid.estimate.diagnosis.fault import Hypothesis
from motorid.estimate.diagnosis.faults import (
    channel_delay,
    common_mode,
    current_limited_supply,
    decay_mode,
    declared_brushes,
    distorted_readings,
    encoder_bandwidth,
    load_slip,
    lost_rows,
    model_alternatives,
    saturation,
    unstated_channels,
)
from motorid.estimate.diagnosis.faults.bridge import pulse_distortion, supply_path
from motorid.estimate.diagnosis.faults.encoder_bandwidth import jumps
from motorid.estimate.diagnosis.faults.filters import aperture, high_pass_filter, low_pass_filter
from motorid.estimate.diagnosis.faults.readings import repeated_readings
from motorid.estimate.diagnosis.faults.zeros import current_zero, voltage_zero
from motorid.estimate.diagnosis.input_noise import InputNoise
from motorid.estimate.diagnosis.refit import Refit, at, go_on, refit, rest
from motorid.estimate.diagnosis.refit import starts as begin_at
from motorid.estimate.diagnosis.score_test import Screen
from motorid.estimate.fit.block_regression import Size
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import Parameter, Suspect
from motorid.estimate.solver.autoregression import inflation
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.covariance import covariance_of

Floats = NDArray[np.float64]

SCREENED = (
    channel_delay,
    low_pass_filter,
    saturation,
    current_zero,
    common_mode,
    high_pass_filter,
    voltage_zero,
    decay_mode,
    aperture,
    distorted_readings,
    declared_brushes,
    supply_path,
    encoder_bandwidth,
)  # by derivatives
SEEN = (load_slip, saturation, encoder_bandwidth, current_limited_supply)  # in blocks: too far
WORTH = 0.08  # fall of F for each reading that a hypothesis must promise, to be fitted; or CLEAR
RIVAL = 0.1  # of the best promise, that makes a rival,
PEER = 0.5  # and that makes one of what a motor does: it stands at the same linear laws
REST = 0.01  # of all that there is to explain: a fault that leaves less has no rival
MOST = 4  # rivals
SURELY = 0.7  # fall of F for each reading that names a suspect,
LIKELY = 0.1  # or this much,
CLEAR = 200.0  # or this much in all, of a misfit too small to matter but for what it moves,
NEAR = 2e-3  # of all that there is to explain: not worth another step of a fit
SHARE = 0.3  # and this share of all that there is to explain,
PART = 0.15  # the least share of a fault that explains so much surely
STRIDES = 8, 4, 2, 1  # of a place over a hypothesis' sizes
FEW, BETTER = 4, 2  # steps of a fit from every size, and how many go on to their end
MUCH = 0.5  # of the misfit, that a fault leaves: another may be larger; or explains of a small one
ALL = 0.9  # of the misfit: what explains so much is told, even where it moves nothing
MOSTLY = 0.75  # the least share of a vague one that explains a small misfit
ODD = 2.0  # excess of one run over that of any other, which makes it the one to look at
HARMLESS = {"current_offset", "supply_limited"}  # a fit may allow for them: others are sought too
HARM = 0.002  # relative shift of a parameter that makes a fault worth naming,
BEYOND = 2.0  # or this many of its standard uncertainties by noise,
SURE = 4.0  # standard deviations of what noise of a voltage makes of a fault's size
PART_OF_ALL = 0.25  # of which none counts as less than this of all that is uncertain of it


@dataclass(frozen=True)
class Trial:
    """A hypothesis after its own fit: ``gain`` is how far F fell for each reading; ``clear``: that
    is far beyond chance.

    ``share`` is that of all that there is to explain; ``shift`` how the fault moved each parameter,
    as a share of it, the ``farthest`` in ``_deviations``; ``seen``: the plain laws show it in
    blocks of the capture; ``chance``: share of its size that noise of a voltage makes; ``own``: as
    ``gain``, by what chance gives the fault itself, at most as much; ``alone``: it explains half
    without that, or jumps show it: chance that adds up explains any ripple.
    """

    hypothesis: Hypothesis
    found: Refit
    gain: float
    share: float
    shift: Mapping[str, float]
    farthest: float
    clear: bool
    seen: bool = False
    chance: float = 0.0
    own: float = 0.0
    alone: bool = True

    @property
    def convincing(self) -> bool:
        """It explains enough, and matters; what the blocks show needs less."""
        much = self.gain > SURELY and (self.seen or self.share > PART)
        much |= self.gain > LIKELY and (self.seen or self.share > SHARE)
        far = self.farthest > BEYOND
        harms = far or max(abs(s) for s in self.shift.values()) > HARM
        harms |= self.gain > SURELY and self.share > ALL  # it leaves a lack of fit, and doubts
        most = MOSTLY if self.hypothesis.vague else MUCH
        enough = (much and harms) or (self.clear and self.share > most and far)
        told = self.alone and abs(float(self.found.size[0])) >= self.hypothesis.least
        return enough and told and not self.at_bound and self.chance * SURE < 1.0

    @property
    def at_bound(self) -> bool:
        """Its size ends where such faults do: it stands in for another that the list has not."""
        h = self.hypothesis
        return bool((self.found.size <= h.lower).any() or (self.found.size >= h.upper).any())


@dataclass(frozen=True)
class Convicted:
    """A fault that a fit with its size as an unknown names; ``records``: those that have it."""

    suspect: Suspect
    records: tuple[int, ...]
    trial: Trial


def suspects(
    records: Sequence[MotorRecord], solution: Solution, parameters: Mapping[str, Parameter]
) -> tuple[tuple[Suspect, ...], Convicted | None]:
    """What in the measuring chain spoils these captures, the surest first, and which of it was
    convicted by a fit; empty: nothing seen. ``parameters``: how well each is known.
    """
    looks = unstated_channels, pulse_distortion, high_pass_filter
    found = direct(records) + [s for look in looks for s in look.suspects(records, solution)]
    others = [s for s in found if s.code != encoder_bandwidth.LOST]
    if spoiling(others):
        return tuple(found), None
    some, alone, k = _odd_one_out(records, solution)
    trial = tried(some, alone, parameters)
    if trial is None or trial.hypothesis.code in {f.code for f in found}:
        return tuple(found), None
    if spoiling(found) and trial.hypothesis.code != encoder_bandwidth.MISSED:
        return tuple(found), None  # counts that are lost at no rate of their own
    where = "" if k is None else f" (run {k + 1})"
    said = _said(trial, some, alone, where)
    convicted = Convicted(said, tuple(range(len(records))) if k is None else (k,), trial)
    return (*others, convicted.suspect), convicted


def spoiling(found: Sequence[Suspect]) -> bool:
    """Whether one of these makes the parameters worthless as long as it is there."""
    return any(s.code not in HARMLESS and not s.allowed for s in found)


def _odd_one_out(
    records: Sequence[MotorRecord], solution: Solution
) -> tuple[Sequence[MotorRecord], Solution, int | None]:
    """The one run that misfits far more than the others and its place, or all of them and None.

    In the fit of all runs together, or where that has spread the misfit, each in its own.
    """
    alone = [_alone(solution, k) for k in range(len(records))]
    together = misfit.of_fit(records, solution)
    k = _odd(records, alone)
    if k is None and together > LIKELY and len(records) > 1:
        runs = zip(records, alone, strict=True)
        alone = [refit([record], [start]).search for record, start in runs]
        k = _odd(records, alone)
    if k is None:
        return records, solution, None
    return records[k : k + 1], alone[k], k


def _odd(records: Sequence[MotorRecord], alone: Sequence[Solution]) -> int | None:
    """Which run's residuals in its own solution stand out; None: no one's."""
    each = [
        misfit.of_fit([record], solution) for record, solution in zip(records, alone, strict=True)
    ]
    k = int(np.argmax(each))
    others = max(each[:k] + each[k + 1 :], default=np.inf)
    return k if each[k] >= ODD * others + LIKELY else None


def _alone(solution: Solution, k: int) -> Solution:
    """A solution as of its run ``k``."""
    return replace(
        solution,
        own=solution.own[k : k + 1],
        own_covariance=solution.own_covariance[k : k + 1],
        linearise=lambda: solution.records[k : k + 1],
    )


def direct(records: Sequence[MotorRecord]) -> list[Suspect]:
    """What the readings show by themselves."""
    found: list[Suspect] = []
    for k, record in enumerate(records):
        run = [
            *encoder_bandwidth.unsized(record),
            *lost_rows.suspects(record.capture, record.judged_at),
            *repeated_readings.suspects(record.capture),
            *at_supply.suspects(record.capture),
            *current_zero.suspects(record),
            *current_limited_supply.suspects(record),
        ]
        where = f" (run {k + 1})" if len(records) > 1 else ""
        found += [replace(s, evidence=s.evidence + where) for s in run]
    return found


def tried(
    records: Sequence[MotorRecord], solution: Solution, parameters: Mapping[str, Parameter]
) -> Trial | None:
    """What a fit with its size as an unknown convicts: the best of all, if it convinces."""
    found = trials(records, solution, parameters)
    if not found or found[0].hypothesis.guard or not found[0].convincing:
        return None
    return found[0]


def _said(best: Trial, records: Sequence[MotorRecord], solution: Solution, where: str) -> Suspect:
    words = best.hypothesis.words(best.found.size)
    name, most = max(best.shift.items(), key=lambda s: abs(s[1]))
    evidence = (
        f"{words.evidence}; that explains {min(best.share, 1.0):.0%} of the misfit, and "
        f"taken into account moves {name} by {most:+.1%}{where}"
    )
    moves = _moves(best, records, solution)
    return Suspect(best.hypothesis.code, words.where, evidence, words.action, "named", moves)


def _moves(best: Trial, records: Sequence[MotorRecord], solution: Solution) -> dict[str, float]:
    """SI, by parameter: how far the fault moved it, or what of it is the fault's own; or how much
    of it the rest of the misfit hides, where the fault leaves much.
    """
    names = [u.name for u in solution.unknowns]
    moved = _moved(best.hypothesis, best.found, solution.values, names)
    moves, rest = dict(zip(names, moved, strict=True)), 1.0 - best.share
    if rest <= MUCH:
        return moves
    hidden = reach.hidden(records, solution, rest)
    return {name: max(move, hidden[name]) for name, move in moves.items()}


def _moved(h: Hypothesis, found: Refit, usual: Floats, names: Sequence[str]) -> list[float]:
    """The same, in the order of ``names``, from ``usual`` (p,)."""
    own = h.belongs(found.size) if h.belongs is not None else {}
    each = zip(names, found.values.tolist(), usual.tolist(), strict=True)
    return [max(abs(v - u), own.get(name, 0.0) * abs(v)) for name, v, u in each]


def trials(
    records: Sequence[MotorRecord], solution: Solution, parameters: Mapping[str, Parameter]
) -> list[Trial]:
    """Each that promises enough, after its own fit, the best first; of equals a vague one last."""
    residuals = misfit.residuals(records, solution)
    readings = sum(m.block.count for r in records for m in r.measured)
    excess = misfit.excess(records, residuals)
    clear = CLEAR * inflation(solution)
    least = min(LIKELY * readings, clear)
    if excess * readings < least:
        return []
    driven = InputNoise.of(records, solution)
    if misfit.excess(records, residuals, driven.variances()) * readings < least:
        return []
    rivals = list(_rivals(records, solution, min(WORTH * readings, clear), driven.screen))
    if not rivals:
        return []
    starts, enough = begin_at(records, solution), max(NEAR * excess * readings, 1.0)
    usual = refit(records, starts, enough=enough)
    names, deviations = [u.name for u in solution.unknowns], _deviations(solution, parameters)
    out = []
    for hypothesis, size, begin, seen in rivals:
        found = _ended(records, begin or starts, hypothesis, size, enough, usual)
        gain = (usual.objective - found.objective) / readings
        moved = found.values / np.maximum(usual.values, 1e-300) - 1.0
        shift = {
            u.name: float(s)
            for u, s, v in zip(solution.unknowns, moved, usual.values, strict=True)
            if v > 0 and u.name != "B"
        }
        moves = zip(_moved(hypothesis, found, usual.values, names), deviations, strict=True)
        far = max((m / sd for m, sd in moves if sd > 0), default=0.0)
        left, scattered = rest(records, found, hypothesis)
        most = excess if hypothesis.scatter is None else gain + left
        share, sure = gain / max(most, 1e-9), gain * readings > clear
        chance = driven.share(hypothesis, found.size)
        own = min(scattered, gain)
        alone = hypothesis.scatter is None or gain > MUCH * excess or jumps(records)
        trial = Trial(hypothesis, found, gain, share, shift, far, sure, seen, chance, own, alone)
        out.append(trial)
        if (
            trial.convincing
            and not hypothesis.vague
            and left < min(REST * excess, clear / readings)
        ):
            break
    return sorted(out, key=lambda t: clear / readings * t.hypothesis.vague - t.gain - t.own)


def _deviations(solution: Solution, parameters: Mapping[str, Parameter]) -> list[float]:
    """SI, by unknown: what noise leaves open of it, or a part of all that is where that is more. A
    shift far below what instruments leave open harms nobody.
    """
    totals = {name: p.total or 0.0 for name, p in parameters.items()}
    noise = solution.slopes * np.sqrt(np.diag(covariance_of(solution.information)))
    each = zip(solution.unknowns, noise.tolist(), strict=True)
    return [max(sd, PART_OF_ALL * totals.get(u.name, 0.0)) if sd > 0.0 else sd for u, sd in each]


def _ended(
    records: Sequence[MotorRecord],
    starts: Sequence[Solution],
    h: Hypothesis,
    size: Size,
    enough: float,
    usual: Refit,
) -> Refit:
    """The best fit from ``size``; of a fault that acts in whole samples the better ones of few
    steps each from all sizes: on its way from one to another a search meets valleys. One that is
    worse than the ``usual`` fit, without a fault, is in a wrong one.
    """
    if h.place is not None:
        found = refit(records, starts, h, size, enough)
        some = found.objective < usual.objective
        return _placed(records, starts[0], h, found, enough) if some else found
    if not h.stepwise:
        return refit(records, starts, h, size, enough)
    sizes = dict.fromkeys((size, *h.sizes))
    tried = [
        (refit(records, [start], h, one, enough, FEW), start) for one in sizes for start in starts
    ]
    begun = sorted(tried, key=lambda each: each[0].objective)[:BETTER]
    better = [each for each in begun if each[0].objective < usual.objective]
    ended = [go_on(records, start, h, one, enough) for one, start in better]
    return min(ended, key=lambda one: one.objective, default=begun[0][0])


def _placed(
    records: Sequence[MotorRecord], near: Solution, h: Hypothesis, found: Refit, enough: float
) -> Refit:
    """A fit whose place is the best that strides over the hypothesis' sizes find, each half as
    long: derivatives promise most at a place where others would explain more.
    """
    sizes = list(h.sizes)
    k = min(range(len(sizes)), key=lambda j: abs(sizes[j][-1] - float(found.size[-1])))
    for stride in STRIDES:
        for j in (k - stride, k + stride):
            if not 0 <= j < len(sizes):
                continue
            there = replace(near, values=found.values, own=found.search.own)
            begun = (float(found.size[0]), *sizes[j][1:])
            other = refit(records, [there], h, begun, enough, FEW)
            if other.objective < found.objective:
                k, found = j, other
    return go_on(records, near, h, found, enough)


def _rivals(
    records: Sequence[MotorRecord],
    solution: Solution,
    least: float,
    screen: Screen | None = None,
) -> Iterator[tuple[Hypothesis, Size, list[Solution] | None, bool]]:
    """Hypotheses worth a fit, with the size and the motors to begin with (None: the usual).

    ``screen``: of this fit, where one was made.
    """
    some = False
    period = min(r.timeline.period_s for r in records)
    for module in SEEN:
        seen = module.seen(records)
        if seen is not None:
            some = True
            hypothesis, start = seen
            yield hypothesis, start.size, [at(solution, start.motor, period), solution], True
    screen = screen or Screen(records, solution)
    scores = [screen.best(h) for module in SCREENED for h in module.hypotheses(records)]
    scores.sort(key=lambda s: -s.gain)
    best = scores[0].gain if scores else 0.0
    for s in scores[:MOST]:
        if s.gain > max(least, RIVAL * best):
            some = True
            yield s.hypothesis, s.size, None, False
    for h in model_alternatives.hypotheses(records) if some else ():
        s = screen.best(h)
        if s.gain > max(least, PEER * best):
            yield s.hypothesis, s.size, [solution], False
