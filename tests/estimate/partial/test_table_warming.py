"""A table of steady points whose winding warms: seen and allowed for, or a line of the budget."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.capture.model import CURRENT, SPEED, TORQUE, VOLTAGE, Capture, Channel
from motorid.estimate.partial import steady_state_table, table_warming
from motorid.estimate.results.estimate import Estimate
from motorid.estimate.results.status import Status

R, K, T0 = 0.5, 0.05, 0.02
ALPHA = 0.00393
UNITS = {CURRENT: "A", SPEED: "rad/s", TORQUE: "N·m", VOLTAGE: "V"}


def table(
    rise_k: float, kept: float = 0.0, *, noise: float = 2e-3, order: str = "up", seed: int = 4,
    volts: tuple[float, ...] = (24.0,), count: int = 24,
) -> Capture:  # fmt: skip
    """Rows from no load to 70 % of stall, as warm as a first-order law of heat makes them."""
    rng = np.random.default_rng(seed)
    each = count // len(volts)
    amperes = np.concatenate([np.linspace(0.6, 0.7 * v / R, each) for v in volts])
    supply = np.repeat(volts, each)
    if order == "down":
        amperes, supply = amperes[::-1], supply[::-1]
    warm, level = [], 0.0
    for one in amperes:
        level = kept * level + (1.0 - kept) * one**2
        warm.append(level)
    rise = rise_k * np.array(warm) / max(warm)
    true = {
        VOLTAGE: supply, CURRENT: amperes,
        SPEED: (supply - R * (1.0 + ALPHA * rise) * amperes) / K, TORQUE: K * amperes - T0,
    }  # fmt: skip
    channels = {
        n: Channel(n, UNITS[n], y + noise * np.abs(y).max() * rng.standard_normal(len(y)))
        for n, y in true.items()
    }
    return Capture(np.arange(len(amperes)) * 10**9, 1e9, channels, provenance={"static": True})


def codes(found: Estimate) -> set[str]:
    return {d.code for d in found.diagnostics}


def off(found: Estimate) -> float:
    """Standard uncertainties between R and the truth."""
    p = found.parameters["R"]
    assert p.value is not None
    assert p.total is not None
    return abs(p.value - R) / p.total


@pytest.mark.parametrize("rise_k", [25.0, 40.0, 70.0])
@pytest.mark.parametrize(("kept", "order"), [(0.0, "up"), (0.6, "down"), (0.88, "up")])
def test_a_winding_that_warms_is_named_and_allowed_for(
    rise_k: float, kept: float, order: str
) -> None:
    found = steady_state_table.fit([table(rise_k, kept, order=order, noise=1e-3, count=40)])
    (said,) = [d for d in found.diagnostics if d.code == "winding_warms"]
    assert said.severity == "warning"
    assert found.parameters["R"].status is Status.ESTIMATED
    assert off(found) < 2.5
    assert found.combinations["Ke"].value == pytest.approx(K, rel=0.03)
    plain = steady_state_table._electrical(
        {n: c.values for n, c in table(rise_k, kept, order=order, noise=1e-3).channels.items()}
    )
    assert plain["R"].value > (1.0 + 0.5 * ALPHA * rise_k) * R  # what it was without that


def test_the_rise_is_told_in_kelvin() -> None:
    one = table(40.0, volts=(12.0, 18.0, 24.0), noise=5e-4, count=48)
    columns = {name: channel.values for name, channel in one.channels.items()}
    warmed = table_warming.warming(columns, [len(one)])
    assert warmed is not None
    assert warmed.seen
    rise, u = warmed.rise_k
    assert u < 5.0
    assert rise == pytest.approx(40.0, abs=3.0 * u)


@pytest.mark.slow
def test_good_tables_are_not_accused_and_hold_the_truth() -> None:
    far = []
    for seed in range(30):
        found = steady_state_table.fit([
            table(
                0.0, seed=seed, noise=(1e-3, 3e-3, 8e-3)[seed % 3], order=("up", "down")[seed % 2],
                volts=((24.0,), (12.0, 24.0))[seed % 4 // 2], count=(12, 24, 40)[seed % 5 % 3],
            )
        ])  # fmt: skip
        assert "winding_warms" not in codes(found)
        far.append(off(found))
    assert max(far) < 3.0


def test_values_of_a_good_table_stay_those_of_straight_lines() -> None:
    one = table(0.0)
    found = steady_state_table.fit([one])
    columns = {name: channel.values for name, channel in one.channels.items()}
    plain = steady_state_table._electrical(columns)
    p = found.parameters["R"]
    assert p.value == pytest.approx(plain["R"].value)
    assert p.statistical == pytest.approx(plain["R"].variance ** 0.5)
    lines = found.budget["R"]
    assert set(lines) == {"noise", "winding warming", "noise of every column"}
    assert lines["noise of every column"] < 0.1 * lines["winding warming"]
    assert p.instrument == pytest.approx(
        np.hypot(lines["winding warming"], lines["noise of every column"])
    )


def test_what_rows_do_not_tell_is_no_more_than_a_usual_rise_does() -> None:
    """A few coarse rows at one voltage."""
    found = steady_state_table.fit([table(0.0, noise=0.03, count=9, seed=2)])
    assert "warming_untold" in codes(found)
    open_ = found.budget["R"]["winding warming"] / R
    usual = table_warming.USUAL_K * ALPHA
    assert 0.2 * usual < open_ < 3.0 * usual


def test_heat_is_kept_from_row_to_row_and_a_table_begins_cold() -> None:
    heat = np.array([1.0, 0.0, 4.0, 2.0, 0.0])
    assert table_warming._kept(heat, 0.0, set()) == pytest.approx(heat / 4.0)
    warm = table_warming._kept(heat, 0.5, {3})
    assert warm == pytest.approx(np.array([1.0, 0.5, 4.25, 2.0, 1.0]) / 4.25)
    assert table_warming._kept(heat, 1.0, {2}) == pytest.approx(
        np.array([1.0, 1.0, 4.0, 6.0, 6.0]) / 6.0
    )


def test_nothing_is_told_without_volts_or_of_too_few_rows() -> None:
    one = table(40.0)
    columns = {name: channel.values for name, channel in one.channels.items()}
    bare = {**columns, VOLTAGE: np.zeros(0)}
    assert table_warming.warming(bare, [24]) is None
    assert table_warming.warming({n: y[:3] for n, y in columns.items()}, [3]) is None
