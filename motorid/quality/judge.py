"""An estimate and a product -> a verdict. Pure: nothing but what the estimate carries is used."""

from __future__ import annotations

from dataclasses import replace

from motorid.estimate.results.estimate import PARAMETERS, Estimate
from motorid.estimate.results.status import Status
from motorid.quality.levels import dead_sensor, disagreement
from motorid.quality.limits import Limit
from motorid.quality.product import BETTER, Product
from motorid.quality.quantities import Context, quantity
from motorid.quality.verdict import Measurement, Outcome, Reading, Verdict, decide
from motorid.version import __version__

LACK = "lack_of_fit"
RUNS = "motor_runs"  # the measurement of a motor that did not
SUPPORTED = ("model_fits", "nothing_doubtful", "derived_as_measured")
NOT_GROUND = (*SUPPORTED, RUNS)  # what fails its limits fails also where these are not good


def judge(estimate: Estimate, limits: Product, *, serial: str = "") -> Verdict:
    """The verdict on the motor of an estimate.

    ``serial`` stands in where the captures name none. Whatever cannot be judged is INVALID, with
    the reason and what to do.
    """
    named = serial or next((str(i["serial"]) for i in estimate.inputs if i.get("serial")), "")
    conditions = [*_captures(estimate, limits), _serial(named, limits), *_ambient(estimate, limits)]
    estimate, model = _of_model(estimate, limits)
    conditions += model
    context = Context(estimate, limits)
    measured = [_measured(name, limit, context) for name, limit in limits.limits.items()]
    return Verdict(
        limits.name,
        named,
        (*(c for c in conditions if c is not None), *_supported(context), *measured),
        estimate.inputs,
        {**estimate.versions, "motorid": __version__, **limits.cited},
    )


def _of_model(estimate: Estimate, limits: Product) -> tuple[Estimate, list[Measurement]]:
    """The estimate with the parameters of the model that the product judges by, and which it is.

    A model that a person asked for is none that the data support. Figures such as the no-load speed
    are those of the six parameters: doubtful where these are.
    """
    better = estimate.alternative
    if limits.model != BETTER or better is None or better.asked:
        return estimate, []
    said = _condition("model", f"R, L, K, B, J and T0 are those of {better.name}", "")
    six = {name: better.parameters[name] for name in PARAMETERS}
    return replace(estimate, parameters={**estimate.parameters, **six}), [said]


def not_measured(product: Product, serial: str, reason: str) -> Verdict:
    """The verdict where there is no estimate: INVALID, and why."""
    limit = Limit("measurement", "1", condition=True)
    missing = Measurement(
        "measurement", "measurement", limit, Reading("1", problem=reason), Outcome.INVALID,
        reason=reason,
    )  # fmt: skip
    versions = {"motorid": __version__, **product.cited}
    return Verdict(product.name, serial, (missing,), (), versions)


def not_running(
    product: Product, serial: str, defect: str, seen: str, unsound: str = ""
) -> Verdict:
    """The verdict on a motor that did not run: FAIL with the ``defect``, as it was ``seen``.

    ``unsound``: why the rig cannot be taken for sound; then it is INVALID.
    """
    limit = Limit(RUNS, "1", low=1.0)
    reason = f"{defect}: {seen}"
    dead = Measurement(
        RUNS, "the motor runs", limit, Reading("1", 0.0, 0.0, reason), Outcome.FAIL, reason=reason
    )
    if unsound:
        unsound = f"motor or rig ({defect}; {seen}): {unsound}"
    sound = _condition("rig_sound", "the rig was shown to be sound", unsound)
    return Verdict(
        product.name, serial, (sound, dead), (),
        {"motorid": __version__, **product.cited},
    )  # fmt: skip


def _measured(name: str, limit: Limit, context: Context) -> Measurement:
    found = quantity(name)
    assert found is not None, name  # a product file with another name was refused
    return decide(limit, found.read(context), found.meaning)


def _supported(context: Context) -> list[Measurement]:
    """What the run must support, or nothing passes. A motor that fails its limits fails still."""
    estimate = context.estimate
    misfit = [d.message for d in estimate.diagnostics if d.code == LACK]
    doubtful = [p.name for p in estimate.parameters.values() if p.status is Status.DOUBTFUL]
    doubt = f"{', '.join(doubtful)}: {context.doubt(*doubtful)}" if doubtful else ""
    problems = ("; ".join(misfit[:1]), doubt, disagreement(estimate, context.as_run))
    meanings = (
        "the run follows the model",
        "no parameter is doubtful",
        "speed by the parameters against the measured one",
    )
    return [
        _condition(*about, ground=False)
        for about in zip(SUPPORTED, meanings, problems, strict=True)
    ]


def _condition(name: str, meaning: str, problem: str, ground: bool = True) -> Measurement:
    """A yes or no as a measurement: 1 is good. ``ground``: without it nothing else counts."""
    limit = Limit(name, "1", low=1.0, condition=ground)
    if problem:
        reading = Reading("1", 0.0, 0.0, problem)
        return Measurement(name, meaning, limit, reading, Outcome.INVALID, reason=problem)
    return Measurement(name, meaning, limit, Reading("1", 1.0, 0.0), Outcome.PASS)


def _captures(estimate: Estimate, product: Product) -> list[Measurement]:
    """The run is whole and the fit settled."""
    problem = ""
    for number, one in enumerate(estimate.inputs, 1):
        where = f"run {number}" if len(estimate.inputs) > 1 else "the run"
        if one.get("end_reason", "completed") != "completed":
            problem = f"{where} ended early ({one['end_reason']}): measure again"
        elif int(one.get("gaps") or 0) > product.lost_samples:
            problem = f"{where} lost {one['gaps']} samples: check cable and computer, measure again"
    errors = [d.message for d in estimate.diagnostics if d.severity == "error"]
    settled = f"{errors[0]}: measure again" if errors else ""
    return [
        _condition("run_complete", "run complete", problem),
        _condition("fit_settled", "fit settled", settled),
        _condition("current_sensed", "the current is sensed", dead_sensor(estimate)),
    ]


def _serial(serial: str, product: Product) -> Measurement | None:
    if product.serial is None:
        return None
    return _condition("serial", "serial number", product.serial.problem(serial))


def _ambient(estimate: Estimate, product: Product) -> list[Measurement]:
    limit = product.ambient
    if limit is None:
        return []
    found = []
    for one in estimate.inputs or ({},):
        ambient = one.get("ambient_c")
        if ambient is None:
            reading = Reading("°C", problem="it is not known: give conditions.ambient_c in the rig")
        else:
            reading = Reading("°C", float(ambient), float(one.get("ambient_uncertainty_c") or 0.0))
        found.append(decide(limit, reading, "ambient temperature"))
    found.sort(key=lambda m: m.outcome is Outcome.PASS)
    return found[:1]
