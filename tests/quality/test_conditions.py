"""Conditions of several runs: the one that spoils the verdict is the one that is said."""

from __future__ import annotations

from dataclasses import replace

import pytest

from motorid.estimate.results.estimate import Estimate
from motorid.quality.judge import NOT_GROUND, SUPPORTED, judge, not_running
from motorid.quality.product import Product
from motorid.quality.verdict import Outcome


@pytest.mark.slow
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


@pytest.mark.slow
def test_what_is_not_the_ground_of_a_verdict_is_named(estimate: Estimate, product: Product) -> None:
    """As ``stored_verdict`` reads it from the name alone."""
    said = [m for m in judge(estimate, product).measurements if m.quantity not in product.limits]
    assert {m.quantity for m in said if not m.limit.condition} == set(SUPPORTED)
    assert {"run_complete", "fit_settled", "ambient"} <= {m.quantity for m in said}
    (_, dead) = not_running(product, "D000001", "open winding", "no current").measurements
    assert {*SUPPORTED, dead.quantity} == set(NOT_GROUND)
