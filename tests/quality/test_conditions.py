"""Conditions of several runs: the one that spoils the verdict is the one that is said."""

from __future__ import annotations

from dataclasses import replace

import pytest

from motorid.estimate.results.estimate import Estimate
from motorid.quality.judge import judge
from motorid.quality.product import Product
from motorid.quality.verdict import Outcome


@pytest.mark.parametrize("warm", [0, 1, 2])
def test_the_ambient_of_the_run_that_is_out_of_range_is_said(
    warm: int, estimate: Estimate, product: Product
) -> None:
    assert product.ambient is not None
    assert product.ambient.high is not None
    beyond = product.ambient.high + 5.0
    runs = [dict(estimate.inputs[0]) for _ in range(3)]
    runs[warm]["ambient_c"] = beyond
    verdict = judge(replace(estimate, inputs=tuple(runs)), product)
    found = verdict["ambient"]
    assert found.outcome is not Outcome.PASS
    assert found.reading.value == beyond
    assert verdict.outcome is Outcome.INVALID
