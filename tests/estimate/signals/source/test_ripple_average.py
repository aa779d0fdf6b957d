"""A mean over PWM periods of what bends with the current, against currents that were integrated."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import integrate, optimize

from motorid.estimate.signals.source import ripple_average as module
from motorid.estimate.signals.source.pwm_bridge import DIODE_DROPS_V
from motorid.estimate.signals.source.ripple_average import Flow, Pulses, Swing
from motorid.program import Decay

Floats = NDArray[np.float64]

OHM, HENRY, PWM_HZ, RAIL, BEND = 2.0, 2e-4, 10e3, 12.0, 0.3
PERIOD_S = 1.0 / PWM_HZ


def bent(current: Floats, bend: float = BEND) -> Floats:
    return np.asarray(current / np.sqrt(current**2 + bend**2))


def test_what_bends_and_its_slope_by_the_bend() -> None:
    current = np.array([-3.0, -0.2, 0.0, 0.1, 5.0])
    share, slope = module._saturation(current, BEND)
    np.testing.assert_allclose(share, bent(current))
    step = 1e-6
    around = (bent(current, BEND * math.exp(step)) - bent(current, BEND * math.exp(-step))) / step
    np.testing.assert_allclose(slope, around / 2.0, atol=1e-8)


@pytest.mark.parametrize("decay", [1e-9, 0.3, 4.0])
def test_an_exponential_at_the_places_of_a_mean(decay: float) -> None:
    """From 0 to 1, of so many time constants; its mean is known."""
    shown = module._bent(decay)
    exact = 0.5 if decay < 1e-6 else 1.0 / -math.expm1(-decay) - 1.0 / decay
    assert float(shown @ module.WEIGHTS) == pytest.approx(exact, rel=1e-9)
    assert (np.diff(shown) > 0.0).all()


def switched(duty: float, side: float) -> tuple[Floats, Floats]:
    """Current less its mean, of a winding at the rail for a share of the period and shorted for the
    rest, over and over; and its times."""
    tau = HENRY / OHM
    on, off = duty * PERIOD_S, (1.0 - duty) * PERIOD_S
    high = RAIL / OHM
    least = high * (1 - math.exp(-on / tau)) * math.exp(-off / tau) / -math.expm1(-PERIOD_S / tau)
    most = high + (least - high) * math.exp(-on / tau)
    t = (np.arange(20_000) + 0.5) / 20_000 * PERIOD_S
    rise = high + (least - high) * np.exp(-t / tau)
    current = np.where(t < on, rise, most * np.exp(-(t - on) / tau))
    return side * (current - current.mean()), t


def part(duty: float, side: float, decay: Decay = Decay.SYNCHRONOUS_SLOW) -> Any:
    return SimpleNamespace(
        start=0, stop=4, slice=slice(0, 4), level=side * duty, decay=decay, is_duty=True,
        open=False,
    )  # fmt: skip


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("duty", [0.25, 0.7])
def test_a_drop_is_averaged_over_the_swing(
    duty: float, side: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    swing, _ = switched(duty, side)
    low, high = (side * swing).min(), (side * swing).max()
    monkeypatch.setattr(module, "ripple", lambda *_: (-low, high))
    monkeypatch.setattr(module, "driven_share", lambda *_: (duty, None))
    capture: Any = SimpleNamespace(supply_v=RAIL, wiring=SimpleNamespace(pwm_hz=PWM_HZ))
    found = Swing.of(capture, part(duty, side), HENRY, OHM, np.zeros(4))
    assert found is not None
    assert found.pulses is None
    assert found.weights.sum() == pytest.approx(1.0)
    mean = np.array([0.05, 0.4, -0.3, 2.0])
    share, slope = found.saturation(mean, BEND)
    exact = [float(bent(one + swing).mean()) for one in mean]
    np.testing.assert_allclose(share, exact, atol=2e-4)
    step = 1e-4
    ends = [found.saturation(mean, BEND * math.exp(s))[0] for s in (step, -step)]
    np.testing.assert_allclose(slope, (ends[0] - ends[1]) / (2.0 * step), atol=1e-6)


def test_without_ripple_there_is_no_swing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "ripple", lambda *_: (0.0, 0.0))
    capture: Any = SimpleNamespace(supply_v=RAIL, wiring=SimpleNamespace(pwm_hz=PWM_HZ))
    assert Swing.of(capture, part(0.5, 1.0), HENRY, OHM, np.zeros(4)) is None
    flow = Flow.of(capture, [part(0.5, 1.0)], np.array([1.0, -2.0]), HENRY, OHM)
    assert flow.swings == ()
    np.testing.assert_allclose(flow.saturation(BEND)[0], bent(np.array([1.0, -2.0])))


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_diode_stops_a_current_below_the_rail_and_its_own_drop(
    side: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "ripple", lambda *_: (0.2, 0.3))
    monkeypatch.setattr(module, "driven_share", lambda *_: (0.3, None))
    capture: Any = SimpleNamespace(supply_v=RAIL, wiring=SimpleNamespace(pwm_hz=PWM_HZ))
    emf = np.array([1.0, 2.0, -30.0, 0.0])
    found = Swing.of(capture, part(0.3, side, Decay.DIODE), HENRY, OHM, emf)
    assert found is not None
    assert found.pulses is not None
    assert (found.pulses.side, found.pulses.duty) == (side, 0.3)
    assert found.pulses.decay == pytest.approx(OHM / (HENRY * PWM_HZ))
    floor = (RAIL + DIODE_DROPS_V + side * emf) / OHM
    np.testing.assert_allclose(found.pulses.floor, np.maximum(floor, module.TINY_A))


def pulse(peak: float, duty: float, decay: float, floor: float) -> tuple[Any, float]:
    """A current in A over one PWM period, and how long it flows, of a period: it rises from nothing
    to ``peak`` as an exponential, then falls towards -``floor`` until it is nothing."""
    falls = math.log1p(peak / floor) / decay

    def current(t: float) -> float:
        if t < duty:
            return peak * math.expm1(-decay * t) / math.expm1(-decay * duty)
        return max((peak + floor) * math.exp(-decay * (t - duty)) - floor, 0.0)

    return current, duty + falls


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(
    ("peak", "duty", "decay"), [(0.4, 0.2, 1.0), (0.05, 0.1, 0.4), (2.0, 0.3, 3.0)]
)
def test_pulses_of_a_diode_bend_as_their_integral_says(
    peak: float, duty: float, decay: float, side: float
) -> None:
    floor = 6.0
    current, flows = pulse(peak, duty, decay, floor)
    over = {"points": [duty, min(flows, 1.0)], "limit": 200}
    mean = integrate.quad(current, 0.0, 1.0, **over)[0]
    exact = integrate.quad(lambda t: float(bent(np.array(current(t)))), 0.0, 1.0, **over)[0]
    found = Pulses(side, duty, decay, np.array([floor]))
    stops, share, slope = found.saturation(np.array([side * mean]), BEND)
    assert stops.tolist() == [flows < 1.0]
    assert share[0] == pytest.approx(side * exact, rel=1e-5)
    step = 1e-4
    ends = [
        found.saturation(np.array([side * mean]), BEND * math.exp(s))[1][0] for s in (step, -step)
    ]
    assert slope[0] == pytest.approx((ends[0] - ends[1]) / (2.0 * step), rel=1e-4)


def test_a_current_that_never_stops_is_said_to_flow() -> None:
    """One that stops just before the period's end, and one that just does not."""
    duty, decay, floor = 0.5, 0.5, 1.0
    last = floor * math.expm1(decay * (1.0 - duty))  # its peak
    current, _ = pulse(last, duty, decay, floor)
    mean = integrate.quad(current, 0.0, 1.0, points=[duty])[0]
    found = Pulses(1.0, duty, decay, np.full(2, floor))
    stops, _, _ = found.saturation(mean * np.array([0.999, 1.001]), BEND)
    assert stops.tolist() == [True, False]
    against = found.saturation(np.array([-0.5]), BEND)
    assert against[1] == pytest.approx([0.0])  # it cannot flow the other way


@pytest.mark.parametrize("a", [1.0001, 1.2, 4.0])
def test_the_peak_solves_its_equation(a: float) -> None:
    charge = np.array([1e-6, 1e-3, 0.1, 2.0, 50.0])
    found = module._peak(a, charge)
    for x, wanted in zip(found, charge, strict=True):
        exact = optimize.brentq(lambda y, c=wanted: a * y - math.log1p(y) - c, 0.0, 1e3, xtol=1e-14)
        assert x == pytest.approx(exact, rel=1e-5)
