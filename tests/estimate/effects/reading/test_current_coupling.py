"""A current behind a capacitor: what it shows, and a fit that names and finds its time constant."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from motorid.capture.model import CURRENT, Capture
from motorid.estimate.effects.reading.current_coupling import CURRENT_COUPLING, bounds, faded
from motorid.estimate.results.status import Status
from tests.estimate.effects.benches import moved, record, ticks, usual
from tests.exact_capture import FAULHABER, Plan, clean_capture, ended, noisy
from tests.six_parameters import fit

PLAN = Plan(volts=(6.0, -4.0, 2.0))


def blocked(series: np.ndarray, steps: float) -> np.ndarray:
    """By SciPy's filter, of straight lines between readings so many time constants apart."""
    keep = float(np.exp(-steps))
    slope = (1.0 - keep) / steps
    return np.asarray(lfilter([slope, -slope], [1.0, -keep], series))


def behind_a_capacitor(records: float) -> Capture:
    """A capture whose current is read so, with a time constant of so many lengths of it."""
    capture = ended(clean_capture(FAULHABER, PLAN))
    channel = capture.channels[CURRENT]
    shown = blocked(channel.values, 1.0 / (records * len(channel.raw)))
    other = replace(channel, raw=shown / channel.scale + channel.offset)
    coupled = replace(capture, channels={**capture.channels, CURRENT: other})
    return noisy(coupled, 1, 1e-2, 2e-3)


@pytest.mark.parametrize("steps", [1e-4, 1e-2, 0.05])
def test_it_shows_what_a_filter_of_first_order_leaves(steps: float) -> None:
    t = np.linspace(0.0, 20.0, 2001)
    series = np.sin(t) + t * (t > 5.0)
    passed = np.full(len(t), steps)
    assert faded(series, passed) == pytest.approx(blocked(series, steps), abs=4.0 * steps**2)
    late = np.array([0.0, *np.exp(-steps * np.arange(1, 9))])
    step = np.concatenate([[0.0], np.ones(8)])
    assert faded(step, np.full(9, steps))[1:] == pytest.approx(late[1:], abs=steps)


def test_nothing_fades_at_no_rate() -> None:
    series = np.array([1.0, -2.0, 3.0])
    assert faded(series, np.zeros(3)) is series


def test_its_tangent_is_the_charge_that_flowed() -> None:
    change, current = moved("moving", CURRENT_COUPLING)[CURRENT], usual("moving")[CURRENT]
    period_s = record("moving").timeline.period_s
    passed = np.diff(ticks("moving", CURRENT)) * period_s
    charge = np.concatenate([[0.0], np.cumsum(passed * (current[1:] + current[:-1]) / 2.0)])
    assert change == pytest.approx(-charge, abs=1e-3 * float(np.abs(charge).max()))
    assert CURRENT_COUPLING.prior(record("moving"), 0) is None  # no fit has it by itself
    assert bounds(record("moving"))[0] == 0.0


@pytest.mark.slow
def test_a_fit_names_it_and_estimates_it_with_the_motor() -> None:
    capture = behind_a_capacitor(0.5)
    found = fit([capture])
    (said,) = [s for s in found.suspects if s.strength == "named"]
    assert (said.code, said.allowed) == ("current_coupled", True)
    rate = found.nuisance[CURRENT_COUPLING.name]
    truth = 1.0 / (0.5 * len(capture) * capture.period_s)
    assert rate.value == pytest.approx(truth, abs=4.0 * rate.total)
    for name, value in FAULHABER.items():
        p = found.parameters[name]
        assert p.status is Status.ESTIMATED
        assert p.value == pytest.approx(value, abs=4.0 * p.total)
