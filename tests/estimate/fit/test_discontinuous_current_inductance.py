"""An inductance that no reading shows: by pulses against brute force, and on simulated rigs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bench.coverage.rigs import draw_bench
from bench.coverage.runs import Runs, record
from motorid.estimate.fit import (
    discontinuous_current_inductance,
    joint_fit,
    multistart,
    subsample_inductance,
)
from motorid.estimate.fit.alternating_fit import vanished
from motorid.estimate.fit.discontinuous_current_inductance import Pulses
from motorid.estimate.results.estimate import Estimate
from motorid.estimate.signals.source.pwm_bridge import DIODE_DROPS_V
from tests.six_parameters import fit

SIX = ("R", "L", "K", "B", "J", "T0")


def integrated(L: float, R: float, rail: float, emf: float, duty: float, period_s: float) -> float:
    """Mean over a period of a current that rises from nothing and falls to it, step by step."""

    def rise(_t: float, x: np.ndarray) -> list[float]:
        return [(rail - emf - R * x[0]) / L, x[0]]

    def fall(_t: float, x: np.ndarray) -> list[float]:
        return [(-rail - DIODE_DROPS_V - emf - R * x[0]) / L, x[0]]

    def stops(_t: float, x: np.ndarray) -> float:
        return float(x[0])

    stops.terminal = True  # type: ignore[attr-defined]
    exact = {"rtol": 1e-10, "atol": 1e-12}
    on = solve_ivp(rise, (0.0, duty * period_s), [0.0, 0.0], **exact)
    off = solve_ivp(fall, (0.0, period_s), on.y[:, -1], events=stops, **exact)
    return float(off.y[1, -1]) / period_s


@pytest.mark.parametrize(
    ("L", "duty", "emf"), [(5e-5, 0.3, 2.0), (2e-4, 0.45, 0.5), (1e-6, 0.6, 4)]
)
def test_pulses_are_as_large_as_those_of_a_switched_winding(
    L: float, duty: float, emf: float
) -> None:
    one = Pulses(np.zeros(1), np.array([emf]), duty, 5e-5, 12.0, 3.0)
    assert one.mean_current(L)[0] == pytest.approx(
        integrated(L, 3.0, 12.0, emf, duty, 5e-5), rel=1e-6
    )


def off(found: Estimate, truth: dict[str, float], name: str) -> float:
    value = found.parameters[name].value
    assert value is not None
    return value / truth[name] - 1.0


@pytest.mark.study
def test_ripple_tells_what_no_reading_shows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """L/R is 0.08 of a sample; brushes drop 2 % of the voltage at a current that ripples 100 %."""
    drawn = draw_bench(1123)
    runs = record(replace(drawn, rigs=drawn.rigs[:1]), tmp_path)
    found = fit(runs.captures, model="six")
    for name in SIX:
        p = found.parameters[name]
        assert abs(p.value - runs.truth[name]) < 3.0 * p.total  # K: the gain that this rig drew
    assert found.parameters["L"].total < 0.2 * runs.truth["L"]
    assert abs(off(found, runs.truth, "L")) < 0.06
    assert abs(off(found, runs.truth, "B")) < 0.02
    share = found.budget["L"]["PWM ripple"] / found.parameters["L"].value
    # with a supply that nobody measured, and iron of which nobody says that it has no eddy currents
    assert share == pytest.approx(np.linalg.norm([0.08, 0.03, 0.15]), rel=0.1)
    (said,) = [d.message for d in found.diagnostics if d.code == "inductance_by_ripple"]
    assert "L/R is 0.08" in said
    assert "that at the PWM frequency" in said
    monkeypatch.setattr(subsample_inductance._Search, "by_ripple", lambda _: None)
    blind = fit(runs.captures, model="six")
    assert "inductance_by_ripple" not in {d.code for d in blind.diagnostics}
    # what it comes to without the ripple is a matter of the valley, and that of the last digits;
    # that the readings are explained better with it is not
    assert blind.chi_square > found.chi_square


def stopping(folder: Path) -> Runs:
    """Diode decay, a current that stops in every period, means over whole periods; 0.2 V of 9 are
    lost to brushes.
    """
    drawn = draw_bench(12)
    options = replace(drawn.options, brush_drop=0.2)
    return record(replace(drawn, rigs=drawn.rigs[:1], options=options), folder)


@pytest.mark.slow
def test_pulses_tell_what_no_reading_shows(tmp_path: Path) -> None:
    runs = stopping(tmp_path)
    found = fit(runs.captures, model="six")
    assert abs(off(found, runs.truth, "L")) < 0.05


@pytest.mark.study
def test_without_pulses_nothing_tells_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    runs = stopping(tmp_path)
    monkeypatch.setattr(discontinuous_current_inductance, "pulses_of", lambda *_: [])
    monkeypatch.setattr(subsample_inductance._Search, "by_ripple", lambda _: None)
    blind = fit(runs.captures, model="six")
    assert blind.parameters["L"].status == "not_identifiable"


@pytest.mark.study
def test_an_inductance_that_a_search_loses_is_found_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Brushes, sag and ripple make a second valley, in which L is nothing and R 5 % too large."""
    runs = record(draw_bench(534), tmp_path)
    found = fit(runs.captures, model="six")
    assert abs(off(found, runs.truth, "L")) < 0.05
    assert abs(off(found, runs.truth, "R")) < 0.015
    assert not [d for d in found.diagnostics if d.code == "inductance_by_ripple"]  # readings do
    monkeypatch.setattr(multistart, "vanished", lambda *_: False)
    monkeypatch.setattr(subsample_inductance._Search, "by_ripple", lambda _: None)
    records, blind = joint_fit.solved(runs.captures, {}, ())
    assert vanished(blind, records)
