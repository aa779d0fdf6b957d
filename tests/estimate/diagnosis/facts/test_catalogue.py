"""Plausible figures: the catalogue's own motors lie well within them."""

from __future__ import annotations

import math

import pytest

from motorid.estimate.diagnosis.facts.catalogue import (
    MARGIN,
    MOTORS,
    OTHERS,
    Figures,
    distance,
    ranges,
)

ALL = {**MOTORS, **OTHERS}


def figures(motor: tuple[float, ...]) -> dict[str, float]:
    _, R, L, K, J = motor
    return {"R": R, "L": L, "K": K, "J": J, "L/R": L / R, "JR/K²": J * R / (K * K)}


@pytest.mark.parametrize("name", list(figures(next(iter(MOTORS.values())))))
def test_the_catalogues_lowest_and_highest_motor_are_one_margin_within(name: str) -> None:
    sizes = [figures(motor)[name] for motor in ALL.values()]
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


@pytest.mark.parametrize(("family", "within"), [("Faulhaber 0816K", 0.07), ("BR19", 0.12)])
def test_windings_of_one_motor_differ_by_their_turns_alone(family: str, within: float) -> None:
    """N turns of wire in one slot: K as N, R and L as N², the rotor the same, the speed at the
    nominal voltage about the same."""
    windings = [motor for name, motor in MOTORS.items() if name.startswith(family)]
    assert len(windings) >= 2
    for figure in (
        lambda V, R, L, K, J: R / K**2, lambda V, R, L, K, J: L / K**2,
        lambda V, R, L, K, J: J, lambda V, R, L, K, J: V / K,
    ):  # fmt: skip
        sizes = [figure(*motor) for motor in windings]
        assert max(sizes) / min(sizes) < (1.0 + within) ** 2, family


@pytest.mark.parametrize("name", ALL)
def test_a_motor_of_the_catalogue_could_be_one(name: str) -> None:
    """No load at its nominal voltage: 1,400 to 15,000 rpm; it is up to speed in 1 to 60 ms."""
    volts, R, _, K, J = ALL[name]
    assert 1400 < volts / K * 30 / math.pi < 15_000
    assert 1e-3 < J * R / K**2 < 60e-3
