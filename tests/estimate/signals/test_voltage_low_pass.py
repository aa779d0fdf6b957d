"""A capacitor on the voltage's divider, seen where the bridge brakes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid import api
from motorid.capture.model import VOLTAGE, Capture
from motorid.estimate.signals.voltage_low_pass import declared, time_constant
from tests.centred_pulses import LENGTH, MOTOR, PWM_HZ, capture_of

PERIOD_S = 1.0 / PWM_HZ


def behind(samples: float, kept: float = 0.0, late: int = 0) -> Capture:
    """Its voltage behind an RC of so many samples; the bridge keeps a share ``kept`` of a brake's
    voltage, which dies away within two samples; readings ``late`` by whole samples.
    """
    capture = capture_of(0.0, stated=0.0)
    volts = capture.channels[VOLTAGE]
    real = volts.values.copy()
    brake = 5 * LENGTH + 1
    real[brake : brake + LENGTH] += kept * real[brake - 1] * np.exp(-np.arange(LENGTH) / 2.0)
    real = np.concatenate([np.full(late, real[0]), real[: len(real) - late]])
    if samples:
        share, now = np.exp(-1.0 / samples), 0.0
        for k, value in enumerate(real.tolist()):  # its mean over the reading, and its end
            real[k] = value + (now - value) * samples * (1.0 - share)
            now = value + (now - value) * share
    return replace(capture, channels={**capture.channels, VOLTAGE: replace(volts, raw=real)})


@pytest.mark.parametrize("samples", [0.6, 1.0, 2.0, 2.5])
@pytest.mark.parametrize("kept", [0.0, 0.06])
def test_the_time_constant_is_found(samples: float, kept: float) -> None:
    """What a bridge's resistance keeps moves it by up to two standard uncertainties and a half."""
    found = time_constant(behind(samples, kept))
    assert found is not None
    assert found[0] == pytest.approx(samples * PERIOD_S, rel=0.05 + 2.5 * kept)
    assert found[1] >= 0.07 * found[0]


@pytest.mark.parametrize(
    ("samples", "kept", "late"),
    [
        (0.0, 0.0, 0),
        (0.0, 0.06, 0),  # what a bridge's resistance keeps
        (0.0, 0.0, 2),  # late, and not filtered
        (0.2, 0.0, 0),  # nothing that matters
        (20.0, 0.0, 0),  # the fit sees that itself
    ],
)
def test_none_is_found_where_there_is_none(samples: float, kept: float, late: int) -> None:
    capture = behind(samples, kept, late)
    assert time_constant(capture) is None
    assert declared(capture) == (capture, None)


def changed(**facts: object) -> Capture:
    capture = behind(1.0)
    volts = replace(capture.channels[VOLTAGE], **facts)  # type: ignore[arg-type]
    return replace(capture, channels={**capture.channels, VOLTAGE: volts})


@pytest.mark.parametrize(
    "capture",
    [
        changed(filter_s=1e-4),  # declared
        changed(sense="supply"),  # no brake takes it away
        replace(behind(1.0), program=None, phases=()),
        replace(behind(1.0), channels={}),
        replace(behind(1.0), phases=behind(1.0).phases[:5]),  # without a brake that ends a drive
    ],
)
def test_none_is_looked_for_where_nothing_would_show_it(capture: Capture) -> None:
    assert time_constant(capture) is None


@pytest.mark.slow
def test_it_is_declared_for_the_fit_and_named() -> None:
    """L was half of what it is, without a word."""
    capture = behind(1.5)
    estimate = api.fit(capture, model="six")
    (said,) = [one for one in estimate.suspects if one.strength == "named"]
    assert (said.code, said.allowed) == ("voltage_filtered", True)
    for name, true in MOTOR.items():
        found = estimate.parameters[name]
        assert found.value is not None
        assert found.total
        assert abs(found.value - true) < 4.0 * found.total, name
    filtered = declared(capture)[0].channels[VOLTAGE]
    assert filtered.delay_s == pytest.approx(filtered.filter_s)
    assert filtered.delay_uncertainty_s >= 0.07 * filtered.filter_s
