"""The uncertainty budget: by how much each influence quantity may move each parameter.

What a fit estimates with a prior moves the parameters as far as the data leave that prior to
decide. What it does not estimate, such as a gain, leaves no residual: its standard uncertainty is
carried to the parameters linearly, the readings moving as it would move them and the fit following.
A cause that all captures share moves them together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.effects.influence_quantity import Scope
from motorid.estimate.effects.registry import BY_NAME
from motorid.estimate.effects.source.held_inductance import HELD_INDUCTANCE
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.tangent import tangent
from motorid.estimate.solver.dense_products import gram, project
from motorid.estimate.solver.problem import Linearised, Solution
from motorid.estimate.uncertainty.covariance import NOISE, SCATTER, SPREAD, Known, covariance_of

Floats = NDArray[np.float64]

FINDING = "finding: "  # begins the line of a fault that the fit has not allowed for
SETTLING = "source iteration"  # of fit and source in turn, as far as it did not settle
SEARCH = "unfinished search"  # what its own quadratic model has left of it
FRICTION = "shared friction"  # by B and T0, where another share is nearly as likely
GRID = "grid of the fit"  # of a log with irregular stamps, whose readings lie between its ticks
UNEVEN = "uneven residuals"  # of a capture: readings that tell a parameter are left the most
BENT = "inductance hardly told"  # what hangs on it by no straight line
UNSTATED = (
    "unstated lags and filters"  # of a log's channels, as far as the readings leave them open
)
INSTRUMENTS = "gains and offsets"  # of a table of steady points, as far as they are declared
COLUMNS = "noise of every column"  # of such a table, as nobody says whose it is
REST = {  # what is left when every influence quantity has its line
    NOISE: "record longer runs with more changes of speed, or more of them",
    INSTRUMENTS: "calibrate the instruments that read the table",
    COLUMNS: "load the motor, so that its current is no small part of its stall current",
    SPREAD: "clamp motor and sensors alike in every run, and take more runs",
    SETTLING: "drive by higher or lower levels: at these the ripple turns the current",
    FRICTION: "drive by two levels of the voltage or more, or end in a coast",
    SEARCH: "hold or leave out what these data do not determine (--fix, --without)",
    UNSTATED: "declare the delays and filters of the log's channels (--delay, --filter)",
    BENT: "log faster than L/R, with steps of the voltage",
    GRID: "log with even stamps",
    UNEVEN: "declare what the chain does to readings after a step (delay, aperture, filter)",
    SCATTER: "log faster, with the moments of the voltage's steps",
}


def remedy(cause: str) -> str:
    """What to do about a line of the budget."""
    if cause.startswith(FINDING):
        return f'do what the finding "{cause.removeprefix(FINDING)}" asks for'
    return BY_NAME[cause].remedy if cause in BY_NAME else REST[cause]


@dataclass(frozen=True)
class Carried:
    """By cause, what one standard uncertainty of it does.

    ``shared`` (p,) to the parameters in search coordinates; ``own``, (m,) a record, to its own.
    """

    shared: dict[str, Floats]
    own: dict[str, tuple[Floats, ...]]

    def own_variance(self, k: int, count: int) -> Floats:
        """(count,) of the unknowns of record k, by all causes."""
        return sum((by[k] ** 2 for by in self.own.values()), np.zeros(count))


def carried(solution: Solution, records: Sequence[MotorRecord]) -> Carried:
    """Of every quantity that is propagated; a cause that all captures share moves all of them."""
    changes = _changes(solution, records)
    shared = _shared(solution, changes)
    follows = [covariance_of(line.own_information) for line in solution.records]
    own = {
        name: tuple(
            f @ project(line.own.T, of.get(name, 0.0) - line.shared @ shift)
            for line, of, f in zip(solution.records, changes, follows, strict=True)
        )
        for name, shift in shared.items()
    }
    return Carried(shared, own)


def _shared(solution: Solution, changes: Sequence[Mapping[str, Floats]]) -> dict[str, Floats]:
    """What ``changes`` of the records do to the parameters, by causes that do anything."""
    inverse = covariance_of(solution.information)
    pulls: dict[str, Floats] = {}
    for line, of in zip(solution.records, changes, strict=True):
        for name, change in of.items():
            pulls[name] = pulls.get(name, 0.0) + project(line.orthogonal.T, change)
    return {name: inverse @ pull for name, pull in pulls.items() if pull.any()}


def _changes(solution: Solution, records: Sequence[MotorRecord]) -> list[dict[str, Floats]]:
    """(n,) of each record's weighed readings by cause, less what the model has of it."""
    return [
        _change(record, line, solution.values, own)
        for record, line, own in zip(records, solution.records, solution.own, strict=True)
    ]


def _change(
    record: MotorRecord, line: Linearised, values: Floats, own: Floats
) -> dict[str, Floats]:
    found: dict[str, Floats] = {}
    for one, unknown in record.propagated:
        moved = record.weighed(tangent(record, values, own, one))
        parts = [unknown.prior_sd * d / s for d, s in zip(moved, line.sigmas, strict=True)]
        # readings that are larger by what the model lacks pull the other way
        name = one.quantity.name
        found[name] = found.get(name, 0.0) - np.concatenate(parts)
    return found


def propagated(solution: Solution, records: Sequence[MotorRecord]) -> dict[str, Floats]:
    """Shift (p,) of every parameter in search coordinates for one standard uncertainty of a cause.

    Causes that are declared to be exact are left out.
    """
    return lines_of(_shared(solution, _changes(solution, records)), solution, records)


def lines_of(
    shared: Mapping[str, Floats], solution: Solution, records: Sequence[MotorRecord]
) -> dict[str, Floats]:
    """The same of what is carried to the parameters already."""
    causes = dict(shared)
    held = records[0].foretold
    if held is not None:
        causes[HELD_INDUCTANCE.name] = np.array(
            [held.shift.get(unknown.name, 0.0) for unknown in solution.unknowns]
        )
    return causes


def of_priors(solution: Solution, records: Sequence[MotorRecord]) -> Known:
    """What the priors of estimated quantities leave open of the parameters.

    A cause that captures share is one: each capture has its own unknown of it, with the same prior,
    and three would seem to know it by the root of three better than that prior does.
    """
    inverse = covariance_of(solution.information)
    apart = np.zeros_like(inverse)
    causes: dict[tuple[str, str, int], list[Floats]] = {}
    for k, (record, line) in enumerate(zip(records, solution.records, strict=True)):
        known = zip(record.instances, record.unknowns, (inverse @ pulled(line)).T, strict=True)
        for one, unknown, shift in known:
            if np.isfinite(unknown.prior_sd):
                shared = one.quantity.scope is Scope.MOTOR
                key = one.quantity.name, one.name, -1 if shared else k
                causes.setdefault(key, []).append(shift)
                apart += np.outer(shift, shift)
    shifts: dict[str, list[Floats]] = {}
    for (name, _, _), each in causes.items():
        shifts.setdefault(name, []).extend(_together(np.array(each)))
    return Known({name: np.array(rows) for name, rows in shifts.items()}, apart)


def _together(each: Floats) -> list[Floats]:
    """Shifts (p,) by a cause that captures share, which moves each of them by a row of (k, p).

    Where those cancel it may still differ a little from one to the next: no less than if it were
    each one's own.
    """
    together = each.sum(axis=0)
    lacking = np.maximum((each**2).sum(axis=0) - together**2, 0.0)
    return [together, np.sqrt(lacking)] if lacking.any() else [together]


def pulled(line: Linearised) -> Floats:
    """Scores (p, m) of the parameters if each unknown of a record were off its prior by one
    standard deviation.
    """
    within = line.own_information
    follows = np.linalg.lstsq(within, np.eye(len(within)), rcond=1e-14)[0]
    return np.asarray(-gram(line.shared.T, line.own.T) @ follows * np.sqrt(line.own_precision))
