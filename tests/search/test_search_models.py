"""``--model``: quadratic load and two masses, on captures made by those models."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.capture import store
from motorid.cli.main import run
from motorid.errors import UsageError
from motorid.motor.batch import DRIVEN_TWO_MASS, Record, blank, quadratic
from motorid.search.fit import fit as search_fit
from motorid.search.review.as_capture import capture_of
from motorid.search.review.tables import table
from tests.six_parameters import fit

NOISE = 2e-3  # of a channel's peak
LOAD = {"R": "R", "L": "L", "K": "c", "B": "Tb", "J": "J", "T0": "Ta", "T_lc": "Tc"}
MASSES = {
    "R": 2.5, "L": 2e-3, "K": 0.05, "B": 1e-4, "J1": 2e-5, "J2": 3e-5, "Ks": 0.8, "b": 1e-4
}  # fmt: skip


def noisy(record, seed):
    rng = np.random.default_rng(seed)
    measured = {
        name: y + NOISE * np.abs(y).max() * rng.standard_normal(len(y))
        for name, y in record.measured.items()
    }
    return capture_of(Record(record.period_s, record.input, measured))


@pytest.fixture(scope="module")
def loaded():
    return noisy(table(4)[0].clean(), 1)


@pytest.fixture(scope="module")
def two_masses():
    chips = np.random.default_rng(3).permutation(np.repeat([0.0, 12.0], 60))
    volts = np.repeat(np.concatenate([[12.0], chips]), 10)
    channels = ("current", "speed")
    silent = Record(5e-4, volts, blank(volts, channels))
    values = np.array([list(MASSES.values())])
    outputs = DRIVEN_TWO_MASS.outputs(values, silent)[0]
    return noisy(Record(5e-4, volts, dict(zip(channels, outputs, strict=True))), 2)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["ml", "nls"])
def test_a_quadratic_load_is_found_within_its_uncertainty(loaded, method):
    found = search_fit([loaded], method, model="quadratic-load")
    truth = table(4)[0].truth
    assert list(found.parameters) == [*"RLKBJ", "T0", "T_lc"]
    for name, theirs in LOAD.items():
        p = found.parameters[name]
        assert p.status == "estimated", name
        assert p.value == pytest.approx(truth[theirs], rel=0.05), name
        assert abs(p.value - truth[theirs]) < 4.0 * p.total, name
    assert found.options["model"] == "quadratic-load"


@pytest.mark.slow
@pytest.mark.parametrize("method", ["ml", "nls"])
def test_two_masses_are_found_within_their_uncertainty(two_masses, method):
    found = search_fit([two_masses], method, model="two-masses", seed=1)
    assert list(found.parameters)[6:] == ["J1", "J2", "Ks", "b"]
    for name, true in {**MASSES, "J": MASSES["J1"] + MASSES["J2"]}.items():
        p = found.parameters[name]
        assert p.value == pytest.approx(true, rel=0.05), name
        assert abs(p.value - true) < 4.0 * p.total, name
    assert found.parameters["T0"].status == "fixed"
    assert any(d.code == "linear_model" for d in found.diagnostics)


@pytest.mark.slow
def test_a_population_search_takes_the_model_budget_and_seed(loaded):
    first, again, other = (
        search_fit([loaded], "pso-ci", model="quadratic-load", budget=900, seed=seed)
        for seed in (3, 3, 4)
    )
    assert first.evaluations == 900
    assert first.parameters["K"].value == again.parameters["K"].value
    assert first.parameters["K"].value != other.parameters["K"].value
    assert "seed 3" in first.method


@pytest.mark.slow
def test_fixed_and_left_out_parameters_of_a_model_stay(loaded):
    found = fit([loaded], method="nls", model="quadratic-load", fix={"R": 3.0}, without=["B"])
    assert found.parameters["R"].value == 3.0
    assert found.parameters["B"].value == 0.0
    assert {found.parameters[name].status for name in "RB"} == {"fixed"}


@pytest.mark.parametrize("method", ["gwo-m", "steiglitz-mcbride", "steady-state"])
def test_methods_of_the_linear_model_refuse_others(loaded, method):
    with pytest.raises(UsageError, match="knows the linear model only"):
        fit([loaded], method=method, model="quadratic-load")


def test_unfit_requests_are_refused_in_a_sentence(loaded):
    with pytest.raises(UsageError, match="did you mean 'two-masses'"):
        fit([loaded], method="nls", model="two-mases")
    with pytest.raises(UsageError, match="has no T0"):
        fit([loaded], method="nls", model="two-masses", without=["T0"])
    with pytest.raises(UsageError, match="ml takes no budget"):
        fit([loaded], budget=100)


def test_the_position_of_a_quadratic_load_is_the_integral_of_its_speed():
    model, volts = quadratic(substeps=4), np.repeat([45.0, -90.0, 0.0], 200)
    record = Record(5e-4, volts, blank(volts, ("speed", "position")))
    speed, position = model.outputs(np.array([list(table(4)[0].truth.values())]), record)[0]
    steps = 0.5 * record.period_s * (speed[1:] + speed[:-1])
    expected = np.concatenate([[0.0], np.cumsum(steps)])
    np.testing.assert_allclose(position, expected, atol=2e-3 * np.abs(position).max())


@pytest.mark.slow
def test_the_command_takes_budget_seed_and_model(tmp_path, capsys, loaded):
    store.save(loaded, tmp_path / "run.h5")
    options = ["--method", "jaya", "--model", "quadratic-load", "--budget", "300", "--seed", "5"]
    assert run(["fit", str(tmp_path / "run.h5"), *options]) == 0
    assert "300 evaluations, seed 5" in capsys.readouterr().out
    assert run(["fit", str(tmp_path / "run.h5"), "--budget", "200"]) != 0
    assert "ml takes no budget" in capsys.readouterr().err
