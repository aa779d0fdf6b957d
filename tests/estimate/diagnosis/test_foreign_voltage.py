"""A voltage that cannot be the motor's is named; one that is, is not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from bench.foreign.cases import chirp, closed_loop, prbs, ramp, steps, trace
from bench.foreign.plant import Drive
from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.diagnosis import foreign_voltage
from motorid.estimate.diagnosis.foreign_voltage import FEWEST, SHORTEST, remarks

NOISE = {VOLTAGE: 0.01, CURRENT: 5e-3, SPEED: 0.1}


def log(drive: Callable[[], Drive], late: int = 0) -> Capture:
    true, rng = trace(drive, 0.0, 0.0), np.random.default_rng(4)
    stamps = np.arange(0.005, 1.95, 1e-3)
    volts = true.at(true.volts, stamps - 1e-3 * late)
    series = {VOLTAGE: volts, CURRENT: true.at(true.current, stamps),
              SPEED: true.at(true.speed, stamps)}  # fmt: skip
    channels = {
        name: Channel(name, unit, y + NOISE[name] * rng.standard_normal(len(y)))
        for (name, y), unit in zip(series.items(), ("V", "A", "rad/s"), strict=True)
    }
    return Capture(np.rint(stamps * 1e6).astype(np.int64), 1e6, channels)


def with_volts(capture: Capture, volts: np.ndarray) -> Capture:
    channel = replace(capture.channels[VOLTAGE], raw=volts)
    return replace(capture, channels={**capture.channels, VOLTAGE: channel})


@pytest.mark.slow
@pytest.mark.parametrize("drive", [steps, prbs, ramp, chirp, closed_loop])
def test_a_motors_own_voltage_is_not_accused(drive: Callable[[], Drive]) -> None:
    assert remarks([log(drive)]) == []


@pytest.mark.slow
@pytest.mark.parametrize("drive", [steps, prbs])
@pytest.mark.parametrize("late", [-50, -20, -8, -3, 3, 8, 20, 50])
def test_a_voltage_that_lags_is_not_accused(drive: Callable[[], Drive], late: int) -> None:
    assert remarks([log(drive, late)]) == []


@pytest.mark.slow
@pytest.mark.parametrize("drive", [prbs, ramp, closed_loop])
def test_a_supply_is_named(drive: Callable[[], Drive]) -> None:
    capture = log(drive)
    supply = 12.0 + 0.02 * np.random.default_rng(5).standard_normal(len(capture))
    (said,) = remarks([with_volts(capture, supply)])
    assert "as a supply does" in said.message
    assert said.moves["K"] == np.inf


def test_another_column_is_named() -> None:
    capture = log(ramp)
    other = 6.0 * np.sin(40.0 * capture.time_s)
    (said,) = remarks([with_volts(capture, other)])
    assert "which column is mapped" in said.message


@pytest.mark.parametrize("known", [FEWEST * SHORTEST - 1, FEWEST * SHORTEST])
def test_a_log_is_judged_from_so_many_whole_rows_on(known: int) -> None:
    capture = log(ramp)
    speed = capture.channels[SPEED]
    gaps = np.where(np.arange(len(capture)) < known, speed.raw, np.nan)
    torn = replace(capture, channels={**capture.channels, SPEED: replace(speed, raw=gaps)})
    short = replace(
        capture, ticks=capture.ticks[:known],
        channels={n: replace(c, raw=c.raw[:known]) for n, c in capture.channels.items()},
    )  # fmt: skip
    for one in (torn, short):
        found = foreign_voltage._columns(one)
        assert (found is None) is (known < FEWEST * SHORTEST)
        if found is not None:
            assert [len(y) for y in found] == [known] * 3
            assert found[2] == pytest.approx(speed.values[:known])


@pytest.mark.parametrize(("swing", "supply"), [(0.05, True), (0.2, False)])
def test_what_swings_more_than_a_tenth_is_no_supply(swing: float, supply: bool) -> None:
    """Of its highest value, from end to end."""
    capture = log(prbs)
    volts = 12.0 * (1.0 - swing * np.linspace(0.0, 1.0, len(capture)))
    (said,) = remarks([with_volts(capture, volts)])
    assert ("as a supply does" in said.message) is supply
