"""What no model offered explains makes the values that it moves doubtful."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from motorid.estimate.assembly.assemble import answered
from motorid.estimate.effects.friction.windage import WINDAGE
from motorid.estimate.fit import joint_fit
from motorid.estimate.results.estimate import Estimate
from motorid.estimate.results.status import Status
from motorid.estimate.selection.seen_effects import with_seen
from motorid.estimate.uncertainty.intervals import Findings
from motorid.estimate.uncertainty.undetected import Undetected, told
from tests.exact_capture import FAULHABER, Plan, clean_capture, noisy


@cache
def fitted() -> tuple[Estimate, Findings]:
    captures = [noisy(clean_capture(FAULHABER, Plan(volts=(6.0, 2.0))), 1, 1e-2, 1e-3)]
    records, solution = joint_fit.solved(captures, {}, ())
    estimate, _, known = answered(captures, records, solution, {}, ())
    return estimate, known


def found(share: float, seen: float) -> Estimate:
    """With an effect that moves B by a share of it."""
    estimate, known = fitted()
    solution = known.solution
    names = [u.name for u in solution.unknowns]
    at = names.index("B")
    shift = np.zeros(len(names))
    shift[at] = np.log1p(share) if solution.unknowns[at].log else share * solution.values[at]
    one = Undetected(WINDAGE, shift / (seen or 1.0), 0.05, seen)  # by one standard deviation
    return with_seen(estimate, replace(known, undetected=(one,)))


@pytest.mark.slow
def test_a_value_that_it_moves_is_doubtful_and_its_interval_covers_the_move() -> None:
    before = fitted()[0].parameters["B"]
    made = found(0.3, seen=5.0)
    after = made.parameters["B"]
    assert after.status == Status.DOUBTFUL
    assert after.interval_95[1] >= before.value * 1.3
    assert made.parameters["R"] == fitted()[0].parameters["R"]
    (said,) = [d for d in made.diagnostics if d.code == "effect_seen"]
    assert "windage" in said.message or WINDAGE.name in said.message
    assert "5.0 standard deviations" in said.message


@pytest.mark.slow
@pytest.mark.parametrize(("share", "seen"), [(0.3, 0.0), (1e-6, 5.0)])
def test_what_is_not_seen_or_moves_nothing_changes_nothing(share: float, seen: float) -> None:
    assert found(share, seen) == fitted()[0]


def test_what_is_seen_is_no_line_of_the_budget() -> None:
    shift = np.ones(6)
    lines = told([Undetected(WINDAGE, shift, 0.05), Undetected(WINDAGE, shift, 0.05, 5.0)])
    assert list(lines) == [WINDAGE.name]
    assert told([Undetected(WINDAGE, shift, 0.05, 5.0)]) == {}
