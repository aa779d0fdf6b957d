"""The filter before the current's converter, by a plant that filters in its own way.

The motor's L/R is 64 µs. A filter that is declared costs L no more than its own uncertainty does;
one that nobody declared is named.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from motorid.estimate.effects.reading.current_filter import CURRENT_FILTER, TOLERANCE
from motorid.estimate.results.estimate import Estimate, Parameter
from motorid.rig import Sampling
from tests.estimate.test_simulated_rig import captured

AMID_RIPPLE = "&aperture=0&delay=0&phase=0.3"
CHANNELS = ("current", "terminal_voltage", "position")


def known(p: Parameter) -> tuple[float, float]:
    """Value and standard uncertainty."""
    assert p.value is not None
    assert p.total is not None
    return p.value, p.total


def fitted(folder: Path, options: str) -> Estimate:
    return captured(folder, options)[0]


@pytest.fixture(scope="module")
def unfiltered(tmp_path_factory: pytest.TempPathFactory) -> float:
    """L of the rig without a filter, H."""
    return known(fitted(tmp_path_factory.mktemp("unfiltered"), "").parameters["L"])[0]


@pytest.mark.slow
@pytest.mark.parametrize(
    "tau_s",
    [
        pytest.param(15e-6, marks=pytest.mark.study),
        30e-6,
        pytest.param(100e-6, marks=pytest.mark.study),
        700e-6,
    ],
)
def test_a_declared_filter_leaves_the_inductance(
    tau_s: float, unfiltered: float, tmp_path: Path
) -> None:
    """700 µs are ten times L/R. The noise is the same with every filter."""
    estimate = fitted(tmp_path, f"&current_filter={tau_s}")
    inductance, u = known(estimate.parameters["L"])
    assert inductance == pytest.approx(unfiltered, abs=u)
    assert (
        u < 0.025 * inductance
    )  # a tenth of it by levels that half a converter's step leaves open
    size, size_u = known(estimate.nuisance[CURRENT_FILTER.name])
    assert abs(size) < 2 * size_u
    assert size_u < 0.5 * TOLERANCE * tau_s  # the readings tell it better than its parts do


@pytest.mark.slow
@pytest.mark.parametrize("tau_s", [30e-6, pytest.param(700e-6, marks=pytest.mark.study)])
def test_an_instant_amid_filtered_ripple(tau_s: float, tmp_path: Path) -> None:
    estimate, true = captured(tmp_path, f"{AMID_RIPPLE}&current_filter={tau_s}")
    inductance, u = known(estimate.parameters["L"])
    assert inductance == pytest.approx(true["L"], abs=2 * u)
    assert u < 0.02 * inductance


@pytest.mark.slow
def test_a_filter_off_by_its_tolerance_is_found(unfiltered: float, tmp_path: Path) -> None:
    """Declared as 90 µs, and truly 100 µs."""
    estimate = fitted(tmp_path, f"&current_filter=90e-6&filter_error={1 / 9}")
    inductance, u = known(estimate.parameters["L"])
    assert inductance == pytest.approx(unfiltered, abs=2 * u)
    size, size_u = known(estimate.nuisance[CURRENT_FILTER.name])
    assert size == pytest.approx(10e-6, abs=2 * size_u)
    assert size_u < 2e-6


@pytest.mark.slow
@pytest.mark.parametrize("tau_s", [30e-6, pytest.param(100e-6, marks=pytest.mark.study)])
def test_a_filter_that_nobody_declared_is_named(tau_s: float, tmp_path: Path) -> None:
    estimate, true = captured(tmp_path, f"&hidden_filter={tau_s}")
    found = estimate.parameters["L"]
    assert found.status == "doubtful"
    assert found.value is not None
    assert found.interval_95 is not None
    half = (found.interval_95[1] - found.interval_95[0]) / 2.0
    assert abs(found.value - true["L"]) < 1.1 * half  # the size of what it did, within a tenth
    (suspect,) = (s for s in estimate.suspects if s.strength == "named")
    assert suspect.code == "current_filtered"
    said = re.search(r"low-pass of (\d+) µs", suspect.evidence)
    assert said is not None
    assert float(said[1]) == pytest.approx(1e6 * tau_s, rel=0.1)


@pytest.mark.slow
def test_a_slow_sampler_finds_the_filter_and_then_the_ripple_that_tells_the_inductance(
    tmp_path: Path,
) -> None:
    """At 1 kHz readings hardly tell L, but do tell the filter."""
    estimate, true = captured(tmp_path, "&current_filter=2e-3", sampling=Sampling(1000.0, CHANNELS))
    inductance, u = known(estimate.parameters["L"])
    assert inductance == pytest.approx(true["L"], abs=3 * u)
    assert CURRENT_FILTER.name in estimate.nuisance
