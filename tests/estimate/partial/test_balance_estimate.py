"""The estimate of a balance: what a gain that nobody stated moves, and figures at their edges."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, SPEED, TORQUE, VOLTAGE, Capture, Channel
from motorid.estimate.partial import mechanical_fit, mechanical_remarks, modulating_functions
from motorid.estimate.partial import mechanical_results as results
from motorid.estimate.partial.mechanical_signals import COASTING, COMMAND, of_capture
from motorid.estimate.results.estimate import Estimate
from motorid.estimate.uncertainty.unstated_gains import PART
from tests.estimate.partial.test_balance_choices import H, motion, swinging
from tests.estimate.partial.test_mechanical_results import T0, B, J, answer, regression, rowed

K = 0.05
MOTION: Any = SimpleNamespace(drive_name=CURRENT, drive_unit="A", linear=False)


def of_balance(patch: pytest.MonkeyPatch, drive: str, silent: str, **fix: float) -> Estimate:
    """Of ratios to K, from a capture that says nothing of one channel's gain."""
    patch.setattr(mechanical_remarks, "expected_rms", lambda *_: 0.1)
    channels = {
        name: Channel(name, "", np.arange(9.0), undeclared=("gain",) if name == silent else ())
        for name in (drive, SPEED)
    }
    one = Capture(1000 * np.arange(9), 1e6, channels)
    rows = rowed()
    best = replace(regression(J / K, B / K, T0 / K), rows=rows.rows, residual=rows.residual)
    return results.estimate([one], [MOTION, MOTION], best, drive, fix, ("offset",), ())


def test_a_gain_that_nobody_stated_moves_ratios_and_parameters(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A speed that reads too much makes J and B too small; T0 has no speed in it."""
    found = of_balance(monkeypatch, CURRENT, SPEED, K=K)
    ((_, moves),) = found.not_stated.items()
    wanted = {"J/K": J / K, "B/K": B / K, "J": J, "B": B}
    assert moves == pytest.approx({n: PART * v for n, v in wanted.items()})
    assert (found.degrees_of_freedom, found.evaluations) == (7 - 3, 1)
    assert found.options["without"] == ["offset"]
    ((_, by_drive),) = of_balance(monkeypatch, CURRENT, CURRENT).not_stated.items()
    assert by_drive["T0/K"] == pytest.approx(-PART * T0 / K)


def test_the_scale_of_a_command_is_that_of_the_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    assert of_balance(monkeypatch, COMMAND, COMMAND).not_stated == {}
    assert len(of_balance(monkeypatch, COMMAND, SPEED).not_stated) == 1


def test_the_worst_clock_counts() -> None:
    channels = {n: Channel(n, "", np.zeros(3)) for n in (CURRENT, SPEED)}
    two = [Capture(np.arange(3), 1e6, channels, clock_uncertainty=u) for u in (1e-3, 4e-3)]
    assert results._gain_uncertainties(two, CURRENT)["B"] == pytest.approx(4e-3)
    assert results._gain_uncertainties(two, COASTING)["B"] == pytest.approx(4e-3)


def test_a_speed_that_costs_no_voltage_gives_no_time_constant() -> None:
    _, ratios = answer(VOLTAGE, regression(1e-3, 0.0, 0.2))
    for name in ("JR/(K²+RB)", "K/(K²+RB)"):
        assert ratios[name].value is None
        assert "below 0 " in ratios[name].note


def test_nothing_follows_from_a_ratio_of_nothing() -> None:
    found, _ = answer(CURRENT, regression(0.0, 2.0, 3.0), J=J)
    assert found["K"].value is None
    by_torque, _ = answer(TORQUE, regression(J, B, T0))
    assert by_torque["K"].note.endswith("to a coast-down would determine it")


def test_three_rows_make_a_curve() -> None:
    best = rowed()
    capture = np.array([0, 0, 0, 0, 1, 1, 1])
    curves = results._curves(
        [MOTION, MOTION], replace(best, rows=replace(best.rows, capture=capture))
    )
    assert [(c.capture, len(c.time_s)) for c in curves] == [(0, 4), (1, 3)]


def test_each_width_is_regressed_with_what_is_wanted_and_known(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[tuple[Any, ...]] = []

    def at_each(widths: Any, at: Any, _: bool) -> list[Any]:
        return [at(h) for h in widths]

    monkeypatch.setattr(mechanical_fit, "choose_width", at_each)
    for name in ("_at_width", "_with_sure_signs"):
        monkeypatch.setattr(mechanical_fit, name, lambda *given, n=name: asked.append((n, *given)))
    wanted, values, one = np.ones(4, dtype=bool), np.arange(4.0), motion()
    for way, given in (("_at_width", one), ("_with_sure_signs", replace(one, unsigned=True))):
        asked.clear()
        mechanical_fit._regress([given], wanted, values)
        widths = mechanical_fit._widths([given])
        assert len(asked) == len(widths) > 2
        for (name, _, free, known, half, terms), width in zip(asked, widths, strict=True):
            assert (name, half, terms) == (way, width, ())
            assert free is wanted
            assert known is values


def test_further_frictions_of_a_steady_speed_are_their_values_times_the_weight() -> None:
    steady = Capture(
        1000 * np.arange(400), 1e6,
        {SPEED: Channel(SPEED, "rad/s", np.where(np.arange(400) < 1, 49.0, 50.0)),
         CURRENT: Channel(CURRENT, "A", np.ones(400))},
    )  # fmt: skip
    rows = modulating_functions.build([of_capture(steady, CURRENT)], 20 * H)
    late = slice(2, None)
    assert len(rows) > 10
    weight = rows.weight[late]
    slow = np.exp(-50.0 / (0.05 * 50.0))
    for column, value in enumerate((50.0 * 50.0 / 50.0, 50.0, 50.0 * slow)):
        assert rows.shapes[late, column] == pytest.approx(value * weight)


def test_rows_do_not_depend_on_when_a_run_began() -> None:
    w, drive = swinging(600)
    channels = {SPEED: Channel(SPEED, "rad/s", w), CURRENT: Channel(CURRENT, "A", drive)}
    one = of_capture(Capture(1000 * np.arange(600), 1e6, channels), CURRENT)
    late = replace(one, time_s=one.time_s + 7.0)
    rows, later = (modulating_functions.build([m], 20 * H) for m in (one, late))
    assert len(rows) == len(later) > 10
    np.testing.assert_allclose(later.matrix, rows.matrix, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(later.time_s, rows.time_s + 7.0)
