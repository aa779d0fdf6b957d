"""The better model on the simulated rig, whose plant shares no code with it.

The study over seeds is bench/bench_wider.py.
"""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from motorid.acquire.record import capture as record
from motorid.capture import store
from motorid.capture.model import Capture
from motorid.errors import DataError, UsageError
from motorid.estimate.effects.brush_and_heating import lossless
from motorid.estimate.fit import joint_fit, multistart
from motorid.estimate.fit.parameter_bounds import merged
from motorid.estimate.model.extended_terms import TERMS
from motorid.estimate.results.estimate import PARAMETERS, Estimate
from motorid.estimate.selection import entry, extended_results
from motorid.estimate.uncertainty import errors_in_variables
from motorid.estimate.uncertainty.budget import of_priors
from motorid.estimate.uncertainty.covariance import statistical
from motorid.program import Decay, Program, Step, StepKind
from motorid.report import html, json_, text
from motorid.rig import Sampling, load_rig
from motorid.sim import truth
from tests.six_parameters import fit

SLOW = Decay.SYNCHRONOUS_SLOW
DRIVES = tuple(Step(StepKind.DRIVE_VOLTS, 0.1, volts, SLOW) for volts in (2.0, 5.0))
ONE_WAY = Program((Step(StepKind.COAST, 0.02), *DRIVES, Step(StepKind.COAST, 0.7)))
CHANNELS = ("current", "terminal_voltage", "position")


def url(options: str) -> str:
    return f"{load_rig('sim').port}&speed=max&seed=4&heating=0&{options}"


@cache
def measured(folder: Path, options: str) -> Capture:
    """A capture of the simulated rig."""
    rig = load_rig("sim")
    rig = replace(rig, port=url(options), program=ONE_WAY, sampling=Sampling(5000.0, CHANNELS))
    return store.load(record(rig, rig.program, folder / "run.h5", force=True))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("wider")


def brushes(folder: Path, model: str) -> Estimate:
    return fit([measured(folder, "stiction=1&brush_drop=0.2")], model=model)


def within(estimate: Estimate, options: str) -> list[str]:
    """The six of the better model whose intervals miss the truth."""
    true, better = truth(url(options)), estimate.alternative
    assert better is not None
    missed = []
    for name in PARAMETERS:
        low, high = better.parameters[name].interval_95
        missed += [] if low <= true[name] <= high else [name]
    return missed


@pytest.mark.slow
def test_brush_drop_is_found_and_what_it_biased_is_put_right(folder: Path) -> None:
    estimate = brushes(folder, "auto")
    assert estimate.alternative is not None
    assert estimate.alternative.terms == ("brush-drop",)
    assert not estimate.alternative.asked
    drop = estimate.alternative.parameters["V_b"]
    assert drop.value == pytest.approx(0.2, rel=0.03)
    assert within(estimate, "stiction=1&brush_drop=0.2") == []
    true, six = truth(url(""))["R"], estimate.parameters["R"]
    assert six.interval_95[0] < true < six.interval_95[1]  # the drop is a nuisance of the six
    channels = measured(folder, "stiction=1&brush_drop=0.2").channels
    for fitted in estimate.alternative.lack_of_fit:  # nothing is left but noise
        one = channels["terminal_voltage" if fitted.channel == "back_emf" else fitted.channel]
        assert fitted.after < 1.25 * max(one.noise, one.resolution / 12**0.5)
        assert fitted.after < fitted.before
    said = {d.code: d.severity for d in estimate.diagnostics}
    assert said["better_model"] == "info"  # the six allow for it


@pytest.mark.slow
def test_what_no_residual_shows_of_the_voltage_is_in_the_wider_intervals_too(folder: Path) -> None:
    """Readings that drive the motor as read: their noise is in R, and in the size of a drop."""
    bare = lossless(measured(folder, "stiction=1&brush_drop=0.2"))
    records, solution = joint_fit.solved([bare], {}, ())
    values = merged({}, solution)
    fitted = entry.asked_for(records, solution, values, (TERMS["brush-drop"],))
    known = of_priors(fitted.solution, fitted.records)
    shown = statistical(fitted.solution, known).deviations
    told = extended_results.findings(fitted, {}, ()).statistical.deviations
    unseen = errors_in_variables.hidden(fitted.solution, fitted.records)
    added = sum(error.shared**2 for error in unseen)
    np.testing.assert_allclose(told**2, shown**2 + added, rtol=1e-9)
    for name in ("R", "V_b"):
        assert added[fitted.free.index(name)] > 0.2 * shown[fitted.free.index(name)] ** 2


@pytest.mark.slow
def test_the_report_shows_both_answers_in_every_form(folder: Path) -> None:
    estimate = brushes(folder, "brush-drop")
    data = json.loads(json_.dumps(estimate))
    jsonschema.validate(data, json_.schema())
    six, better = data["parameters"]["R"]["value"], data["alternative"]["parameters"]["R"]["value"]
    assert better == pytest.approx(six, rel=0.01)  # the six allow for a drop; this says how large
    assert data["alternative"]["asked"]
    assert [model["chosen"] for model in data["models"]] == [True, False]
    for form in (text.render(estimate), html.render(estimate)):
        assert "six + brush-drop" in form
        assert "brush drop" in form


@pytest.mark.slow
def test_a_motor_without_effects_is_offered_nothing_and_nothing_is_fitted(folder: Path) -> None:
    estimate = fit([measured(folder, "stiction=1")], model="auto")
    assert estimate.alternative is None
    assert "model_tried" not in {d.code for d in estimate.diagnostics}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "fits"), [("stiction=1&dead_time=0", 0), ("stiction=1&brush_drop=0.2", 1)]
)
def test_a_fit_without_loss_is_made_only_where_loss_or_residuals_ask(
    folder: Path, monkeypatch: pytest.MonkeyPatch, options: str, fits: int
) -> None:
    """Brushes and heat are unknowns of the six already: most captures need no second fit."""
    made = []
    solve = multistart.solve
    monkeypatch.setattr(multistart, "solve", lambda *given: made.append(1) or solve(*given))
    fit([measured(folder, options)], model="auto")
    assert len(made) == fits


@pytest.mark.slow
def test_ripple_is_sized_and_an_open_bridge_shows_it(folder: Path) -> None:
    estimate = fit([measured(folder, "stiction=1&ripple=0.06")], model="ripple")
    assert estimate.alternative is not None
    found = estimate.alternative.parameters
    assert found["N_r"].value == 10.0
    assert found["k_K"].value == pytest.approx(0.06, rel=5e-3)
    (emf,) = (fitted for fitted in estimate.alternative.lack_of_fit if fitted.channel == "back_emf")
    assert emf.after < 0.15 * emf.before


@pytest.mark.slow
def test_all_terms_named_at_once_are_told_apart(folder: Path) -> None:
    """Sizes begin from one step for all of them: alone, each would explain the others' residuals.

    Heat is searched as what a joule does, which is nothing where nothing warms up.
    """
    options = (
        "brush_drop=0.15&quadratic=2e-10&stiction=2&stribeck=60&ripple=0.02"
        "&cogging=6e-4&cogging_per_turn=4"
    )
    terms = "brush-drop+quadratic-load+stribeck+ripple+cogging+heating"
    estimate = fit([measured(folder, options)], model=terms)
    assert estimate.alternative is not None
    found = estimate.alternative.parameters
    true = {"V_b": 0.15, "T_s": 4.3e-4, "w_s": 60.0, "k_K": 0.02, "T_c": 6e-4, "T_lc": 2e-10}
    for name, size in true.items():
        assert found[name].value == pytest.approx(size, rel=0.06), name
    assert (found["N_r"].value, found["N_c"].value) == (10.0, 4.0)
    assert found["C_w"].status == "not_identifiable"
    assert estimate.alternative.evaluations < 2500


@pytest.mark.slow
def test_cogging_above_the_friction_is_counted_and_sized(folder: Path) -> None:
    """It bends the start by more than a radian: the angle is the encoder's, not the model's."""
    options = "stiction=1&cogging=6e-4&cogging_per_turn=4"
    estimate = fit([measured(folder, options)], model="auto")
    assert estimate.alternative is not None
    assert estimate.alternative.terms == ("cogging",)
    assert estimate.alternative.parameters["N_c"].value == 4.0
    assert estimate.alternative.parameters["T_c"].value == pytest.approx(6e-4, rel=0.02)
    assert within(estimate, options) == []


@pytest.mark.slow
def test_a_ripple_that_moves_nothing_hides_no_windage(folder: Path) -> None:
    """The ripple explains ten times as much, and moves no parameter: B is what counts."""
    options = "stiction=1&ripple=0.01&quadratic=9e-11"  # 29 % of the viscous torque at no load
    estimate = fit([measured(folder, options)], model="auto")
    assert estimate.alternative is not None
    assert "quadratic-load" in estimate.alternative.terms
    assert within(estimate, options) == []
    assert estimate.alternative.parameters["T_lc"].value == pytest.approx(9e-11, rel=0.02)
    true = truth(url(options))
    for name in ("B", "T0"):  # the headline says that it may be wrong, and by how much
        six, better = estimate.parameters[name], estimate.alternative.parameters[name]
        assert six.status == "doubtful"
        assert six.interval_95[0] <= true[name] <= six.interval_95[1]
        assert six.interval_95[0] <= better.interval_95[0]
        assert six.interval_95[1] >= better.interval_95[1]


@pytest.mark.slow
def test_six_is_six_whatever_the_residuals_say(folder: Path) -> None:
    estimate = brushes(folder, "six")
    assert estimate.alternative is None
    assert estimate.parameters["R"].value == brushes(folder, "auto").parameters["R"].value


@pytest.mark.slow
def test_what_the_data_do_not_support_is_not_identifiable_in_the_wider_model(folder: Path) -> None:
    estimate = fit([measured(folder, "stiction=1")], model="stribeck")
    assert estimate.alternative is not None
    statuses = {estimate.alternative.parameters[n].status for n in ("T_s", "w_s")}
    assert statuses <= {"not_identifiable", "at_bound"}
    assert within(estimate, "stiction=1") == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("model", "says"),
    [("ke-kt", "hold one"), ("direction", "turns one way"), ("cogging", "do not repeat")],
)
def test_terms_that_a_capture_cannot_tell_are_refused(folder: Path, model: str, says: str) -> None:
    with pytest.raises(DataError, match=says):
        fit([measured(folder, "stiction=1")], model=model)


@pytest.mark.slow
def test_a_held_inertia_tells_both_constants_apart(folder: Path) -> None:
    """A current gain of 0.97 that nobody declares: torque for an ampere seems 3 % larger."""
    options = "stiction=1&gain_error=-0.03&gain_uncertainty=0"
    J = truth(url(options))["J"]
    estimate = fit([measured(folder, options)], model="ke-kt", fix={"J": J})
    assert estimate.alternative is not None
    assert estimate.alternative.parameters["d_Ke"].value == pytest.approx(-0.03, abs=0.004)


@pytest.mark.slow
def test_unknown_models_are_refused_with_the_nearest_name(folder: Path) -> None:
    with pytest.raises(UsageError, match="did you mean 'stribeck'"):
        fit([measured(folder, "stiction=1")], model="stribek")
    with pytest.raises(UsageError, match="no model"):
        fit([measured(folder, "stiction=1")], model="cogging+nothing")
