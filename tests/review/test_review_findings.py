"""What the review's printed numbers imply, against the equations: methods of arithmetic only."""

from __future__ import annotations

import re

import numpy as np
import pytest

from motorid.errors import UsageError
from motorid.search.relations import inertia, steady, steady_peak, step_facts
from motorid.search.review.remarks import printed_rule_bias, remarks, speed_mse, tied_r
from motorid.search.review.run import relative_to_estimate, relative_to_nominal
from motorid.search.review.speed_only import speed_numbers, speed_twin
from motorid.search.review.tables import PERCENT_ORDER, printed, table

TWIN = {"R": 1.0998, "L": 0.55, "K": 0.01155, "B": 0.1050, "J": 0.0105}
R, K, L, J, B = range(5)
CONSTRAINED = ("GWO_m", "Jaya_m", "CSO_o", "CSO_m")


def motor(number):
    return table(number)[0].truth


def test_the_speed_twin_of_table_6_turns_alike():
    truth = printed()["table6"]["value"]
    twin = speed_twin(truth, TWIN["L"], TWIN["J"])
    for name, value in TWIN.items():
        assert twin[name] == pytest.approx(value, rel=1e-4)
    assert speed_mse(twin, truth) < 1e-30
    assert speed_numbers(twin) == pytest.approx(speed_numbers(truth), rel=1e-12)
    with pytest.raises(ValueError, match="no motor"):
        speed_twin(truth, 10.0, 1.0)


def test_table_6_prints_errors_that_its_parameters_do_not_have():
    figures = printed()["table6"]
    truth = figures["value"]
    assert speed_mse(figures["pso-ci"], truth) == pytest.approx(6.76e-8, rel=0.01)
    assert speed_mse(figures["pso-ldw"], truth) == pytest.approx(4.79e-4, rel=0.01)
    assert speed_mse(figures["pso-ci"], truth) > 1e6 * figures["mse"]["pso-ci"]


@pytest.mark.parametrize("number", [8, 9])
def test_errors_of_tables_8_and_9_are_relative_to_the_estimate(number):
    """With R and B from K, R% follows from K%; only that convention fits every printed row."""
    truth = motor(number)
    a = truth["K"] ** 2 / (truth["R"] * truth["B"])
    for label in CONSTRAINED:
        for row in printed()[f"table{number}"][label]:
            assert row[B] == row[K], label
            low, high = row[K] - 0.0006, row[K] + 0.0006  # printed to three decimals
            reach = [tied_r(max(k, 0.0), a, sign) for k in (low, high) for sign in (1.0, -1.0)]
            assert min(reach) - 0.001 <= row[R] <= max(reach) + 0.001, (label, row)


def test_a_of_table_9_is_that_of_table_7s_motor():
    assert motor(9)["K"] ** 2 / (motor(9)["R"] * motor(9)["B"]) == pytest.approx(4.48820, rel=1e-5)


@pytest.mark.parametrize(("number", "recovered"), [(8, 0.2235), (9, 0.8092)])
def test_the_printed_rule_has_the_recovered_bias(number, recovered):
    assert abs(printed_rule_bias(number)) == pytest.approx(recovered, rel=0.01)


def test_jaya_m_test_4_is_the_printed_rules_bias_and_gone_with_the_exact_rule():
    experiment = table(9)[0]
    problem = experiment.problem(0.0, 0)
    facts = step_facts(problem.step, problem.acceleration)
    published = printed()["table9"]["Jaya_m"][3][J]
    assert published == 0.809
    assert abs(printed_rule_bias(9)) == pytest.approx(published, rel=0.02)
    nominal = np.array([experiment.truth["K"]])
    for rule, reach in (("exact", 1e-8), ("integral", 2e-3)):
        assert inertia(facts, rule, nominal)[0] == pytest.approx(experiment.truth["J"], rel=reach)


def test_relations_return_the_nominal_motor_from_its_k_and_l():
    experiment = table(9)[0]
    truth = experiment.truth
    problem = experiment.problem(0.0, 0)
    facts = step_facts(problem.step, problem.acceleration)
    whole = np.array(list(truth.values()))
    found = steady_peak(facts, "exact", np.array([[truth["K"], truth["L"]]]))[0]
    assert found == pytest.approx(whole, rel=1e-5)
    found = steady(facts, "exact", np.array([[truth["K"], truth["L"], truth["J"]]]))[0]
    assert found == pytest.approx(whole, rel=1e-5)


def test_the_printed_sign_of_equation_30_gives_a_negative_inertia():
    facts = step_facts(table(9)[0].problem(0.0, 0).step)
    k = motor(9)["K"]
    b = k * facts.current / facts.speed
    assert (b * facts.peak_speed - k * facts.peak_current) / facts.largest_acceleration < 0


def test_table_5s_friction_is_a_slip():
    figures = printed()["table5"]
    for method in ("pso", "pso-ciw", "pso-ci"):
        said = figures[f"{method}-percent"]["b"]
        assert relative_to_nominal(np.array(figures[method]["b"]), np.array(0.04)) == pytest.approx(
            said, abs=0.05
        )
    wrong = relative_to_nominal(np.array(figures["pso"]["b"]), np.array(0.055))
    assert wrong == pytest.approx(81.8, abs=0.05)


def test_table_7_mixes_its_conventions():
    figures = printed()["table7"]
    value, found, said = (
        figures[key] for key in ("value", "steiglitz-mcbride", "steiglitz-mcbride-percent")
    )

    def both(name):
        pair = np.array(found[name]), np.array(value[name])
        return float(relative_to_nominal(*pair)), float(relative_to_estimate(*pair))

    assert both("R")[1] == pytest.approx(said["R"], abs=0.006)
    assert both("K")[1] == pytest.approx(said["K"], abs=0.006)
    assert both("L")[0] == pytest.approx(said["L"], abs=0.006)
    assert both("B")[0] == pytest.approx(3.30, abs=0.005)
    assert min(abs(figure - said["B"]) for figure in both("B")) > 10


@pytest.mark.parametrize("number", range(2, 10))
def test_every_table_has_its_sentences(number):
    said = remarks(number)
    assert len(said) >= 3
    assert all(sentence.endswith(".") for sentence in said)
    assert not any(re.search(r"\b(nan|inf)\b", sentence) for sentence in said)
    assert len(set(PERCENT_ORDER)) == 5


def test_other_tables_are_refused():
    with pytest.raises(UsageError, match="no table 10"):
        table(10)
