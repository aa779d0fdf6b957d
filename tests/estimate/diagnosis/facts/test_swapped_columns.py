"""Columns under each other's names are named; other mistakes are not taken for that."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest

from motorid.capture.model import CURRENT, QUANTITIES, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.diagnosis.facts.swapped_columns import find, findings
from tests.estimate.diagnosis.facts.made_log import log, rounded, truth

NAMES = (VOLTAGE, CURRENT, SPEED)


@pytest.mark.parametrize("order", [o for o in permutations(NAMES) if o != NAMES])
def test_each_arrangement_is_found(order: tuple[str, ...]) -> None:
    shown = {q: truth()[of] for q, of in zip(NAMES, order, strict=True)}
    holds = find(log(0.1, **shown))
    assert holds is not None
    assert [dict(zip(NAMES, order, strict=True))[q] for q in holds] == list(NAMES)


def test_the_two_columns_are_named() -> None:
    shown = {VOLTAGE: truth()[SPEED], SPEED: truth()[VOLTAGE]}
    (said,) = findings(log(**shown))
    assert "voltage and speed are swapped" in said.message
    assert "the one called speed reads as the voltage" in said.message
    assert said.moves["L"] == np.inf


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("factor", [-1.0, 1000.0])
def test_another_sign_or_unit_is_no_swap(name: str, factor: float) -> None:
    assert find(log(**{name: factor * truth()[name]})) is None


@pytest.mark.parametrize("bits", [0, 8])
def test_columns_in_their_places_are_not_accused(bits: int) -> None:
    assert find(rounded(log(), bits)) is None


@pytest.mark.parametrize("name", NAMES)
def test_a_late_column_is_no_swap(name: str) -> None:
    late = np.r_[np.full(20, truth()[name][0]), truth()[name][:-20]]
    assert find(log(**{name: late})) is None


def test_a_supplys_voltage_is_no_swap() -> None:
    assert find(log(**{VOLTAGE: np.full(len(truth()[VOLTAGE]), 24.0)})) is None


def test_a_step_of_few_bits_is_not_swapped() -> None:
    """The second law of a speed of 8 bits fails by the noise of its changes, row by row."""
    rng = np.random.default_rng(3)
    t = np.arange(1600) / 200.0  # mechanical time constants
    rises = np.where(t > 0.5, 1.0 - np.exp(-np.maximum(t - 0.5, 0.0)), 0.0)
    shown = {VOLTAGE: 6.0 * (t > 0.5), CURRENT: np.where(t > 0.5, 1.05 - rises, 0.0), SPEED: rises}
    channels = {}
    for name, values in shown.items():
        step = 2.6 * float(np.abs(values).max()) / 256.0
        rounded = np.round(values / step + 0.5 * rng.standard_normal(len(t))) * step
        channels[name] = Channel(name, QUANTITIES[name], rounded)
    ticks = np.arange(len(t), dtype=np.int64)
    assert find(Capture(ticks, 1000.0, channels)) is None
