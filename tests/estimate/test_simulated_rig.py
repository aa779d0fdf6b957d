"""The fit on captures of the simulated rig, whose plant shares no code with the fit's model."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import chi2

from motorid.acquire.record import capture as record
from motorid.capture import store
from motorid.errors import DataError
from motorid.estimate.results.estimate import PARAMETERS, Estimate
from motorid.program import Decay, Program, Step, StepKind
from motorid.rig import Sampling, load_rig
from motorid.sim import truth
from tests.six_parameters import fit


def duties(decay: Decay) -> Program:
    """Rest, two duties, coast."""
    drives = [Step(StepKind.DRIVE_DUTY, 0.1, duty, decay) for duty in (0.4, 0.85)]
    return Program((Step(StepKind.COAST, 0.03), *drives, Step(StepKind.COAST, 0.5)))


def captured(
    folder: Path,
    options: str = "",
    channels: tuple[str, ...] = (),
    seed: int = 7,
    **changes: object,
) -> tuple[Estimate, dict[str, float]]:
    rig = load_rig("sim")
    url = f"{rig.port}&speed=max&seed={seed}{options}"
    rig = replace(rig, port=url, **{"program": duties(Decay.SYNCHRONOUS_SLOW), **changes})
    if channels:
        rig = replace(rig, sampling=Sampling(10_000.0, channels))
    path = record(rig, rig.program, folder / "run.h5")
    return fit([store.load(path)]), truth(url)


def errors(estimate: Estimate, true: dict[str, float]) -> dict[str, float]:
    """Relative errors of what was estimated, none beyond four standard uncertainties."""
    out = {}
    for name in PARAMETERS:
        p = estimate.parameters[name]
        if p.value is not None:
            assert abs(p.value - true[name]) < 4 * p.total, name
            out[name] = abs(p.value / true[name] - 1)
    return out


@pytest.mark.slow
def test_every_parameter_of_the_default_bench(tmp_path: Path) -> None:
    estimate, true = captured(tmp_path)
    off = errors(estimate, true)
    assert 0.96 < estimate.chi_square / estimate.degrees_of_freedom < 1.04
    assert set(off) == set(PARAMETERS)
    assert max(off[n] for n in ("R", "K", "J")) < 0.01
    assert max(off[n] for n in ("L", "B", "T0")) < 0.03


@pytest.mark.slow
@pytest.mark.parametrize(
    "options",
    [
        "&aperture=0&delay=0&phase=0.3",  # an instant, amid the ripple
        "&aperture=30e-6&delay=10e-6",  # a window that is no whole PWM period
        "&sense=bridge",
    ],
)
def test_other_measuring_chains(tmp_path: Path, options: str) -> None:
    changes = {"voltage_sense": "bridge"} if "sense" in options else {}
    off = errors(*captured(tmp_path, options, **changes))
    assert set(off) == set(PARAMETERS)
    assert max(off[n] for n in ("R", "K", "J")) < 0.01
    assert max(off[n] for n in ("L", "B", "T0")) < 0.03


@pytest.mark.slow
def test_duty_times_supply_for_a_voltage(tmp_path: Path) -> None:
    channels = ("current", "supply_voltage", "position")
    off = errors(*captured(tmp_path, channels=channels))
    assert max(off.values()) < 0.03


@pytest.mark.slow
def test_duty_times_supply_is_refused_with_diode_decay(tmp_path: Path) -> None:
    channels = ("current", "supply_voltage", "position")
    with pytest.raises(DataError, match="diode decay"):
        captured(tmp_path, channels=channels, program=duties(Decay.DIODE))


INSTANT, PART = "&aperture=0&delay=0&phase=0.3", "&aperture=20e-6&delay=10e-6"


@pytest.mark.slow
@pytest.mark.parametrize("options", ["", INSTANT, PART])
@pytest.mark.parametrize("decay", [Decay.DIODE, Decay.FAST])
def test_every_parameter_with_a_current_that_stops_or_reverses(
    tmp_path: Path, decay: Decay, options: str
) -> None:
    """With diodes it stops within the PWM period at both duties, but for the start of each."""
    estimate, true = captured(tmp_path, options, program=duties(decay))
    off = errors(estimate, true)
    assert set(off) == set(PARAMETERS)
    said = [d.message for d in estimate.diagnostics if d.code == "discontinuous_current"]
    assert bool(said) is (decay == Decay.DIODE)
    assert all("levels 0.4, 0.85" in message and "full duty" in message for message in said)
    assert max(off[n] for n in ("R", "K", "J")) < 0.02
    assert max(off[n] for n in ("L", "B", "T0")) < 0.04


@pytest.mark.slow
def test_a_fit_that_ignores_the_ripple_is_told_apart(tmp_path: Path) -> None:
    """The chain matters: with the ripple left out, no motor explains the readings."""
    rig = load_rig("sim")
    url = f"{rig.port}&speed=max&seed=7&aperture=0&delay=0&phase=0.02"
    rig = replace(rig, port=url, program=duties(Decay.SYNCHRONOUS_SLOW))
    measured = store.load(record(rig, rig.program, tmp_path / "run.h5"))
    blind = replace(measured, wiring=replace(measured.wiring, pwm_hz=0.0))
    true = truth(url)["R"]
    told, untold = fit([measured]), fit([blind])
    assert abs(told.parameters["R"].value / true - 1) < 0.01
    misfits = ["lack_of_fit" in {d.code for d in one.diagnostics} for one in (told, untold)]
    assert misfits == [False, True]


@pytest.mark.slow
def test_what_noise_hides_behind_a_step_does_not_bias_the_inductance(tmp_path: Path) -> None:
    """L/R is 0.7 of a sample: L is told by two or three readings behind each of two steps, where
    the supply gives way and dead times change by three times a reading's noise.
    """
    levels = ((2.477, 0.0512), (5.76, 0.0682))
    drives = [Step(StepKind.DRIVE_VOLTS, s, v, Decay.SYNCHRONOUS_SLOW) for v, s in levels]
    program = Program((Step(StepKind.COAST, 0.0032), *drives, Step(StepKind.COAST, 0.0337)))
    off = []
    for seed in range(1, 7):
        folder = tmp_path / str(seed)
        folder.mkdir()
        estimate, true = captured(folder, seed=seed, program=program)
        L = estimate.parameters["L"]
        off.append((L.value - true["L"]) / L.total)
    assert np.mean(np.square(off)) < chi2.ppf(0.99, len(off)) / len(off)
