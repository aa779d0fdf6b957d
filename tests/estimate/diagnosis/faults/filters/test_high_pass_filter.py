"""A log's current behind a capacitor whose time constant is the record's: it fades by little."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from motorid.capture.model import CURRENT, Capture
from motorid.estimate.results.estimate import Estimate
from motorid.estimate.results.status import Status
from tests.estimate.diagnosis.facts.made_log import MOTOR, log, truth
from tests.six_parameters import fit

FADING = np.linspace(1.0, 0.97, len(truth()[CURRENT]))


def coupled(records: float) -> Capture:
    """The log, with a time constant of so many of its lengths."""
    keep = float(np.exp(-1.0 / (records * len(truth()[CURRENT]))))
    return log(**{CURRENT: np.asarray(lfilter([1.0, -1.0], [1.0, -keep], truth()[CURRENT]))})


def named(estimate: Estimate) -> list[str]:
    return [s.code for s in estimate.suspects if s.strength == "named"]


@pytest.mark.slow
def test_it_is_named_and_what_it_moved_is_doubtful() -> None:
    found = fit([coupled(3.0)])
    assert named(found) == ["current_coupled"]
    (said,) = [s for s in found.suspects if s.code == "current_coupled"]
    assert "time constant" in said.evidence
    K = found.parameters["K"]
    assert K.status is Status.DOUBTFUL
    assert K.interval_95 is not None
    assert K.interval_95[0] < MOTOR["K"] < K.interval_95[1]


@pytest.mark.slow
@pytest.mark.parametrize("shown", [truth()[CURRENT], truth()[CURRENT] * FADING])
def test_a_current_at_a_direct_input_is_not_accused(shown: np.ndarray) -> None:
    """Nor one whose gain fades in its place."""
    assert "current_coupled" not in named(fit([log(**{CURRENT: shown})]))
