"""Levels at rest and in a drive, by a board whose readings are given; what ends one early."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.acquire import session as room
from motorid.acquire.session import Session, level_of
from motorid.errors import RigError
from motorid.rig import Nameplate
from motorid.sim.port import open_sim
from tests.acquire.rigs import sim_rig
from tests.acquire.test_session import opened


class Readings:
    """A board and its port's clock: reading n is n, and asking takes ``asking_s``."""

    def __init__(self, asking_s: float = 0.0) -> None:
        self.time, self.count, self.asking_s = 10.0, 0, asking_s

    def now(self) -> float:
        return self.time

    def ask(self, name: str) -> dict[str, float]:
        assert name == "read_status"
        self.time += self.asking_s
        self.count += 1
        return {"current_raw": self.count - 1, "tick": 100 * self.count}

    def wait(self, seconds: float) -> None:
        self.time += seconds


def resting_on(readings: Readings) -> Session:
    session = Session.__new__(Session)
    session.port = session.board = readings  # type: ignore[assignment]
    return session


@pytest.mark.parametrize(("seconds", "count"), [(1.0, 128), (2.0, 128), (0.0, 32)])
def test_a_level_at_rest_is_of_eight_readings_a_block_or_two_at_least(
    seconds: float, count: int
) -> None:
    readings = Readings()
    found = resting_on(readings).resting("current", seconds)
    assert readings.count == count
    assert readings.time == 10.0 + seconds
    assert found.mean == (count - 1) / 2
    assert found.drift == count / 2


def test_slow_answers_make_a_level_longer_and_not_rougher() -> None:
    readings = Readings(asking_s=0.25)
    resting_on(readings).resting("current", 1.0)
    assert readings.count == 32


def test_ticks_stand_between_the_times_of_asking() -> None:
    readings = Readings(asking_s=0.25)
    found = resting_on(readings).ticks(2.0, 4)
    assert found == [
        (100, 10.0, 10.25), (200, 10.75, 11.0), (300, 11.5, 11.75), (400, 12.25, 12.5),
    ]  # fmt: skip
    assert readings.time == 13.0


# -- a level's mean, uncertainty and drift
def test_a_drift_is_that_of_the_second_half_over_the_first() -> None:
    """Eight blocks about 1 and eight about 3: s² = 16/15, and a drift of 2."""
    found = level_of(np.array([-1.0, 3.0] * 8 + [1.0, 5.0] * 8))
    assert (found.mean, found.drift) == (2.0, 2.0)
    assert found.uncertainty == pytest.approx(math.sqrt(16 / 15 / 16 + 4 / 3))


def test_a_level_without_noise_hides_within_a_count() -> None:
    found = level_of(np.full(32, 7.0))
    assert (found.mean, found.drift) == (7.0, 0.0)
    assert found.uncertainty == pytest.approx(1 / math.sqrt(12))
    dithered = level_of(np.array([0.0, 1.0] * 16))  # half a count of noise shows it
    assert (dithered.mean, dithered.uncertainty) == (0.5, 0.0)


def test_a_level_of_fewer_than_two_readings_a_block_is_none() -> None:
    with pytest.raises(RigError, match="too few samples of a level arrived"):
        level_of(np.arange(31.0))


# -- of the simulated board
@pytest.mark.parametrize(("asked_hz", "ticks"), [(10_000.0, 16_000), (500.0, 32_000)])
def test_a_session_samples_a_thousand_times_a_second_at_most(asked_hz: float, ticks: int) -> None:
    rig = sim_rig()
    rig = replace(
        rig, sampling=replace(rig.sampling, rate_hz=asked_hz, mode="burst", channels=("current",))
    )
    port = open_sim(rig.port)
    try:
        session = Session(port, rig)
    finally:
        port.close()
    assert session.config["sample_period_ticks"] == ticks
    assert session.rig.sampling.mode == "stream"
    assert session.rig.sampling.channels == tuple(session.facts)
    assert len(session.facts) > 1


def test_a_contact_that_is_open_lets_no_session_begin(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuses(board: Any, rig: Any) -> None:
        raise RigError(f"{board.identity['board']}: a contact is open at {rig.sampling.rate_hz:g}")

    monkeypatch.setattr(room, "check_inputs", refuses)
    with pytest.raises(RigError, match="motorid-sim: a contact is open at 1000"), opened():
        pass


@pytest.mark.parametrize(
    ("seconds", "samples"), [(0.2, 200), (0.001, 16), (0.05, 50), (10.0, 4096)]
)
def test_a_zero_is_of_so_many_readings(seconds: float, samples: int) -> None:
    with opened() as session, pytest.MonkeyPatch.context() as patch:
        zero = {"current_offset": 512.0, "voltage_offset": 512.0}
        asked: list[int] = []
        patch.setattr(session.board, "zero", lambda count: (asked.append(count), zero)[1])
        assert session.zero(seconds) == (zero, samples)
        assert (session.last_zero, session.zero_samples) == (zero, samples)
        assert asked == [samples]
        end = session.facts["current"]["raw_max"]
        patch.setattr(session.board, "zero", lambda count: zero | {"current_offset": float(end)})
        with pytest.raises(RigError, match="an end of its range"):
            session.zero(seconds)


@contextmanager
def driven(
    patch: pytest.MonkeyPatch, reason: str = "completed", stop: bool = False
) -> Iterator[Session]:
    """A session whose drives end for that reason, without a sample."""

    @contextmanager
    def asked() -> Iterator[Any]:
        yield SimpleNamespace(requested=stop)

    with opened() as session:
        patch.setattr(room, "drive", lambda *what: reason)
        patch.setattr(room, "interruptible", asked)
        yield session


SHOWN: Any = SimpleNamespace(volts=0.7, peak_a=0.1)  # 7 ohm, over a margin of 1.5


def test_a_level_that_trips_or_is_stopped_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    with driven(monkeypatch, "fault: over_current") as session:
        session.board.trip = "of the coil"
        with pytest.raises(RigError, match=r"^at 2 V the board tripped \(over_current: of the c"):
            session.hold(2.0, 0.2, SHOWN)
    with driven(monkeypatch, "stopped", stop=True) as session:
        with pytest.raises(KeyboardInterrupt, match="interrupted; the bridge is open"):
            session.hold(2.0, 0.2, SHOWN)
        monkeypatch.setattr(room, "weak_pulse", lambda *what: None)
        with pytest.raises(KeyboardInterrupt, match="interrupted; the bridge is open"):
            session.pulse()


@pytest.mark.parametrize(
    ("peak_a", "refused"), [(0.1, False), (0.0, False), (2.0, True)]
)  # 2 V over (0.7 V / 2 A / 1.5) are 8.6 A
def test_a_level_is_held_against_what_the_pulse_drew(
    peak_a: float, refused: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And not against the nameplate: a resistor may stand in the motor's place."""
    says = "could draw 8.57 A" if refused else "not one sample arrived"
    with driven(monkeypatch) as session:
        session.rig = replace(session.rig, nameplate=Nameplate(resistance_ohm=0.01))
        with pytest.raises(RigError, match=says):
            session.hold(2.0, 0.2, SimpleNamespace(volts=0.7, peak_a=peak_a))  # type: ignore[arg-type]


def test_a_level_above_the_supply_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    with driven(monkeypatch) as session, pytest.raises(RigError, match="asks for 99 V"):
        session.hold(99.0, 0.2, SHOWN)
