"""Levels that a calibration holds: over their settled half, and none without a sample."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from motorid.acquire import session as session_module
from motorid.acquire.interrupt import interruptible
from motorid.acquire.pulse import weak_pulse
from motorid.acquire.session import Session
from motorid.errors import RigError
from motorid.sim.port import open_sim
from tests.acquire.rigs import sim_rig


@contextmanager
def opened(options: str = "") -> Iterator[Session]:
    rig = sim_rig(options)
    port = open_sim(rig.port)
    try:
        yield Session(port, rig)
    finally:
        port.close()


def test_a_level_is_of_the_half_in_which_the_motor_runs_evenly() -> None:
    """Half of two tenths of a second at 10 kHz, at 2 V: its voltage is that, and rises no more."""
    seen: list[int] = []
    level_of = session_module.level_of
    with opened("heating=0") as session, pytest.MonkeyPatch.context() as patch:
        pulse = session.pulse()
        session.board.wait_for_rest()
        patch.setattr(
            session_module, "level_of", lambda raw: (seen.append(len(raw)), level_of(raw))[1]
        )
        levels = session.hold(2.0, 0.2, pulse)
        fact = session.facts["terminal_voltage"]
        rate_hz = session.board.identity["clock_hz"] / session.config["sample_period_ticks"]
    volts = fact["scale"] * (levels["terminal_voltage"].mean - session.last_zero["voltage_offset"])
    assert volts == pytest.approx(2.0, rel=0.02)
    assert seen == [pytest.approx(0.1 * rate_hz, abs=1)] * len(levels)


def test_a_level_of_which_no_sample_came_is_no_level(monkeypatch: pytest.MonkeyPatch) -> None:
    with opened() as session:
        pulse = session.pulse()
        session.board.wait_for_rest()
        monkeypatch.setattr(session_module, "drive", lambda *what: "completed")
        with pytest.raises(RigError, match="at 2 V not one sample arrived: check the link"):
            session.hold(2.0, 0.2, pulse)


def test_a_pulse_that_ends_with_a_brake_shows_the_current_that_flows_back() -> None:
    """A turning motor drives it through its winding, against the one that turned it."""
    with opened("heating=0") as session, interruptible() as stop:
        zero, _ = session.zero()
        told = (session.board, session.rig, session.config, zero, stop, 0.3, 7.0)
        driven = weak_pulse(*told)
        session.board.wait_for_rest()
        braked = weak_pulse(*told, braking=True)
    assert driven is not None
    assert braked is not None
    assert driven.draws
    assert braked.draws
    assert driven.current_a is not None
    assert braked.current_a is not None
    assert driven.current_a > 0.0 > braked.current_a
