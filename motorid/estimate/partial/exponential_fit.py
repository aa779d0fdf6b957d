"""The rise of a speed under a constant drive: exponentials with a common time constant, fitted.

    ω(t) = ω0 + (ω1 − ω0) s(t − t0),   s(t) = 1 − (τ1 exp(−t/τ1) − τ2 exp(−t/τ2)) / (τ1 − τ2)

A second lag τ2, of the winding's inductance or a filter of the speed, is 0 where the readings do
not ask for it. Levels are linear, so that only times are searched (variable projection; G. H. Golub
and V. Pereyra, SIAM J. Numer. Anal. 10, 1973). A position is the integral of the same.

Readings are rounded. While the speed stays within one quantum q, every reading has the same error;
noise of a standard deviation σ makes the errors independent (B. Widrow and I. Kollár, Quantization
Noise, 2008): what they still share has a variance of q²/12 exp(−4π²σ²/q²).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.model.effective_sample_size import excess
from motorid.estimate.partial.unstated_lag import WINDING

Floats = NDArray[np.float64]

SHORTEST, LONGEST = 0.3, 5.0  # of a time constant: sample periods, and lengths of the record
CONSTANTS, ONSETS = 18, 18  # tried before any refinement
MOST_EVALUATIONS = 400  # of a refinement
SETTLED, ROUGHLY = 1e-13, 1e-8  # relative changes that end it
LAST = 3  # readings that an onset lies before
WHITENINGS = 3  # rounds of weights and fit in turn
ASKED = 20.0  # of chi-square, by which a second lag must be better
LEAST_LAG = 0.01  # of the time constant: a second lag below is none
HIDDEN = (0.0, 0.005, 0.01, 0.02, 0.04, 0.08, 0.16)  # of it: a second lag that may hide
BETWEEN = 161  # such lags, by straight lines
STAMPED, FEW_STEPS = 1e-9, 4  # s, of stamps; different steps of stamps that are rounded
NEIGHBOURS = 3.0  # standard deviations of a correlation between neighbours
TINY = 1e-7  # of the readings' range: the least noise


@dataclass(frozen=True)
class Record:
    """Readings ``values`` (n,) of a speed, or of a position, at ``time_s`` (n,).

    Each is a mean over ``aperture_s`` before its stamp, 0: an instant. ``quantum`` is that of the
    readings. ``onset_s`` is when the drive is known to begin; None: no column tells.
    """

    time_s: Floats
    values: Floats
    is_position: bool = False
    aperture_s: float = 0.0
    quantum: float = 0.0
    onset_s: float | None = None

    @property
    def period_s(self) -> float:
        """The usual one."""
        return float(np.median(np.diff(self.time_s)))

    @cached_property
    def stamp_quantum_s(self) -> float:
        """To what the stamps are rounded, where their steps show it; 0: they do not."""
        steps = np.unique(np.rint(np.diff(self.time_s) / STAMPED)) * STAMPED
        if not 1 < len(steps) <= FEW_STEPS:
            return 0.0
        return float(np.diff(steps).min())

    @property
    def length_s(self) -> float:
        """From the first stamp to the last."""
        return float(self.time_s[-1] - self.time_s[0])


@dataclass(frozen=True)
class Rise:
    """What the records of one motor say together.

    ``times``: τ1, then τ2 where there is a second lag, then the onset of every record that shows
    one. ``before`` and ``after`` (records,): the speeds. ``covariance``: of times, before, after.
    ``freedom``: degrees of freedom of the noise. ``wander``: variance of slow residuals, over that
    of noise.
    """

    lags: Floats
    onsets: tuple[float | None, ...]
    before: Floats
    after: Floats
    covariance: Floats
    freedom: int
    deviations: Floats  # (records,) of a reading
    wander: float
    fitted: tuple[Floats, ...]
    evaluations: int
    hidden_s: float = 0.0  # by which a second lag that is not told would move the sum of the lags

    @property
    def constant_s(self) -> float:
        """The sum of the lags, which the inductance leaves as it is."""
        return float(self.lags.sum())

    @property
    def constant_variance(self) -> float:
        """s², of that: a lag that no reading asks for hides in an onset that is free, too."""
        n = len(self.lags)
        return float(self.covariance[:n, :n].sum()) + self.hidden_s**2

    @property
    def lag_variance(self) -> float:
        """s², of the shortest lag; two that are alike are told by their sum alone."""
        own = np.diag(self.covariance)[: len(self.lags)]
        return float(max(own.max(), self.constant_variance))

    def place(self, record: int) -> int:
        """Of a record's speed after the rise, among what the covariance is of."""
        return len(self.covariance) - len(self.after) + record

    def onset_variance(self, record: int) -> float:
        """s², of the onset of a record that has one."""
        shown = [k for k, onset in enumerate(self.onsets) if onset is not None]
        k = len(self.lags) + shown.index(record)
        return float(self.covariance[k, k])


def rise(records: Sequence[Record]) -> Rise:
    """The most likely rise; with a second lag where the readings ask for it."""
    problem = _Problem(records, _starts(records))
    single = problem.solved(1)
    double = problem.solved(2, near=single)
    enough = double.lags.min() > LEAST_LAG * double.lags.max()
    better = problem.misfit(single, double) > ASKED * double.wander  # in the noise that it leaves
    if enough and better:
        return double
    hidden_s = max(abs(double.constant_s - single.constant_s), problem.hidden_s(single))
    return replace(single, hidden_s=hidden_s, evaluations=problem.evaluations)


def shape(since_s: Floats, lags: Floats) -> tuple[Floats, Floats]:
    """s and its integral at times (n,) since the onset, both 0 before it."""
    t = np.maximum(since_s, 0.0)
    if len(lags) == 1 or lags[1] <= 0.0:
        tau = float(lags[0])
        rest = np.exp(-t / tau)
        return 1.0 - rest, t - tau * (1.0 - rest)
    a, b = float(lags.max()), float(lags.min())
    if b > 0.999 * a:
        b = 0.999 * a
    slow, fast = np.exp(-t / a), np.exp(-t / b)
    speed = 1.0 - (a * slow - b * fast) / (a - b)
    return speed, t - (a * a * (1.0 - slow) - b * b * (1.0 - fast)) / (a - b)


def columns(record: Record, lags: Floats, onset_s: float) -> Floats:
    """(n, 2 or 3): readings for a unit of the speed before, of that after, and of an angle."""
    t = record.time_s
    if record.is_position:
        risen = shape(t - onset_s, lags)[1]
        return np.column_stack([t - t[0] - risen, risen, np.ones(len(t))])
    if record.aperture_s:
        late = shape(t - onset_s, lags)[1] - shape(t - record.aperture_s - onset_s, lags)[1]
        risen = late / record.aperture_s
    else:
        risen = shape(t - onset_s, lags)[0]
    return np.column_stack([1.0 - risen, risen])


@dataclass(frozen=True)
class Start:
    """Where a search begins; ``shown``: a reading lies before the onset."""

    constant_s: float
    onset_s: float
    shown: bool


def _starts(records: Sequence[Record]) -> list[Start]:
    """The best of a grid of time constants and onsets, record by record."""
    return [_start(record) for record in records]


def _start(record: Record) -> Start:
    t = record.time_s
    constants = np.geomspace(SHORTEST * record.period_s, LONGEST * record.length_s, CONSTANTS)
    onsets = np.quantile(t[:-LAST], np.linspace(0.0, 0.9, ONSETS))
    onsets = np.unique([*onsets, t[0] + record.period_s / 2.0])
    best, constant_s, onset_s = np.inf, float(constants[0]), float(t[0])
    for onset in onsets:
        for constant in constants:
            X = columns(record, np.array([constant]), float(onset))
            left = record.values - X @ np.linalg.lstsq(X, record.values, rcond=None)[0]
            if float(left @ left) < best:
                best, constant_s, onset_s = float(left @ left), float(constant), float(onset)
    return Start(constant_s, onset_s, bool(onset_s > t[0]))


class _Problem:
    """Times are searched; levels follow by least squares with the weights as they are."""

    def __init__(self, records: Sequence[Record], starts: Sequence[Start]) -> None:
        self.records, self.starts = records, starts
        self.roots = [np.ones(len(r.values)) for r in records]
        self.evaluations = 0
        self.second = 0.0  # of one lag that is searched: another one

    def solved(self, lags: int, near: Rise | None = None) -> Rise:
        """With that many lags, and the weights that its residuals leave.

        One lag begins at those of the starts; two divide the one of ``near``.
        """
        if near is None:
            constants = [s.constant_s for s in self.starts]
            begins = dict.fromkeys((float(np.median(constants)), min(constants)))
            times = [self._times([tau]) for tau in begins]
        else:
            tau = near.lags[0]
            times = [self._times([(1 - x) * tau, x * tau], near) for x in (0.05, 0.3)]
        best = min((self._refined(t, lags) for t in times), key=lambda found: found[1])[0]
        for _ in range(WHITENINGS):
            self._weigh(best, lags)
            best = self._refined(best, lags)[0]
        return self._rise(best, lags)

    def misfit(self, one: Rise, other: Rise) -> float:
        """Of chi-square, by which the other is better."""
        each = (
            float(((w * (r.values - a)) ** 2).sum() - ((w * (r.values - b)) ** 2).sum())
            for r, w, a, b in zip(self.records, self.roots, one.fitted, other.fitted, strict=True)
        )
        return sum(each)

    def hidden_s(self, single: Rise) -> float:
        """By how much, rms, the sum of the lags may be off for a second lag that no reading asks
        for: as likely as the readings and what is usual of a winding's make it.
        """
        found = [(self._times(single.lags.tolist(), single), 0.0)]
        for self.second in HIDDEN:
            found.append(self._refined(found[-1][0], 1, ROUGHLY))
        self.second = 0.0
        ratios = np.linspace(0.0, HIDDEN[-1], BETWEEN)
        half = np.interp(ratios, HIDDEN, [cost for _, cost in found[1:]])  # of chi-square
        sums = np.exp([times[0] for times, _ in found[1:]]) * (1.0 + np.array(HIDDEN))
        off = np.interp(ratios, HIDDEN, sums - single.constant_s)
        density = np.exp(-ratios / WINDING - (half - half.min()) / single.wander)
        return float(np.sqrt(density @ off**2 / density.sum()))

    def _times(self, lags: Sequence[float], near: Rise | None = None) -> Floats:
        onsets = [s.onset_s for s in self.starts if s.shown]
        if near is not None:
            onsets = [onset for onset in near.onsets if onset is not None]
        return np.array([*np.log(lags), *onsets])

    def _split(self, times: Floats, lags: int) -> tuple[Floats, list[float]]:
        onsets = iter(times[lags:].tolist())
        taus = np.exp(times[:lags])
        return np.append(taus, self.second * taus[:1]) if self.second else taus, [
            next(onsets) if s.shown else float(r.time_s[0])
            for r, s in zip(self.records, self.starts, strict=True)
        ]

    def _levels(self, times: Floats, lags: int) -> Iterator[tuple[Floats, Floats]]:
        """Columns and coefficients of every record."""
        taus, onsets = self._split(times, lags)
        for record, onset, w in zip(self.records, onsets, self.roots, strict=True):
            X = columns(record, taus, onset)
            found = np.linalg.lstsq(w[:, None] * X, w * record.values, rcond=None)[0]
            yield X, np.asarray(found, np.float64)

    def _left(self, times: Floats, lags: int) -> Floats:
        self.evaluations += 1
        parts = zip(self.records, self.roots, self._levels(times, lags), strict=True)
        return np.concatenate([w * (r.values - X @ c) for r, w, (X, c) in parts])

    def _refined(self, times: Floats, lags: int, enough: float = SETTLED) -> tuple[Floats, float]:
        from scipy.optimize import least_squares

        periods = min(r.period_s for r in self.records)
        length = max(r.length_s for r in self.records)
        low = [*[np.log(1e-3 * periods)] * lags, *[-np.inf] * (len(times) - lags)]
        high = [*[np.log(1e3 * length)] * lags, *[np.inf] * (len(times) - lags)]
        scale = np.array([1.0] * lags + [periods] * (len(times) - lags))
        found = least_squares(
            self._left, np.clip(times, low, high), args=(lags,), bounds=(low, high), x_scale=scale,
            jac="3-point", xtol=enough, ftol=enough, gtol=enough, max_nfev=MOST_EVALUATIONS,
        )  # fmt: skip
        return np.asarray(found.x, np.float64), float(found.cost)

    def _weigh(self, times: Floats, lags: int) -> None:
        """Let every reading be worth what its noise and its rounding leave of it."""
        levels = self._levels(times, lags)
        for k, (record, (X, c)) in enumerate(zip(self.records, levels, strict=True)):
            fitted = X @ c
            left = record.values - fitted
            each = variances(left, fitted, record.quantum, X.shape[1] + 2)
            if record.stamp_quantum_s:
                slope = np.gradient(fitted, record.time_s)
                each = each + slope**2 * record.stamp_quantum_s**2 / 12.0
            self.roots[k] = 1.0 / np.sqrt(each)

    def _rise(self, times: Floats, lags: int) -> Rise:
        taus, onsets = self._split(times, lags)
        found = list(self._levels(times, lags))
        fitted = tuple(X @ c for X, c in found)
        residuals = [r.values - y for r, y in zip(self.records, fitted, strict=True)]
        weighed = [w * left for w, left in zip(self.roots, residuals, strict=True)]
        wander = max(
            excess(weighed, [np.ones(len(w)) for w in weighed]),
            *(
                _correlated(left)
                for r, left in zip(self.records, residuals, strict=True)
                if float(np.mean(left**2)) > r.quantum**2
            ),
            1.0,
        )
        jacobian = self._jacobian(times, lags, found)
        covariance = np.linalg.pinv(jacobian.T @ jacobian, hermitian=True) * wander
        scale = np.concatenate([taus, np.ones(len(times) - lags)])
        covariance[: len(times)] *= scale[:, None]
        covariance[:, : len(times)] *= scale
        n, count = len(times), len(self.records)
        order = [
            *range(n),
            *(n + 3 * k for k in range(count)),
            *(n + 3 * k + 1 for k in range(count)),
        ]
        worth = sum(float(_worth(w)) for w in self.roots)
        return Rise(
            taus,
            tuple(t if s.shown else None for t, s in zip(onsets, self.starts, strict=True)),
            np.array([c[0] for _, c in found]),
            np.array([c[1] for _, c in found]),
            np.asarray(covariance[np.ix_(order, order)], np.float64),
            max(int(worth) - n - sum(X.shape[1] for X, _ in found), 1),
            np.array([float(np.sqrt(np.mean(left**2))) for left in residuals]),
            wander,
            fitted,
            self.evaluations,
        )

    def _jacobian(self, times: Floats, lags: int, found: Sequence[tuple[Floats, Floats]]) -> Floats:
        """Of all readings, weighed, by times and three levels of every record, (n, p)."""
        count = len(self.records)
        rows = []
        for k, (record, w, (X, c)) in enumerate(zip(self.records, self.roots, found, strict=True)):
            block = np.zeros((len(w), len(times) + 3 * count))
            for j in range(len(times)):
                step = 1e-5 if j < lags else 1e-4 * record.period_s
                ends = []
                for side in (step, -step):
                    moved = times.copy()
                    moved[j] += side
                    taus, onsets = self._split(moved, lags)
                    ends.append(columns(record, taus, onsets[k]) @ c)
                block[:, j] = (ends[0] - ends[1]) / (2.0 * step)
            block[:, len(times) + 3 * k : len(times) + 3 * k + X.shape[1]] = X
            rows.append(w[:, None] * block)
        return np.vstack(rows)


def _correlated(left: Floats) -> float:
    """Variance of a mean of residuals (n,) over that of white ones, by their neighbours; 1 where
    these may be white.
    """
    power = float(left @ left)
    rho = float(left[1:] @ left[:-1]) / power if power else 0.0
    if rho < NEIGHBOURS / np.sqrt(len(left)):
        return 1.0
    return (1.0 + rho) / max(1.0 - rho, 1e-3)


def _worth(roots: Floats) -> float:
    """Readings that those weights make of (n,): the sum over the largest."""
    weights = roots**2
    return float(weights.sum() / weights.max())


def variances(left: Floats, fitted: Floats, quantum: float, unknowns: int) -> Floats:
    """Of every reading (n,), so that as many with the same rounding are worth one.

    ``left``: residuals; ``fitted``: the model, whose steps of a quantum renew the rounding.
    """
    extent = float(np.ptp(fitted)) or 1.0
    rounding = quantum**2 / 12.0
    total = float(left @ left) / max(len(left) - unknowns, 1)
    total = max(total, rounding, (TINY * extent) ** 2)
    if not quantum:
        return np.full(len(left), total)
    noise = max(total - rounding, 0.0)
    common = rounding * float(np.exp(-4.0 * np.pi**2 * noise / quantum**2))
    cells = np.floor(fitted / quantum + 0.5)
    edges = np.flatnonzero(np.diff(cells, prepend=np.nan) != 0.0)
    lengths = np.diff(np.append(edges, len(fitted)))
    many = np.repeat(lengths, lengths).astype(np.float64)
    return np.asarray(many * common + (total - common))
