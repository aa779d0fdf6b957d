"""What readings count for: filters and thinning by numpy's convolution, block by block."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.estimate.model import prewhitening, program_parts
from motorid.estimate.model.source_mixing import AHEAD, BACK, Mixer
from motorid.estimate.model.weighting import Weighed
from tests.estimate.effects.benches import record
from tests.estimate.uncertainty.test_budget import fitted

FILTER = np.array([1.0, -0.5, 0.25])


def weighed() -> Weighed:
    return Weighed(record("measured").measured)


def random_parts(of: Weighed) -> list[np.ndarray]:
    rng = np.random.default_rng(4)
    return [rng.normal(size=len(m.values)) for m in of.measured]


def test_a_filter_is_a_convolution_that_begins_when_it_is_full() -> None:
    one = weighed()
    parts = random_parts(one)
    one.whiten([FILTER, None, None][: len(parts)])
    found = one.filtered(parts)
    expected = [
        sum(c * parts[0][2 - k : len(parts[0]) - k] for k, c in enumerate(FILTER)), *parts[1:]
    ]  # fmt: skip
    for a, b in zip(found, expected, strict=True):
        assert a == pytest.approx(b)
    assert one.blocks[0].count == one.measured[0].block.count - 2


def test_thinned_readings_count_by_their_weights() -> None:
    one = weighed()
    roots = [np.full(len(m.values), 0.5) for m in one.measured]
    one.thin(roots)
    for m, block in zip(one.measured, one.blocks, strict=True):
        weights = np.ones(len(m.values)) if m.root_weights is None else m.root_weights**2
        assert block.count == pytest.approx(0.25 * weights.sum())


@pytest.mark.parametrize("thinned", [False, True])
def test_rows_are_filtered_as_parts_are(thinned: bool) -> None:
    one = weighed()
    parts = random_parts(one)
    one.whiten([FILTER] * len(parts))
    if thinned:
        one.thin([np.linspace(0.5, 1.0, len(p)) for p in parts])
    table = np.array([np.concatenate(parts), 2.0 * np.concatenate(parts)])
    rows = one.filtered_rows(table)
    assert rows[0] == pytest.approx(np.concatenate(one.filtered(parts)))
    assert rows[1] == pytest.approx(2.0 * rows[0])


def test_every_residual_belongs_to_the_part_that_its_reading_lies_in() -> None:
    records, solution = fitted("measured")
    (numbers,) = program_parts.by_part(solution, records)
    one = records[0]
    for m, block in zip(one.measured, solution.records[0].slices, strict=True):
        edges = [p.start for p in one.timeline.parts]
        expected = np.searchsorted(edges, m.keep, side="right") - 1
        assert numbers[block].tolist() == expected[-len(numbers[block]) :].tolist()


@pytest.mark.slow
def test_white_noise_needs_no_filter_and_coloured_noise_does() -> None:
    records, solution = fitted("noisy_source")
    one = records[0].twin()

    def left_as(series: np.ndarray) -> bool:
        class Left(type(one)):  # type: ignore[misc, name-defined]
            def departures(self, shared: np.ndarray, own: np.ndarray) -> list[np.ndarray]:
                return [series[: len(m.values)] for m in self.measured]

        twin = one.twin()
        twin.__class__ = Left
        return prewhitening.whiten([twin], solution)

    white = np.random.default_rng(8).normal(0.0, 0.01, 2000)
    coloured = np.zeros(2000)
    for k in range(1, 2000):
        coloured[k] = 0.8 * coloured[k - 1] + white[k]
    assert not left_as(white)
    assert left_as(coloured)


def test_a_mixed_source_ends_where_a_linear_one_would() -> None:
    """v → a + g v settles at a/(1 − g): two judgements of it tell where."""

    class Drive:
        """A source of one figure, and how it is judged."""

        def __init__(self, volts: float) -> None:
            self.volts = np.array([volts])
            self.excitation = self

        def judged(self) -> Drive:
            return Drive(1.0 + 0.5 * float(self.volts[0]))

        def mixed(self, other: Drive, share: float) -> Drive:
            return Drive(float((1 - share) * self.volts[0] + share * other.volts[0]))

    mixer, now = Mixer(), Drive(0.0)
    for _ in range(2):
        now = mixer.next(now, now.judged())  # type: ignore[arg-type, assignment]
    assert now.volts[0] == pytest.approx(2.0)
    assert AHEAD > BACK > 0.0
