"""How much warmer a table of steady points made the winding, and what that does to R and K.

    i (1 + q s) = g V − h ω,    R = 1/g,  K = h/g,  q = α Θ

α is copper's coefficient. Θ (K) is how much warmer the winding is at its warmest row than without
current, and s, from 0 to 1, the course of that over the rows. It follows from i² by how long a row
lasts beside the time in which a winding cools, which no table says: rows may each be as warm as
their own current makes them, or keep the heat of the rows before, or both, as a winding in a case.
The course that leaves least is taken; where others leave hardly more, R is in doubt by what they
make of it.

Where the rows show a rise, it is allowed for, and R is that of the winding without current. Where
they do not, what they leave open of a usual rise is a line of the budget.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED, VOLTAGE
from motorid.errors import DataError
from motorid.estimate.effects.winding_temperature import Coefficients
from motorid.estimate.partial.mechanical_results import Quantity
from motorid.estimate.results.estimate import Diagnostic

Floats = NDArray[np.float64]
Columns = Mapping[str, Floats]

USUAL_K = 20.0  # standard, of the warmest row: rows that take seconds at a load
KEPT = (0.0, 0.25, 0.5, 0.65, 0.75, 0.83, 0.9, 0.95, 1.0)  # of the heat, from a row to the next
BOTH = ((0.0, 0.5, 0.75), (0.95, 1.0))  # of a winding, beside those of its case
FORM = 0.1  # standard, of what a rise moves: a case that warms too, rows of unlike length
SEEN = 4.0  # standard deviations of a rise that rows show
MOST_K = 250.0  # no winding's insulation survives such a rise: something else bends the line
UNTOLD = 0.5  # of the usual rise: where more of it stays open, the rows do not tell it
LEAST = 0.1  # of a resistance: no rows make it less
PASSES = 3  # of the current that a rise multiplies, which is the fitted one


@dataclass(frozen=True)
class Course:
    """``share`` s (n,) of the rows, the rise q with its variance, and R and K beside it;
    ``likelihood``: beside that of the best course. ``parts``: of how many it is made; two are no
    less likely before the rows are seen.
    """

    share: Floats
    rise: float
    variance: float
    beside: Mapping[str, Quantity]
    likelihood: float
    parts: int


@dataclass(frozen=True)
class Warming:
    """``courses`` that the rows may have had, the likeliest first; ``seen``: its rise shows."""

    courses: tuple[Course, ...]
    seen: bool

    @property
    def rise_k(self) -> tuple[float, float]:
        """K at the warmest row, with its standard deviation."""
        best, per_k = self.courses[0], Coefficients().copper_per_k
        return best.rise / per_k, float(np.sqrt(best.variance)) / per_k

    @property
    def open_k(self) -> float:
        """K that stay open of the usual rise."""
        return (
            max(_open(one)[1] for one in self.courses if one.parts == 1)
            / Coefficients().copper_per_k
        )

    def cold(self, columns: Columns) -> Columns:
        """Columns whose current makes the cold winding's voltage, where a rise was seen."""
        return columns if not self.seen else _warmer(columns, self.courses[0], 1.0)

    def quantities(self, solved: Mapping[str, Quantity]) -> dict[str, Quantity]:
        """R and K as uncertain as a rise that was seen makes them; else as ``solved``."""
        return dict(self.courses[0].beside if self.seen else solved)

    def lines(
        self, columns: Columns, solve: Callable[[Columns], Mapping[str, Quantity]]
    ) -> dict[str, float]:
        """What warming leaves open of R and K (SI): other courses of a rise that was seen, or so
        much of a usual rise as the rows do not exclude.
        """
        plain = solve(columns)
        usual = self.courses[0].beside if self.seen else plain
        total = sum(one.likelihood for one in self.courses if self.seen or one.parts == 1)
        squares = {
            name: (FORM * (q.value - plain[name].value)) ** 2
            for name, q in usual.items()
            if name in plain
        }
        for course in self.courses:
            other = course.beside
            if not self.seen and course.parts > 1:
                continue
            if not self.seen:
                part = float(np.hypot(*_open(course))) / max(abs(course.rise), 1e-300)
                other = solve(_warmer(columns, course, part))
            for name in squares.keys() & other.keys():
                move = other[name].value - usual[name].value
                squares[name] += course.likelihood / total * move**2
        return {name: float(np.sqrt(square)) for name, square in squares.items()}

    def remarks(self, open_ohm: float, R: float) -> Iterator[Diagnostic]:
        """That the rows show a rise, or that they do not tell it: ``open_ohm`` of ``R`` is open."""
        if self.seen:
            rise, u = self.rise_k
            yield Diagnostic(
                "winding_warms", "warning",
                f"R rises with the current or from row to row by as much as copper does that is "
                f"{rise:.2g} ± {1.96 * u:.1g} K warmer at its warmest row: the winding warmed. The "
                "fit allows for it, and R is that of the winding without current; pause between "
                "rows, or take them quicker, and let it cool before",
            )  # fmt: skip
        elif self.open_k > UNTOLD * USUAL_K:
            yield Diagnostic(
                "warming_untold", "info",
                f"These points do not tell whether the winding was warmer at a high current: "
                f"{USUAL_K:g} K are usual, and what stays open of them is "
                f"{100.0 * open_ohm / R:.2g} % in the uncertainty of R. More rows, or "
                "several voltages, would tell it.",
            )  # fmt: skip


def line(drive: Floats, *regressors: Floats) -> tuple[Floats, Floats]:
    """Least-squares coefficients and their covariance, of the points with every reading."""
    matrix = np.stack(regressors, axis=1)
    whole = np.isfinite(matrix).all(axis=1) & np.isfinite(drive)
    if not whole.all():
        matrix, drive = matrix[whole], drive[whole]
    if len(drive) <= matrix.shape[1]:
        raise DataError(f"{len(drive)} whole steady points are too few: add points, or readings")
    values, _, rank, _ = np.linalg.lstsq(matrix, drive, rcond=None)
    if rank < matrix.shape[1]:
        raise DataError("the steady points are all alike: nothing can be fitted to them")
    residual = drive - matrix @ values
    variance = float(residual @ residual) / max(len(drive) - len(values), 1)
    covariance = variance * np.linalg.inv(matrix.T @ matrix)
    return np.asarray(values, np.float64), np.asarray(covariance, np.float64)


def of_slopes(values: Floats, covariance: Floats) -> dict[str, Quantity]:
    """R and K of g and h; nothing where no winding has them."""
    g, h = (float(x) for x in values[:2])
    if g <= 0:
        return {}
    slope, cov = np.array([-h / g**2, 1 / g]), covariance[:2, :2]
    return {
        "R": Quantity(1 / g, float(cov[0, 0] / g**4)),
        "K": Quantity(h / g, float(slope @ cov @ slope)),
    }


def warming(columns: Columns, tables: Sequence[int]) -> Warming | None:
    """What the rows say of it; None: they have no volts, no speed, or too few points.

    ``tables``: how many rows each table has, in the order in which they were taken.
    """
    current, speed, volts = columns[CURRENT], columns[SPEED], columns[VOLTAGE]
    if not len(volts) or not len(speed):
        return None
    points, found = int(np.isfinite(current + speed + volts).sum()), []
    for shares in _shares(current, tables):
        try:
            found.append(_fitted(current, speed, volts, shares))
        except DataError:  # too few points, or a rise that is like another column
            continue
    told = [(one, left) for one, left in found if one is not None and left > 0.0]
    if not told:
        return None
    least = min(left for _, left in told)
    weighed = [replace(one, likelihood=float((least / left) ** (points / 2))) for one, left in told]
    weighed.sort(key=lambda course: -course.likelihood)
    best = weighed[0]
    seen = best.rise > _surely(points - 2 - best.parts) * np.sqrt(best.variance)
    seen &= best.rise < MOST_K * Coefficients().copper_per_k
    return Warming(tuple(weighed), bool(seen))


def _surely(freedom: int) -> float:
    """So many standard deviations by Student as ``SEEN`` are by Gauss."""
    from scipy.stats import norm, t

    return float(t.isf(norm.sf(SEEN), max(freedom, 1)))


def _shares(current: Floats, tables: Sequence[int]) -> Iterator[tuple[Floats, ...]]:
    """Each s (n,) that rows may have, or two beside each other."""
    heat = np.where(np.isfinite(current), current, 0.0) ** 2
    ends = set(np.cumsum(tables).tolist())
    alone = {kept: _kept(heat, kept, ends) for kept in KEPT}
    yield from ((share,) for share in alone.values())
    winding, case = BOTH
    yield from ((_kept(heat, a, ends), alone[b]) for a in winding for b in case)


def _kept(heat: Floats, kept: float, ends: Set[int]) -> Floats:
    """(n,) of a heat of which so much is kept from a row to the next; a table begins cold."""
    level, warm = 0.0, np.empty_like(heat)
    for k, more in enumerate(heat.tolist()):
        level = (0.0 if k in ends else kept * level) + more
        warm[k] = level
    return warm / max(float(warm.max(initial=0.0)), 1e-300)


def _fitted(
    current: Floats, speed: Floats, volts: Floats, shares: tuple[Floats, ...]
) -> tuple[Course | None, float]:
    """A course's rise, and the squares that it leaves; None: no winding has it.

    A rise multiplies the fitted current: noise of the measured one would seem to be a rise.
    """
    (g, h), _ = line(current, volts, -speed)
    fitted, table = g * volts - h * speed, np.array(shares)
    for _ in range(PASSES):
        values, covariance = line(current, volts, -speed, *(-table * fitted))
        warm = values[2:] @ table
        fitted = (values[0] * volts - values[1] * speed) / np.maximum(1.0 + warm, LEAST)
    beside, left = of_slopes(values, covariance), float(np.nansum((current - fitted) ** 2))
    if not beside or (len(shares) > 1 and (values[2:] < 0.0).any()):
        return None, left
    top = table[:, int(np.argmax(np.abs(warm)))]
    rise, variance = float(values[2:] @ top), float(top @ covariance[2:, 2:] @ top)
    share = warm / rise if rise else table[0]
    return Course(share, rise, variance, beside, 1.0, len(shares)), left


def _open(course: Course) -> tuple[float, float]:
    """The likeliest rise q beside what is usual, and its deviation. No current cools."""
    usual = (USUAL_K * Coefficients().copper_per_k) ** 2
    part = usual / (usual + course.variance)
    return part * max(course.rise, 0.0), float(np.sqrt(part * course.variance))


def _warmer(columns: Columns, course: Course, part: float) -> Columns:
    """Columns whose current is multiplied as by so large a part of a course's rise."""
    grown = 1.0 + part * abs(course.rise) * course.share
    return {**columns, CURRENT: columns[CURRENT] * grown}
