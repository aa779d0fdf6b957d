"""Starts from voltage and current alone: a back-EMF of a motor that scipy drove."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from motorid.capture.model import CURRENT, POSITION, SPEED
from motorid.errors import DataError
from motorid.estimate.fit import start_values_without_motion as without
from motorid.estimate.signals.measurements import EMF
from motorid.estimate.signals.time_grid import Part
from motorid.program import StepKind

R, L, K, B, J, T0 = 2.0, 2e-4, 0.05, 4e-5, 2e-4, 6e-3
PERIOD_S, DRIVEN, SERIES = 1e-3, 1200, 0.3
VOLTS = (6.0, 12.0, 8.0)


def ran() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Voltage, current and speed of three levels in turn."""
    times = PERIOD_S * np.arange(DRIVEN)
    each = DRIVEN // len(VOLTS)

    def slope(t: float, y: np.ndarray) -> list[float]:
        i, w = y
        v = VOLTS[min(int(t / (PERIOD_S * each)), 2)]
        dry = T0 if w > 0 else 0.0
        return [(v - (R + SERIES) * i - K * w) / L, (K * i - B * w - dry) / J]

    found = solve_ivp(slope, (0, times[-1]), [0, 0.1], t_eval=times, method="LSODA", max_step=1e-2)
    return np.repeat(VOLTS, each).astype(float), found.y[0], found.y[1]


RAN = ran()


def record(scale: float = 1.0, names: tuple[str, ...] = (CURRENT,), offset: float = 0.0,
           unsigned: bool = False) -> Any:  # fmt: skip
    volts, current, speed = RAN
    edges = [0, DRIVEN // 3, 2 * DRIVEN // 3, DRIVEN]
    parts = tuple(Part(a, b, StepKind.DRIVE_DUTY, 0.5) for a, b in pairwise(edges))
    series = {CURRENT: current + offset, EMF: K * speed, SPEED: speed, POSITION: np.cumsum(speed)}
    measured = [
        SimpleNamespace(block=SimpleNamespace(name=n), unsigned=unsigned, keep=np.arange(DRIVEN),
                        values=series[n]) for n in names
    ]  # fmt: skip
    return SimpleNamespace(
        measured=measured, volts=scale * volts, driven=np.ones(DRIVEN, bool),
        unknowns=(SimpleNamespace(name="current offset", start=offset),),
        timeline=SimpleNamespace(count=DRIVEN, period_s=PERIOD_S, parts=parts),
        sensed=SimpleNamespace(volts=scale * volts, series_ohm=SERIES),
    )  # fmt: skip


def begun(monkeypatch: pytest.MonkeyPatch, *records: Any, **fixed: float
          ) -> tuple[dict[str, float], list[Mapping[str, float]]]:  # fmt: skip
    """The start that is chosen, by how near its resistance and L/R are; and all that were tried."""
    tried: list[Mapping[str, float]] = []

    def misfit(_r: Any, start: Mapping[str, float], _f: Any) -> float:
        tried.append(start)
        return abs(start["R"] / R - 1.0) + abs(np.log(start["L"] / L))

    monkeypatch.setattr(without, "_misfit", misfit)
    return without.start_values(records or [record()], {"K": K, **fixed}), tried


def test_the_back_emf_of_the_right_resistance_gives_the_motor(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found, tried = begun(monkeypatch, R=R)
    assert found["J"] == pytest.approx(J, rel=0.05)
    usual = float(np.median(RAN[2]))  # what brakes it there is shared by guess
    assert found["B"] * usual + found["T0"] == pytest.approx(B * usual + T0, rel=0.05)
    assert (found["R"], found["K"]) == (R, K)
    assert [s["L"] for s in tried] == pytest.approx([t * R * PERIOD_S for t in without.TIMES])


def test_an_offset_of_the_current_is_taken_off(monkeypatch: pytest.MonkeyPatch) -> None:
    clean, _ = begun(monkeypatch, R=R)
    shifted, _ = begun(monkeypatch, record(offset=0.4), R=R)
    assert shifted == pytest.approx(clean)


def test_each_resistance_that_the_peaks_allow_is_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    volts, current, _ = RAN
    most = np.abs(volts - SERIES * current).max() / np.abs(current).max()
    found, tried = begun(monkeypatch)
    ohms = sorted({s["R"] for s in tried})
    shares = np.array(ohms) / most  # the smallest ones leave no motion that follows the current
    assert shares[-1] <= 1.0 + 1e-9
    assert np.diff(shares) == pytest.approx(0.1)
    assert [round(s["L"] / s["R"] / PERIOD_S, 9) for s in tried] == [0.1, 1.0, 10.0] * len(ohms)
    assert set(np.round(ohms, 9)) <= set(np.round(most * without.SHARES, 9))
    assert found["R"] == min(ohms, key=lambda r: abs(r / R - 1.0))
    assert found["J"] > 0.0


def test_what_is_held_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    found, _ = begun(monkeypatch, R=R, B=0.0, L=5e-4)
    assert (found["B"], found["L"]) == (0.0, 5e-4)


def test_the_least_resistance_of_several_captures_is_the_most(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    other = record()
    other.measured[0].values = 2.0 * other.measured[0].values
    _, tried = begun(monkeypatch, record(), other)
    _, alone = begun(monkeypatch, other)
    assert max(s["R"] for s in tried) <= max(s["R"] for s in alone) * (1 + 1e-9)


def test_the_drive_may_be_small_but_must_be_one(monkeypatch: pytest.MonkeyPatch) -> None:
    small = record(0.05)
    small.measured[0].values = 0.05 * RAN[1]
    assert begun(monkeypatch, small, R=R)[0]["J"] > 0.0
    with pytest.raises(DataError, match="never driven"):
        begun(monkeypatch, record(0.0))


def test_captures_that_show_no_motion_by_their_current_are_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with pytest.raises(DataError, match="neither a motion nor a signed current"):
        begun(monkeypatch, record(unsigned=True))
    with pytest.raises(DataError, match="neither a motion nor a signed current"):
        begun(monkeypatch, record(names=()))
    silent = record()
    silent.measured[0].values = np.zeros(DRIVEN)
    with pytest.raises(DataError, match="no current flowed"):
        begun(monkeypatch, silent)


def test_resistances_with_which_no_motor_would_turn_are_passed_over(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: list[float] = []

    def mechanical(data: Any, _K: float, _fixed: Any) -> tuple[float, float, float]:
        seen.append(float(data[0].angle[-1]))
        if len(seen) != 3:
            raise DataError("it would move by itself")
        return B, J, T0

    monkeypatch.setattr(without, "mechanical", mechanical)
    _, tried = begun(monkeypatch)
    assert len(seen) == len(without.SHARES)
    assert len(tried) == len(without.TIMES)
    assert seen == sorted(seen, reverse=True)  # more resistance leaves less back-EMF
    with pytest.raises(DataError, match="shows no motion that follows the current"):
        begun(monkeypatch, R=R)


def test_an_open_bridge_shows_its_back_emf() -> None:
    one = record(names=(CURRENT, EMF))
    one.driven[800:] = False
    readings = without._Readings(one)
    signals = readings.signals(R, K)
    _, current, speed = RAN
    assert signals.current[:800] == pytest.approx(current[:800])
    assert not signals.current[800:].any()
    assert not signals.volts[800:].any()
    turned = np.diff(signals.angle) / PERIOD_S
    assert turned[800:] == pytest.approx(speed[801:])
    settled = turned[300:390]
    assert settled == pytest.approx(speed[301:391], rel=0.02)
    assert signals.edges == (0, 400, 800, 1200)
    assert signals.series_ohm == SERIES


def test_it_suits_where_nothing_shows_a_motion_and_the_constant_is_held() -> None:
    assert without.suits([record()], {"K": K})
    assert not without.suits([record()], {})
    for name in (SPEED, POSITION):
        assert not without.suits([record(), record(names=(CURRENT, name))], {"K": K})


@pytest.mark.slow
@pytest.mark.parametrize("periods", [0.03, 0.3, 3.0, 30.0])
def test_some_start_has_nearly_the_time_constant_of_the_winding(
    periods: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    _, tried = begun(monkeypatch, R=R)
    ratios = [s["L"] / (periods * R * PERIOD_S) for s in tried]
    assert min(abs(np.log10(r)) for r in ratios) < 0.6


def test_the_likelihood_of_all_readings_chooses(monkeypatch: pytest.MonkeyPatch) -> None:
    """With every parameter that is not held as it begins there."""
    seen: list[Any] = []

    class Likelihood:
        def __init__(self, *of: Any) -> None:
            seen.append(of)
            self.start = SimpleNamespace(objective=7.0)

    monkeypatch.setattr(without, "unknowns_of", lambda *of: seen.append(of) or "unknowns")
    monkeypatch.setattr(without, "Concentrated", Likelihood)
    records, start = ["record"], {"R": 2.0}
    assert without._misfit(records, start, {"K": K, "B": B}) == 7.0  # type: ignore[arg-type]
    assert seen == [(records, ["R", "L", "J", "T0"], start), ("unknowns", records)]


def test_a_motion_of_one_record_is_enough_and_so_is_a_lacking_constant() -> None:
    still, moving = record(), record(names=(CURRENT, SPEED))
    assert without.suits([still, still], {"K": K})
    assert not without.suits([still, moving], {"K": K})
    assert not without.suits([still], {"R": R})


def test_the_currents_of_all_captures_must_flow(monkeypatch: pytest.MonkeyPatch) -> None:
    """And one that is driven is enough."""
    silent, undriven = record(), record(0.0)
    silent.measured[0].values = np.zeros(DRIVEN)
    with pytest.raises(DataError, match="no current flowed"):
        begun(monkeypatch, record(), silent)
    assert begun(monkeypatch, undriven, record(), R=R)[0]["R"] == R
