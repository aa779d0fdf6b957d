"""The score test by algebra: what a fault explains of residuals that are made by hand."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.diagnosis import score_test
from motorid.estimate.solver.problem import Block, Linearised

N = 400
RNG = np.random.default_rng(3)
SIGMAS = np.array([0.1, 2.0])  # of a current and of a position
SHARED = np.r_[np.ones(N), np.linspace(-1.0, 1.0, N)][:, None]  # one parameter
OWN = np.r_[np.zeros(N), np.ones(N)][:, None]  # one nuisance: the position's origin
COURSE = np.sin(np.arange(N) / 7.0)  # A, of the fault


def line(residual: np.ndarray) -> Linearised:
    own_of = OWN @ np.linalg.lstsq(OWN, SHARED, rcond=None)[0]
    blocks = tuple(Block(name, 1e-9, N, name) for name in ("current", "position"))
    return Linearised(
        residual, SHARED, OWN, SHARED - own_of, np.zeros(1), blocks,
        (slice(0, N), slice(N, 2 * N)), SIGMAS,
    )  # fmt: skip


def screen(monkeypatch: pytest.MonkeyPatch, *residuals: np.ndarray) -> score_test.Screen:
    lines = tuple(line(r) for r in residuals)
    information = sum(one.orthogonal.T @ one.orthogonal for one in lines)
    solution = SimpleNamespace(
        records=lines, information=information, values=np.zeros(1),
        own=[np.zeros(1) for _ in lines],
    )  # fmt: skip
    monkeypatch.setattr(score_test, "plain", lambda *_: solution)
    record = SimpleNamespace(weighed=lambda parts, filtered: parts)
    given: Any = [record for _ in lines]
    return score_test.Screen(given, solution)  # type: ignore[arg-type]


def fault(*sizes: tuple[float, ...], lower: float = -9.0, upper: float = 9.0) -> Any:
    """A of COURSE in the current, for a size."""

    def effect(_r: Any, _v: Any, _own: Any, size: np.ndarray) -> list[np.ndarray]:
        return [size[0] * COURSE, np.zeros(N)]

    k = len(sizes[0])
    return SimpleNamespace(
        effect=effect, sizes=sizes, lower=(lower,) * k, upper=(upper,) * k, place=None
    )  # fmt: skip


def left(size: float, *also: np.ndarray) -> np.ndarray:
    """Residuals in standard deviations: noise, and so much of the fault."""
    noise = RNG.normal(size=2 * N)
    noise[:N] += size * COURSE / SIGMAS[0]
    return noise + sum(also) if also else noise


def cleared(residual: np.ndarray) -> np.ndarray:
    """Less what parameter and nuisance explain, by least squares."""
    columns = np.hstack([SHARED, OWN])
    return residual - columns @ np.linalg.lstsq(columns, residual, rcond=None)[0]


def test_what_a_fault_changes_is_cleared_of_what_others_explain(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    probe = screen(monkeypatch, left(0.5))
    whole = np.r_[COURSE / SIGMAS[0], np.zeros(N)]
    (change,) = probe.of(fault((1.0,)), (3.0,))
    assert change == pytest.approx(3.0 * cleared(whole))
    tilt = np.r_[np.zeros(N), np.arange(N) / 50.0]  # rad, and the parameter's own course there
    (change,) = probe.cleared([[COURSE, tilt[N:]]])
    assert change == pytest.approx(cleared(whole + tilt / SIGMAS[1]), abs=1e-9)


@pytest.mark.parametrize("size", [0.5, -0.2])
def test_a_unit_of_one_fault_is_scaled_to_what_is_there(
    size: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    residual = left(size, 30.0 * SHARED[:, 0], -8.0 * OWN[:, 0])  # which others explain
    found = screen(monkeypatch, residual).best(fault((1.0,)))
    assert found.size == pytest.approx((size,), abs=0.03)
    rest, change = cleared(residual), cleared(np.r_[COURSE / SIGMAS[0], np.zeros(N)])
    after = rest - change * (change @ rest) / (change @ change)
    parts = (slice(0, N), slice(N, 2 * N))
    gain = sum(N * np.log((rest[p] ** 2).sum() / (after[p] ** 2).sum()) for p in parts)
    assert found.gain == pytest.approx(gain)
    assert found.gain > 100.0


def test_of_several_sizes_the_best_stands_for_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    found = screen(monkeypatch, left(0.5)).best(fault((0.1, 3.0), (0.4, 2.0)))
    assert found.size in ((0.1, 3.0), (0.4, 2.0))  # along a line both explain as much
    lone = screen(monkeypatch, left(0.5)).best(fault((1.0, 2.0)))
    assert lone.size == pytest.approx((0.5, 2.0), abs=0.03)  # the first is scaled alone
    placed = fault((0.1, 3.0), (0.4, 2.0))
    placed.place = lambda size: 7
    at = screen(monkeypatch, left(0.5)).best(placed)
    assert at.size[0] == pytest.approx(0.5, abs=0.03)  # so is one that has a place
    assert at.size[1] in (3.0, 2.0)
    bounded = screen(monkeypatch, left(0.5)).best(fault((1.0,), upper=0.3))
    assert bounded.size == (0.3,)
    below = screen(monkeypatch, left(-0.5)).best(fault((1.0,), lower=-0.3))
    assert below.size == (-0.3,)


def test_a_fault_that_cannot_be_negative_explains_nothing_of_the_other_sign(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert screen(monkeypatch, left(-0.5)).best(fault((1.0,), lower=0.0)).gain == 0.0
    assert screen(monkeypatch, left(0.5)).best(fault((1.0,), lower=0.0)).gain > 100.0
    assert screen(monkeypatch, left(-0.5)).best(fault((1.0,), lower=-1.0)).gain > 100.0
    nothing = fault((0.0,))
    assert screen(monkeypatch, left(0.5)).best(nothing).gain == 0.0


def test_several_records_speak_together(monkeypatch: pytest.MonkeyPatch) -> None:
    residuals = [left(0.4), left(0.4)]
    both = screen(monkeypatch, *residuals).best(fault((1.0,)))
    one = screen(monkeypatch, residuals[0]).best(fault((1.0,)))
    assert both.size == pytest.approx((0.4,), abs=0.03)
    assert both.gain == pytest.approx(2.0 * one.gain, rel=0.2)
    opposed = screen(monkeypatch, left(0.4), left(-0.4)).best(fault((1.0,)))
    assert opposed.gain < 0.05 * both.gain


def test_readings_of_one_kind_are_counted_together() -> None:
    """Those of a group, whatever their capture; those of none by their name."""
    line: Any = SimpleNamespace(
        blocks=(Block("current", 1.0, 3.0, "fine"), Block("speed", 1.0, 2.0)),
        slices=(slice(0, 3), slice(3, 5)),
    )
    other: Any = SimpleNamespace(
        blocks=(Block("current", 1.0, 3.0, "coarse"), Block("speed", 1.0, 2.0)),
        slices=(slice(0, 3), slice(3, 5)),
    )
    third: Any = SimpleNamespace(
        blocks=(Block("current", 1.0, 1.5, "fine"),), slices=(slice(0, 2),)
    )
    probe = object.__new__(score_test.Screen)
    solution: Any = SimpleNamespace(records=(line, other, third))
    probe.solution = solution
    left = [
        np.array([1.0, 1.0, 1.0, 2.0, 2.0]),
        np.array([3.0, 0, 0, 1.0, 0]),
        np.array([2.0, 1.0]),
    ]
    assert probe._by_kind(left) == {
        "fine": (4.5, 8.0), "coarse": (3.0, 9.0), "speed": (4.0, 9.0),
    }  # fmt: skip
