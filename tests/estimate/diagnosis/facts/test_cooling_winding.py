"""A resistance that falls through a run is said where it surely does, of the run where most."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from motorid.estimate.diagnosis.facts import cooling_winding
from motorid.estimate.results.estimate import Diagnostic


def found(R: float | None = 2.0, **sizes: tuple[float | None, float]) -> list[Diagnostic]:
    """Of sizes and uncertainties by run."""
    nuisance: Any = {
        f"winding warming{run.replace('_', ' ')}": SimpleNamespace(value=value, total=u)
        for run, (value, u) in sizes.items()
    }
    nuisance["brush drop"] = SimpleNamespace(value=-9.0, total=0.1)
    parameters: Any = {"R": SimpleNamespace(value=R)}
    return list(cooling_winding.findings(nuisance, parameters))


@pytest.mark.parametrize(
    ("grown", "u", "named"),
    [(-0.03, 0.007, True), (-0.03, 0.008, False), (0.03, 0.001, False), (-0.0149, 1e-4, False),
     (-0.0151, 1e-4, True), (-0.03, 0.0, False), (None, 0.1, False)],
)  # fmt: skip
def test_a_fall_beyond_its_uncertainty_is_said(grown: float | None, u: float, named: bool) -> None:
    said = found(_of_run=(grown, u))
    assert bool(said) is named
    if said:
        assert said[0].code == "winding_cools"
        assert said[0].moves == {"R": pytest.approx(2.0 * abs(grown or 0.0))}


def test_the_run_that_falls_most_is_said_once() -> None:
    (said,) = found(_of_run_1=(-0.02, 0.001), _of_run_2=(-0.05, 0.0021))
    assert said.message.startswith("R falls by 5 ± 0.4 % through the capture of run 2, and")


def test_of_no_resistance_nothing_is_said() -> None:
    assert found(R=None, _of_run=(-0.03, 0.001)) == []
