"""Where a scale is clear and what stands beside it, by departures whose chi-squares are whole."""

from __future__ import annotations

import math

import pytest

from motorid.estimate.diagnosis.faults import scale_errors
from motorid.estimate.diagnosis.faults.scale_errors import (
    AMPERES,
    SERIES,
    SPEED,
    VOLTS,
    WINDING,
    Cause,
    Verdict,
)
from motorid.estimate.results.estimate import Parameter
from motorid.estimate.results.status import Status

X = 0.375  # a departure of three and of two standard deviations
BOTH = {"R": (X, X / 3.0), "K": (X, X / 2.0)}


def named(known: dict[str, tuple[float, float]]) -> list[Cause]:
    return [verdict.cause for verdict in scale_errors.by_nameplate(known)]


def test_a_scale_is_clear_from_a_chi_square_of_twelve_on() -> None:
    """Volts explain both and leave one for an unusual factor: 9 + 4 - 1. Currents and leads
    explain R and leave K's 4: four more, which is not as well."""
    assert named(BOTH) == [VOLTS, WINDING]
    (volts, winding) = scale_errors.by_nameplate(BOTH)
    assert volts == Verdict(VOLTS, pytest.approx(math.exp(X)), pytest.approx(1.0))
    assert 1.0 < winding.left < 5.0
    assert winding.factor == pytest.approx(math.exp(X / 2.0), rel=0.1)
    less = {name: (d, 1.001 * s) for name, (d, s) in BOTH.items()}
    assert named(less) == []
    assert named({}) == []


def test_one_figure_alone_is_explained_in_too_many_ways() -> None:
    assert named({"R": (X, X / 5.0)}) == []
    two = {"R": (X, X / 5.0), "L": (0.0, 0.1)}  # leads have no inductance, a current would
    assert named(two) == [SERIES]
    lower = {"R": (-X, X / 5.0), "L": (0.0, 0.1)}
    assert named(lower) == []  # no leads take resistance away


@pytest.mark.parametrize(
    ("cause", "powers"),
    [(AMPERES, {"R": -1, "L": -1, "J": 1}), (SPEED, {"K": -1, "J": -2, "R": 0, "L": 0}),
     (VOLTS, {"R": 1, "L": 1, "K": 1, "J": 1}), (WINDING, {"R": 2, "L": 2, "K": 1, "J": 0})],
)  # fmt: skip
@pytest.mark.parametrize("x", [0.6, -0.6])
def test_a_scale_is_told_by_the_powers_of_its_figures(
    cause: Cause, powers: dict[str, int], x: float
) -> None:
    known = {name: (power * x, 0.08) for name, power in powers.items()}
    known.setdefault("K", (0.0, 0.08))
    found = scale_errors.by_nameplate(known)
    assert found[0].cause is cause
    assert found[0].factor == pytest.approx(math.exp(x), rel=0.02)


def test_a_usual_factor_costs_nothing_and_another_one_a_unit() -> None:
    known = {"K": (-math.log(2.0), 0.05), "J": (-2.0 * math.log(2.0), 0.05), "R": (0.0, 0.05)}
    usual = scale_errors._best(SPEED, known)
    assert usual is not None
    assert (usual.left, usual.factor) == (pytest.approx(0.0, abs=1e-9), pytest.approx(2.0))
    odd = {"K": (-0.2, 0.05), "J": (-0.4, 0.05), "R": (0.0, 0.05)}
    other = scale_errors._best(SPEED, odd)
    assert other is not None
    assert (other.left, other.factor) == (pytest.approx(1.0), pytest.approx(math.exp(0.2)))
    assert scale_errors._best(SERIES, {"K": (0.2, 0.05)}) is None


def test_motors_of_one_label_differ_by_so_much() -> None:
    """The usual spread of each figure, as the logarithm's deviation, of a fit that is exact."""

    def exact(value: float) -> Parameter:
        return Parameter("", "", value, 0.0, 0.0, 0.0, None, Status.ESTIMATED)

    plate = {"R": 2.0, "L": 1e-3, "K": 0.05, "J": 2e-5}
    fitted = {name: exact(1.5 * value) for name, value in plate.items()}
    found = scale_errors.departures(fitted, plate)
    assert {n: d for n, (d, _) in found.items()} == pytest.approx(
        dict.fromkeys(plate, math.log(1.5))
    )
    spread = {name: s for name, (_, s) in found.items()}
    assert spread == pytest.approx({"R": 0.08, "L": 0.3, "K": 0.08, "J": 0.15})
    none = {name: exact(0.0) for name in plate}
    assert scale_errors.departures(none, plate) == {}


def test_a_large_factor_is_roughly_so() -> None:
    """A tenth of its logarithm beside the deviation of the figure."""
    x = math.log(1e3)
    known = {"R": (-x + 0.5, 0.1), "L": (-x, 0.1)}
    found = scale_errors._best(AMPERES, known)
    assert found is not None
    assert found.factor == pytest.approx(1e3)
    assert found.left == pytest.approx((0.5 / math.hypot(0.1, 0.1 * x)) ** 2)
