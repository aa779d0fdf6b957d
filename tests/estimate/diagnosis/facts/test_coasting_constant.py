"""The constant that coasts show, against least squares and readings made by hand."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT
from motorid.estimate.diagnosis.facts.coasting_constant import Share, findings, pooled, slope
from motorid.estimate.results.estimate import Parameter
from motorid.estimate.results.status import Status
from motorid.estimate.signals.measurements import EMF

VALUES = {"R": 2.0, "L": 1e-3, "K": 0.05, "B": 2e-5, "J": 3e-5, "T0": 4e-3}
SPEED = np.linspace(300.0, 0.0, 400)  # rad/s, of a coast


def noise(size: float, seed: int = 1, rho: float = 0.0) -> np.ndarray:
    """Of an autoregression with that deviation."""
    rng, out = np.random.default_rng(seed), np.zeros(len(SPEED))
    for k, e in enumerate(rng.standard_normal(len(SPEED))):
        out[k] = rho * out[k - 1] + e * np.sqrt(1.0 - rho**2)
    return size * out


def parameters(statistical: float | None = 1e-5, **missing: None) -> dict[str, Parameter]:
    made = {}
    for name, value in (VALUES | missing).items():
        total = statistical if statistical is None else 2.0 * statistical
        made[name] = Parameter(
            name, "N·m/A", value, statistical, 0.0, total, (0.0, 1.0), Status.ESTIMATED, ""
        )
    return made


def record(more: float, seed: int = 1, offset: float = 0.0, name: str = EMF, **facts: Any) -> Any:
    """One whose coast shows so much more of K than the fit foretells."""
    foretold = VALUES["K"] * SPEED
    left = more * foretold + offset + noise(0.02, seed)
    block = SimpleNamespace(name=name, floor=1e-3)
    facts = {"block": block, "values": foretold + left, "unsigned": False, **facts}
    current = SimpleNamespace(**{**facts, "block": SimpleNamespace(name=CURRENT, floor=1e-3)})
    return SimpleNamespace(
        measured=[current, SimpleNamespace(**facts)],
        departures=lambda *_: [left * 0.0, left[: len(facts["values"])]],
    )


def found(*records: Any, **how: Any) -> list[Any]:
    solution: Any = SimpleNamespace(values=np.zeros(6), own=[np.zeros(1) for _ in records])
    return list(findings(solution, records, parameters(**how)))


@pytest.mark.parametrize("offset", [0.0, 0.3])
def test_a_slope_is_that_of_least_squares_beside_an_offset(offset: float) -> None:
    x, e = VALUES["K"] * SPEED, noise(0.02)
    share = slope(x, 0.02 * x + offset + e, 1e-4)
    assert share is not None
    table = np.column_stack([x, np.ones_like(x)])
    (size, _), squares, _, _ = np.linalg.lstsq(table, 0.02 * x + offset + e, rcond=None)
    covariance = np.linalg.inv(table.T @ table) * squares[0] / len(x)
    assert share.size == pytest.approx(size)
    assert share.u == pytest.approx(covariance[0, 0] ** 0.5, rel=0.12)  # and a little colour


def test_neighbours_that_agree_make_a_slope_less_sure() -> None:
    x = VALUES["K"] * SPEED
    white, coloured = (slope(x, noise(0.02, 3, rho), 1e-9) for rho in (0.0, 0.8))
    assert white is not None
    assert coloured is not None
    assert coloured.u / white.u == pytest.approx(3.0, rel=0.3)  # the root of 1.8 over .2
    stays = slope(x, np.where(np.arange(400) % 200 < 100, 0.02, -0.02), 1e-9)
    assert stays is not None
    assert stays.u < 0.02 * 10.0 / np.sqrt(np.sum((x - x.mean()) ** 2))  # as far as .98, no more


def test_nothing_is_surer_than_its_rounding() -> None:
    x = VALUES["K"] * SPEED
    exact = slope(x, 0.02 * x + noise(1e-4), 0.1)
    assert exact is not None
    assert exact.size == pytest.approx(0.02, rel=1e-3)
    assert exact.u == pytest.approx(0.1 / np.sqrt(np.sum((x - x.mean()) ** 2)), rel=0.15)


def test_a_motor_that_stood_still_shows_no_constant() -> None:
    assert slope(np.full(64, 0.01), noise(0.02)[:64], 1e-3) is None
    assert slope(np.linspace(0.0, 1e-3, 64), noise(0.02)[:64], 1e-3) is None


def test_captures_count_by_what_they_are_sure_of_and_by_how_they_agree() -> None:
    assert pooled([]) is None
    assert pooled([Share(0.02, 0.01)]) == Share(pytest.approx(0.02), pytest.approx(0.01))
    two = pooled([Share(0.02, 0.01), Share(0.03, 0.02)])
    assert two == Share(pytest.approx(0.022), pytest.approx(125.0**-0.5 * 0.1))
    apart = pooled([Share(0.02, 0.001), Share(0.06, 0.001)])  # 20 deviations of .001 either way
    assert apart == Share(pytest.approx(0.04), pytest.approx(0.02))


@pytest.mark.parametrize("more", [0.024, -0.024])
def test_coasts_that_contradict_the_fit_are_said_with_what_a_torque_measures(more: float) -> None:
    (one,) = found(record(more), record(more, 2))
    assert (one.code, one.severity) == ("coasting_constant", "warning")
    assert one.moves == pytest.approx(
        {name: 0.024 * VALUES[name] for name in ("K", "B", "J", "T0")}, rel=0.05
    )
    for name, move in one.moves.items():
        assert one.sides[name] == ((0.0, move) if more > 0.0 else (move, 0.0))
    assert f"show K of {0.05 * (1.0 + more):.3g}" in one.message
    assert "the fit finds 0.05 N·m/A" in one.message


@pytest.mark.parametrize(
    ("records", "how"),
    [
        ((record(0.004),), {}),  # harmless
        ((record(0.024),), {"statistical": 0.024 * 0.05 / 3.9}),  # the fit is not so sure
        ((record(0.024, values=VALUES["K"] * SPEED[:31]),), {}),  # too short
        ((record(0.024, unsigned=True),), {}),
        ((record(0.024, name=CURRENT),), {}),  # without a voltage
        ((record(0.024),), {"statistical": None}),
        ((record(0.024),), {"K": None}),
        ((), {}),
    ],
)
def test_what_is_small_unsure_or_unseen_is_no_remark(records: Any, how: dict[str, Any]) -> None:
    assert found(*records, **how) == []


def test_a_parameter_without_a_value_does_not_move() -> None:
    (one,) = found(record(0.024), J=None)
    assert set(one.moves) == {"K", "B", "T0"}
