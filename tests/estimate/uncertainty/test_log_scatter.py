"""Rivals of an answer, and what they widen."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.uncertainty import log_scatter


@pytest.mark.parametrize(("behind", "share"), [(0.0, 0.5), (2.0, 0.26894), (40.0, 0.0)])
def test_a_rival_widens_by_its_distance_and_how_likely_it_is(behind: float, share: float) -> None:
    """Of two answers with odds of exp(-F/2): the variance about the first is share times d²."""
    solution: Any = SimpleNamespace(
        unknowns=[SimpleNamespace(log=True), SimpleNamespace(log=False)],
        values=np.array([2.0, 5.0]),
    )  # fmt: skip
    rival = SimpleNamespace(friction=False, behind=behind, values=np.array([3.0, 4.0]))
    record: Any = SimpleNamespace(rivals=[rival])
    (shift,) = log_scatter.rivals(solution, record)
    distance = np.array([np.log(1.5), -1.0])  # of a logarithm, and of a value
    assert shift == pytest.approx(distance * np.sqrt(share), abs=1e-4)
    record.rivals = []
    assert log_scatter.rivals(solution, record) == []
