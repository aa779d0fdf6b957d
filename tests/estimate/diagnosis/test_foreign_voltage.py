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


@pytest.mark.slow
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


@pytest.mark.slow
@pytest.mark.parametrize(("swing", "supply"), [(0.05, True), (0.2, False)])
def test_what_swings_more_than_a_tenth_is_no_supply(swing: float, supply: bool) -> None:
    """Of its highest value, from end to end."""
    capture = log(prbs)
    volts = 12.0 * (1.0 - swing * np.linspace(0.0, 1.0, len(capture)))
    (said,) = remarks([with_volts(capture, volts)])
    assert ("as a supply does" in said.message) is supply


# a speed that counts edges


def counted(edge_rad: float) -> Capture:
    """V = R i + K ω at every row, of a speed that counts edges since the row before."""
    at_s = np.arange(1920) * 1e-3
    current, speed = 0.3 * np.sin(8.2 * np.pi * at_s), 300.0 * np.sin(3.0 * np.pi * at_s)
    counts = np.floor(np.cumsum(speed) * 1e-3 / edge_rad + 0.3)
    read = np.diff(counts, prepend=counts[0]) * edge_rad / 1e-3
    series = {VOLTAGE: current + 0.02 * speed, CURRENT: current, SPEED: read}
    units = ("V", "A", "rad/s")
    channels = {
        name: Channel(name, unit, y) for (name, y), unit in zip(series.items(), units, strict=True)
    }
    return Capture(np.arange(1920) * 1000, 1e6, channels)


def departing(capture: Capture) -> float:
    """The least share of blocks that depart."""
    columns = foreign_voltage._columns(capture)
    assert columns is not None
    return min(foreign_voltage._departs([columns], lag) for lag in foreign_voltage.LAGS)


def test_a_speed_that_counts_few_edges_makes_no_voltage_foreign(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A block of 16 rows has one edge or two: a third of them is far off, by chance."""
    coarse = counted(3.0)
    assert np.abs(coarse.channels[SPEED].values).max() == pytest.approx(3000.0)  # of 300 in truth
    assert remarks([coarse]) == []
    assert departing(coarse) < foreign_voltage.MANY
    monkeypatch.setattr(foreign_voltage, "CHANCE", 0.0)
    assert departing(coarse) > 2.0 * foreign_voltage.MANY


@pytest.mark.parametrize("edge_rad", [0.1, 3.0])
def test_a_supply_beside_a_speed_of_few_edges_is_named(edge_rad: float) -> None:
    capture = counted(edge_rad)
    (said,) = remarks([with_volts(capture, np.full(len(capture), 12.0))])
    assert "as a supply does" in said.message


def test_chance_is_how_much_neighbours_differ_in_speed() -> None:
    """Of blocks of 16: a speed that stands, one of ±.5 by turns, and a slope of .1; each counts
    with K = 3. A block is as uncertain as is usual at least, whatever voltage and current do.
    """
    speed = np.array([np.zeros(16), 0.5 * (-1.0) ** np.arange(16), 0.1 * np.arange(16)])
    others = np.random.default_rng(6).standard_normal((3, 3, 16))
    cut = np.array([others[0], others[1], speed, others[2]])
    found = foreign_voltage._chance(cut, np.array([2.0, 3.0, 5.0]))
    usual = 3.0 * np.sqrt((0.0 + 1.0 + 0.1**2) / 3.0 / 32.0)
    assert found == pytest.approx([usual, 3.0 / np.sqrt(32.0), usual], abs=1e-12)
    noise = np.random.default_rng(7).standard_normal((1, 4000))
    cut = np.array([*np.zeros((2, 1, 4000)), noise, np.zeros((1, 4000))])
    assert foreign_voltage._chance(cut, np.ones(3)) == pytest.approx(1.0 / np.sqrt(4000.0), rel=0.1)
