"""What is not known of a PWM period's wave, carried to L, against fits in which it is otherwise."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motorid.acquire.record import capture as record
from motorid.capture import store
from motorid.capture.model import VOLTAGE, Capture
from motorid.estimate.fit import start_values
from motorid.estimate.fit.alternating_fit import with_sources
from motorid.estimate.fit.multistart import whitened
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.signals.source import pwm_bridge
from motorid.estimate.uncertainty import budget
from motorid.program import Decay, Program, Step, StepKind
from motorid.rig import load_rig

SUPPLY_V, GAIN_U = 6.0, 5e-3


def instants(folder: Path, kind: StepKind, levels: tuple[float, ...], decay: Decay) -> Capture:
    """The simulated rig with an instant current amid ripple, behind a supply of ``SUPPLY_V``."""
    rig = load_rig("sim")
    rig = replace(
        rig, port=f"{rig.port}&speed=max&aperture=0&delay=0&phase=0.3&seed=7&supply={SUPPLY_V}"
    )
    drives = [Step(kind, 0.05, level, decay) for level in levels]
    steps = (Step(StepKind.COAST, 0.03), *drives, Step(StepKind.COAST, 0.2))
    capture = store.load(record(rig, Program(steps), folder / "run.h5"))
    volts = replace(capture.channels[VOLTAGE], gain_uncertainty=GAIN_U)
    wiring = replace(capture.wiring, supply_voltage_v=SUPPLY_V)
    return replace(capture, wiring=wiring, channels={**capture.channels, VOLTAGE: volts})


def inductance(capture: Capture, cause: str) -> tuple[float, float]:
    """The logarithm of L, and what the cause does to it."""
    records = [MotorRecord(capture, PARAMETERS, {})]
    start = start_values.start_values(records, {})
    solution = whitened(records, PARAMETERS, start, with_sources(records, PARAMETERS, start))
    moved = budget.propagated(solution, records).get(cause, np.zeros(len(PARAMETERS)))
    k = PARAMETERS.index("L")
    return float(np.log(solution.values[k])), float(moved[k])


@pytest.mark.slow
def test_volts_are_made_by_a_duty_that_nobody_measured(tmp_path: Path) -> None:
    capture = instants(tmp_path, StepKind.DRIVE_VOLTS, (2.0, 4.5), Decay.SYNCHRONOUS_SLOW)
    L, share = inductance(capture, "duty of volts")
    rail = replace(capture.wiring, supply_voltage_v=SUPPLY_V / (1.0 + GAIN_U))
    other, _ = inductance(replace(capture, wiring=rail), "duty of volts")
    assert abs(share) == pytest.approx(abs(other - L), rel=0.1)
    assert abs(share) > 1e-3


@pytest.mark.slow
def test_a_duty_that_was_commanded_is_known(tmp_path: Path) -> None:
    capture = instants(tmp_path, StepKind.DRIVE_DUTY, (0.4, 0.85), Decay.SYNCHRONOUS_SLOW)
    assert inductance(capture, "duty of volts")[1] == 0.0
    assert inductance(capture, "diode drops")[1] == 0.0


@pytest.mark.slow
def test_what_diodes_drop_moves_the_wave_of_diode_decay(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    capture = instants(tmp_path, StepKind.DRIVE_DUTY, (0.7, 0.9), Decay.DIODE)
    L, share = inductance(capture, "diode drops")
    drops = pwm_bridge.DIODE_DROPS_V + pwm_bridge.DIODE_DROPS_SD_V
    monkeypatch.setattr(pwm_bridge, "DIODE_DROPS_V", drops)
    other, _ = inductance(capture, "diode drops")
    assert abs(share) == pytest.approx(abs(other - L), rel=0.1)
    assert abs(share) > 1e-3
