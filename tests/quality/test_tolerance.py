"""What a plan takes from a product's limits: wants, spreads, and steady turns."""

from __future__ import annotations

import math

import pytest

from motorid.plan.wants import Want
from motorid.quality.product import Product, parse
from motorid.quality.tolerance import TURNS, demand_of, spread_of

HEAD = """
[motor]
voltage_v = 6
segments = 5
[[program.steps]]
kind = "coast"
duration_s = 1
"""


def product(**limits: tuple[float | None, float | None]) -> Product:
    text = HEAD
    for name, (low, high) in limits.items():
        text += f"[limits.{name}]\n"
        text += "" if low is None else f"low = {low}\n"
        text += "" if high is None else f"high = {high}\n"
    return parse(text)


@pytest.mark.parametrize(
    ("name", "limits", "reach"),
    [
        ("R_25", (2.0, 3.0), 0.125 / math.sqrt(6.0)),  # an eighth of the width, over √(2 · 3)
        ("R", (1.0, 9.0), 1.0 / math.sqrt(2.25 * 9.0)),  # no less than a quarter of the top
        ("K_25", (None, 8.0), 1.0 / math.sqrt(2.0 * 8.0)),  # from nothing
        ("J", (4.0, None), 0.5 / math.sqrt(4.0 * 8.0)),  # to twice the least
        ("B", (1e-6, 3e-6), 0.25e-6), ("T0", (None, 8e-4), 1e-4), ("L", (2.0, 3.0), 0.125 / 6**0.5),
    ],
)  # fmt: skip
def test_a_want_is_a_quarter_of_the_tolerance(
    name: str, limits: tuple[float | None, float | None], reach: float
) -> None:
    (want,) = demand_of(product(**{name: limits})).wants
    assert want == Want(name.removesuffix("_25"), pytest.approx(reach))


def test_wants_stand_in_the_order_of_the_parameters() -> None:
    both = product(T0=(None, 1.0), K_25=(1.0, 2.0), R=(1.0, 2.0), no_load_speed=(1.0, None))
    assert [want.name for want in demand_of(both).wants] == ["R", "K", "T0"]
    assert demand_of(both).turns == 0.0


@pytest.mark.parametrize(
    ("name", "turns"),
    [
        ("direction_current", TURNS), ("direction_speed", TURNS), ("ripple_turn", TURNS),
        ("friction_turn", TURNS), ("unbalance", TURNS), ("brush_noise", TURNS), ("cogging", 0.0),
        ("curve_shape", 0.0),
    ],
)  # fmt: skip
def test_what_repeats_with_the_turn_needs_turns(name: str, turns: float) -> None:
    found = demand_of(product(**{name: (None, 0.1)}))
    assert (found.turns, found.wants) == (turns, ())


@pytest.mark.parametrize(
    ("limits", "spread"),
    [
        ((1.5, 4.0), (1.5, 4.0)), ((0.5, None), (0.5, 3.0)), ((2.0, None), (2.0, 3.0)),
        ((None, 2.0), (1.0, 2.0)), ((None, 5.0), (1.0, 3.0)), ((None, 0.5), (0.5, 0.5)),
        ((5.0, None), (5.0, 5.0)),
    ],
)  # fmt: skip
def test_motors_within_the_limits(
    limits: tuple[float | None, float | None], spread: tuple[float, float]
) -> None:
    """Where one end alone is limited, the spread of 1 to 3 is cut to it."""
    otherwise = {"R": (1.0, 3.0), "K": (0.1, 0.2)}
    found = spread_of(product(R_25=limits, no_load_speed=(1.0, 2.0)), otherwise)
    assert found == {"R": spread, "K": (0.1, 0.2)}
    assert otherwise["R"] == (1.0, 3.0)
