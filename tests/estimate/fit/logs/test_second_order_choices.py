"""Low-passes of second order: which is taken, on fits of which the objective is given."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.registry import SECOND_ORDER
from motorid.estimate.effects.unstated.current_smoothing import CURRENT_SMOOTHING
from motorid.estimate.effects.unstated.speed_smoothing import SPEED_SMOOTHING
from motorid.estimate.fit.logs import log_second_order
from motorid.estimate.signals.intersample_voltage import Rival
from motorid.estimate.solver.problem import Solution, Unknown
from tests.estimate.fit.made_fits import (
    LAG,
    NAMES,
    SMOOTHING,
    Found,
    fit,
    known,
    record,
    solution,
)


def test_a_second_order_must_pay_for_one_unknown_more() -> None:
    measured = [SimpleNamespace(values=np.zeros(1000))]
    before = [record(measured=measured)], solution(100.0)
    for gain, better in ((6.8, False), (7.0, True)):  # ln 1000 = 6.91
        other = fit(100.0 - gain)
        assert (log_second_order._better(before, other) is other) is better


def test_the_size_of_a_low_pass_is_of_one_that_was_found() -> None:
    one, own = known((LAG, 3.0, 1.0), (SMOOTHING, 2.0, 1.0), found=[SMOOTHING, LAG])
    assert log_second_order._size(one, own, CURRENT_SMOOTHING) == 2.0
    assert log_second_order._size(one, own, SPEED_SMOOTHING) == 0.0
    unsure, own = known((SMOOTHING, 2.0, 1.0))
    assert log_second_order._size(unsure, own, CURRENT_SMOOTHING) == 0.0
    below, own = known((SMOOTHING, -2.0, 1.0), found=[SMOOTHING])
    assert log_second_order._size(below, own, CURRENT_SMOOTHING) == 0.0


def test_second_orders_are_begun_from_two_bends_and_half_the_inductance(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    began: list[tuple[float, float, float]] = []

    def settled(records: list[Found], _free: object, start: dict[str, float]) -> Solution:
        (unknown,) = records[0].sizes.values()
        began.append((unknown.start, unknown.prior_sd, start["L"]))  # type: ignore[attr-defined]
        return solution(100.0)

    monkeypatch.setattr(log_second_order, "MotorRecord", Found)
    monkeypatch.setattr(log_second_order, "like", lambda _, records: records)
    monkeypatch.setattr(log_second_order, "settled", settled)
    monkeypatch.setattr(log_second_order, "widened", lambda _r, _f, _s, found: found)
    monkeypatch.setattr(type(LAG), "unknown", lambda self, _: Unknown(self.name, 0.0))
    last, own = known((SMOOTHING, 2e-3, 1e-3), found=[SMOOTHING])
    last.capture, last.measured = "run", [SimpleNamespace(values=np.zeros(1000))]
    before = [last], replace(solution(100.0), own=(own,))
    assert log_second_order.taken(before, NAMES, {}, {}) is before
    assert began == [pytest.approx((0.3 * 2e-3, 2e-3, 2.0)), pytest.approx((0.7 * 2e-3, 2e-3, 1.0))]
    began.clear()
    log_second_order.taken(before, ("R", "K"), {"L": 3.0}, {})
    assert [L for *_, L in began] == [2.0, 2.0]
    began.clear()
    unsure, own = known((SMOOTHING, 2e-3, 1e-3))
    log_second_order.taken(([unsure], replace(solution(1.0), own=(own,))), NAMES, {}, {})
    assert began == []


@pytest.mark.parametrize(("size", "worse", "dropped"), [(1e-7, 6.8, True), (1e-7, 7.0, False),
                                                        (3e-6, 0.0, False)])  # fmt: skip
def test_a_second_order_of_no_size_is_no_unknown_any_more(
    size: float, worse: float, dropped: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of 2 ms that were expected, a thousandth is none; ln 1000 = 6.91."""
    bent = Instance(SECOND_ORDER[CURRENT_SMOOTHING])
    last, own = known((SMOOTHING, 2e-3, 1e-3), (bent, size, 2e-3), found=[SMOOTHING, bent])
    last.capture, last.rivals = "run", (Rival(np.zeros(3), 50.0),)
    given: list[Any] = []

    class Fresh(SimpleNamespace):
        def propagate(self, *gone: Instance) -> None:
            given.append(gone)

    def fresh(*_: Any) -> Fresh:
        return Fresh(found={SMOOTHING, bent}, measured=[SimpleNamespace(values=np.zeros(1000))])

    monkeypatch.setattr(log_second_order, "MotorRecord", fresh)
    monkeypatch.setattr(log_second_order, "like", lambda _, records: records)
    monkeypatch.setattr(log_second_order, "settled", lambda *_: solution(100.0 + worse))
    before = [last], replace(solution(100.0), own=(own,))
    found = log_second_order.without_vanished(before, NAMES, {}, {})
    assert (found is not before) is dropped
    if dropped:
        assert given == [(bent,)]
        assert found[0][0].found == {SMOOTHING}
        assert [r.behind for r in found[0][0].rivals] == [pytest.approx(50.0 - worse)]
