"""What no motor gives is refused, at a bounded cost; what is good is not."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bench.spoilt import made
from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture
from motorid.estimate.assembly import refusal
from motorid.estimate.model.unexplained import Unexplained
from motorid.estimate.results.estimate import Diagnostic, Estimate, Parameter
from motorid.estimate.results.status import Status
from tests.exact_capture import FAULHABER, Plan, clean_capture, noisy
from tests.report.example import estimate as example
from tests.six_parameters import fit

MOST_EVALUATIONS = 10_000  # a good fit takes a tenth of it; a search without a bound ten times


def spoilt(base: str, spoil: str) -> Estimate:
    capture = made(base, spoil, "sim-qube", np.random.default_rng(0)).capture
    return fit([capture])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("base", "spoil"),
    [
        pytest.param("diode-decay", "voltage and current swapped", marks=pytest.mark.study),
        ("log-steps", "all shuffled"),
        pytest.param("log-drop-outs", "voltage shuffled", marks=pytest.mark.study),
        ("fast-decay", "current of another run"),
    ],
)
def test_what_no_motor_gives_has_no_values(base: str, spoil: str) -> None:
    found = spoilt(base, spoil)
    for p in (*found.parameters.values(), *found.combinations.values()):
        assert (p.value, p.status) == (None, Status.NOT_SUPPORTED)
    assert not found.derived
    assert not found.budget
    assert found.alternative is None
    first = found.diagnostics[0]
    assert (first.code, first.severity) == ("not_supported", "error")
    assert "check which column is which" in first.message
    assert found.evaluations < MOST_EVALUATIONS


def of_16_bits(capture: Capture) -> Capture:
    """With a hundredth of the noise, and readings of a converter so fine."""
    channels = dict(capture.channels)
    for name in (CURRENT, VOLTAGE):
        if name in channels:
            fine = float(np.ptp(channels[name].values)) / 2**16
            channels[name] = replace(channels[name], resolution=fine, noise=fine)
    return replace(capture, channels=channels)


@pytest.mark.slow
def test_a_tiny_misfit_of_a_fine_converter_is_not_refused() -> None:
    """A current that is bent by a thousandth: chi-square is large, and each value is there."""
    capture = noisy(clean_capture(FAULHABER, Plan(volts=(6.0, 3.0, 1.5))), 1, 1e-5, 1e-5)
    channel = capture.channels[CURRENT]
    bent = channel.values * (1.0 + 1e-3 * channel.values / float(np.abs(channel.values).max()))
    fine = of_16_bits(
        replace(capture, channels={**capture.channels, CURRENT: replace(channel, raw=bent)})
    )
    found = fit([fine], model="six")
    assert found.chi_square > 3.0 * found.degrees_of_freedom
    for p in found.parameters.values():
        assert p.status.measured
        assert p.value == pytest.approx(FAULHABER[p.name], rel=5e-3)


@pytest.mark.slow
def test_what_was_given_stays() -> None:
    capture = made("log-steps", "all shuffled", "sim", np.random.default_rng(0)).capture
    found = fit([capture], fix={"K": 0.05}, model="six")
    K = found.parameters["K"]
    assert (K.value, K.status) == (0.05, Status.FIXED)
    assert found.parameters["R"].status is Status.NOT_SUPPORTED


def test_a_motion_that_the_model_has_not_shows_noise_alone() -> None:
    held = Unexplained(SPEED, 1.0, 0.3, declared=False, made=1e-9)
    assert not held.contradicts
    assert replace(held, made=0.5).contradicts


@pytest.mark.parametrize(
    ("share", "beyond", "declared", "refused"),
    [
        (0.30, 0.30, False, True),
        (0.20, 0.20, False, False),
        (0.80, 0.00, False, False),  # a noisy sensor, whose current still shows
        (0.95, 0.00, False, True),  # nothing but noise
        (0.95, 0.00, True, False),  # which is what it declares
    ],
)
def test_misfit_is_judged_by_the_readings(
    share: float, beyond: float, declared: bool, refused: bool
) -> None:
    assert Unexplained(CURRENT, share, beyond, declared).contradicts is refused


@pytest.mark.parametrize(
    ("share", "times"),
    [
        (0.49, "70% of the readings"),
        (99.0, "995% of the readings"),
        (121.0, "11 times the readings"),
    ],
)
def test_a_refusal_says_how_much_is_left_of_which_channel(share: float, times: str) -> None:
    worst: Any = SimpleNamespace(channel="terminal_voltage", share=share)
    said = refusal._said(worst).message
    assert f"what the model leaves of the terminal voltage is {times} (rms; at most" in said


def test_what_was_given_stays_and_the_rest_has_no_value() -> None:
    before = example()
    given = Parameter("K", "N·m/A", 0.05, 0.0, 0.0, 0.0, (0.05, 0.05), Status.FIXED)
    others = tuple(Diagnostic(code, "info", "so") for code in (*refusal.OF_VALUES, "lost_samples"))
    before = replace(
        before, parameters={**before.parameters, "K": given}, diagnostics=others,
        budget={"R": {"noise": 1.0}},
    )  # fmt: skip
    worst: Any = SimpleNamespace(channel="current", share=4.0)
    found = refusal.refused(before, worst)
    assert found.parameters["K"] is given
    for name, p in found.parameters.items():
        if name != "K":
            assert (p.name, p.value, p.status) == (name, None, Status.NOT_SUPPORTED)
            assert p.unit == before.parameters[name].unit
    assert (found.derived, found.nuisance, found.budget) == ({}, {}, {})
    assert [d.code for d in found.diagnostics] == ["not_supported", "lost_samples"]
