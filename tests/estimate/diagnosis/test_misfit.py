"""How much there is to explain: residuals of known noise, by formula."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.diagnosis import misfit


def measured(count: float = 200.0, floor: float = 0.0, roots: Any = None) -> Any:
    return SimpleNamespace(
        block=SimpleNamespace(name="current", floor=floor, count=count), root_weights=roots,
        values=np.zeros(200),
    )  # fmt: skip


def test_noise_is_told_by_neighbours_whatever_they_wander_about() -> None:
    rng = np.random.default_rng(1)
    left = 0.3 * rng.standard_normal(20_000)
    assert misfit.noise_variance(measured(), left) == pytest.approx(0.09, rel=0.03)
    wandering = left + np.linspace(-50.0, 50.0, 20_000)
    assert misfit.noise_variance(measured(), wandering) == pytest.approx(0.09, rel=0.03)


def test_noise_is_no_less_than_what_its_block_declares() -> None:
    assert misfit.noise_variance(measured(floor=0.2), np.zeros(9)) == pytest.approx(0.04)
    roots = np.array([1.0, 0.5, 0.5])
    weighed = misfit.noise_variance(measured(floor=0.2, roots=roots), np.zeros(3))
    assert weighed == pytest.approx(0.04 * 0.5)
    assert misfit.noise_variance(measured(floor=0.2), np.array([7.0])) == pytest.approx(0.04)


def excess(*blocks: tuple[float, float, float], more: Any = ()) -> float:
    """Of blocks of one record: worth, noise, and an offset that nothing explains."""
    rng = np.random.default_rng(2)
    record: Any = SimpleNamespace(
        measured=[measured(count, 1e-9) for count, _, _ in blocks], instances=(), unknowns=()
    )
    left = [noise * rng.standard_normal(4000) + off for _, noise, off in blocks]
    return misfit.excess([record], [left], more)


def test_an_excess_is_the_mean_fall_of_f_by_readings() -> None:
    assert excess((100.0, 0.1, 0.0)) == pytest.approx(0.0, abs=0.05)
    assert excess((100.0, 0.1, 0.3)) == pytest.approx(np.log(10.0), abs=0.05)
    both = excess((100.0, 0.1, 0.3), (300.0, 2.0, 0.0))
    assert both == pytest.approx(np.log(10.0) / 4.0, abs=0.05)
    assert misfit.excess([], []) == 0.0


def test_what_noise_has_besides_leaves_less_to_explain() -> None:
    """By channel: it adds to what neighbours show, and explains nothing of another channel."""
    assert excess((100.0, 0.1, 0.3), more=[[0.03]]) == pytest.approx(np.log(2.5), abs=0.05)
    assert excess((100.0, 0.1, 0.3), more=[[0.09]]) == pytest.approx(0.0, abs=0.05)
    given = (100.0, 0.1, 0.3), (100.0, 0.2, 0.6)
    first, second = (excess(*given, more=[more]) for more in ([0.09, 0.0], [0.0, 0.36]))
    assert first == pytest.approx(np.log(10.0) / 2.0, abs=0.05)
    assert second == pytest.approx(np.log(10.0) / 2.0, abs=0.05)
    assert excess(*given, more=[[0.0, 0.09]]) == pytest.approx(
        (np.log(10.0) + np.log(0.4 / 0.13)) / 2.0, abs=0.05
    )


@pytest.mark.parametrize("declared", [0.1, 0.5])
def test_noise_that_was_smoothed_is_what_the_kernel_leaves_of_it(
    declared: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of readings left .3 all alike: their differences show nothing, the declared noise does."""
    kernel = np.array([0.0, 0.5, 0.5])
    monkeypatch.setattr(misfit, "smoothed_by", lambda *_: kernel)
    monkeypatch.setattr(misfit, "hidden", lambda given, order: 4.0 if given is kernel else 0.0)
    one = measured(100.0, 0.05)
    one.noise = declared
    record: Any = SimpleNamespace(measured=[one], instances=(), unknowns=())
    left = np.full(400, 0.3 * np.sqrt(2.0))
    found = misfit.excess([record], [[left]])  # type: ignore[list-item]
    noise = max(4.0 * 0.05**2, declared**2 / 2.0 + 0.05**2)
    assert found == pytest.approx(np.log(0.18 / noise))


def test_residuals_are_weighed_and_not_whitened() -> None:
    asked: list[Any] = []

    def weighed(parts: Any, filtered: bool) -> Any:
        asked.append((parts, filtered))
        return "weighed"

    record: Any = SimpleNamespace(departures=lambda values, own: (values, own), weighed=weighed)
    solution: Any = SimpleNamespace(values="values", own=("first", "second"))
    assert misfit.residuals([record, record], solution) == ["weighed"] * 2
    assert asked == [(("values", "first"), False), (("values", "second"), False)]
