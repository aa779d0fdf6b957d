"""A supply's current is named as such; a motor's is not, however it is spoiled."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.capture.model import CURRENT, SPEED, VOLTAGE
from motorid.estimate.diagnosis.facts.supply_current import findings, found
from tests.estimate.diagnosis.facts.made_log import log, rounded, truth


def test_a_supplys_current_is_named() -> None:
    (said,) = findings(log(**{CURRENT: truth()[CURRENT] * truth()[VOLTAGE] / 24.0}))
    assert said.code == "supply_current"
    assert said.severity == "error"
    assert said.moves["J"] == np.inf


@pytest.mark.parametrize("bits", [0, 8])
def test_a_motors_current_is_not_accused(bits: int) -> None:
    assert not found(rounded(log(), bits))


@pytest.mark.parametrize("name", [VOLTAGE, CURRENT, SPEED])
@pytest.mark.parametrize("late", [3, 30])
def test_a_late_channel_is_not_accused(name: str, late: int) -> None:
    shown = np.r_[np.full(late, truth()[name][0]), truth()[name][:-late]]
    assert not found(log(**{name: shown}))


@pytest.mark.parametrize("name", [VOLTAGE, CURRENT, SPEED])
def test_a_reversed_channel_is_not_accused(name: str) -> None:
    assert not found(log(**{name: -truth()[name]}))


def test_a_drive_at_one_level_says_nothing() -> None:
    assert not found(log(**{VOLTAGE: np.full(len(truth()[VOLTAGE]), 24.0)}))
