"""The filter before the current's converter, by a plant that filters in its own way.

The motor's L/R is 64 µs. One that is declared costs L no more than its own tolerance does; one that
nobody declared is named.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from motorid.estimate.effects.reading.current_filter import CURRENT_FILTER, TOLERANCE
from motorid.estimate.results.estimate import Estimate, Parameter
from tests.estimate.test_simulated_rig import captured

Known = tuple[float, float]


def known(p: Parameter) -> Known:
    """Value and standard uncertainty."""
    assert p.value is not None
    assert p.total is not None
    return p.value, p.total


def fitted(folder: Path, options: str) -> Estimate:
    return captured(folder, options)[0]


@pytest.fixture(scope="module", params=["", "&aperture=0&delay=0&phase=0.3"], ids=["mean", "instant"])
def chain(request: pytest.FixtureRequest) -> str:
    """Options of a converter that averages over the PWM, or takes an instant amid its ripple."""
    return str(request.param)


@pytest.fixture(scope="module")
def unfiltered(chain: str, tmp_path_factory: pytest.TempPathFactory) -> Known:
    """L of the rig without a filter."""
    return known(fitted(tmp_path_factory.mktemp("unfiltered"), chain).parameters["L"])


@pytest.mark.parametrize("tau_s", [15e-6, 30e-6, 100e-6, 700e-6])
def test_a_declared_filter_moves_no_inductance(
    tau_s: float, chain: str, unfiltered: Known, tmp_path: Path
) -> None:
    """700 µs are ten times L/R; taken for a pure delay, 100 µs would make L a quarter larger."""
    estimate = fitted(tmp_path, f"{chain}&current_filter={tau_s}")
    L, u = known(estimate.parameters["L"])
    assert L == pytest.approx(unfiltered[0], abs=u)
    assert u < 0.02 * L
    size, size_u = known(estimate.nuisance[CURRENT_FILTER.name])
    assert abs(size) < 2.5 * size_u
    assert size_u < 0.3 * TOLERANCE * tau_s  # the readings tell it better than its parts' tolerance


def test_a_filter_off_by_its_tolerance_is_found(
    chain: str, unfiltered: Known, tmp_path: Path
) -> None:
    """Declared as 90 µs, and truly 100 µs."""
    estimate = fitted(tmp_path, f"{chain}&current_filter=90e-6&filter_error={1 / 9}")
    L, u = known(estimate.parameters["L"])
    assert L == pytest.approx(unfiltered[0], abs=2 * u)
    size, size_u = known(estimate.nuisance[CURRENT_FILTER.name])
    assert size == pytest.approx(10e-6, abs=2.5 * size_u)
    assert size_u < 2e-6


@pytest.mark.parametrize("tau_s", [30e-6, 100e-6])
def test_a_filter_that_nobody_declared_is_named(tau_s: float, tmp_path: Path) -> None:
    estimate = fitted(tmp_path, f"&hidden_filter={tau_s}")
    L, u = known(estimate.parameters["L"])
    assert L - 180e-6 > 20 * u
    (suspect,) = (s for s in estimate.suspects if s.strength == "named")
    assert suspect.code == "current_filtered"
    assert f"low-pass of {1e6 * tau_s:.0f}"[:-1] in suspect.evidence
