"""A supply that is read before a fuse: named, and estimated with the motor."""

from __future__ import annotations

import re

import numpy as np
import pytest

from motorid.estimate.diagnosis.faults.bridge import supply_path
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.results.status import Status
from tests.estimate.effects.benches import record
from tests.estimate.effects.bridge.commanded import commanded, with_noise
from tests.exact_capture import FAULHABER
from tests.six_parameters import fit

PATH_OHM = 0.05  # 2 % of R


@pytest.mark.slow
def test_it_is_offered_where_a_supply_is_read_and_the_duty_commanded() -> None:
    (one,) = supply_path.hypotheses([MotorRecord(commanded(), PARAMETERS, {})])
    assert one.code == "supply_read_upstream"
    assert one.lower == (0.0,)  # no wire has less than none
    assert "about 50 mohm between" in one.words(np.array([PATH_OHM])).evidence
    for name in ("measured", "commanded", "log"):  # none of these reads its supply
        assert supply_path.hypotheses([record(name)]) == []


@pytest.mark.slow
def test_a_fuse_is_named_and_estimated_with_the_motor() -> None:
    estimate = fit([with_noise(commanded(path_ohm=PATH_OHM))])
    (said,) = [s for s in estimate.suspects if s.strength == "named"]
    assert (said.code, said.allowed) == ("supply_read_upstream", True)
    told = re.search(r"about ([\d.]+) mohm", said.evidence)
    assert told is not None
    assert float(told[1]) == pytest.approx(1e3 * PATH_OHM, rel=0.2)
    for name, truth in FAULHABER.items():
        p = estimate.parameters[name]
        assert p.status is Status.ESTIMATED
        assert p.value == pytest.approx(truth, abs=4.0 * p.total)


@pytest.mark.slow
def test_a_supply_read_at_the_bridge_is_not_accused() -> None:
    estimate = fit([with_noise(commanded())])
    assert [s.code for s in estimate.suspects if s.strength == "named"] == []
