"""Where a fit with terms begins: its scales, what is known of shapes, and what is held."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.errors import DataError
from motorid.estimate.model.extended_terms import ADDED, TERMS, Scales
from motorid.estimate.selection import extended_fit
from motorid.estimate.selection.extended_fit import Begun, Fitted
from motorid.estimate.solver.problem import Solution, Unknown

SIX = {"R": 2.0, "L": 4e-3, "K": 0.05, "B": 4e-5, "J": 2e-5, "T0": 6e-3}
SIZES = Scales(
    volts=12.0, current=3.0, speed=400.0, torque=0.02, resistance=4.0, inertia=1e-6,
    inductance=2e-4, duration=0.5,
)  # fmt: skip


def solution(**values: float) -> Solution:
    found = {**SIX, **values}
    n = len(found)
    return Solution(
        tuple(Unknown(name, v, log=name in "RLKJ") for name, v in found.items()),
        np.array(list(found.values())), (np.array([0.5]),), (), 100.0 * np.eye(n),
        np.zeros(n, dtype=bool), tuple, 5.0, 1, True,
    )  # fmt: skip


def test_scales_are_those_of_the_busiest_capture(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(extended_fit, "typical", lambda *_: (0.02, 300.0))
    lines = [SimpleNamespace(count=n, period_s=h) for n, h in ((400, 1e-3), (100, 1e-2))]
    records: Any = [
        SimpleNamespace(volts=np.array(volts), timeline=line)
        for volts, line in zip(([0.0, -9.0], [4.0, 6.0]), lines, strict=True)
    ]
    assert extended_fit.scales_of(records, SIX) == Scales(
        9.0, 4.5, 300.0, 0.02, 2.0, 2e-5, 4e-3, 1.0
    )
    idle: Any = [SimpleNamespace(volts=np.zeros(4), timeline=records[0].timeline)]
    assert extended_fit.scales_of(idle, SIX).volts == 1.0


def test_shapes_are_known_to_a_factor_and_heat_by_what_any_motor_stands() -> None:
    """About where a search begins with them: a standard deviation is a factor of a few."""
    known = extended_fit._known(SIZES)
    for name in ("i_b", "w_s", "i_K", "i_L", "t_e"):
        mean, sd = known[name]
        assert np.exp(mean) == pytest.approx(ADDED[name].part * SIZES.of(name))
        assert 2.0 < np.exp(sd) < 5.0
        assert ADDED[name].log
    mean, sd = known["per_C_w"]
    assert mean == 0.0
    stalled_w = SIZES.volts * SIZES.current
    assert 2 * sd * stalled_w == pytest.approx(150.0)  # K/s: no motor heats up faster
    assert known["k_w"] == (0.0, 0.5)


def test_a_start_is_no_end_of_what_a_parameter_may_be() -> None:
    assert extended_fit._within("c_load", 5.0) == pytest.approx(0.8 * 0.9)
    assert extended_fit._within("c_load", -5.0) == 0.0
    assert extended_fit._within("c_load", 0.3) == 0.3
    assert extended_fit._within("d_T0", -5.0) == -1.0
    assert extended_fit._within("T_lc", 1e9) == 1e9


class Wide:
    """A record under a wider model, that notes where it begins."""

    def __init__(self, record: Any, free: Any, fixed: Any, terms: Any, scales: Any, known: Any,
                 first: bool) -> None:  # fmt: skip
        self.record, self.free, self.fixed, self.first = record, tuple(free), fixed, first
        self.terms, self.known = terms, known
        self.unknowns = (Unknown("offset", 0.5),)

    def starting(self, sizes: Any) -> None:
        self.sizes = sizes

    def plan(self, values: Any, own: Any) -> None:
        self.planned = dict(zip(self.free, values.tolist(), strict=True)), own.tolist()


def begun(monkeypatch: pytest.MonkeyPatch, *names: str, before: Solution | None = None,
          **how: Any) -> Begun:  # fmt: skip
    monkeypatch.setattr(extended_fit, "WideRecord", Wide)
    monkeypatch.setattr(extended_fit, "scales_of", lambda *_: SIZES)
    record: Any = SimpleNamespace(unknowns=(Unknown("offset", 0.0),))
    terms = [TERMS[n] for n in names]
    return extended_fit.begin([record], before or solution(), terms, **how)


def test_terms_begin_at_their_part_of_the_scale_beside_the_six(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found = begun(monkeypatch, "brush-drop", own=[{"phase": 2.0}])
    assert found.free == (*SIX, "V_b", "i_b")
    assert found.start["V_b"] == pytest.approx(0.01 * 12.0)
    assert found.start["i_b"] == pytest.approx(0.05 * 3.0)
    assert {n: found.start[n] for n in SIX} == SIX
    (one,) = found.records
    made: Any = one
    assert made.sizes == {"offset": 0.5, "phase": 2.0}
    assert made.first
    assert made.planned[0]["V_b"] == found.start["V_b"]
    assert made.planned[1] == [0.5]
    assert set(made.known) == {"i_b", "w_s", "i_K", "i_L", "t_e", "per_C_w", "k_w", "w_R", "r_f"}
    assert made.known["w_R"] == (0.0, 0.5 * 400.0)
    assert made.known["r_f"] == (0.0, 5.0 / 0.5)


def test_what_is_held_is_not_searched_and_a_start_goes_before_a_part(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    start = {"V_b": 9.0, "R": 7.0, "J": 3.0}
    found = begun(monkeypatch, "brush-drop", fixed={"T0": 0.0, "J": 1e-5}, start=start,
                  priors={"i_b": (1.0, 2.0)})  # fmt: skip
    assert found.free == ("R", "L", "K", "B", "V_b", "i_b")
    assert found.start["R"] == 7.0
    assert found.start["V_b"] == 9.0
    assert (found.start["T0"], found.start["J"]) == (0.0, 1e-5)
    made: Any = found.records[0]
    assert made.fixed == {"T0": 0.0, "J": 1e-5}
    assert made.known["i_b"] == (1.0, 2.0)


def test_a_count_is_given_and_a_term_that_goes_takes_its_values_along(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    before = solution(T_lc=0.3, T_c=0.01)
    found = begun(monkeypatch, "cogging", before=before, start={"N_c": 7.0})
    assert found.free == (*SIX, "T_c")
    assert found.start["N_c"] == 7.0
    assert found.start["T_c"] == 0.01
    assert "T_lc" not in found.start


def test_a_rough_fit_that_no_motor_follows_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: dict[str, Any] = {}

    def maximise(_u: Any, _r: Any, **how: Any) -> Solution:
        asked.update(how)
        return solution(R=9.0)

    monkeypatch.setattr(extended_fit, "unknowns_of", lambda *_: [])
    monkeypatch.setattr(extended_fit, "maximise", maximise)
    one = Begun((TERMS["direction"],), (), tuple(SIX), {**SIX, "extra": 1.0})
    rough = one.followed()
    assert rough is not None
    assert asked == {"max_iterations": extended_fit.ROUGH_STEPS, "enough": 1.0}
    assert rough.values == {**SIX, "R": 9.0, "extra": 1.0}

    def fails(*_: Any, **__: Any) -> Solution:
        raise DataError("no motor")

    monkeypatch.setattr(extended_fit, "maximise", fails)
    assert one.followed() is None


def test_a_deviation_is_in_the_parameters_own_unit() -> None:
    fitted = Fitted((), (), solution(), tuple(SIX), SIX)
    assert fitted.deviation("R") == pytest.approx(0.1 * 2.0)
    assert fitted.deviation("T0") == pytest.approx(0.1)
    assert fitted.model == ((), fitted.solution, SIX)
    bound = solution()
    bound.at_bound[3] = True
    assert Fitted((), (), bound, tuple(SIX), SIX).deviation("B") == np.inf
