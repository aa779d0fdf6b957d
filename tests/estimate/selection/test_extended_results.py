"""What a wider fit's sizes are stated as: by algebra, on an uncertain answer made by hand."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import Wiring
from motorid.estimate.model.extended_terms import ADDED, TERMS
from motorid.estimate.results.estimate import UNITS
from motorid.estimate.results.status import Status
from motorid.estimate.selection import extended_results as results
from motorid.estimate.selection import measurands
from motorid.estimate.solver.problem import Solution, Unknown
from motorid.estimate.uncertainty import intervals
from motorid.estimate.uncertainty.covariance import Statistical
from motorid.estimate.uncertainty.intervals import NORMAL_95, Findings

SIX = {"R": 2.0, "L": 3e-3, "K": 0.05, "B": 4e-5, "J": 2e-5, "T0": 6e-3}
LOG = {"R", "L", "K", "J"}


def findings(
    sizes: dict[str, float], deviations: dict[str, float], cause: dict[str, float] | None = None,
    bound: tuple[str, ...] = (), correlation: dict[tuple[str, str], float] | None = None,
) -> Findings:  # fmt: skip
    """Added parameters with their deviations in search coordinates; the six known to 1 %."""
    values = {**SIX, **sizes}
    log = {n: n in LOG or (n in ADDED and ADDED[n].log) for n in values}
    names = list(values)
    sd = np.array([deviations.get(n, 0.01 * (1.0 if log[n] else abs(values[n]))) for n in names])
    covariance = np.diag(sd**2)
    for (a, b), rho in (correlation or {}).items():
        i, j = names.index(a), names.index(b)
        covariance[i, j] = covariance[j, i] = rho * sd[i] * sd[j]
    solution = Solution(
        tuple(Unknown(n, v, log=log[n], scale=abs(v) or 1.0) for n, v in values.items()),
        np.array(list(values.values())), (), (), np.linalg.inv(covariance),
        np.array([n in bound for n in names]), tuple, 0.0, 1, True,
    )  # fmt: skip
    known = Statistical(covariance, np.full(len(names), np.inf), 1.0, False,
                        {"noise": np.diag(covariance)})  # fmt: skip
    shifts = {"cause": np.array([(cause or {}).get(n, 0.0) for n in names])}
    return Findings(solution, known, shifts, {}, ())


def fitted(*names: str, **values: float) -> Any:
    capture = SimpleNamespace(
        stated=SimpleNamespace(nameplate={"rated_current_a": 2.0}), wiring=Wiring(pwm_hz=20e3)
    )
    return SimpleNamespace(
        terms=tuple(TERMS[n] for n in names), values={**SIX, **values},
        records=[SimpleNamespace(capture=capture)],
    )  # fmt: skip


def test_a_size_has_noise_and_instruments_and_an_interval_of_both() -> None:
    found = findings({"T_lc": 2.0}, {"T_lc": 0.3}, {"T_lc": 0.4})
    p = results.parameters(found, fitted("quadratic-load"))["T_lc"]
    assert (p.value, p.statistical, p.instrument, p.total) == pytest.approx((2.0, 0.3, 0.4, 0.5))
    assert p.interval_95 == pytest.approx((2.0 - NORMAL_95 * 0.5, 2.0 + NORMAL_95 * 0.5), rel=1e-3)
    assert p.status is Status.ESTIMATED
    assert p.unit == ADDED["T_lc"].unit


def test_a_positive_size_has_a_factor_for_its_interval() -> None:
    found = findings({"V_b": 0.5, "i_b": 0.2}, {"V_b": 0.02, "i_b": 0.1})
    p = results.parameters(found, fitted("brush-drop"))["i_b"]
    assert p.statistical == pytest.approx(0.2 * 0.1)
    factor = np.exp(NORMAL_95 * 0.1)
    assert p.interval_95 == pytest.approx((0.2 / factor, 0.2 * factor), rel=1e-3)


def test_a_lower_end_is_not_below_the_bound() -> None:
    found = findings({"V_b": 0.5, "i_b": 0.2}, {"V_b": 0.3, "i_b": 0.1})
    p = results.parameters(found, fitted("brush-drop"))["V_b"]
    assert p.interval_95 is not None
    assert p.interval_95[0] == 0.0
    sided = findings({"d_T0": 0.1}, {"d_T0": 0.03})
    low, high = results.parameters(sided, fitted("direction"))["d_T0"].interval_95 or (0, 0)
    assert (low, high) == pytest.approx((0.1 - 0.0588, 0.1 + 0.0588), abs=1e-3)


def test_what_is_at_its_bound_is_none_and_its_shape_means_nothing() -> None:
    found = findings({"V_b": 0.0, "i_b": 0.2}, {"V_b": 0.03, "i_b": 0.1}, bound=("V_b",))
    all_of = results.parameters(found, fitted("brush-drop"))
    size, shape = all_of["V_b"], all_of["i_b"]
    assert (size.value, size.status) == (0.0, Status.AT_BOUND)
    assert size.interval_95 == pytest.approx((0.0, NORMAL_95 * 0.03), rel=1e-3)
    assert shape.value is None
    assert shape.note == "it means nothing without V_b"


@pytest.mark.parametrize("name", ["T_lc", "i_b"])
def test_what_is_too_uncertain_is_not_given(name: str) -> None:
    log = ADDED[name].log
    limit = intervals.UNKNOWN if log else intervals.UNKNOWN_FRICTION
    term = "brush-drop" if log else "quadratic-load"
    for share, given in ((0.97, True), (1.03, False)):
        sd = share * limit * (1.0 if log else 2.0)
        sizes = {"V_b": 1.0, "i_b": 2.0} if log else {"T_lc": 2.0}
        p = results.parameters(findings(sizes, {name: sd}), fitted(term))[name]
        assert (p.value is not None) is given
    assert p.note.startswith(results.UNTOLD)
    assert (": below" in p.note) is not log
    if not log:
        assert f"{2.0 + NORMAL_95 * sd:.2g} {ADDED[name].unit}" in p.note


def test_a_count_is_a_whole_number_that_was_given() -> None:
    p = results.parameters(findings({"T_c": 0.1}, {}), fitted("cogging", N_c=7.0))["N_c"]
    assert (p.value, p.status, p.total) == (7.0, Status.FIXED, 0.0)
    assert (p.statistical, p.instrument) == (0.0, 0.0)
    assert p.interval_95 == (7.0, 7.0)


def test_a_heat_capacity_is_one_over_what_was_searched() -> None:
    found = findings({"per_C_w": 0.25, "k_w": 0.1}, {"per_C_w": 0.01, "k_w": 0.001})
    out = results.parameters(found, fitted("heating"))
    p = out["C_w"]
    assert (p.value, p.unit) == (4.0, "J/K")
    assert p.statistical == pytest.approx(0.01 / 0.25**2)
    chain = findings({"per_C_w": 0.25, "k_w": 0.1}, {}, {"per_C_w": 0.02})
    by_chain = results.parameters(chain, fitted("heating"))["C_w"].instrument
    assert by_chain == pytest.approx(0.02 / 0.25**2)
    assert "per_C_w" not in out
    cold = findings({"per_C_w": 0.0, "k_w": 0.1}, {"per_C_w": 0.01, "k_w": 0.001})
    out = results.parameters(cold, fitted("heating"))
    assert out["C_w"].value is None
    assert out["k_w"].note == "it means nothing without C_w"


def test_two_masses_are_parts_of_the_inertia_whose_errors_oppose_each_other() -> None:
    sizes = {"J2_share": 0.25, "Ks": 3.0, "b": 0.1}
    rho = {("J", "J2_share"): 0.6}
    found = findings(sizes, {"J2_share": 0.02, "J": 0.03}, correlation=rho)
    out = results.parameters(found, fitted("two-masses"))
    J, share = SIX["J"], 0.25
    for name, value, sign in (("J1", J * 0.75, -1.0), ("J2", J * 0.25, 1.0)):
        gradient = np.array([value, sign * J])
        cov = np.array([[0.03**2, 0.6 * 0.03 * 0.02], [0.6 * 0.03 * 0.02, 0.02**2]])
        assert out[name].value == pytest.approx(value)
        assert out[name].statistical == pytest.approx(np.sqrt(gradient @ cov @ gradient))
    assert share * J == pytest.approx(out["J2"].value)
    assert "J2_share" not in out


@pytest.mark.parametrize(("size", "stands"), [(1.99, False), (2.01, True), (-2.01, True)])
def test_a_size_stands_out_by_four_of_its_total_uncertainties(size: float, stands: bool) -> None:
    found = findings({"d_T0": size}, {"d_T0": 0.3}, {"d_T0": 0.4})
    assert results.stands_out(found, TERMS["direction"]) is stands


@pytest.mark.parametrize(("size", "stands"), [(1.49, False), (1.51, True)])
def test_of_brushes_which_every_motor_has_three_suffice(size: float, stands: bool) -> None:
    found = findings({"V_b": size, "i_b": 0.2}, {"V_b": 0.3, "i_b": 1.0}, {"V_b": 0.4})
    assert results.stands_out(found, TERMS["brush-drop"]) is stands


def test_a_size_whose_shape_is_open_stands_out_at_that_shape() -> None:
    rho = {("V_b", "i_b"): 0.9}
    found = findings({"V_b": 1.0, "i_b": 0.2}, {"V_b": 0.5, "i_b": 1.0}, correlation=rho)
    assert results.stands_out(found, TERMS["brush-drop"])  # 0.5 sqrt(1 - .81) = .22
    alone = findings({"V_b": 1.0, "i_b": 0.2}, {"V_b": 0.5, "i_b": 1.0})
    assert not results.stands_out(alone, TERMS["brush-drop"])


def test_the_lack_of_both_fits_is_their_rms_by_channel() -> None:
    block = SimpleNamespace(name="current")
    narrow: Any = SimpleNamespace(
        measured=[SimpleNamespace(block=block)], departures=lambda *_: [np.array([3.0, -4.0])]
    )
    wide = SimpleNamespace(departures=lambda *_: [np.array([1.0, 1.0])])
    before: Any = SimpleNamespace(values=None, own=[None])
    fit: Any = SimpleNamespace(records=[wide], solution=before)
    (one,) = results._lack_of_fit(fit, [narrow], before)
    assert (one.capture, one.channel, one.unit) == (0, "current", "A")
    assert (one.before, one.after) == pytest.approx((np.sqrt(12.5), 1.0))


# iron: K and L elsewhere


def test_iron_states_k_and_l_where_they_are_used() -> None:
    sizes = {"a_K": 0.1, "i_K": 0.5, "L2_share": 0.4, "t_e": 2e-4}
    found = findings(sizes, {"a_K": 0.01, "K": 0.02, "L": 0.03}, {"K": 0.04})
    fit = fitted("armature-reaction", "eddy", **sizes)
    out = measurands.stated(found, fit)
    values = {**SIX, **sizes}
    assert out["K_rated"].value == pytest.approx(measurands.torque_constant(values, 2.0))
    assert out["L_rated"].value == pytest.approx(SIX["L"])
    assert out["L_1kHz"].value == pytest.approx(measurands.inductance(values, 0.0, 1e3))
    assert out["L_pwm"].value == pytest.approx(measurands.inductance(values, 0.0, 20e3))
    bend = np.hypot(2.0, 0.5) - 0.5
    by_K, by_a = out["K_rated"].value * 0.02, SIX["K"] * bend * 0.01
    by_knee = SIX["K"] * 0.1 * (0.5 / np.hypot(2.0, 0.5) - 1.0) * 0.5 * 0.01
    noise = np.sqrt(by_K**2 + by_a**2 + by_knee**2)
    assert out["K_rated"].statistical == pytest.approx(noise, rel=1e-3)
    assert out["K_rated"].instrument == pytest.approx(out["K_rated"].value * 0.04, rel=1e-3)
    assert out["L_rated"].statistical == pytest.approx(SIX["L"] * 0.03, rel=1e-3)
    assert measurands.stated(found, fitted("direction")) == {}


def test_constants_of_a_motor_whose_iron_is_unknown_in_part() -> None:
    """A fall from the first ampere on; an inductance that nothing takes."""
    assert measurands.torque_constant({"K": 2.0, "a_K": 0.1}, -3.0) == pytest.approx(1.4)
    assert measurands.torque_constant({"K": 2.0, "i_K": 5.0}, 3.0) == 2.0
    assert measurands.inductance({"L": 2.0}, 3.0, 1e4) == 2.0
    assert measurands.inductance({"L": 2.0, "d_L": 0.5}, 1.0) == pytest.approx(1.5)
    slow = {"L": 2.0, "L2_share": 0.5, "t_e": 1.0 / (2.0 * np.pi)}  # at 1 Hz it is halved
    assert measurands.inductance(slow, 9.0, 1.0) == pytest.approx(1.5)
    assert measurands.inductance(slow, 9.0, 0.0) == 2.0


def test_what_nobody_stated_is_asked_for() -> None:
    found = findings({"a_K": 0.1, "i_K": 0.5}, {})
    fit = fitted("armature-reaction", a_K=0.1, i_K=0.5)
    fit.records[0].capture.stated.nameplate = {}
    fit.records[0].capture.wiring = Wiring()
    out = measurands.stated(found, fit)
    assert out["K_rated"].note == out["L_rated"].note == measurands.NO_CURRENT
    assert out["L_pwm"].note == measurands.NO_PWM
    assert out["L_1kHz"].value is not None


def test_a_figure_that_is_too_uncertain_is_not_given() -> None:
    fit = fitted("armature-reaction", a_K=0.1, i_K=0.5)
    for share, given in ((0.97, True), (1.03, False)):
        found = findings({"a_K": 0.1, "i_K": 0.5}, {"L": share * intervals.UNKNOWN})
        assert (measurands.stated(found, fit)["L_1kHz"].value is not None) is given


@pytest.mark.parametrize("term", TERMS)
def test_what_is_stated_has_its_own_name_and_unit(term: str) -> None:
    sizes = dict.fromkeys(TERMS[term].free, 0.5)
    found = findings(sizes, dict.fromkeys(sizes, 0.01))
    counted = {TERMS[term].per_turn: 7.0} if TERMS[term].per_turn else {}
    for fit in (fitted(term, **counted, **sizes), fitted(term, **counted)):
        for name, p in {**results.parameters(found, fit), **measurands.stated(found, fit)}.items():
            assert p.name == name
            if name in ADDED:
                assert p.unit == ADDED[name].unit
            elif name in UNITS:
                assert p.unit == UNITS[name]
            elif name.partition("_")[0] in UNITS:
                assert p.unit == UNITS[name.partition("_")[0]]
            if p.interval_95 is not None and p.value is not None:
                assert p.interval_95[0] <= p.value <= p.interval_95[1]
