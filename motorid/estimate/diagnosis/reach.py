"""How far a misfit, or a fault that has no size, could have moved the parameters.

Two bounds, from the fit's own derivatives. C is the covariance of white residuals, J their
derivatives, r the residuals in units of their standard deviation.

- The parts of the program disagree. Part k alone would pull the parameters by C J_k' r_k. The pulls
  of all parts sum to nothing, and twice the root of the sum of their squares is the bound: a
  jackknife, less twice the variance that noise gives it. It holds for what is in some parts only,
  such as repeated readings.
- A fault that shows in the residuals with a norm s hides in the parameters with some share of it:
  |Δp| <= share · sqrt(C_pp) · s. Faults put into simulated captures hid 0.1 to 0.5 of what they
  showed, so the share is a third. This serves a misfit that is large beside the readings.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.diagnosis import misfit
from motorid.estimate.diagnosis.faults import lost_samples
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.program_parts import by_part
from motorid.estimate.model.unexplained import unexplained
from motorid.estimate.results.estimate import Diagnostic, Parameter, Suspect
from motorid.estimate.solver.dense_products import square
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.covariance import covariance_of

Floats = NDArray[np.float64]
Moves = Mapping[str, float]

BY_NOISE = 2.0  # times the variance by white noise, which the pulls of a few parts may show
TWICE = 2.0  # standard deviations of the parts' pulls
FEWEST, PIECES = 3, 8  # parts that show a disagreement, and into how many a log is cut
HALF = 0.5  # of an interval's half-width, that a misfit must be able to move to be named with it
HIDDEN = 1.0 / 3.0  # of a misfit's norm, that may be in the parameters
MATTERS = 0.03  # share of a channel's mean square, from which a misfit without a name counts
SIZED_BY_TRAVEL = {"K": 1.0, "B": 2.0, "J": 2.0, "T0": 1.0}  # powers of a wrong speed
LACK, STEADY = "lack_of_fit", "steady_"  # findings that show a misfit, not its cause


def disagreement(records: Sequence[MotorRecord], solution: Solution) -> dict[str, float]:
    """SI, by parameter: twice what the parts of the program disagree by."""
    inverse, pulls = covariance_of(solution.information), []
    for line, part in zip(solution.records, by_part(solution, records), strict=True):
        groups = part if len(np.unique(part)) >= FEWEST else _pieces(line.slices, len(part))
        for k in np.unique(groups):
            rows = groups == k
            pulls.append(inverse @ (line.orthogonal[rows].T @ line.residual[rows]))
    spread = (np.array(pulls) ** 2).sum(axis=0) - BY_NOISE * np.diag(inverse)
    return _named(solution, TWICE * np.sqrt(np.maximum(spread, 0.0)))


def _pieces(blocks: Sequence[slice], count: int) -> NDArray[np.intp]:
    """Every block cut evenly: a log has no program."""
    out = np.zeros(count, dtype=np.intp)
    for block in blocks:
        length = block.stop - block.start
        out[block] = np.arange(length) * PIECES // max(length, 1)
    return out


def hidden(
    records: Sequence[MotorRecord], solution: Solution, share: float = 1.0
) -> dict[str, float]:
    """SI, by parameter: what a fault with the residuals' norm beyond noise could hide; ``share``
    of its square is what nothing else explains.
    """
    total = 0.0
    left = misfit.residuals(records, solution)
    for record, blocks in zip(records, left, strict=True):
        for m, r in zip(record.measured, blocks, strict=True):
            noise = misfit.noise_variance(m, r) * len(r)
            total += m.block.count * max(1.0 - noise / max(square(r), 1e-300), 0.0)
    deviations = np.sqrt(np.diag(covariance_of(solution.information)))
    return _named(solution, HIDDEN * np.sqrt(share * total) * deviations)


def _named(solution: Solution, size: Floats) -> dict[str, float]:
    each = zip(solution.unknowns, size * solution.slopes, strict=True)
    return {unknown.name: float(move) for unknown, move in each}


def sized(
    found: Sequence[Suspect],
    records: Sequence[MotorRecord],
    solution: Solution,
    parameters: Mapping[str, Parameter],
) -> tuple[Suspect, ...]:
    """Suspects whose moves nobody stated, with what the parts' disagreement allows."""
    if not any(_lacks(one) for one in found):
        return tuple(found)
    allowed = disagreement(records, solution)
    return tuple(
        replace(one, moves=_with_travel(one, allowed, records, parameters)) if _lacks(one) else one
        for one in found
    )


def _lacks(one: Suspect) -> bool:
    """What the fit allows for moves nothing; a scale states its own."""
    named = one.strength == "named" and not one.allowed
    return named and not one.moves and one.code in MOVING


def _with_travel(
    one: Suspect,
    allowed: Moves,
    records: Sequence[MotorRecord],
    parameters: Mapping[str, Parameter],
) -> dict[str, float]:
    """Lost counts and lost time make a speed wrong by their share of all."""
    share = max(MOVING[one.code](record) for record in records)
    out = dict(allowed)
    for name, power in SIZED_BY_TRAVEL.items():
        p = parameters.get(name)
        if p is not None and p.value:
            out[name] = max(out.get(name, 0.0), power * share * abs(p.value))
    return {name: move for name, move in out.items() if move > 0.0}


def _counts(record: MotorRecord) -> float:
    """Lost counts, as a share of all that were counted."""
    jumps = lost_samples.find(record.capture, record.timeline)
    position = record.capture.get("position")
    if jumps is None or position is None:
        return 0.0
    travel = float(np.abs(np.diff(position.values)).sum() / position.resolution)
    return jumps.lost / travel if travel > 0.0 else 0.0


def _time(record: MotorRecord) -> float:
    """Samples that are seen to be missing between others, as a share of all.

    A run may also be short because it ended early, which moves nothing.
    """
    jumps = lost_samples.find(record.capture, record.timeline)
    return jumps.dropped / max(len(record.capture), 1) if jumps is not None else 0.0


def _nothing(record: MotorRecord) -> float:
    return 0.0


MOVING = {
    "samples_dropped": _time,
    "encoder_loses_counts": _counts,
    "readings_held": _nothing,
}


def lacks(said: Sequence[Diagnostic]) -> bool:
    """Whether a lack of fit is said: what the model lacks may look like anything else."""
    return any(one.code == LACK for one in said)


def of_lack(
    said: Sequence[Diagnostic],
    found: Sequence[Suspect],
    records: Sequence[MotorRecord],
    solution: Solution,
    parameters: Mapping[str, Parameter],
) -> tuple[Diagnostic, ...]:
    """A lack of fit says which parameters it can move, by the parts' disagreement. One that no
    named fault explains, and that is large, moves them.

    Where a named fault states its moves, they stand for what the same misfit does elsewhere.
    """
    if any(one.moves for one in found):
        return tuple(replace(d, moves={}) if d.code.startswith(STEADY) else d for d in said)
    if not lacks(said):
        return tuple(said)
    parts = disagreement(records, solution)
    words = _movable(parts, parameters)
    said = [replace(d, message=f"{d.message}; {words}") if d.code == LACK else d for d in said]
    if max((one.beyond for one in unexplained(records, solution)), default=0.0) < MATTERS:
        return tuple(said)
    norm = hidden(records, solution)
    moves = {name: max(parts[name], norm[name]) for name in norm}
    return stating(said, moves)


def movable(moves: Moves, parameters: Mapping[str, Parameter]) -> dict[str, float]:
    """Moves by more than half the half-width of the parameters' intervals."""
    out = {}
    for name, move in moves.items():
        p = parameters.get(name)
        if p is None or p.value is None or p.interval_95 is None:
            continue
        if move > HALF * (p.interval_95[1] - p.interval_95[0]) / 2.0:
            out[name] = move
    return out


def _movable(moves: Moves, parameters: Mapping[str, Parameter]) -> str:
    """The same in words."""
    each = (
        (name, move, parameters[name].value) for name, move in movable(moves, parameters).items()
    )
    out = [f"{name} by {100.0 * move / abs(value):.2g} %" for name, move, value in each if value]
    if not out:
        return "the parts of the program agree on every parameter"
    return f"it can move {', '.join(out)}"


def stating(said: Sequence[Diagnostic], moves: Moves) -> tuple[Diagnostic, ...]:
    """A lack of fit states its moves; one of several stands for all."""
    first = next(k for k, one in enumerate(said) if one.code == LACK)
    return (*said[:first], replace(said[first], moves=moves), *said[first + 1 :])
