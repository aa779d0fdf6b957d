"""Responses that are counted: of the process, and of a stretch of work."""

from __future__ import annotations

from threading import Thread

import pytest

from motorid.motor import tally
from motorid.motor.reading import Output, Quantity
from motorid.motor.response import Response
from motorid.motor.tally import Tally, counting

MOTOR = (2.0, 1e-3, 0.05, 4e-5, 2e-5, 6e-3)


def respond() -> None:
    Response(1e-3, [0.0, 6.0, 6.0], [Output(Quantity.CURRENT)])(MOTOR)


def test_a_count_begins_and_ends_with_its_stretch(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Tally, "responses", 100)
    respond()
    with counting() as outer:
        respond()
        with counting() as inner:
            tally.add(5)
        respond()
    respond()
    assert (outer.responses, inner.responses) == (7, 5)
    assert Tally.responses == 109


def test_another_thread_has_counts_of_its_own() -> None:
    with counting() as count:
        other = Thread(target=respond)
        other.start()
        other.join()
    assert count.responses == 0
