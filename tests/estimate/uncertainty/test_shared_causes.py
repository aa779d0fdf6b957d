"""Causes that captures share, against what their sum must be."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Instance
from motorid.estimate.effects.source.brush_drop import BRUSH_DROP
from motorid.estimate.effects.source.source_level import SOURCE_LEVEL
from motorid.estimate.solver.problem import Linearised, Unknown
from motorid.estimate.uncertainty.budget import of_priors

RUNS, READINGS, PRIOR = 3, 400, 0.5


def fitted(
    quantity: InfluenceQuantity, signs: tuple[float, ...] = (1.0,) * RUNS
) -> tuple[SimpleNamespace, list]:
    """Runs that read a parameter plus an unknown of that name, which its prior alone tells."""
    own, ones, none = 1.0 / PRIOR**2 + READINGS, np.ones((READINGS, 1)), np.zeros(0)
    precision = np.array([PRIOR**-2.0])
    lines = [Linearised(none, ones, sign * ones, none, precision, (), (), none) for sign in signs]
    information = np.array([[len(signs) * (READINGS - READINGS**2 / own)]])
    one = Instance(quantity)
    unknown = Unknown(one.name, 0.0, prior_sd=PRIOR)
    records = [SimpleNamespace(instances=(one,), unknowns=(unknown,)) for _ in signs]
    return SimpleNamespace(information=information, records=tuple(lines)), records


def variance(solution: SimpleNamespace, records: list) -> float:
    """Of the parameter: noise, and what the cause leaves open."""
    known = of_priors(solution, records)
    noise = 1.0 / solution.information[0, 0] - known.apart[0, 0]
    return noise + sum(float((rows**2).sum()) for rows in known.shifts.values())


def test_three_runs_know_a_common_drop_no_better_than_its_prior() -> None:
    solution, records = fitted(BRUSH_DROP)
    alone = 1.0 / solution.information[0, 0]
    assert alone == pytest.approx((PRIOR**2 + 1.0 / READINGS) / RUNS)
    assert variance(solution, records) == pytest.approx(PRIOR**2 + 1.0 / READINGS / RUNS, rel=1e-9)


def test_runs_that_a_common_drop_pulls_apart_are_as_if_each_had_its_own() -> None:
    """It may still differ a little from one to the next."""
    solution, records = fitted(BRUSH_DROP, (1.0, -1.0))
    assert variance(solution, records) == pytest.approx(1.0 / solution.information[0, 0])


def test_what_each_run_has_for_itself_is_left_to_it() -> None:
    solution, records = fitted(SOURCE_LEVEL)
    assert variance(solution, records) == pytest.approx(1.0 / solution.information[0, 0])
