"""What each term would do to the readings: their derivatives in its size, at size nothing."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.model.angle_spectrum import periods_a_turn, turned
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.extended_capture_model import WideRecord
from motorid.estimate.model.extended_terms import ADDED, TERMS, Term
from motorid.estimate.selection.extended_fit import scales_of
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.cogging_of_logs import strongest

Floats = NDArray[np.float64]

TRIED = 1e-4  # of a term's scale, by which a derivative is taken
QUARTER = np.pi / 2
BACKWARDS = 0.05  # of the largest speed, that is motion the other way


class Probe:
    """The records under a model of every term, each of size nothing but those they have."""

    def __init__(
        self, records: Sequence[MotorRecord], solution: Solution, values: Mapping[str, float]
    ) -> None:
        self._solution = solution
        self.names = tuple(u.name for u in solution.unknowns)
        self.scales = scales_of(records, values)
        self._free = (*self.names, *(n for n in ADDED if n not in self.names))
        absent = {name: added.absent for name, added in ADDED.items()}
        self._values = {**absent, **values}
        fixed = {n: v for n, v in values.items() if n not in self._free}
        everything = tuple(TERMS.values())
        self.records = []
        for k, record in enumerate(records):
            wide = WideRecord(record, self._free, fixed, everything, self.scales, {}, k == 0)
            wide.step_as(record)
            self.records.append(wide)
        self._own = [
            {**dict.fromkeys((u.name for u in wide.unknowns), 0.0),
             **dict(zip((u.name for u in record.unknowns), own.tolist(), strict=True))}
            for wide, record, own in zip(self.records, records, solution.own, strict=True)
        ]  # fmt: skip
        for k, wide in enumerate(self.records):
            wide.locate(*self._vectors(k, {}, {}))
        self._base = [self._fitted(k, {}, {}) for k in range(len(records))]

    def changes(self, k: int, term: Term, shape: Mapping[str, float]) -> Floats:
        """(q, n): what record k's readings change by for each unit of its sizes, by their weights.

        Sizes count in their scales. A phase of the record's own makes two of each size.
        """
        if not term.per_turn:
            return self._change(k, term.size, shape, {})[None]
        return np.array(
            [
                self._change(k, name, shape, term.phased(phase))
                for name in term.sizes
                for phase in (0.0, QUARTER)
            ]
        )

    def tells(self, term: Term) -> bool:
        """Whether such captures can tell the term at all."""
        if term.name == "ke-kt":  # torque, inertia and friction scale together unless one is held
            return not {"J", "B", "T0"} <= set(self.names)
        if term.name == "direction":
            return bool(min(self._turns) < 0 < max(self._turns))
        return True

    def shapes(self, term: Term) -> Iterator[dict[str, float]]:
        """What to try for the parameters that mean nothing while the size is 0."""
        if term.per_turn:
            more = self._kicks if term.name == "cogging" else []
            for count in dict.fromkeys([*self._counts, *more]):
                yield {term.per_turn: float(count)}
            return
        names = list(term.shapes)
        for parts in product(*(term.shapes[name] for name in names)):
            yield {n: p * self.scales.of(n) for n, p in zip(names, parts, strict=True)}

    def _vectors(
        self, k: int, shared: Mapping[str, float], own: Mapping[str, float]
    ) -> tuple[Floats, Floats]:
        values, nuisances = {**self._values, **shared}, {**self._own[k], **own}
        names = (u.name for u in self.records[k].unknowns)
        return np.array([values[n] for n in self._free]), np.array([nuisances[n] for n in names])

    def _fitted(
        self, k: int, shared: Mapping[str, float], own: Mapping[str, float]
    ) -> list[Floats]:
        return self.records[k].fitted(*self._vectors(k, shared, own))

    def _change(
        self, k: int, name: str, shape: Mapping[str, float], own: Mapping[str, float]
    ) -> Floats:
        size = self._values[name] + TRIED * self.scales.of(name)
        moved = self._fitted(k, {**shape, name: size}, own)
        parts = [(a - b) / TRIED for a, b in zip(moved, self._base[k], strict=True)]
        return np.concatenate(self.records[k].weighed(parts, filtered=False))

    @cached_property
    def _angles(self) -> list[Floats]:
        """The rotor's angle in every record, (count,), rad."""
        return [r.angle(*self._vectors(k, {}, {})) for k, r in enumerate(self.records)]

    @cached_property
    def _turns(self) -> list[float]:
        """The fastest steps either way, of each record."""
        steps = [np.diff(angle) for angle in self._angles]
        most = max(float(np.abs(step).max()) for step in steps)
        ends = [float(end) for step in steps for end in (step.min(), step.max())]
        return [end if abs(end) > BACKWARDS * most else 0.0 for end in ends]

    @cached_property
    def _kicks(self) -> list[int]:
        """How often a turn cogging would repeat that explains the starts and turns of logs best."""
        vectors = [self._vectors(k, {}, {}) for k in range(len(self.records))]
        return strongest(self.records, vectors, self._solution)

    @cached_property
    def _counts(self) -> list[int]:
        """How often a turn the residuals repeat."""
        channels = []
        for record, angle, base in zip(self.records, self._angles, self._base, strict=True):
            left = [m.values - y for m, y in zip(record.measured, base, strict=True)]
            channels.append(turned(record, left, angle))
        return periods_a_turn(channels)
