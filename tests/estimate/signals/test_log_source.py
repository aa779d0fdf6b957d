"""A supply with a resistance before a log's voltmeter, by exact steps of the motor's linear law."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from scipy.linalg import expm

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.signals.log_source import source, source_ohms
from tests.six_parameters import fit

R, L, K, B, J, T0 = 1.3, 4e-4, 0.02, 3e-6, 8e-6, 1.5e-3
TRUE = {"R": R, "L": L, "K": K, "J": J}
VOLTS, EACH = (0.0, 6.0, 11.0, 4.0, 9.0), 160  # one way, so that friction keeps its sign


def turned(
    ohms: float,
    period_s: float,
    levels: Sequence[float] = VOLTS,
    shares: Sequence[float] = (),
) -> dict[str, np.ndarray]:
    """Readings at instants of what turns behind a source of so many ohms. ``shares``: of a period,
    by which each jump comes after the last reading before it; none: it comes with a reading.
    """
    law = np.zeros((4, 4))  # current, speed; source, friction
    law[0] = [-(R + ohms) / L, -K / L, 1 / L, 0.0]
    law[1] = [K / J, -B / J, 0.0, -1 / J]
    step = expm(law * period_s)[:2]
    source, state, rows = np.repeat(levels, EACH), np.zeros(2), []
    jumped = dict(zip(EACH * np.arange(1, len(levels)), shares, strict=False))
    for n, u in enumerate(source, start=1):
        rows.append((u - ohms * state[0], *state))
        friction = T0 if u or state[1] > 0.0 else 0.0
        if n not in jumped:
            state = step @ [*state, u, friction]
            continue
        for volts, share in ((u, jumped[n]), (source[n], 1.0 - jumped[n])):
            state = expm(law * share * period_s)[:2] @ [*state, volts, T0]
    volts, amperes, speed = np.array(rows).T
    return {VOLTAGE: volts, CURRENT: amperes, SPEED: speed}


def log(
    ohms: float,
    period_s: float,
    levels: Sequence[float] = VOLTS,
    shares: Sequence[float] = (),
) -> Capture:
    rng = np.random.default_rng(5)
    shown = turned(ohms, period_s, levels, shares)
    noise = {VOLTAGE: 2e-3, CURRENT: 2e-3, SPEED: 0.2}
    units = {VOLTAGE: "V", CURRENT: "A", SPEED: "rad/s"}
    channels = {
        name: Channel(name, units[name], x + noise[name] * rng.standard_normal(len(x)))
        for name, x in shown.items()
    }
    ticks = np.rint(np.arange(len(levels) * EACH) * period_s * 1e9).astype(np.int64)
    return Capture(ticks, 1e9, channels)


def steps() -> np.ndarray:
    return EACH * np.arange(1, len(VOLTS))


@pytest.mark.slow
def test_the_resistance_is_what_the_current_shows() -> None:
    shown = turned(0.2, 1e-3)
    assert source_ohms(shown[VOLTAGE], shown[CURRENT], steps()) == pytest.approx(0.2, rel=1e-6)
    stiff = turned(0.0, 1e-3)
    assert source_ohms(stiff[VOLTAGE], stiff[CURRENT], steps()) == 0.0


def test_noise_is_no_resistance() -> None:
    rng = np.random.default_rng(3)
    shown = turned(0.0, 1e-3)
    volts = shown[VOLTAGE] + 0.01 * rng.standard_normal(len(shown[VOLTAGE]))
    assert source_ohms(volts, shown[CURRENT], steps()) == 0.0
    assert source_ohms(volts, np.full(len(volts), np.nan), steps()) == 0.0
    assert source_ohms(volts, np.zeros(len(volts)), steps()) == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("samples", [0.4, 1.5])
def test_the_inductance_holds_behind_a_weak_supply(samples: float) -> None:
    """L/R of less than a sample: between two readings the terminals fall by what no line tells."""
    found = fit([log(0.2 * R, L / R / samples)], model="six").parameters
    for name, true in TRUE.items():
        p = found[name]
        assert abs(p.value - true) < 3.0 * p.total, name
        assert p.total < 0.05 * true, name


SMALL = (0.0, 6.0, 11.0, 10.6, 4.0, 9.0)  # one jump is less than 5 % of the range


def test_small_jumps_of_a_source_are_seen_where_its_terminals_follow_the_current() -> None:
    shown = log(0.2, 1e-3, SMALL, (0.3, 0.8, 0.1, 0.6, 0.45)).channels
    ohms, jumped = source(shown[VOLTAGE].values, shown[CURRENT].values)
    assert ohms == pytest.approx(0.2, rel=0.02)
    assert jumped.tolist() == [EACH * n for n in range(1, 6)]


def test_without_a_source_its_jumps_are_those_of_the_terminals() -> None:
    shown = log(0.0, 1e-3).channels
    ohms, jumped = source(shown[VOLTAGE].values, shown[CURRENT].values)
    assert ohms == 0.0
    assert jumped.tolist() == steps().tolist()


@pytest.mark.slow
@pytest.mark.parametrize("samples", [0.4, pytest.param(0.8, marks=pytest.mark.study)])
def test_the_inductance_holds_where_a_weak_supply_jumps_at_any_moment(samples: float) -> None:
    """What the terminals had between the jump and the next reading fell with the current."""
    shown = log(0.1 * R, L / R / samples, SMALL, (0.3, 0.8, 0.1, 0.6, 0.45))
    found = fit([shown], model="six").parameters
    for name, true in TRUE.items():
        p = found[name]
        assert abs(p.value - true) < 3.0 * p.total, name
        assert p.total < 0.05 * true, name


def stretch(count: int, volts: float, ohms: float = 0.3, off: float = 0.0) -> np.ndarray:
    """Rows of V and A behind so many ohms, the first two of which came in the jump's middle."""
    amperes = 1.0 + 0.5 * (-1.0) ** np.arange(count)
    shown = volts - ohms * amperes + off * (-1.0) ** (np.arange(count) // 2)
    shown[:2] = 77.0
    return np.array([shown, amperes])


def told(*stretches: np.ndarray) -> float:
    volts, amperes = np.hstack(stretches)
    return source_ohms(volts, amperes, np.cumsum([s.shape[1] for s in stretches])[:-1])


def test_two_stretches_of_eight_readings_after_the_jump_tell_a_resistance() -> None:
    assert told(stretch(10, 6.0), stretch(10, 2.0)) == pytest.approx(0.3)
    assert told(stretch(20, 6.0)) == 0.0
    assert told(stretch(10, 6.0), stretch(9, 2.0)) == 0.0


def test_a_stretch_with_a_missing_current_tells_nothing() -> None:
    broken = stretch(30, 4.0, ohms=5.0)
    broken[1, 20] = np.nan
    assert told(stretch(10, 6.0), broken, stretch(10, 2.0)) == pytest.approx(0.3)


@pytest.mark.parametrize(("sure", "given"), [(8.0, False), (12.0, True)])
def test_a_resistance_is_any_from_ten_deviations_on(sure: float, given: bool) -> None:
    """Of 16 readings .5 A from their mean, which are e V off: e / (.5 sqrt(16))."""
    for ohms in (0.3, 30.0):
        off = ohms / sure * 0.5 * 4.0
        found = told(stretch(10, 6.0, ohms, off), stretch(10, 2.0, ohms, off))
        assert found == pytest.approx(ohms if given else 0.0)
