"""What all searches draw on, and where one ends that has no more."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from motorid.estimate.fit import alternating_fit
from motorid.estimate.solver.allowance import Allowance, current, opened, used_up
from motorid.estimate.solver.levenberg_marquardt import maximise
from motorid.estimate.solver.problem import Block, Unknown
from motorid.motor import tally
from motorid.motor.tally import Count
from tests.estimate.solutions import OneByOne, solution


def test_what_is_kept_for_later_is_not_left() -> None:
    count = Count(30)
    allowed = Allowance(count, 100.0)
    assert (allowed.spent, allowed.left) == (30, 70.0)
    with allowed.keeping(50.0), allowed.keeping(15.0):
        assert allowed.left == 5.0
        assert allowed.has(5.0)
        assert not allowed.has(5.1)
        count.responses += 5
        assert allowed.ends()
    assert allowed.left == 65.0
    assert allowed.ended  # until somebody sets it back
    assert not allowed.ends()


def test_all_may_take_so_many_times_what_was_spent() -> None:
    allowed = Allowance(Count(40))
    assert allowed.left == math.inf
    allowed.bound(5.0, 0.25)
    assert (allowed.most, allowed.kept, allowed.left) == (200.0, 10.0, 150.0)


def test_the_one_that_is_open_counts_every_response() -> None:
    assert current().left == math.inf
    assert not used_up()
    with opened() as allowed:
        assert current() is allowed
        tally.add(3)
        assert not used_up()
        allowed.most = 3.0
        assert used_up()
    assert allowed.ended
    assert not used_up()


class Curved(OneByOne):
    """Readings of exp(k t), each of whose responses counts unless it is ``free``."""

    unknowns = ()

    def __init__(self, free: bool = False) -> None:
        self.t = np.linspace(0.0, 1.0, 20)
        self.blocks = (Block("speed", 1e-3, 20.0),)
        self.simulated, self._free = 0, free

    def residuals(self, shared: np.ndarray, _own: np.ndarray) -> list[np.ndarray]:
        if not self._free:
            self.simulated += 1
            tally.add(1)
        return [np.exp(2.0 * self.t) - np.exp(shared[0] * self.t)]


def test_a_search_ends_at_the_best_so_far() -> None:
    start = [Unknown("k", 0.5)]
    with opened():
        whole = maximise(start, [Curved()])
    assert whole.converged
    with opened() as allowed:
        allowed.most = 4.0
        cut = maximise(start, [Curved()])
    assert allowed.ended
    assert not cut.converged
    assert allowed.spent <= 4 + 2  # a set of derivatives ends that has begun
    worst = maximise(start, [Curved()], max_iterations=0)
    assert whole.objective < cut.objective <= worst.objective


def test_a_search_that_computes_no_response_goes_on() -> None:
    with opened() as allowed:
        allowed.most = 0.0
        found = maximise([Unknown("k", 0.5)], [Curved(free=True)])
    assert found.converged
    assert found.values[0] == pytest.approx(2.0)


def test_no_other_pass_begins(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(alternating_fit, "used_up", lambda: True)
    monkeypatch.setattr(alternating_fit, "vanished", lambda *_: False)
    record = _Driven()
    before = solution()
    found = alternating_fit.in_turn([record], ("R",), {}, before)  # type: ignore[list-item]
    assert found is before
    assert record.unsettled is None


class _Driven:
    """As far as passes look at a record before the first of them."""

    simulated, names, loss, unsettled = 0, ("R",), "loss", None
    driving = SimpleNamespace(decided=True)
