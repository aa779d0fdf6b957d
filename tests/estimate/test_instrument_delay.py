"""A delay's stated uncertainty against the fit of a capture whose delay is wrong by just that."""

from __future__ import annotations

from dataclasses import replace

import pytest

from motorid.capture.model import CURRENT, Capture
from motorid.estimate import fit
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
