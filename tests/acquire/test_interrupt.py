"""A request to stop is followed, or it ends the program's wait: nothing hangs."""

from __future__ import annotations

import signal
import time

import pytest

from motorid.acquire import interrupt
from motorid.errors import UsageError
from motorid.sim.port import open_sim

WAIT_S = 60.0  # however busy the computer


def wait_while_asked_to_stop(until: float) -> None:
    with interrupt.interruptible() as stop:
        signal.raise_signal(signal.SIGTERM)
        assert stop.requested
        while time.monotonic() < until:
            time.sleep(0.01)


@pytest.mark.slow
def test_a_request_that_nobody_follows_ends_the_wait(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(interrupt, "PATIENCE_S", 0.1)
    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        wait_while_asked_to_stop(began + WAIT_S)
    assert time.monotonic() - began < WAIT_S


@pytest.mark.slow
def test_one_that_was_followed_leaves_the_program_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(interrupt, "PATIENCE_S", 0.05)
    with interrupt.interruptible() as stop:
        signal.raise_signal(signal.SIGINT)
    time.sleep(0.2)
    assert stop.requested


@pytest.mark.parametrize("option", ["max_step=1e-13", "supply_capacitance=1e-12"])
def test_steps_too_short_to_wait_for_are_refused(option: str) -> None:
    with pytest.raises(UsageError, match="too short to wait for"):
        open_sim(f"sim://?speed=max&{option}")
