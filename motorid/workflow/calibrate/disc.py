"""The step that checks the whole chain: J with a disc of known inertia, and without."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from motorid.calibration.disc import Inertia, check_disc
from motorid.calibration.toml import render
from motorid.capture.model import CURRENT, VOLTAGE
from motorid.errors import DataError
from motorid.estimate.results.status import Status
from motorid.rig_calibration import FORMAT, apply, parse_calibration
from motorid.workflow.calibrate.bench import Bench, Tables, now

if TYPE_CHECKING:
    from motorid.rig import Rig


def disc(bench: Bench) -> Tables:
    """A disc of known inertia: the fit's J with it and without, against what was computed."""
    person = bench.person
    known = {"": {"format": FORMAT, "date": now()}, **bench.found}
    rig = apply(bench.rig, parse_calibration(render(known), "what was calibrated so far"))
    weight = person.disc(rig)
    runs = f"{bench.settings.runs} runs of the rig's own program, up to full speed"
    person.proceed(f"without the disc: {runs}")
    without = _inertia(bench, person.arrange(rig, "free"), "without")
    person.proceed(f"put the disc on and keep clear of it: {runs}")
    loaded = _heavier(person.arrange(rig, "disc"), weight.inertia)
    found = check_disc(without, _inertia(bench, loaded, "with"), weight)
    says = found.says(_gains(bench))
    person.say(
        f"disc: {found.measured:.4g} ± {2 * found.measured_uncertainty:.2g} kg·m² measured, "
        f"{found.expected:.4g} ± {2 * found.expected_uncertainty:.2g} computed (95 %); zeta "
        f"{found.zeta:+.2f}, {found.outcome}"
    )
    person.say(f"  {says}")
    return {
        "disc": {
            "date": now(),
            **{key: float(value) for key, value in vars(weight).items()},
            "expected_kg_m2": found.expected,
            "expected_uncertainty_kg_m2": found.expected_uncertainty,
            "measured_kg_m2": found.measured,
            "measured_uncertainty_kg_m2": found.measured_uncertainty,
            "zeta": found.zeta,
            "outcome": found.outcome,
            "says": says,
        }
    }


def _heavier(rig: Rig, inertia: float) -> Rig:
    """The rig whose derived program leaves the heavier rotor its time."""
    from motorid.rig import default_program

    plate = rig.nameplate
    if plate.inertia_kg_m2 is None or plate.voltage_v is None:
        return rig
    if rig.program != default_program(plate):
        return rig
    plate = replace(plate, inertia_kg_m2=plate.inertia_kg_m2 + inertia)
    return replace(rig, nameplate=plate, program=default_program(plate))


def _inertia(bench: Bench, rig: Rig, name: str) -> Inertia:
    """J that several runs give together."""
    from motorid.capture import store
    from motorid.identify import fit
    from motorid.workflow.record import capture_runs

    with tempfile.TemporaryDirectory(prefix="motorid-") as scratch:
        folder = bench.settings.captures or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"{name}-disc.h5"
        paths = capture_runs(
            rig, path, repeat=bench.settings.runs, note=path.stem, progress=bench.progress
        )
        found = fit([store.load(one) for one in paths]).parameters["J"]
    if found.value is None or found.status is not Status.ESTIMATED:
        raise DataError(f"these runs do not tell J ({found.note}): see motorid fit's report")
    return Inertia(found.value, found.statistical or 0.0, found.instrument or 0.0)


def _gains(bench: Bench) -> Mapping[str, float]:
    """Relative uncertainties of the gains that were calibrated."""
    known = {
        name: bench.found[name]["gain_uncertainty"]
        for name in (CURRENT, VOLTAGE)
        if "gain_uncertainty" in bench.found.get(name, {})
    }
    turned = bench.found.get("encoder")
    if turned:
        known["encoder"] = turned["uncertainty"] / turned["counts_per_turn"]
    return known
