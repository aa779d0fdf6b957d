"""Blocks of a log whose voltage no R, K and L explain: how many, how far, and at which lag."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.diagnosis import foreign_voltage
from motorid.program import Program, Step, StepKind

RNG = np.random.default_rng(6)


def test_blocks_are_means_of_the_voltage_some_samples_later() -> None:
    volts, current, speed = np.arange(10.0), np.arange(10.0) ** 2, np.full(10, 7.0)
    found = foreign_voltage._blocks((volts, current, speed), 0, 4)
    rises = np.gradient(current)
    expected = [[1.5, 3.5, 7.0, rises[:4].mean()], [5.5, 31.5, 7.0, rises[4:8].mean()]]
    assert found == pytest.approx(np.array(expected))
    later = foreign_voltage._blocks((volts, current, speed), 3, 4)
    assert later[:, 0] == pytest.approx([4.5, (7 + 8 + 9 + 9) / 4])
    earlier = foreign_voltage._blocks((volts, current, speed), -2, 4)
    assert earlier[:, 0] == pytest.approx([(0 + 0 + 0 + 1) / 4, 3.5])
    assert later[:, 1:] == pytest.approx(found[:, 1:])


def part(off: float = 0.0, every: int = 8, blocks: int = 120) -> tuple[Any, Any, Any]:
    """Rows in blocks of four of a motor at up to 10 V; of each so many blocks one is off, in turn
    above and below."""
    n = 4 * blocks
    current, speed = RNG.uniform(-1.0, 1.0, n), np.repeat(RNG.uniform(-160.0, 160.0, blocks), 4)
    volts = 2.0 * current + 0.05 * speed + 3.0 * np.gradient(current)
    scale = 10.0 / np.percentile(np.abs(volts.reshape(-1, 4).mean(axis=1)), 98)
    wrong = np.zeros(blocks)
    wrong[::every] = off * (-1.0) ** np.arange(len(wrong[::every]))
    return scale * volts + np.repeat(wrong, 4), current, speed


@pytest.mark.parametrize(("off", "share"), [(0.0, 0.0), (2.0, 0.0), (3.2, 1 / 8)])
def test_a_block_departs_by_a_quarter_of_the_highest_voltage(off: float, share: float) -> None:
    assert foreign_voltage._departs([part(off)], 0) == pytest.approx(share, abs=0.01)


def test_blocks_of_all_parts_are_judged_together_if_they_are_enough() -> None:
    many = foreign_voltage._departs([part(3.2, 4, 60), part(0.0, 4, 60)], 0)
    assert many == pytest.approx(1 / 8, abs=0.03)
    few = [part(9.0, 4, 12), part(9.0, 4, 11)]
    assert foreign_voltage._departs(few, 0) == 0.0
    assert foreign_voltage._departs([part(9.0, 4, 12), part(9.0, 4, 12)], 0) > 0.0
    # of a log ten times as long, blocks are ten times as wide
    long = tuple(np.repeat(column, 10) for column in part(3.2))
    assert foreign_voltage._departs([long], 0) == pytest.approx(1 / 8, abs=0.02)  # type: ignore[list-item]


def log(**facts: Any) -> Capture:
    volts, current, speed = part()
    known = {VOLTAGE: ("V", volts), CURRENT: ("A", current), SPEED: ("rad/s", speed)}
    channels = {n: Channel(n, unit, values) for n, (unit, values) in known.items()}
    return Capture(1000 * np.arange(len(volts)), 1e6, **{"channels": channels, **facts})


def said(monkeypatch: pytest.MonkeyPatch, capture: Capture, *shares: float) -> list[Any]:
    """Of blocks that depart in such shares, lag after lag; the last is for the others too."""
    of = dict(zip(foreign_voltage.LAGS, shares, strict=False))
    monkeypatch.setattr(foreign_voltage, "_departs", lambda _, lag: of.get(lag, shares[-1]))
    return foreign_voltage.remarks([capture])


def test_the_lag_at_which_fewest_depart_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    assert said(monkeypatch, log(), 0.12) == []
    assert said(monkeypatch, log(), 0.5, 0.12, 0.5) == []
    (one,) = said(monkeypatch, log(path=Path("run.csv")), 0.5, 0.14, 0.5)
    assert (one.code, one.severity) == ("foreign_voltage", "warning")
    assert one.message.startswith(
        "the voltage of run.csv cannot be the motor's: in 14 % of the log it departs from R i + K "
        "ω by more than 25 % of its highest value; log the voltage at the motor's terminals"
    )
    assert set(one.moves.values()) == {np.inf}
    (bare,) = said(monkeypatch, log(), 0.14)
    assert bare.message.startswith("the voltage cannot be")
    steady = log()
    supply = replace(steady.channels[VOLTAGE], raw=12.1 + 0.1 * RNG.uniform(-1.0, 1.0, len(steady)))
    (still,) = said(
        monkeypatch, replace(steady, channels={**steady.channels, VOLTAGE: supply}), 0.9
    )
    assert "it stays near 12.1 V whatever current and speed do" in still.message


@pytest.mark.parametrize("lacking", [VOLTAGE, CURRENT, SPEED])
def test_a_log_is_judged_by_voltage_current_and_motion(
    lacking: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = log()
    rest = {n: c for n, c in whole.channels.items() if n != lacking}
    assert said(monkeypatch, replace(whole, channels=rest), 0.9) == []
    if lacking != VOLTAGE:
        blind = replace(whole.channels[lacking], raw=np.abs(whole.channels[lacking].raw),
                        unsigned=True)  # fmt: skip
        channels = {**whole.channels, lacking: blind}
        assert said(monkeypatch, replace(whole, channels=channels), 0.9) == []
    program = Program((Step(StepKind.COAST, 1.0),))
    assert said(monkeypatch, replace(whole, program=program), 0.9) == []
    assert len(said(monkeypatch, whole, 0.9)) == 1


def test_a_position_moves_by_its_slope() -> None:
    whole = log()
    angle = Channel(POSITION, "rad", 3.0 * whole.time_s**2)
    channels = {n: c for n, c in whole.channels.items() if n != SPEED}
    turned = replace(whole, channels={**channels, POSITION: angle})
    found = foreign_voltage._columns(turned)
    assert found is not None
    assert found[2][5:-5] == pytest.approx(6.0 * whole.time_s[5:-5])
