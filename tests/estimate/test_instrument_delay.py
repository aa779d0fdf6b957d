"""A delay's stated uncertainty against the fit of a capture whose delay is wrong by just that."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from motorid.acquire.record import capture as record
from motorid.capture import store
from motorid.capture.model import CURRENT, Capture
from motorid.estimate import fit
from motorid.program import Decay, Program, Step, StepKind
from motorid.rig import load_rig
from tests.exact_capture import FAULHABER, Plan, clean_capture, noisy

LATE_S = 3e-7


def declared(capture: Capture, delay_s: float, uncertainty_s: float) -> Capture:
    """The same capture whose current's delay is declared so."""
    current = replace(capture.channels[CURRENT], delay_s=delay_s, delay_uncertainty_s=uncertainty_s)
    return replace(capture, channels={**capture.channels, CURRENT: current})


def test_an_uncertain_delay_moves_the_answer_as_a_wrong_one_does() -> None:
    clean = clean_capture(FAULHABER, Plan())
    capture = noisy(clean, 3, 1e-3, 1e-4)
    true_s = capture.channels[CURRENT].delay_s
    right = fit([declared(capture, true_s, LATE_S)])
    wrong = fit([declared(capture, true_s - LATE_S, 0.0)])
    share = right.budget["L"]["current delay"]
    moved = wrong.parameters["L"].value - right.parameters["L"].value  # type: ignore[operator]
    assert share == pytest.approx(abs(moved), rel=0.05)
    assert share > 1e-4 * FAULHABER["L"]
    assert "current delay" not in wrong.budget["L"]
    for name in ("K", "J"):
        assert right.budget[name]["current delay"] < 1e-5 * FAULHABER[name]


def test_an_instant_that_is_later_is_one_of_another_phase_of_the_ripple(tmp_path: Path) -> None:
    """Ripple is most of what a delay changes of an instant's reading amid it."""
    rig = load_rig("sim")
    rig = replace(rig, port=f"{rig.port}&speed=max&seed=7&aperture=0&delay=0&phase=0.3")
    slow = Decay.SYNCHRONOUS_SLOW
    drives = [Step(StepKind.DRIVE_DUTY, 0.05, duty, slow) for duty in (0.4, 0.85)]
    steps = (Step(StepKind.COAST, 0.03), *drives, Step(StepKind.COAST, 0.2))
    capture = store.load(record(rig, Program(steps), tmp_path / "run.h5"))
    current = capture.channels[CURRENT]
    right = fit([declared(capture, current.delay_s, LATE_S)])
    phase = (current.pwm_phase or 0.0) - LATE_S * capture.wiring.pwm_hz
    shifted = replace(current, pwm_phase=phase, delay_s=current.delay_s + LATE_S)
    wrong = fit([replace(capture, channels={**capture.channels, CURRENT: shifted})])
    share = right.budget["L"]["current delay"]
    moved = wrong.parameters["L"].value - right.parameters["L"].value  # type: ignore[operator]
    assert share == pytest.approx(abs(moved), rel=0.1)
    assert share > 0.01 * right.parameters["L"].value  # type: ignore[operator]
