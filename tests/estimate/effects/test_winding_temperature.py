"""How much a run warms its winding: against the differential equation, with figures and without."""

from __future__ import annotations

import math
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from motorid.capture.model import CURRENT, VOLTAGE, Capture, Channel
from motorid.estimate.effects import winding_temperature
from motorid.estimate.effects.winding_temperature import Body, by_figures, self_heating, shown_by

R, PERIOD_S, COUNT = 2.0, 1e-3, 2001
STATED = {"winding_k_w": 8.0, "winding_s": 4.0, "voltage_v": 12.0}
BEGAN = datetime(2026, 1, 1, 12, tzinfo=UTC)


def amperes(t: np.ndarray) -> np.ndarray:
    return 3.0 * np.exp(-t / 0.5) + 1.0


def capture(at: datetime | None = BEGAN, volts: float = 10.0) -> Capture:
    t = PERIOD_S * np.arange(COUNT)
    return Capture(
        ticks=np.arange(COUNT, dtype=np.int64), clock_hz=1.0 / PERIOD_S,
        channels={
            CURRENT: Channel(CURRENT, "A", amperes(t)),
            VOLTAGE: Channel(VOLTAGE, "V", np.full(COUNT, volts)),
        },
        provenance={"created": at.isoformat()} if at else {},
    )  # fmt: skip


def integrated(capacity: float, cooling_s: float, begin: float = 0.0) -> tuple[float, float, float]:
    """Rise in the mean over the energy, energy, and the rise at the end."""

    def slope(t: float, y: np.ndarray) -> list[float]:
        power = R * float(amperes(np.array(t))) ** 2
        return [power / capacity - y[0] / cooling_s, power * y[0], power]

    end = (COUNT - 1) * PERIOD_S
    y = solve_ivp(slope, (0.0, end), [begin, 0.0, 0.0], rtol=1e-9, atol=1e-12).y[:, -1]
    return float(y[1] / y[2]), float(y[2]), float(y[0])


def test_a_run_warms_its_winding_as_the_equation_says() -> None:
    found = self_heating([capture()], R, STATED)
    mean, energy, _ = integrated(0.5, 4.0)
    assert found is not None
    assert found.kelvin == pytest.approx(mean, rel=2e-3)
    assert found.heat_j == pytest.approx(energy, rel=2e-3)
    assert found.uncertainty_k == pytest.approx(0.2 * found.kelvin)
    assert "thermal figures" in found.basis


def test_a_second_run_begins_as_warm_as_the_pause_left_it() -> None:
    length = (COUNT - 1) * PERIOD_S
    later = BEGAN + timedelta(seconds=length + 3.0)
    found = self_heating([capture(later), capture()], R, STATED)  # in any order
    first, energy, end = integrated(0.5, 4.0)
    second, _, _ = integrated(0.5, 4.0, end * math.exp(-3.0 / 4.0))
    assert found is not None
    assert found.kelvin == pytest.approx((first + second) / 2, rel=3e-3)
    assert found.heat_j == pytest.approx(2 * energy, rel=2e-3)


def test_runs_that_overlap_have_no_pause() -> None:
    both = self_heating([capture(), capture()], R, STATED)
    first, _, end = integrated(0.5, 4.0)
    second, _, _ = integrated(0.5, 4.0, end)
    assert both is not None
    assert both.kelvin == pytest.approx((first + second) / 2, rel=3e-3)


@pytest.mark.parametrize(("stated", "volts"), [({}, 10.0), ({"voltage_v": 24.0}, 24.0)])
def test_without_figures_the_rise_is_between_none_and_a_bound(
    stated: dict[str, float], volts: float
) -> None:
    found = self_heating([capture()], R, stated)
    bound, _, _ = integrated(volts**2 / R / 150.0, 600.0)
    assert found is not None
    assert found.kelvin == pytest.approx(bound / 2, rel=3e-3)
    assert found.uncertainty_k == pytest.approx(bound / math.sqrt(12), rel=3e-3)
    assert found.basis == winding_temperature.BOUND


def test_what_the_runs_show_serves_where_no_sheet_does() -> None:
    shown = Body(0.5, 4.0, 0.3, "as the runs themselves show it")
    found = self_heating([capture()], R, {}, shown)
    assert found is not None
    assert found.uncertainty_k == pytest.approx(0.3 * integrated(0.5, 4.0)[0], rel=2e-3)
    by_sheet = self_heating([capture()], R, STATED, Body(5.0, 4.0, 0.3, "x"))
    assert by_sheet is not None
    assert "thermal figures" in by_sheet.basis


def test_without_a_current_nothing_is_known() -> None:
    one = capture()
    blind = replace(one, channels={VOLTAGE: one.channels[VOLTAGE]})
    assert self_heating([blind], R, STATED) is None
    still = replace(one, channels={CURRENT: one.channels[CURRENT]})
    assert self_heating([still], R, {}) is None  # no voltage that would bound it


def test_readings_that_are_lost_bring_no_heat() -> None:
    one = capture()
    values = one.channels[CURRENT].raw.copy()
    values[500:] = np.nan
    cut = replace(one, channels={**one.channels, CURRENT: Channel(CURRENT, "A", values)})
    found = self_heating([cut], R, STATED)
    whole = self_heating([one], R, STATED)
    assert found is not None
    assert whole is not None
    assert 0.0 < found.heat_j < 0.8 * whole.heat_j


def test_figures_of_a_sheet() -> None:
    body = by_figures(STATED)
    assert body == Body(0.5, 4.0, 0.2, "by the motor's thermal figures")
    assert by_figures({"winding_k_w": 8.0}) is None
    assert by_figures({"winding_s": 4.0, "winding_k_w": 0.0}) is None


def better(**values: tuple[float, float]) -> Any:
    return SimpleNamespace(
        parameters={n: SimpleNamespace(value=v, total=u) for n, (v, u) in values.items()}
    )


def test_a_better_model_tells_the_capacity_and_its_doubt() -> None:
    body = shown_by(better(C_w=(0.5, 0.05), k_w=(0.2, 0.1)))
    assert body is not None
    assert (body.capacity_j_k, body.cooling_s) == (0.5, pytest.approx(5.0))
    assert body.doubt == pytest.approx(math.hypot(0.1, 0.2))
    slow = shown_by(better(C_w=(0.5, 0.05), k_w=(0.0, 0.1)))
    assert slow is not None
    assert slow.cooling_s == winding_temperature.SLOW_S
    assert shown_by(better(k_w=(0.2, 0.1))) is None
    assert shown_by(None) is None
