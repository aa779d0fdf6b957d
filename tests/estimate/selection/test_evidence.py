"""What speaks for a better model, on solutions of which all is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.estimate.fit.parameter_bounds import unknowns_of
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.extended_terms import TERMS
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.selection import score_test, shaft_resonance, trigger
from motorid.estimate.selection.evidence import MARGIN, Evidence, evidence, size_of
from motorid.estimate.selection.score_derivatives import Probe
from motorid.estimate.solver.levenberg_marquardt import maximise
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty import log_scatter, uneven_residuals
from motorid.estimate.uncertainty.covariance import statistical
from tests.estimate.effects.benches import FAULHABER, POINT, measured, start
from tests.estimate.uncertainty.test_budget import fitted
from tests.exact_capture import noisy


@pytest.mark.parametrize("more", [1, 2])
def test_schwarzs_penalty_and_a_margin(more: int) -> None:
    """k ln n; n by the readings that are worth one each."""
    _, solution = fitted("measured")
    found = evidence(solution, replace(solution, objective=solution.objective + 50.0), more)
    count = sum(b.count for line in solution.records for b in line.blocks)
    assert found.gain == pytest.approx(50.0)
    assert found.inflation >= 1.0
    assert found.needed == pytest.approx(more * np.log(count / found.inflation) + MARGIN)


@pytest.mark.parametrize(
    ("gain", "size", "left_out", "supported"),
    [
        (30.0, 9.0, None, True), (30.0, 9.0, 1.0, True), (30.0, 9.0, -1.0, False),
        (30.0, 3.9, None, False), (19.0, 9.0, None, False),
    ],
)  # fmt: skip
def test_all_must_speak_for_a_term(
    gain: float, size: float, left_out: float | None, supported: bool
) -> None:
    assert Evidence(gain, 1.0, 20.0, size, left_out).supports is supported


@pytest.mark.parametrize(
    ("gain", "size", "possible"), [(41.0, 2.1, True), (39.0, 9.0, False), (41.0, 1.9, False)]
)
def test_a_term_is_possible_where_it_explains_twice_what_it_costs(
    gain: float, size: float, possible: bool
) -> None:
    """Of many terms that are tried, one explains what it costs by chance."""
    assert Evidence(gain, 1.0, 20.0, size).possible is possible
    assert Evidence(2.0 * gain, 2.0, 20.0, size).possible is possible


@pytest.mark.parametrize(
    ("gain", "size", "left_out", "possible"),
    [(21.0, 2.1, 1.0, True), (19.0, 9.0, 1.0, False), (21.0, 1.9, 1.0, False),
     (39.0, 3.0, -1.0, False), (41.0, 3.0, -1.0, True)],
)  # fmt: skip
def test_a_term_is_possible_where_it_pays_for_itself_and_captures_left_out_agree(
    gain: float, size: float, left_out: float, possible: bool
) -> None:
    """Else what is offered with a size of four deviations would be nothing with one of less."""
    assert Evidence(gain, 1.0, 20.0, size, left_out).possible is possible


def test_what_is_likelier_explains_more_beyond_its_cost() -> None:
    one, other = Evidence(90.0, 1.0, 20.0), Evidence(120.0, 2.0, 1.0)
    assert one.beats(replace(other, gain=120.0 - 1.0))
    assert not one.beats(replace(other, gain=120.0 + 3.0))
    assert not one.beats(one)


def test_a_size_in_its_own_deviations() -> None:
    _, solution = fitted("measured")
    deviation = float(statistical(solution).deviations[0])  # of ln R
    assert size_of(solution, 0) == pytest.approx(1.0 / deviation)


def test_a_size_at_a_bound_is_nothing_only_where_the_bound_is() -> None:
    _, solution = fitted("measured")
    b = [one.name for one in solution.unknowns].index("B")
    at_bound = np.arange(len(solution.values)) == b
    largest = replace(solution, at_bound=at_bound)
    assert size_of(largest, b) == size_of(solution, b) > 4.0
    none = replace(largest, values=np.where(at_bound, 0.0, solution.values))
    assert size_of(none, b) == 0.0


@pytest.mark.parametrize("hz", [40.0, 333.0, 1500.0])
def test_a_resonance_is_a_peak_that_stands_out(hz: float) -> None:
    time = np.arange(4000) * 1e-4
    noise = np.random.default_rng(4).normal(0.0, 0.3, 4000)
    peaks = shaft_resonance._peaks(np.sin(2 * np.pi * hz * time) + noise, 0.4)
    assert peaks[0] == pytest.approx(2 * np.pi * hz, rel=0.01)
    assert len(shaft_resonance._peaks(noise, 0.4)) == 0


def test_a_stiff_shaft_is_not_looked_for_in_noise() -> None:
    records, solution = fitted("measured")
    assert shaft_resonance.springs(records, solution, FAULHABER, [TERMS["two-masses"]]) == []


@pytest.mark.slow
def test_a_loss_that_is_noise_asks_for_nothing() -> None:
    records = [MotorRecord(noisy(measured(), 7, 2e-3, 2e-4), PARAMETERS, {})]
    records[0].retake_sources(POINT, start(records[0]))  # now what it loses has a course
    solution = maximise(unknowns_of(records, PARAMETERS, FAULHABER), records)
    assert trigger.carry_loss(records)
    k = [u.name for u in records[0].unknowns].index("brush drop")

    def lost(deviations: float) -> Solution:
        own = np.zeros_like(solution.own[0])
        own[k] = deviations * float(np.sqrt(solution.own_covariance[0][k, k]))
        return replace(solution, own=(own,))

    anywhere = dict.fromkeys(FAULHABER, 0.0)
    assert not trigger.loss_stands_out(records, lost(1.0), anywhere)
    # one that is a hundred deviations does, wherever it moves a parameter
    large = lost(100.0)
    assert trigger.loss_stands_out(records, large, anywhere)
    # and does not where it moves each by much less than matters
    assert not trigger.loss_stands_out(records, large, dict.fromkeys(FAULHABER, 1e9))


def test_a_program_shows_no_scatter_of_a_log() -> None:
    records, solution = fitted("measured")
    assert log_scatter.shifts(solution, records) == []


def test_a_log_scatters_as_its_stretches_do() -> None:
    """In orthogonal directions; scores of all stretches add up to those of the whole."""
    records, solution = fitted("log")
    line = solution.records[0]
    pulls = log_scatter._pulls(records[0], line)
    assert pulls.sum(axis=0) == pytest.approx(line.orthogonal.T @ line.residual)
    inverse = np.linalg.inv(solution.information)
    white = line.orthogonal.T @ line.orthogonal
    found = np.array(uneven_residuals.ways(inverse @ (pulls.T @ pulls - white) @ inverse))
    assert len(log_scatter.shifts(solution, records)) >= len(found)
    products = found @ found.T
    assert products - np.diag(np.diag(products)) == pytest.approx(
        0.0, abs=1e-6 * np.abs(products).max()
    )


def test_a_terms_changes_are_of_its_own_readings() -> None:
    """Friction that grows with the square of the speed, by the wide model's own difference."""
    records, solution = fitted("measured")
    probe = Probe(records, solution, dict(zip(FAULHABER, solution.values, strict=True)))
    term = TERMS["quadratic-load"]
    (change,) = probe.changes(0, term, {})
    assert change.shape == (len(solution.records[0].residual),)
    angle = change[solution.records[0].slices[1]]
    assert angle[-1] < 0.0  # it brakes
    tried = score_test.everything(probe, [term])
    assert [one.term.name for one in tried] == ["quadratic-load"]
    line = solution.records[0]
    sums = score_test.sums_of(np.atleast_2d(change), line)
    assert sums.squares.shape == (1, 1)
    assert sums.squares[0, 0] > 0.0
