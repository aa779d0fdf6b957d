"""What derivatives at a solution say of more sizes: against a least squares with these among the
unknowns.
"""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.fit.logs import unstated_channels
from motorid.estimate.solver.problem import Unknown
from tests.estimate.fit.made_fits import LAG, SMOOTHING, record, solution


def told() -> tuple[Any, Any, Any, Any]:
    """Rows of two doubts, a line with two shared and one own unknown, and its full design."""
    rng = np.random.default_rng(4)
    own, shared = rng.standard_normal((80, 1)), rng.standard_normal((80, 2))
    rows = rng.standard_normal((2, 80)) + shared[:, 0] + own[:, 0]
    residual = 0.8 * rows[0] - 0.3 * rows[1] + rng.standard_normal(80)
    orthogonal = shared - own @ np.linalg.inv(own.T @ own) @ own.T @ shared
    line = SimpleNamespace(
        own=own, own_information=own.T @ own, orthogonal=orthogonal,
        residual=residual, slices=(slice(0, 30), slice(30, 80)), sigmas=np.array([0.5, 2.0]),
    )  # fmt: skip
    # at a solution nothing of the residual goes with what is unknown already
    design = np.column_stack([shared, own])
    line.residual = residual - design @ np.linalg.lstsq(design, residual, rcond=None)[0]
    return rows, line, np.linalg.inv(shared.T @ orthogonal), design


def test_what_is_heard_of_sizes_is_the_fit_with_them_among_the_unknowns() -> None:
    rows, line, inverse, design = told()
    heard = unstated_channels.heard(rows, line, inverse)
    every = np.column_stack([design, rows.T])
    prior = np.diag([0.0, 0.0, 0.0, 1.0, 1.0])
    covariance = np.linalg.inv(every.T @ every + prior)
    found = covariance @ every.T @ line.residual
    sizes = found[3:]
    assert heard.largest == pytest.approx(np.abs(sizes).max())
    assert heard.step == pytest.approx(-found[:2])  # parameters give way by as much
    rest = line.residual - every @ found
    fallen = line.residual @ line.residual - rest @ rest - sizes @ sizes
    assert heard.gain == pytest.approx(fallen)
    assert (heard.unknowns, heard.readings) == (2, 80)
    more = covariance[:2, :2] - np.linalg.inv(design.T @ design)[:2, :2]
    total = sum((np.outer(s, s) for s in heard.shifts), np.zeros((2, 2)))
    assert total == pytest.approx(more)


def test_a_size_that_the_others_explain_is_as_open_as_its_prior() -> None:
    _, line, inverse, design = told()
    heard = unstated_channels.heard(design[:, :1].T * 2.0, line, inverse)
    assert heard.gain == pytest.approx(0.0, abs=1e-9)
    (shift,) = heard.shifts
    assert shift == pytest.approx([2.0, 0.0], abs=1e-9)


def test_a_record_tells_of_each_channel_that_nobody_states(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rows, line, inverse, _ = told()
    priors = {LAG: 3.0, SMOOTHING: 0.5}
    weights = np.repeat(line.sigmas, [30, 50])
    slopes = dict(zip(priors, rows, strict=True))
    monkeypatch.setattr(
        Instance, "unknown",
        lambda one, _: Unknown(one.name, 0.0, prior_sd=priors[one]) if one in priors else None,
    )  # fmt: skip

    def tangent(run: Any, values: Any, own: Any, one: Instance) -> Any:
        assert (run, values.tolist(), own.tolist()) == (record_, [1.0, 2.0, 3.0], [7.0])
        column = slopes[one] * weights / priors[one]
        return [column[:30], column[30:]]

    monkeypatch.setattr(unstated_channels, "tangent", tangent)
    record_ = record(weighed=lambda parts: parts)
    found = solution(1.0, np.linalg.inv(inverse), (7.0,))
    vars(found)["records"] = (line,)
    (heard,) = unstated_channels.told([record_], found)
    wanted = unstated_channels.heard(rows, line, inverse)
    assert (heard.gain, heard.largest) == pytest.approx((wanted.gain, wanted.largest))
    assert heard.step == pytest.approx(wanted.step)
    priors.clear()
    (none,) = unstated_channels.told([record_], found)
    assert (none.gain, none.unknowns, none.largest, none.readings) == (0.0, 0, 0.0, 80)
    assert (none.shifts, none.step.tolist()) == ((), [0.0, 0.0])
    assert not none.asked_for


@pytest.mark.parametrize(
    ("largest", "gain", "asked"), [(0.51, 14.0, True), (0.49, 14.0, False), (0.51, 13.5, False)]
)
def test_a_size_is_asked_for_beyond_half_of_what_is_usual(
    largest: float, gain: float, asked: bool
) -> None:
    """And where it gains its price: twice ln 1000, 13.8."""
    one = unstated_channels.Told(gain, 2, largest, 1000, (), np.zeros(2))
    assert one.asked_for is asked
    assert unstated_channels.Told(0.0, 3, 0.0, 1, (), np.zeros(2)).needed == pytest.approx(
        3.0 * math.log(2.0)
    )
