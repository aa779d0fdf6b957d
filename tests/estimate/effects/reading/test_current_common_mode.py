"""A current's amplifier that follows a voltage: what it shows, and a fit that finds it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import CURRENT, VOLTAGE, Capture
from motorid.estimate.effects.reading.current_common_mode import CURRENT_COMMON_MODE
from motorid.estimate.results.status import Status
from tests.estimate.effects.benches import moved, record, ticks
from tests.exact_capture import FAULHABER, Plan, clean_capture, ended, noisy
from tests.six_parameters import fit

PLAN = Plan(volts=(6.0, -4.0, 2.0))
LEAK_S = 0.03


def leaking(siemens: float) -> Capture:
    """A capture whose current reads so many amperes more for each volt."""
    capture = ended(clean_capture(FAULHABER, PLAN))
    channel, volts = capture.channels[CURRENT], capture.channels[VOLTAGE].values
    shown = replace(channel, raw=channel.raw + siemens * volts / channel.scale)
    return noisy(replace(capture, channels={**capture.channels, CURRENT: shown}), 1, 1e-2, 2e-3)


def test_its_tangent_is_the_voltage_that_was_read() -> None:
    change = moved("measured", CURRENT_COMMON_MODE)[CURRENT]
    volts = record("measured").capture.channels[VOLTAGE].values
    assert change == pytest.approx(volts[ticks("measured", CURRENT)])
    assert float(np.abs(change).max()) > 0.0
    assert CURRENT_COMMON_MODE.prior(record("measured"), 0) is None  # no fit has it by itself


def test_without_a_voltage_it_shows_nothing() -> None:
    assert not moved("commanded", CURRENT_COMMON_MODE)[CURRENT].any()


@pytest.mark.slow
def test_a_fit_names_it_and_estimates_it_with_the_motor() -> None:
    found = fit([leaking(LEAK_S)])
    (said,) = [s for s in found.suspects if s.strength == "named"]
    assert (said.code, said.allowed) == ("current_common_mode", True)
    size = found.nuisance[CURRENT_COMMON_MODE.name]
    assert size.value == pytest.approx(LEAK_S, abs=4.0 * size.total)
    for name, truth in FAULHABER.items():
        p = found.parameters[name]
        assert p.status is Status.ESTIMATED
        assert p.value == pytest.approx(truth, abs=4.0 * p.total)


@pytest.mark.slow
def test_an_amplifier_that_follows_nothing_is_not_accused() -> None:
    assert [s.code for s in fit([leaking(0.0)]).suspects if s.strength == "named"] == []
