"""Laws of a motor in blocks of a log: how much better another reading of it must be."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from motorid.estimate.diagnosis.facts import motor_laws, supply_current, swapped_columns
from motorid.estimate.results.estimate import PARAMETERS
from tests.estimate.diagnosis.facts.test_motor_laws import lawful, logged


def test_blocks_are_means_and_rises_between_their_edges() -> None:
    """A block has its own rows, and ends where the next begins: the last row only ends one."""
    squares = np.arange(10.0) ** 2
    assert motor_laws._means(squares, 3) == pytest.approx([5 / 3, 50 / 3, 149 / 3])
    assert motor_laws._rises(squares, 3) == pytest.approx([3.0, 9.0, 15.0])
    assert len(motor_laws._means(squares[:9], 3)) == len(motor_laws._rises(squares[:9], 3)) == 2
    assert len(motor_laws._means(np.arange(12.0), 3)) == 3


def test_the_unit_of_a_column_moves_no_share() -> None:
    volts, current, speed = lawful()
    assert motor_laws.left(24.0 * volts, 0.1 * current, 400.0 * speed) == pytest.approx(
        motor_laws.left(volts, current, speed), rel=1e-6
    )
    small = motor_laws.non_negative([np.array([1e-3, 2e-3])], np.array([1e-3, 3e-3]))
    assert small[0] == pytest.approx([1.4])
    assert small[1] == pytest.approx(0.02)


def test_forty_blocks_of_three_rows_tell_something() -> None:
    assert motor_laws.columns(logged(120)) is not None
    assert motor_laws.columns(logged(119)) is None
    rows = np.zeros(1200, dtype=bool)
    rows[:120] = True
    assert motor_laws.left(*lawful(), rows) != (1.0, 1.0)
    rows[119:] = False
    assert motor_laws.left(*lawful(), rows) == (1.0, 1.0)
    # 400 blocks of a long log: noise of a row is small in the mean of ten
    rng = np.random.default_rng(1)
    volts, current, speed = (np.repeat(x, 10)[:4000] for x in lawful())
    noisy = volts + 0.3 * rng.standard_normal(4000)
    fine, usual = (motor_laws.left(noisy, current, speed, blocks=n)[0] for n in (4000, 400))
    assert usual == motor_laws.left(noisy, current, speed)[0]
    assert fine == pytest.approx(10.0 / 3.0 * usual, rel=0.25)


def test_a_speed_near_standstill_has_no_friction() -> None:
    """Within .02 of the highest: of noise about rest, a sign would be noise too."""
    speed = np.concatenate([np.tile([0.015, -0.015], 300), np.linspace(0.1, 1.0, 600)])
    current = np.where(np.abs(speed) > 0.05, 0.1 + 0.2 * speed, 0.0)
    assert motor_laws.left(speed, current, speed)[1] < 1e-4
    current = np.where(speed > 0.018, current, -0.1)
    speed[:600] = -0.03
    current[:600] = -0.1 - 0.2 * 0.03
    assert motor_laws.left(speed, current, speed)[1] < 1e-4


@pytest.mark.parametrize(
    ("stated", "best", "coarse", "swapped"),
    [
        (0.6, 0.05, (0.6, 0.05), True),
        (0.09, 0.01, (0.6, 0.05), False),  # a motor's columns as they are
        (0.6, 0.11, (0.6, 0.05), False),  # no motor's in any arrangement
        (0.3, 0.07, (0.6, 0.05), False),  # not five times better,
        (0.6, 0.05, (0.6, 0.13), False),  # nor in coarser blocks
        (0.6, 0.05, (0.6, 0.11), True),
    ],
)
def test_another_arrangement_is_a_motors_and_five_times_better(
    stated: float, best: float, coarse: tuple[float, float], swapped: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    others = {(0, 1, 2): stated, (2, 1, 0): 0.9}

    def shares(found: Any, blocks: int) -> Any:
        at = {400: (stated, best), 100: coarse}[blocks]
        return at[0], {**others, (1, 0, 2): at[1]}

    monkeypatch.setattr(swapped_columns, "columns", lambda _: "columns")
    monkeypatch.setattr(swapped_columns, "_shares", shares)
    capture: Any = None
    found = swapped_columns.find(capture)
    names = ("terminal_voltage", "current", "speed")
    assert found == ((names[1], names[0], names[2]) if swapped else None)
    said = list(swapped_columns.findings(capture, " in run 2"))
    assert len(said) == swapped
    if swapped:
        assert said[0].message.startswith("voltage and current are swapped in run 2: the one")
        assert set(said[0].moves) == set(PARAMETERS)


def test_three_columns_that_have_changed_places_are_each_named(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found = ("speed", "terminal_voltage", "current")
    monkeypatch.setattr(swapped_columns, "find", lambda _: found)
    (said,) = swapped_columns.findings(logged())
    assert said.message.startswith(
        "the columns have changed places: the one called speed reads as the voltage, the one "
        "called voltage reads as the current, the one called current reads as the speed; in"
    )


@pytest.mark.parametrize(
    ("divided", "as_logged", "found"),
    [(0.02, 0.5, True), (0.02, 0.09, False), (0.02, 0.11, True), (0.06, 0.5, False)],
)
def test_a_supplys_current_is_a_motors_after_the_division_alone(
    divided: float, as_logged: float, found: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    volts = np.array([0.5, -0.5, 0.07, -1.0, 0.09])
    current = np.array([0.2, 0.2, 0.2, 0.2, 0.09])
    speed = np.ones(5)

    def left(v: Any, i: Any, w: Any, rows: Any) -> Any:
        assert list(rows) == [True, True, False, True, True]
        assert v is volts
        assert w is speed
        if i is current:
            return as_logged / 2, as_logged / 2
        assert i == pytest.approx([0.4, -0.4, 0.0, -0.2, 1.0])
        return divided / 4, 3 * divided / 4

    monkeypatch.setattr(supply_current, "columns", lambda _: (volts, current, speed))
    monkeypatch.setattr(supply_current, "left", left)
    capture: Any = None
    assert supply_current.found(capture) == found
    monkeypatch.setattr(supply_current, "columns", lambda _: None)
    assert supply_current.found(capture) is False
