"""What a quantity reads where the run lacks what it rests on."""

from __future__ import annotations

import math
from dataclasses import replace

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


def test_the_misfit_of_curves_is_one_where_the_residual_is_the_noise(
    estimate: Estimate, product: Product
) -> None:
    as_noise = replace(estimate, chi_square=800.0, degrees_of_freedom=800)
    twice = replace(estimate, chi_square=3200.0, degrees_of_freedom=800)
    for one, value in ((as_noise, 1.0), (twice, 2.0)):
        found = QUANTITIES["curve_shape"].read(Context(one, product))
        assert (found.value, found.uncertainty) == (value, math.sqrt(0.5 / 800))


@pytest.mark.parametrize("channel", ["voltage", "current"])
def test_an_offset_tells_directions_apart_by_twice_itself(
    channel: str, estimate: Estimate, product: Product
) -> None:
    name = {"voltage": "direction_speed", "current": "direction_current"}[channel]
    windows = Context(estimate, product).windows
    levels = [abs(w.level if channel == "voltage" else w.mean_current) for w in windows]
    level = sum(levels) / len(levels)
    some = next(iter(estimate.nuisance.values()))
    u = []
    for offset in (0.0, 0.1 * level):
        known = {f"{channel} offset": replace(some, total=offset)}
        found = QUANTITIES[name].read(Context(replace(estimate, nuisance=known), product))
        u.append(found.uncertainty or 0.0)
    assert math.sqrt(u[1] ** 2 - u[0] ** 2) == pytest.approx(0.2, rel=0.1)
