"""``motorid fit --method NAME`` on captures that obey the fit's own equations."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import VOLTAGE
from motorid.errors import DataError, UsageError
from motorid.search.fit import fit as search_fit
from motorid.search.fit import names
from tests.exact_capture import FAULHABER, Plan, clean_capture, noisy
from tests.six_parameters import fit


@pytest.fixture(scope="module")
def capture():
    plan = Plan(volts=(6.0, 3.0, 4.5), count=6000)
    return noisy(clean_capture(FAULHABER, plan), seed=1, current_a=2e-3, angle_rad=2e-3)


@pytest.fixture(scope="module")
def likely(capture):
    return fit([capture])


@pytest.mark.slow
def test_nls_ends_near_the_likelihoods_maximum(capture, likely):
    found = fit([capture], method="nls")
    for name, parameter in likely.parameters.items():
        assert found.parameters[name].value == pytest.approx(parameter.value, rel=0.02), name
        assert 0 < found.parameters[name].total < 0.1 * parameter.value
    assert found.evaluations <= 5000
    assert found.options["method"] == "nls"


@pytest.mark.slow
@pytest.mark.parametrize("method", ["de-best-1-bin", "pso-ciw", "tlbo", "aco", "de-aco"])
def test_a_population_search_finds_the_motor(capture, method):
    found = search_fit([capture], method, budget=6000, seed=2)
    values = {name: parameter.value for name, parameter in found.parameters.items()}
    for name in ("R", "K", "J"):
        assert values[name] == pytest.approx(FAULHABER[name], rel=0.1), name
    # so few evaluations share friction out between B and T0 by chance; their sum is found
    whole = [m["T0"] + 400.0 * m["B"] for m in (values, FAULHABER)]
    assert whole[0] == pytest.approx(whole[1], rel=0.1)
    assert found.evaluations == 6000
    assert found.options["seed"] == 2
    assert any(d.code == "search" for d in found.diagnostics)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["steady-state", "acceleration"])
def test_closed_forms_find_the_motor(capture, method):
    found = fit([capture], method=method)
    for name, part in (("R", 0.03), ("K", 0.01), ("J", 0.1)):
        assert found.parameters[name].value == pytest.approx(FAULHABER[name], rel=part), name


@pytest.mark.slow
@pytest.mark.parametrize("model", [{}, {"model": "quadratic-load"}])
def test_a_search_says_what_it_does_not_know_of_a_logs_voltage(capture, model):
    instant = replace(capture.channels[VOLTAGE], kind="instant", aperture_s=0.0)
    log = replace(capture, program=None, phases=(), channels={**capture.channels, VOLTAGE: instant})
    codes = [
        {d.code for d in search_fit([c], "nls", **model, budget=30, seed=0).diagnostics}
        for c in (capture, log)
    ]
    assert ["voltage_between_stamps" in found for found in codes] == [False, True]


@pytest.mark.slow
def test_an_answer_far_from_the_minimum_says_so(capture):
    found = search_fit([capture], "abc", budget=60, seed=0)
    (said,) = [d for d in found.diagnostics if d.code == "not_the_minimum"]
    assert "intervals do not include" in said.message


@pytest.mark.slow
def test_nls_without_noise_has_next_to_nothing_left_to_gain():
    found = fit([clean_capture(FAULHABER, Plan(count=3000))], method="nls")
    for name, value in FAULHABER.items():
        assert found.parameters[name].value == pytest.approx(value, rel=0.02), name


@pytest.mark.slow
def test_the_m_methods_say_that_friction_went_into_b(capture):
    found = search_fit([capture], "jaya-m", budget=3000)
    assert any(d.code == "linear_model" for d in found.diagnostics)
    assert found.parameters["T0"].status == "fixed"
    (ended,) = [d.message for d in found.diagnostics if d.code == "search"]
    assert float(re.search(r"3000 evaluations \((.+) % answered from memory\)", ended)[1]) > 1.0
    assert found.parameters["K"].value == pytest.approx(FAULHABER["K"], rel=0.05)


@pytest.mark.slow
def test_fixed_and_left_out_parameters_stay(capture):
    found = fit([capture], method="nls", fix={"K": 7.68e-3}, without=["L"])
    assert found.parameters["K"].status == "fixed"
    assert found.parameters["L"].value == 0.0
    assert found.parameters["R"].value == pytest.approx(FAULHABER["R"], rel=0.05)


@pytest.mark.slow
def test_seeds_repeat(capture):
    first, again = (search_fit([capture], "gwo", budget=900, seed=7) for _ in range(2))
    assert [p.value for p in first.parameters.values()] == [
        p.value for p in again.parameters.values()
    ]


@pytest.mark.slow
def test_unknown_names_and_unfit_requests_are_refused(capture):
    with pytest.raises(UsageError, match="did you mean 'jaya'"):
        fit([capture], method="jayaa")
    with pytest.raises(UsageError, match="takes no fixed"):
        fit([capture], method="gwo-m", fix={"K": 7.68e-3})
    with pytest.raises(UsageError, match="one capture"):
        fit([capture, capture], method="jaya-m")
    with pytest.raises(UsageError, match="takes no fixed"):
        fit([capture], method="steady-state", without=["L"])
    one_level = clean_capture(FAULHABER, Plan(volts=(6.0,), count=3000))
    with pytest.raises(DataError, match="two voltage levels"):
        fit([one_level], method="steady-state")


def test_every_named_method_is_listed_once():
    assert len(set(names())) == len(names())
    assert {"steady-state", "acceleration", "nls", "steiglitz-mcbride", "de-aco"} <= set(names())
    assert np.all([name == name.lower() for name in names()])
