"""What a quantity reads where the run lacks what it rests on."""

from __future__ import annotations

import pytest

from motorid.estimate.results.estimate import Estimate
from motorid.quality.product import Product
from motorid.quality.quantities import QUANTITIES, Context


@pytest.mark.parametrize("name", ["direction_current", "direction_speed"])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_difference_of_directions_needs_both(
    name: str, sign: float, estimate: Estimate, product: Product
) -> None:
    whole, half = Context(estimate, product), Context(estimate, product)
    assert QUANTITIES[name].read(whole).value is not None
    one_way = tuple(w for w in whole.windows if w.speed * sign > 0)
    assert 0 < len(one_way) < len(whole.windows)
    half.__dict__["windows"] = one_way
    found = QUANTITIES[name].read(half)
    assert found.value is None
    assert found.problem.endswith("in both directions")
