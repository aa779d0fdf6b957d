"""The fit again with a convicted fault among its unknowns, on captures without noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import CURRENT
from motorid.estimate.diagnosis.faults.current_zero import seen
from motorid.estimate.diagnosis.repair import ZERO, repaired
from motorid.estimate.fit.joint_fit import solved
from motorid.estimate.results.estimate import Suspect
from tests.exact_capture import FAULHABER, clean_capture

OFFSET_A = 0.05
DECLARED_A = 1e-3
NOISE_A = 1e-3


def test_a_zero_beyond_its_declaration_becomes_an_unknown() -> None:
    """With the declared prior the fit is torn between its rest and its drive."""
    good = clean_capture(FAULHABER)
    noise = np.random.default_rng(5).normal(0.0, NOISE_A, len(good))
    current = good.channels[CURRENT]
    off = replace(
        current, raw=np.asarray(current.raw) + OFFSET_A + noise, offset_uncertainty=DECLARED_A
    )
    records, solution = solved([replace(good, channels={**good.channels, CURRENT: off})], {}, ())
    assert seen(records[0]) == pytest.approx(OFFSET_A, abs=NOISE_A)
    named = Suspect(ZERO, "current", "it is off", "mend it", "named")
    found = repaired(records, solution, [named], None, {}, ())
    assert found is not None
    assert found.suspect.allowed
    assert found.suspect.without["R"] == solution.values[0]
    for unknown, value in zip(found.solution.unknowns, found.solution.values, strict=True):
        assert value == pytest.approx(FAULHABER[unknown.name], rel=0.01), unknown.name


def test_nothing_is_repaired_that_nobody_named() -> None:
    records, solution = solved([clean_capture(FAULHABER)], {}, ())
    hidden = Suspect("speed_scale", "encoder", "no residual", "name a disc", "not excluded")
    assert repaired(records, solution, [hidden], None, {}, ()) is None
    assert repaired(records, solution, [], None, {}, ()) is None
