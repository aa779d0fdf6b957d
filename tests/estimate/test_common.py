"""Causes that captures share, against what their sum must be."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from motorid.estimate.effects.brush_and_heating import DROP
from motorid.estimate.solver.problem import Linearised, Unknown
from motorid.estimate.uncertainty.shared_causes import shifts

RUNS, READINGS, PRIOR = 3, 400, 0.5


def fitted(name: str, signs: tuple[float, ...] = (1.0,) * RUNS) -> tuple[SimpleNamespace, list]:
    """Runs that read a parameter plus an unknown of that name, which its prior alone tells."""
    own, ones, none = 1.0 / PRIOR**2 + READINGS, np.ones((READINGS, 1)), np.zeros(0)
    precision = np.array([PRIOR**-2.0])
    lines = [Linearised(none, ones, sign * ones, none, precision, (), (), none) for sign in signs]
    information = np.array([[len(signs) * (READINGS - READINGS**2 / own)]])
    records = [SimpleNamespace(unknowns=(Unknown(name, 0.0, prior_sd=PRIOR),)) for _ in signs]
    return SimpleNamespace(information=information, records=tuple(lines)), records


def test_three_runs_know_a_common_drop_no_better_than_its_prior() -> None:
    solution, records = fitted(DROP)
    noise = 1.0 / solution.information[0, 0]
    assert noise == pytest.approx((PRIOR**2 + 1.0 / READINGS) / RUNS)
    lacking = sum(float(shift[0]) ** 2 for shift in shifts(solution, records))
    assert noise + lacking == pytest.approx(PRIOR**2 + 1.0 / READINGS / RUNS, rel=1e-9)


def test_runs_that_a_common_drop_pulls_apart_lack_nothing() -> None:
    assert shifts(*fitted(DROP, (1.0, -1.0))) == [pytest.approx(0.0)]


def test_what_each_run_has_for_itself_is_left_to_it() -> None:
    assert shifts(*fitted("source_level_1")) == []
