"""A current behind a capacitor is named as such; one that is spoiled otherwise is not."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.diagnosis.facts.coupled_current import findings, found, restored
from tests.estimate.diagnosis.facts.made_log import FULL, PERIOD_S, log, rounded, rows, truth


def coupled(hertz: float) -> np.ndarray:
    """By SciPy's filter of first order, its corner at that frequency."""
    keep = float(np.exp(-2.0 * np.pi * hertz * PERIOD_S))
    return np.asarray(lfilter([1.0, -1.0], [1.0, -keep], truth()[CURRENT]))


@pytest.mark.parametrize("hertz", [0.5, 2.0, 8.0])
def test_a_current_behind_a_capacitor_is_named_with_its_corner(hertz: float) -> None:
    capture = log(**{CURRENT: coupled(hertz)})
    (said,) = findings(capture, " in run 2")
    assert (said.code, said.severity) == ("current_coupled", "error")
    assert "AC-coupled in run 2" in said.message
    assert said.moves["J"] == np.inf
    rows_of_it = found(capture)
    assert rows_of_it is not None
    assert 1.0 / (2.0 * np.pi * rows_of_it * PERIOD_S) == pytest.approx(hertz, rel=0.3)


def test_what_was_blocked_is_restored() -> None:
    keep = 0.99
    shown = np.asarray(lfilter([1.0, -1.0], [1.0, -keep], truth()[CURRENT]))
    assert restored(shown, 100.0) == pytest.approx(truth()[CURRENT], abs=0.02 * FULL[CURRENT])
    assert restored(np.array([1.0, -1.0, 2.0]), 2.0) == pytest.approx([1.5, -1.0, 3.0])


@pytest.mark.parametrize("bits", [0, 8])
def test_a_current_at_a_direct_input_is_not_accused(bits: int) -> None:
    assert found(rounded(log(), bits)) is None


DRIFT = np.linspace(0.0, 0.5, len(truth()[CURRENT]))
SPOILED = {
    "late": np.r_[np.zeros(30), truth()[CURRENT][:-30]],
    "filtered": np.asarray(lfilter([0.02], [1.0, -0.98], truth()[CURRENT])),
    "offset": truth()[CURRENT] + 1.0,
    "drift": truth()[CURRENT] + DRIFT,
    "reversed": -truth()[CURRENT],
    "of the supply": truth()[CURRENT] * truth()[VOLTAGE] / 24.0,
    "clipped": np.clip(truth()[CURRENT], -4.0, 4.0),
    "of something else": np.random.default_rng(3).normal(0.0, 3.0, len(truth()[CURRENT])),
}


@pytest.mark.parametrize("how", SPOILED)
def test_a_current_that_is_spoiled_otherwise_is_not_accused(how: str) -> None:
    assert found(log(**{CURRENT: SPOILED[how]})) is None


@pytest.mark.parametrize("name", [VOLTAGE, SPEED])
@pytest.mark.parametrize("late", [3, 30])
def test_another_late_channel_is_not_taken_for_it(name: str, late: int) -> None:
    shown = np.r_[np.full(late, truth()[name][0]), truth()[name][:-late]]
    assert found(log(**{name: shown})) is None


def test_rows_that_are_lost_are_not_taken_for_it() -> None:
    whole = log()
    kept = np.arange(len(whole))
    assert found(rows(whole, kept[kept % 200 > 30])) is None


def test_a_log_that_lacks_a_column_says_nothing() -> None:
    whole = log(**{CURRENT: coupled(2.0)})
    channels = {n: c for n, c in whole.channels.items() if n != SPEED}
    assert list(findings(Capture(whole.ticks, whole.clock_hz, channels))) == []


def one_step(seed: int) -> Capture:
    """A step of 10 V at 100 kHz by converters of 8 bits: the speed's slope is mostly noise."""
    R, L, K, J, T0, period_s = 4.5, 2.2e-3, 0.014, 1.6e-6, 1.1e-3, 1e-5
    i = w = 0.0
    made = []
    for k in range(5500):
        volts = 10.0 if k > 367 else 0.0
        made.append((volts, i, w))
        i, w = i + period_s / L * (volts - R * i - K * w), w + period_s / J * max(K * i - T0, 0.0)
    rng = np.random.default_rng(seed)
    noise = np.array([0.04, 0.015, 4.0]) * rng.standard_normal((5500, 3))
    shown = (np.array(made) + noise).T
    shown[0] = 0.1 * np.rint(10.0 * shown[0])
    units = {VOLTAGE: "V", CURRENT: "A", SPEED: "rad/s"}
    channels = {n: Channel(n, unit, y) for (n, unit), y in zip(units.items(), shown, strict=True)}
    return Capture(np.arange(5500), 1.0 / period_s, channels)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_noisy_speed_does_not_accuse_the_current(seed: int) -> None:
    """The integral of the current is about the speed, and friction of it suits the second law."""
    assert found(one_step(seed)) is None
