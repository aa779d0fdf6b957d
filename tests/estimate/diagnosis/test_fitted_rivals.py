"""Rivals that promise enough are fitted, each with its size: what is said of every trial, and where
none is worth it.
"""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.diagnosis import misfit, rank
from motorid.estimate.diagnosis.refit import Refit
from tests.estimate.diagnosis.test_rank import hypothesis
from tests.estimate.solutions import MOTOR, solution


class Fits:
    """Instead of fits with a fault's size: F of each hypothesis, and how far it moves R."""

    def __init__(
        self, monkeypatch: pytest.MonkeyPatch, usual: float, excess: float = 2.0,
        driven: float | None = None, chance: float = 0.0, rest: float = 1.0,
        **each: tuple[float, float],
    ) -> None:  # fmt: skip
        """``driven``: the excess beyond noise of a voltage as well; None: none has any. ``rest``:
        what every fault leaves of it.
        """
        self.usual, self.each = usual, each
        self.rivals: list[Any] = []
        self.began: list[Any] = []
        self.enough: list[float] = []
        monkeypatch.setattr(misfit, "residuals", lambda *_: [])
        variances = () if driven is None else "variances"
        left = {(): excess, "variances": driven}
        monkeypatch.setattr(rank, "rest", lambda *_: (rest, 0.0))
        noise = SimpleNamespace(
            screen="screen",
            variances=lambda: variances,
            share=lambda h, size: chance * float(size[0]) * (h.code != "certain"),
        )
        monkeypatch.setattr(misfit, "excess", lambda _, of, more=(): left[more])
        monkeypatch.setattr(rank, "InputNoise", SimpleNamespace(of=lambda *_: noise))
        monkeypatch.setattr(rank, "refit", self.refit)
        monkeypatch.setattr(rank, "_rivals", lambda *given: self.asked(*given))
        monkeypatch.setattr(rank, "begin_at", lambda *_: ["usual starts"])
        monkeypatch.setattr(rank, "inflation", lambda _: 1.5)
        self.least = 0.0

    def asked(self, _records: Any, _solution: Any, least: float, screen: Any) -> list[Any]:
        assert screen == "screen"  # that of the noise: one for both
        self.least = least
        return self.rivals

    def refit(
        self, _records: Any, starts: Any, h: Any = None, size: Any = (), enough: float = 0.0
    ) -> Refit:
        self.began.append(starts)
        self.enough.append(enough)
        F, moves = self.each[h.code] if h else (self.usual, 0.0)
        values = np.array([v * (1 + moves * (n == "R")) for n, v in MOTOR.items()])
        return Refit(values, np.array(size), F, solution())


def readings(*counts: float) -> Any:
    measured = [SimpleNamespace(block=SimpleNamespace(count=n)) for n in counts]
    return [SimpleNamespace(measured=measured)]


def test_each_rival_is_fitted_and_the_one_that_explains_most_comes_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fits = Fits(monkeypatch, 5000.0, late=(4000.0, 0.1), slips=(3500.0, -0.2))
    late, slips = (replace(hypothesis(), code=code) for code in ("late", "slips"))
    fits.rivals = [(late, (1.0,), None, False), (slips, (2.0,), ["its own"], True)]
    one, two = rank.trials(readings(600.0, 400.0), solution(), {})
    assert [t.hypothesis.code for t in (one, two)] == ["slips", "late"]
    assert (one.gain, two.gain) == pytest.approx((1.5, 1.0))
    assert (one.share, two.share) == pytest.approx((0.75, 0.5))
    assert one.shift["R"] == pytest.approx(-0.2)
    assert set(one.shift) == {"R", "L", "K", "J", "T0"}  # B is hardly ever well known
    assert (one.seen, two.seen) == (True, False)
    assert fits.began == [["usual starts"], ["usual starts"], ["its own"]]
    assert fits.least == pytest.approx(rank.WORTH * 1000.0)
    assert fits.enough == pytest.approx([rank.NEAR * 2.0 * 1000.0] * 3)


@pytest.mark.parametrize(
    ("rest", "moves", "tried"),
    [
        (0.019, 0.1, 1),  # less than a hundredth of 2 for each reading, and than 300 in all
        (0.021, 0.1, 2),
        (0.019, 1e-4, 2),  # it convinces nobody
    ],
)
def test_a_fault_that_leaves_nothing_has_no_rival(
    rest: float, moves: float, tried: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    fits = Fits(monkeypatch, 5000.0, rest=rest, late=(4000.0, moves), slips=(3500.0, -0.2))
    late, slips = (replace(hypothesis(), code=code) for code in ("late", "slips"))
    fits.rivals = [(late, (1.0,), None, False), (slips, (2.0,), None, False)]
    known: Any = {"R": SimpleNamespace(total=100.0)}
    assert len(rank.trials(readings(600.0, 400.0), solution(), known)) == tried


def test_a_trial_knows_what_noise_of_a_voltage_makes_of_its_size(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fits = Fits(monkeypatch, 5000.0, chance=0.1, late=(4000.0, 0.1), certain=(3500.0, 0.1))
    late, certain = (replace(hypothesis(), code=code) for code in ("late", "certain"))
    fits.rivals = [(late, (2.0,), None, False), (certain, (2.0,), None, False)]
    one, two = rank.trials(readings(1000.0), solution(), {})
    assert (one.hypothesis.code, one.chance) == ("certain", 0.0)
    assert (two.hypothesis.code, two.chance) == ("late", pytest.approx(0.2))


@pytest.mark.parametrize(("driven", "tried"), [(0.11, 1), (0.09, 0)])
def test_nothing_is_fitted_where_noise_of_a_voltage_explains_what_there_is(
    driven: float, tried: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    fits = Fits(monkeypatch, 5000.0, driven=driven, late=(4000.0, 0.1))
    fits.rivals = [(replace(hypothesis(), code="late"), (1.0,), None, False)]
    found = rank.trials(readings(1000.0), solution(), {})
    assert len(found) == tried
    assert bool(fits.began) is bool(tried)
    assert [one.share for one in found] == pytest.approx([0.5] * tried)  # of all there is


@pytest.mark.parametrize("total", [0.0, 2.0, 8.0])
def test_how_far_a_shift_is_counts_in_what_noise_or_instruments_leave_open(
    total: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    fits = Fits(monkeypatch, 5000.0, late=(4000.0, 0.1))
    fits.rivals = [(replace(hypothesis(), code="late"), (1.0,), None, False)]
    (by_noise,) = rank.trials(readings(1000.0), solution(), {})
    known: Any = {"R": SimpleNamespace(total=total), "T0": SimpleNamespace(total=None)}
    (found,) = rank.trials(readings(1000.0), solution(), known)
    moved = 0.1 * MOTOR["R"]
    expected = min(by_noise.farthest, moved / (rank.PART_OF_ALL * total) if total else math.inf)
    assert found.farthest == pytest.approx(expected)
    assert (found.farthest < by_noise.farthest) is (total == 8.0)


def test_nothing_is_fitted_where_there_is_little_to_explain_or_no_rival(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    calm = Fits(monkeypatch, 5000.0, excess=0.09, late=(4000.0, 0.1))
    calm.rivals = [(replace(hypothesis(), code="late"), (1.0,), None, False)]
    assert rank.trials(readings(1000.0), solution(), {}) == []
    assert calm.began == []
    many = readings(1.5 * rank.CLEAR / 0.04)  # enough readings show any misfit
    assert len(rank.trials(many, solution(), {})) == 1
    assert calm.least == pytest.approx(1.5 * rank.CLEAR)
    more = Fits(monkeypatch, 5000.0, excess=0.11, late=(4000.0, 0.1))
    more.rivals = calm.rivals
    assert len(rank.trials(readings(1000.0), solution(), {})) == 1
    none = Fits(monkeypatch, 5000.0)
    assert rank.trials(readings(1000.0), solution(), {}) == []
    assert none.began == []


def test_a_parameter_that_the_usual_fit_has_at_nothing_has_no_share(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fits = Fits(monkeypatch, 5000.0, late=(4000.0, 0.1))
    fits.rivals = [(replace(hypothesis(), code="late"), (1.0,), None, False)]
    monkeypatch.setitem(MOTOR, "T0", 0.0)
    (found,) = rank.trials(readings(1000.0), solution(), {})
    assert "T0" not in found.shift
