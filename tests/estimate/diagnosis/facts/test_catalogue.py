"""Plausible figures: the catalogue's own motors lie well within them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from motorid.estimate.diagnosis.facts.catalogue import (
    MARGIN,
    MOTORS,
    OTHERS,
    Figures,
    distance,
    distance_of,
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


# diameter of the rotor or the housing in mm, which the names tell; wound without iron
CORELESS = {
    "Faulhaber 0816K003SR": 8, "Faulhaber 0816K006SR": 8, "Faulhaber 0816K009SR": 8,
    "Faulhaber 0816K012SR": 8, "Faulhaber 2338S006S": 23, "maxon A-max 22": 22, "maxon RE 35": 35,
    "maxon RE 65": 65, "maxon DCX 10 S": 10, "maxon DCX 22 L": 22, "maxon RE 40": 40,
    "maxon RE 50": 50,
}  # fmt: skip
DISCS = {
    "B9M4": 90, "B12M4": 120, "BR13": 130, "BR17": 170, "BR19": 190, "BR19 HR": 190, "B23": 230,
    "BR24": 240, "BR27": 270,
}  # fmt: skip
ALNICO = ("Faulhaber 2338S006S", "maxon A-max 22")  # a third of the field of a rare earth


@pytest.mark.parametrize("name", CORELESS)
def test_a_coreless_motor_is_as_its_diameter_says(name: str) -> None:
    """Inertia as D⁵ of a like shape, L/R as D² of a like winding, the rim's speed at no load and
    the time constant about the same."""
    (volts, R, L, K, J), D = ALL[name], CORELESS[name]
    assert 6e-14 < J / D**5 < 1.85e-13
    assert 1e-7 < L / R / D**2 < 3e-7
    assert 1e5 < volts / K * 30 / math.pi * D < 3.2e5
    low, high = (15e-3, 22e-3) if name in ALNICO else (3e-3, 7.5e-3)
    assert low < J * R / K**2 < high


@pytest.mark.parametrize("name", DISCS)
def test_a_disc_motor_is_as_its_diameter_says(name: str) -> None:
    """Inertia as D⁴ of discs alike thick, K²/R about as D⁵, L/R as D²."""
    (volts, R, L, K, J), D = ALL[name], DISCS[name] / 10
    assert 5.5e-9 < J / D**4 < 1.5e-8
    assert 2.3e-8 < K**2 / R / D**5 < 8.5e-8
    assert 1.5e-7 < L / R / D**2 < 7.5e-7
    assert 3000 < volts / K * 30 / math.pi < 5000


# rpm at no load, mN·m at stall, ms of the mechanical time constant: lines 4, 6 and 14 of the sheet
SHEET = {
    "Faulhaber 0816K003SR": (13_250, 1.15, 6.1), "Faulhaber 0816K006SR": (13_500, 1.13, 6.5),
    "Faulhaber 0816K009SR": (13_500, 1.15, 6.2), "Faulhaber 0816K012SR": (12_600, 1.0, 6.5),
}  # fmt: skip


@pytest.mark.parametrize("name", SHEET)
def test_a_data_sheets_other_lines_follow(name: str) -> None:
    """Friction and the mean of brushes take a few per cent of them."""
    volts, R, _, K, J = ALL[name]
    rpm, stall_mnm, tau_ms = SHEET[name]
    assert volts / K * 30 / math.pi == pytest.approx(rpm, rel=0.05)
    assert 1e3 * K * volts / R == pytest.approx(stall_mnm, rel=0.05)
    tau = J * R / K**2
    assert tau == pytest.approx(1e-3 * tau_ms, rel=0.05)


def test_a_motor_is_as_far_off_as_its_logarithms_are_unusual() -> None:
    """Of figures that cannot be a load or a lower voltage: a chi-square by the table itself."""
    table = np.log(np.array(list(MOTORS.values())))
    wide = np.log(np.array(list(ALL.values())))
    figures = {"R": 3.0, "L": 2e-3, "K": 0.01}
    for rows, among_all in ((table, False), (wide, True)):
        mean = rows[:, 1:4].mean(axis=0)
        covariance = np.cov(rows[:, 1:4].T) + np.diag([0.4**2, 0.8**2, 0.3**2])
        off = np.log(list(figures.values())) - mean
        expected = off @ np.linalg.solve(covariance, off)
        assert distance_of(figures, among_all) == pytest.approx(expected)
    assert distance_of({"L": 2e-3}) == pytest.approx(
        (math.log(2e-3) - table[:, 2].mean()) ** 2 / (table[:, 2].var(ddof=1) + 0.64)
    )


@pytest.mark.parametrize(
    ("name", "factor", "deviation"),
    [("J", 30.0, 1.5), ("V", 1 / 5.0, 1.0), ("V", 2.0, 0.2), ("J", 1 / 30.0, 0.0)],
)
def test_a_load_and_a_lower_voltage_are_in_a_motors_favour(
    name: str, factor: float, deviation: float
) -> None:
    """By a figure alone: u² and what is left after it, at its least; a rotor's load only adds."""
    k = ("V", "R", "L", "K", "J").index(name)
    column = np.log(np.array(list(MOTORS.values())))[:, k]
    variance = column.var(ddof=1) + (0.04 if name == "V" else 0.16)
    off = math.log(factor)
    value = math.exp(column.mean() + off)
    expected = off**2 / (variance + deviation**2)  # both variances together
    assert distance_of({name: value}) == pytest.approx(expected, rel=0.02)


def test_a_load_is_taken_for_one_up_to_four_deviations() -> None:
    column = np.log(np.array(list(MOTORS.values())))[:, 4]
    variance = column.var(ddof=1) + 0.16
    off = 80.0
    expected = (off - 6.0) ** 2 / variance + 16.0
    assert distance_of({"J": math.exp(column.mean() + off)}) == pytest.approx(expected)


def test_a_distance_is_of_all_figures_that_are_known() -> None:
    known = Figures(12.0, 2.0, 0.02, 1e-6)
    bare = {"V": 12.0, "R": 2.0, "K": 0.02, "J": 1e-6}
    assert distance(known) == distance_of(bare)
    told = Figures(12.0, 2.0, 0.02, 1e-6, 0.05)
    assert distance(told, wide=True) == distance_of({**bare, "L": 0.05}, wide=True)
    assert distance(told) > distance(known) + 1.0


def test_true_figures_are_those_read_over_the_factors_power() -> None:
    read = Figures(12.0, 2.0, 0.02, 1e-6)
    true = read.scaled({"V": 1.0, "K": -1.0, "J": 2.0, "L": 1.0}, 10.0)
    assert vars(true) == pytest.approx({"top_v": 1.2, "R": 2.0, "K": 0.2, "J": 1e-8, "L": None})
