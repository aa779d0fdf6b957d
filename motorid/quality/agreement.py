"""Attribute studies: who calls which part what, how often, and whether it is right (AIAG MSA).

Every appraiser (a person, a fixture, a station) rates every part several times. Kappa is Cohen's
(1960) of two raters and Fleiss' (1971) of many: the agreement beyond that of chance.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from motorid.errors import DataError, UsageError

Floats = NDArray[np.float64]
Counts = NDArray[np.int64]
DRAWS, SEED = 1000, 1960  # of the bootstrap over parts
REFERENCE = "reference"


@dataclass(frozen=True)
class Ratings:
    """Categories of shape (parts, appraisers, trials) by their index in ``categories``.

    ``reference`` (parts,): what each part is; None: nobody knows. ``bad``: the index of the
    category that must not pass, for misses and false alarms; None: there is none such.
    """

    values: Counts
    parts: tuple[str, ...]
    appraisers: tuple[str, ...]
    categories: tuple[str, ...]
    reference: Counts | None = None
    bad: int | None = None

    def __post_init__(self) -> None:
        parts, appraisers, _ = self.values.shape
        if parts < 2 or (appraisers < 2 and self.reference is None):
            raise DataError(
                "an attribute study needs 2 parts or more, and 2 appraisers or a reference: "
                f"this has {parts} and {appraisers}"
            )
        if len(self.categories) < 2:
            raise DataError("every rating is the same: the study needs good parts and bad ones")


@dataclass(frozen=True)
class Share:
    """So many of so many, with the exact 95 % interval (Clopper and Pearson 1934)."""

    found: int
    of: int

    @property
    def value(self) -> float:
        """The share itself; not a number where it is of nothing."""
        return self.found / self.of if self.of else math.nan

    @property
    def interval_95(self) -> tuple[float, float]:
        """Holds the true share in at least 95 of 100 studies."""
        from scipy.special import betaincinv

        k, n = self.found, self.of
        low = float(betaincinv(k, n - k + 1, 0.025)) if k else 0.0
        high = float(betaincinv(k + 1, n - k, 0.975)) if k < n else 1.0
        return low, high


@dataclass(frozen=True)
class Kappa:
    """Agreement beyond chance of two raters, or of ``first`` and everyone; not a number where
    chance alone explains all. ``table`` (k, k): ratings by the first, then by the second."""

    first: str
    second: str
    value: float
    interval_95: tuple[float, float] | None
    table: Counts | None = None


@dataclass(frozen=True)
class Appraiser:
    """One appraiser. ``consistent``: parts called alike in all trials. ``right``: and rightly so.

    ``missed`` and ``alarmed``: single ratings of bad parts as another, of others as bad.
    """

    name: str
    consistent: Share
    right: Share | None
    missed: Share | None
    alarmed: Share | None


@dataclass(frozen=True)
class Agreement:
    """The answer of a study."""

    ratings: Ratings
    appraisers: tuple[Appraiser, ...]
    all_agree: Share
    all_right: Share | None
    pairs: tuple[Kappa, ...]
    with_reference: tuple[Kappa, ...]
    overall: Kappa | None


def agreement(ratings: Ratings) -> Agreement:
    """Every share and kappa that the study supports."""
    values, reference = ratings.values, ratings.reference
    same = (values == values[:, :, :1]).all(axis=2)
    everyone = (values == values[:, :1, :1]).all(axis=(1, 2))
    truly = None if reference is None else everyone & (values[:, 0, 0] == reference)
    names = ratings.appraisers
    pairs = tuple(
        _pair(ratings, names[a], names[b], values[:, a], values[:, b])
        for a, b in combinations(range(len(names)), 2)
    )
    against: tuple[Kappa, ...] = ()
    if reference is not None:
        known = np.repeat(reference[:, None], values.shape[2], axis=1)
        against = tuple(
            _pair(ratings, name, REFERENCE, values[:, a], known) for a, name in enumerate(names)
        )
    return Agreement(
        ratings,
        tuple(_appraiser(ratings, a, same[:, a]) for a in range(len(names))),
        _share(everyone),
        None if truly is None else _share(truly),
        pairs,
        against,
        _overall(ratings),
    )


def _share(hits: NDArray[np.bool_]) -> Share:
    return Share(int(hits.sum()), int(hits.size))


def _appraiser(ratings: Ratings, a: int, same: NDArray[np.bool_]) -> Appraiser:
    mine, reference = ratings.values[:, a], ratings.reference
    right = missed = alarmed = None
    if reference is not None:
        right = _share(same & (mine[:, 0] == reference))
        if ratings.bad is not None:
            is_bad = reference == ratings.bad
            missed = _share(mine[is_bad] != ratings.bad)
            alarmed = _share(mine[~is_bad] == ratings.bad)
    return Appraiser(ratings.appraisers[a], _share(same), right, missed, alarmed)


def _pair(ratings: Ratings, first: str, second: str, one: Counts, other: Counts) -> Kappa:
    """Trial with trial, as the AIAG's cross tabulation counts them."""
    k = len(ratings.categories)
    tables = np.zeros((len(ratings.parts), k, k), dtype=np.int64)
    for part, table in enumerate(tables):
        np.add.at(table, (one[part], other[part]), 1)
    drawn = np.tensordot(_weights(len(tables)), tables, axes=1)
    found = tables.sum(axis=0)
    value = float(cohen(found[None])[0])
    return Kappa(first, second, value, _interval(value, cohen(drawn)), found)


def cohen(tables: NDArray[np.number]) -> Floats:
    """Cohen's kappa of cross tabulations (n, k, k); not a number where both use one category."""
    total = tables.sum(axis=(1, 2))
    seen = np.trace(tables, axis1=1, axis2=2) / total
    chance = (tables.sum(axis=1) * tables.sum(axis=2)).sum(axis=1) / total**2
    return _beyond_chance(seen, chance)


def fleiss(counts: NDArray[np.number], weights: NDArray[np.number] | None = None) -> Floats:
    """Fleiss' kappa of ``counts`` (parts, k): how many ratings of each part fell where.

    Every part has as many. ``weights`` (n, parts): how often each part counts; (n,) results.
    """
    many = np.ones((1, len(counts))) if weights is None else np.asarray(weights, float)
    raters = float(counts[0].sum())
    agreed = ((counts**2).sum(axis=1) - raters) / (raters * (raters - 1.0))
    parts = many.sum(axis=1)
    shares = many @ counts / (parts[:, None] * raters)
    return _beyond_chance(many @ agreed / parts, (shares**2).sum(axis=1))


def _beyond_chance(seen: Floats, chance: Floats) -> Floats:
    left = 1.0 - chance
    some = left > 1e-12
    return np.where(some, (seen - chance) / np.where(some, left, 1.0), np.nan)


def _overall(ratings: Ratings) -> Kappa | None:
    """Of all ratings of a part together, whoever made them; None where each has one alone."""
    parts = len(ratings.parts)
    flat = ratings.values.reshape(parts, -1)
    if flat.shape[1] < 2:
        return None
    counts = np.stack([(flat == k).sum(axis=1) for k in range(len(ratings.categories))], axis=1)
    value = float(fleiss(counts)[0])
    return Kappa("all", "all", value, _interval(value, fleiss(counts, _weights(parts))))


def _weights(parts: int) -> Counts:
    """How often each part comes in each resample of the parts: trials of one part go together."""
    draw = np.random.default_rng(SEED)
    return draw.multinomial(parts, np.full(parts, 1.0 / parts), size=DRAWS)


def _interval(value: float, drawn: Floats) -> tuple[float, float] | None:
    good = drawn[np.isfinite(drawn)]
    if not math.isfinite(value) or len(good) < 0.9 * len(drawn):
        return None
    low, high = np.quantile(good, [0.025, 0.975])
    return float(low), float(high)


def ratings_of(
    parts: Sequence[str],
    appraisers: Sequence[str],
    called: Sequence[str],
    known: Sequence[str] | None = None,
    bad: str | None = None,
    where: str = "the study",
) -> Ratings:
    """The study of rows: part, appraiser, what it was called and, if known, what it is.

    Raises DataError where the design is not crossed or a part's reference changes; UsageError
    where nothing is ever called ``bad``.
    """
    names = tuple(dict.fromkeys(parts)), tuple(dict.fromkeys(appraisers))
    categories = tuple(sorted({*called, *(known or ())}))
    if any(not one for one in categories):
        raise DataError(f"{where} has an empty rating: fill it in, or leave the row out")
    if bad is not None and bad not in categories:
        raise UsageError(
            f"nothing in {where} is called {bad!r}; ratings are {', '.join(categories)}"
        )
    place = {name: k for k, name in enumerate(categories)}
    cells: dict[tuple[str, str], list[int]] = {}
    for part, who, one in zip(parts, appraisers, called, strict=True):
        cells.setdefault((part, who), []).append(place[one])
    most = max(len(cell) for cell in cells.values())
    for part in names[0]:
        for who in names[1]:
            if len(cells.get((part, who), [])) != most:
                raise DataError(
                    f"{where} is no crossed study: part {part} by {who} has "
                    f"{len(cells.get((part, who), []))} ratings, another has {most}"
                )
    reference = None if known is None else _reference(parts, known, place, names[0], where)
    table = np.array([[cells[p, a] for a in names[1]] for p in names[0]], dtype=np.int64)
    return Ratings(table, *names, categories, reference, None if bad is None else place[bad])


def _reference(
    parts: Sequence[str],
    known: Sequence[str],
    place: dict[str, int],
    names: Sequence[str],
    where: str,
) -> Counts:
    found: dict[str, str] = {}
    for part, one in zip(parts, known, strict=True):
        if found.setdefault(part, one) != one:
            raise DataError(f"{where}: part {part} is {found[part]} in one row, {one} in another")
    return np.array([place[found[name]] for name in names], dtype=np.int64)
