"""Logs of a rotor that stands still: said at once, with R and L where the current tells them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.foreign import cases
from bench.foreign.plant import Drive, turn
from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture, Channel
from motorid.capture.table import read_table
from motorid.errors import DataError
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.partial import locked_rotor
from motorid.estimate.partial.locked_rotor import is_noise
from tests.report.example import estimate
from tests.six_parameters import fit

HELD = replace(cases.MOTOR, T0=10.0)
MOST = 20_000  # evaluations; a fit of all six takes more


def log(folder: Path, drive: Callable[[], Drive], columns: str = "viw") -> Capture:
    """What a busy PC logs of a rotor that is held."""
    rng = np.random.default_rng(1)
    true = turn(HELD, drive(), cases.LENGTH_S)
    stamps = cases.at_random(rng)
    truths = {"v": true.volts, "i": true.current, "w": true.speed}
    table = {"t": stamps}
    for name in columns:
        noise = cases.NOISE[name] * rng.standard_normal(len(stamps))
        table[name] = true.at(truths[name], stamps) + noise
    path = folder / "log.csv"
    rows = np.column_stack(list(table.values()))
    np.savetxt(path, rows, delimiter=",", header=",".join(table), comments="", fmt="%.7g")
    return read_table(path, ["time=t:s", *(cases.MAPS[c] for c in columns)])


@pytest.fixture
def responses(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """One entry for every evaluation of a record's model."""
    seen: list[int] = []
    fitted = MotorRecord.fitted

    def counted(record: MotorRecord, *given):  # type: ignore[no-untyped-def]
        seen.append(1)
        return fitted(record, *given)

    monkeypatch.setattr(MotorRecord, "fitted", counted)
    return seen


@pytest.mark.slow
def test_a_motor_that_was_never_driven_tells_nothing_and_soon(
    tmp_path: Path, responses: list[int]
) -> None:
    with pytest.raises(DataError, match="determine nothing: nothing shows that the rotor turned"):
        fit([log(tmp_path, lambda: lambda t, w: 0.0)], model="auto")
    assert not responses


@pytest.mark.slow
def test_a_rotor_that_is_held_tells_resistance_and_inductance(
    tmp_path: Path, responses: list[int]
) -> None:
    found = fit([log(tmp_path, cases.steps)], model="auto")
    for name in ("R", "L"):
        low, high = found.parameters[name].interval_95 or (0.0, 0.0)
        assert low < getattr(HELD, name) < high
    assert {found.parameters[n].status for n in ("K", "B", "J", "T0")} == {"not_identifiable"}
    assert found.diagnostics[0].code == "rotor_held"
    assert len(responses) < MOST


def test_motion_in_noise_shows_in_means() -> None:
    noise = np.random.default_rng(2).standard_normal(2000)
    assert is_noise(noise, origin=False)
    assert is_noise(noise + 5.0, origin=True)
    assert not is_noise(noise + 0.2, origin=False)
    assert not is_noise(noise + np.where(np.arange(2000) % 500 < 250, 0.3, -0.3), origin=False)
    assert not is_noise(np.zeros(2000), origin=False)


# what shows a motion, and what a current


def made(n: int = 64, program: Any = None, **series: Any) -> Capture:
    units = {CURRENT: "A", SPEED: "rad/s", POSITION: "rad", VOLTAGE: "V"}
    channels = {
        name: y if isinstance(y, Channel) else Channel(name, units[name], np.asarray(y, float))
        for name, y in series.items()
    }
    return Capture(np.arange(n) * 1000, 1e6, channels, program=program)


RNG = np.random.default_rng(6)


def test_a_motion_that_reads_one_value_throughout_is_none() -> None:
    one = made(current=RNG.standard_normal(64), speed=np.full(64, 3.0), position=np.arange(64.0))
    (kept,) = locked_rotor.without_constant_motion([one])
    assert set(kept.channels) == {CURRENT, POSITION}
    holed = made(speed=np.where(np.arange(64) % 2, 3.0, np.nan))
    assert set(locked_rotor.without_constant_motion([holed])[0].channels) == set()
    missing = made(speed=np.full(64, np.nan))
    assert set(locked_rotor.without_constant_motion([missing])[0].channels) == set()
    board = made(speed=np.full(64, 3.0), program=object())
    assert locked_rotor.without_constant_motion([board]) == [board]
    moving = made(speed=np.arange(64.0))
    assert locked_rotor.without_constant_motion([moving]) == [moving]


def test_noise_has_no_more_in_its_means_than_between_neighbours() -> None:
    white = RNG.standard_normal(4096)
    assert locked_rotor.is_noise(white, origin=False)
    assert not locked_rotor.is_noise(white + 0.5, origin=False)
    assert locked_rotor.is_noise(white + 0.5, origin=True)
    wander = white + 0.3 * np.sin(2 * np.pi * np.arange(4096) / 1000)
    assert not locked_rotor.is_noise(wander, origin=True)
    assert not locked_rotor.is_noise(np.zeros(64), origin=False)
    assert not locked_rotor.is_noise(white[:7], origin=False)
    gaps = np.where(np.arange(4096) % 5, white, np.nan)
    assert locked_rotor.is_noise(gaps, origin=False)


def test_means_of_noise_stay_below_a_bound_once_in_thousands() -> None:
    for seed in range(50):
        noise = np.random.default_rng(seed).standard_normal(512)
        assert locked_rotor.is_noise(noise, origin=False)


def test_a_current_flows_where_it_is_more_than_noise_or_goes_with_the_voltage() -> None:
    n = 4096
    noise, swing = 0.1 * RNG.standard_normal(n), np.where(np.arange(n) % 512 < 256, 1.0, -1.0)
    still = made(n, current=noise, terminal_voltage=swing)
    assert not locked_rotor._draws_current(still)
    hidden = made(n, current=noise + 0.012 * swing, terminal_voltage=swing)
    assert locked_rotor._draws_current(hidden)
    assert locked_rotor._draws_current(made(n, current=noise + 0.1, terminal_voltage=swing))
    assert locked_rotor._draws_current(made(n, current=noise))  # nothing to compare it with


def test_a_log_at_rest_has_a_current_and_a_motion_of_noise_alone() -> None:
    noise = RNG.standard_normal(256)
    assert locked_rotor._is_log_at_rest(made(256, current=noise, speed=noise))
    assert locked_rotor._is_log_at_rest(made(256, current=noise, position=noise + 40.0))
    assert not locked_rotor._is_log_at_rest(made(256, current=noise, speed=noise + 40.0))
    assert not locked_rotor._is_log_at_rest(made(256, current=noise))
    assert not locked_rotor._is_log_at_rest(made(256, speed=noise))
    both = made(256, current=noise, speed=noise, position=np.arange(256.0))
    assert not locked_rotor._is_log_at_rest(both)
    magnitude = Channel(CURRENT, "A", noise, unsigned=True)
    assert not locked_rotor._is_log_at_rest(made(256, current=magnitude, speed=noise))
    coarse = Channel(CURRENT, "A", np.where(noise > 0, 1.0, 0.0), resolution=0.7)
    assert not locked_rotor._is_log_at_rest(made(256, current=coarse, speed=noise))
    fine = Channel(CURRENT, "A", np.where(noise > 0, 1.0, 0.0), resolution=0.6)
    assert locked_rotor._is_log_at_rest(made(256, current=fine, speed=noise))
    assert not locked_rotor._is_log_at_rest(made(256, current=noise, speed=noise, program=object()))


def test_a_friction_that_holds_the_rotor_is_twice_what_its_current_gives() -> None:
    runs = [made(current=[1.0] * 63 + [-3.0]), made(current=[np.nan] + [2.0] * 63)]
    assert locked_rotor.still_motor(runs, {}) == {"K": 1.0, "B": 0.0, "J": 1.0, "T0": 6.0}
    held = locked_rotor.still_motor(runs, {"K": 0.05, "R": 2.0})
    assert held["T0"] == pytest.approx(0.3)
    assert held["R"] == 2.0
    assert locked_rotor._peak(held) == pytest.approx(3.0)


@pytest.mark.parametrize(("share", "given"), [(0.9, True), (1.1, False)])
def test_an_inductance_that_leans_is_not_given_nor_what_is_made_of_it(
    share: float, given: bool
) -> None:
    found = estimate()
    L = found.parameters["L"]
    assert L.value is not None
    leaning = replace(L, statistical=share * locked_rotor.LEANS["L"] * L.value)
    some = replace(
        found, parameters={**found.parameters, "L": leaning},
        combinations={"L/R": L, "K/R": L, "J/K": L},
        derived={"electrical_time_constant": L, "stall_current": L},
    )  # fmt: skip
    kept = locked_rotor._without_leaning(some)
    if given:
        assert kept is some
        return
    assert kept.parameters["L"].value is None
    assert kept.parameters["L"].unit == "H"
    assert set(kept.combinations) == {"K/R", "J/K"}
    assert set(kept.derived) == {"stall_current"}
    assert kept.parameters["R"] == found.parameters["R"]


def test_the_current_that_would_have_turned_it_gives_the_highest() -> None:
    amperes = 3.0
    still = {"K": 0.05, "T0": 0.05 * amperes * locked_rotor.HOLDS}
    assert locked_rotor._peak(still) == pytest.approx(amperes)


@pytest.mark.parametrize(("part", "noise"), [(0.99, True), (1.01, False)])
def test_the_mean_of_all_readings_is_looked_at_too(part: float, noise: bool) -> None:
    """Neighbours that differ by 2 have a variance of 2; a mean is the rarest over all of them."""
    rare = locked_rotor.RARE
    count = 32 * locked_rotor.NARROWEST
    bound = 2.0 * (1.0 + 2.0 * np.sqrt(rare) + 2.0 * rare)
    mean = np.sqrt(part * bound / count)
    readings = mean + np.tile([1.0, -1.0], count // 2)
    assert locked_rotor.is_noise(readings, origin=False) is noise
    assert locked_rotor.is_noise(readings, origin=True)
    assert not locked_rotor.is_noise(readings[: 2 * locked_rotor.NARROWEST - 1], origin=True)
    known = np.full(2 * count, np.nan)
    known[::2] = readings
    assert locked_rotor.is_noise(known, origin=False) is noise
