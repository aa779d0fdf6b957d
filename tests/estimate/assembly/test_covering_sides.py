"""How far one interval must grow to cover another."""

from __future__ import annotations

from dataclasses import replace

import pytest

from motorid.estimate.assembly.covering import COUNTED, covering_sides
from motorid.estimate.results.estimate import Parameter
from motorid.estimate.results.status import Status


def parameter(value: float | None, low: float = 0.0, high: float = 0.0) -> Parameter:
    interval = None if value is None else (low, high)
    return Parameter("J", "kg", value, 0.1, 0.0, 0.1, interval, Status.ESTIMATED)


TEN = parameter(10.0, 9.0, 11.0)


@pytest.mark.parametrize(
    ("other", "sides"),
    [
        (parameter(10.2, 9.5, 10.9), None),  # within
        (parameter(10.2, 9.5, 11.2), None),  # beyond by little, and it moves by little
        (parameter(10.2, 9.5, 12.0), (0.0, 1.0)),
        (parameter(8.0, 7.0, 9.0), (2.0, 0.0)),
        (parameter(10.0, 7.0, 14.0), (2.0, 3.0)),
        (parameter(10.8, 10.4, 11.2), (0.0, COUNTED * 0.5)),  # it moves: at least what counts
        (parameter(None), None),
        (replace(parameter(13.0), interval_95=None), (0.0, 2.0)),
    ],
)
def test_sides(other: Parameter, sides: tuple[float, float] | None) -> None:
    assert covering_sides(TEN, other) == (None if sides is None else pytest.approx(sides))


def test_what_is_not_known_covers_nothing() -> None:
    assert covering_sides(parameter(None), TEN) is None


def test_findings_before_add_in_squares() -> None:
    (below, above) = covering_sides(TEN, parameter(14.0, 13.0, 15.0), 3.0) or (0.0, 0.0)
    assert below == 0.0
    assert (3.0**2 + above**2) ** 0.5 == pytest.approx(3.0 + 4.0)
