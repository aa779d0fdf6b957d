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

    def first(motor: Motor, hold_s: float = 0.0) -> tuple[tuple[shape.Stage, ...], ...]:
        return shape.seeds(motor, hold_s)[:1]

    monkeypatch.setattr(search, "seeds", first)
    monkeypatch.setattr(search, "SHAKES", 0)
