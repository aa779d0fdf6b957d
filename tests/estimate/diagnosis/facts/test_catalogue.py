"""Plausible figures: the catalogue's own motors lie well within them."""

from __future__ import annotations

import math

import pytest

from motorid.estimate.diagnosis.facts.catalogue import MARGIN, MOTORS, Figures, distance, ranges


def figures(motor: tuple[float, ...]) -> dict[str, float]:
    _, R, L, K, J = motor
    return {"R": R, "L": L, "K": K, "J": J, "L/R": L / R, "JR/K²": J * R / (K * K)}


@pytest.mark.parametrize("name", list(figures(next(iter(MOTORS.values())))))
def test_the_catalogues_lowest_and_highest_motor_are_one_margin_within(name: str) -> None:
    sizes = [figures(motor)[name] for motor in MOTORS.values()]
    low, high = ranges()[name]
    assert min(sizes) / low == pytest.approx(MARGIN)
    assert (
        high == math.inf if name in ("J", "JR/K²") else high / max(sizes) == pytest.approx(MARGIN)
    )


def test_a_motor_that_was_read_too_large_is_farther_off_until_it_is_scaled_back() -> None:
    volts, R, L, K, J = MOTORS["maxon A-max 22"]
    true = Figures(volts, R, K, J, L)
    powers = {"R": -1.0, "L": -1.0, "J": 1.0}  # of a current
    read = Figures(volts, R / 1e3, K, 1e3 * J, L / 1e3)
    assert distance(read) > distance(true) + 10.0
    back = read.scaled(powers, 1e3)
    assert vars(back) == pytest.approx(vars(true))
    assert distance(back) == pytest.approx(distance(true))
