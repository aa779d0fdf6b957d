"""What tests of plans share: a search that ends at once, where not its answer's price is judged."""

from __future__ import annotations

import pytest

from motorid.motor.parameters import Motor
from motorid.plan import search, shape
from motorid.plan.motors import middle


@pytest.fixture
def one_motor(monkeypatch: pytest.MonkeyPatch) -> None:
    """The middle of the spread alone, where the spread is not what is tested: quicker."""
    monkeypatch.setattr("motorid.plan.motors.motors", lambda spread: (middle(spread),))


@pytest.fixture
def one_shape(monkeypatch: pytest.MonkeyPatch) -> None:
    """A search from one beginning, without shaking, where no program's price is tested: quicker.

    With what it ends at every limit is kept and every want is foreseen, as with the cheapest one.
    """
    _begin_at(0, monkeypatch)


@pytest.fixture
def best_shape(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same from the beginning that leads to the simulated rig's cheapest program."""
    _begin_at(1, monkeypatch)


def _begin_at(which: int, monkeypatch: pytest.MonkeyPatch) -> None:
    def one(motor: Motor, hold_s: float = 0.0) -> tuple[tuple[shape.Stage, ...], ...]:
        return (shape.seeds(motor, hold_s)[which],)

    monkeypatch.setattr(search, "seeds", one)
    monkeypatch.setattr(search, "SHAKES", 0)
