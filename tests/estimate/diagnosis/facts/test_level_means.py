"""Means over a steady level with their uncertainty, and what the motor's laws foretell there."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, SPEED
from motorid.estimate.diagnosis.facts import steady_levels
from motorid.estimate.diagnosis.facts.steady_levels import Level, Reached, _Means
from motorid.motor.parameters import Motor
from motorid.segment import SegmentKind

MOTOR = {"R": 2.0, "L": 4e-3, "K": 0.05, "B": 4e-5, "J": 2e-5, "T0": 6e-3}
PERIOD_S = 1e-3


def record(values: np.ndarray, name: str = CURRENT, floor: float = 1e-9, **facts: Any) -> Any:
    n = len(values)
    block = SimpleNamespace(name=name, floor=floor)
    measured = SimpleNamespace(
        **{"block": block, "keep": np.arange(n), "values": values, "unsigned": False, **facts}
    )
    timeline = SimpleNamespace(index=np.arange(n), period_s=PERIOD_S)
    return SimpleNamespace(timeline=timeline, measured=[measured])


def means(values: np.ndarray, left: np.ndarray, start: int = 0, stop: int | None = None,
          **how: Any) -> _Means | None:  # fmt: skip
    subject = record(values, **how)
    segment: Any = SimpleNamespace(start=start, stop=len(values) if stop is None else stop)
    return steady_levels._means(subject, subject.measured[0], left, segment)


def test_a_mean_is_as_sure_as_its_scatter_and_its_colour_say() -> None:
    """Of an autoregression the variance of the mean grows by (1 + ρ)/(1 - ρ)."""
    rng = np.random.default_rng(1)
    left = np.zeros(4000)
    for k, e in enumerate(rng.standard_normal(4000)):
        left[k] = 0.6 * left[k - 1] + e
    left -= np.linspace(left[:1000].mean(), left[-1000:].mean(), 4000)  # no drift
    found = means(left + 3.0, left + 0.01)
    assert found is not None
    assert found.name == CURRENT
    assert found.measured == pytest.approx(3.0 + left.mean())
    assert found.off == pytest.approx(0.01 + left.mean())
    about = left - left.mean()
    rho = float(about[1:] @ about[:-1] / (about @ about))
    assert rho == pytest.approx(0.6, abs=0.05)
    drift = (left[-1000:].mean() - left[:1000].mean()) / 2
    white = about.std() * np.sqrt((1 + rho) / (1 - rho) / 4000)
    assert found.u == pytest.approx(np.hypot(white, drift), rel=1e-6)


def test_a_level_that_drifts_is_known_the_less_by_half_of_that() -> None:
    left = np.linspace(-1.0, 1.0, 400)
    found = means(left, left)
    assert found is not None
    assert found.u > (left[-100:].mean() - left[:100].mean()) / 2 == pytest.approx(0.75, rel=0.01)


def test_colour_is_believed_up_to_a_limit_and_below_nothing_is_none() -> None:
    up = np.where(np.arange(64) < 32, 0.5, -0.5)
    found = means(up, up)
    assert found is not None
    # neighbours correlate by .97: it counts, with a drift of half of one
    about = up - up.mean()
    rho = float(about[1:] @ about[:-1] / (about @ about))
    assert found.u == pytest.approx(np.hypot(0.5 * np.sqrt((1 + rho) / (1 - rho) / 64), 0.5))
    even = np.tile([1.0, -1.0], 32)
    found = means(even, even)
    assert found is not None
    assert found.u == pytest.approx(1.0 / 8.0)  # alternation is no knowledge


def test_nothing_is_surer_than_its_rounding() -> None:
    found = means(np.full(64, 3.0), np.full(64, 0.125), floor=0.4)
    assert found is not None
    assert found.u == pytest.approx(0.4 / 8.0)


def test_only_the_levels_own_readings_count_and_enough_of_them() -> None:
    values = np.r_[np.full(20, 100.0), np.full(16, 5.0), np.full(20, 100.0)]
    found = means(values, np.zeros(56), 20, 36)
    assert found is not None
    assert found.measured == 5.0
    assert means(values, np.zeros(56), 20, 35) is None
    assert means(values, np.zeros(56), 20, 36, unsigned=True) is None


def test_a_position_shows_its_speed_by_its_slope() -> None:
    rng = np.random.default_rng(2)
    time = PERIOD_S * np.arange(300)
    left = 0.2 + 0.7 * time + 0.01 * rng.standard_normal(300)
    values = 5.0 + 40.0 * time
    found = means(values, left, name=POSITION)
    assert found is not None
    assert found.name == SPEED
    assert found.measured == pytest.approx(40.0)
    line = np.polyfit(time, left, 1)
    assert found.off == pytest.approx(line[0])
    scatter = np.std(left - np.polyval(line, time))
    assert found.u == pytest.approx(scatter * np.sqrt(2.0) / (time[-1] - time[0]))
    exact = means(values, 0.7 * time, name=POSITION, floor=0.03)
    assert exact is not None
    assert exact.u == pytest.approx(0.03 * np.sqrt(2.0) / (time[-1] - time[0]))


class Known:
    """A solution of which all that is uncertain is given, in search coordinates."""

    def __init__(self, **deviations: float) -> None:
        names = list(MOTOR)
        self.log = [n not in ("B", "T0") for n in names]
        self.search = np.array([np.log(v) if log else v for v, log in
                                zip(MOTOR.values(), self.log, strict=True)])  # fmt: skip
        unknowns = [
            SimpleNamespace(name=n, log=log) for n, log in zip(names, self.log, strict=True)
        ]
        self.solution = SimpleNamespace(unknowns=unknowns, values=None)
        self.sd = np.array([deviations.get(n, 0.0) for n in names])

    def motor(self, search: Any = None) -> Motor:
        at = self.search if search is None else search
        values = [np.exp(x) if log else x for x, log in zip(at, self.log, strict=True)]
        return Motor.of(dict(zip(MOTOR, map(float, values), strict=True)))

    def propagate(self, gradient: np.ndarray) -> tuple[float, float, float]:
        u = float(np.sqrt(((gradient * self.sd) ** 2).sum()))
        return 0.6 * u, 0.8 * u, 10.0


SPEED_THERE = _Means(SPEED, 220.0, 2.0, 0.3)
CURRENT_THERE = _Means(CURRENT, 0.32, 0.004, 0.001)


def test_a_speed_is_foretold_by_the_voltage_of_the_level() -> None:
    """ω = (K v - R T0)/(K² + R B) at v = R i + K ω: its uncertainty by each parameter's."""
    one: Any = Known(R=0.02)
    found = steady_levels._speed(one, [None, SPEED_THERE, CURRENT_THERE])
    assert found is not None
    assert (found.quantity, found.unit, found.measured) == (SPEED, "rad/s", 220.0)
    assert found.foretold == 218.0
    m = MOTOR
    volts = m["R"] * (0.32 - 0.004) + m["K"] * 218.0

    def at(R: float) -> float:
        return (m["K"] * volts - R * m["T0"]) / (m["K"] ** 2 + R * m["B"])

    by_R = 0.02 * m["R"] * (at(2.0 + 1e-5) - at(2.0 - 1e-5)) / 2e-5
    assert found.u == pytest.approx(np.hypot(0.3, by_R), rel=1e-5)
    back: Any = [_Means(SPEED, -220.0, -2.0, 0.3), _Means(CURRENT, -0.32, -0.004, 0.001)]
    reverse = steady_levels._speed(one, back)
    assert reverse is not None
    assert reverse.u == pytest.approx(found.u, rel=1e-6)
    assert steady_levels._speed(one, [CURRENT_THERE]) is None
    assert steady_levels._speed(one, [SPEED_THERE]) is not None


def test_a_speed_is_as_unsure_as_friction_makes_it() -> None:
    """By B, which is no logarithm: dω/dB = −R ω/(K² + R B)."""
    one: Any = Known(B=2e-5)
    found = steady_levels._speed(one, [_Means(SPEED, 220.0, 2.0, 0.0), CURRENT_THERE])
    assert found is not None
    m = MOTOR
    stiff = m["K"] ** 2 + m["R"] * m["B"]
    speed = (m["K"] * (m["R"] * 0.316 + m["K"] * 218.0) - m["R"] * m["T0"]) / stiff
    assert found.u == pytest.approx(2e-5 * m["R"] * speed / stiff, rel=1e-4)


def test_a_current_is_foretold_by_the_friction_at_the_measured_speed() -> None:
    one: Any = Known(T0=1e-4, K=0.01)
    found = steady_levels._current(one, [SPEED_THERE, CURRENT_THERE])
    assert found is not None
    assert (found.quantity, found.unit, found.foretold) == (CURRENT, "A", 0.32 - 0.004)
    amperes = (MOTOR["B"] * 220.0 + MOTOR["T0"]) / MOTOR["K"]
    by = np.hypot(1e-4 / MOTOR["K"], 0.01 * amperes)
    assert found.u == pytest.approx(np.hypot(0.001, by), rel=1e-5)
    still = steady_levels._current(one, [CURRENT_THERE])
    assert still is not None
    assert still.u == 0.001
    assert steady_levels._current(one, [SPEED_THERE]) is None


def reached(name: str, measured: float, foretold: float, u: float = 0.01) -> Reached:
    return Reached(name, "x", measured, foretold, u)


def test_what_would_make_up_for_a_difference() -> None:
    motor = Motor.of(MOTOR)
    fast = Level(0, 0.0, 1.0, reached(SPEED, -200.0, -190.0), reached(CURRENT, 0.3, 0.5))
    assert fast.speed is not None
    assert fast.current is not None
    assert steady_levels._moves(fast.speed, fast, motor) == pytest.approx({"K": 0.05 * 10 / 200})
    found = steady_levels._moves(fast.current, fast, motor)
    assert found == pytest.approx({"T0": 0.05 * 0.2, "B": 0.05 * 0.2 / 200.0})
    alone = Level(0, 0.0, 1.0, None, fast.current)
    assert steady_levels._moves(fast.current, alone, motor) == pytest.approx({"T0": 0.01})
    assert steady_levels._moves(reached(SPEED, 0.0, 1.0), fast, motor) == {}


def test_of_each_quantity_the_level_that_differs_most_is_said() -> None:
    motor = Motor.of(MOTOR)
    levels = [
        Level(0, 0.1, 0.2, reached(SPEED, 100.0, 90.0, 1.0), reached(CURRENT, 1.0, 1.001, 1e-6)),
        Level(1, 0.3, 0.4, reached(SPEED, 100.0, 95.0, 0.1)),
        Level(1, 0.5, 0.6, reached(SPEED, 100.0, 99.9, 0.1)),
    ]
    (said,) = steady_levels.findings(levels, motor, 2)
    assert said.code == "steady_speed"
    assert said.message.startswith("steady level from 0.300 to 0.400 s in run 2: the speed was")
    assert "measured as 100 x and is predicted as 95 x, 50 standard uncertainties" in said.message
    assert said.moves == pytest.approx({"K": 0.05 * 5 / 100})
    (alone,) = steady_levels.findings(levels[:1], motor)
    assert "0.200 s: the speed" in alone.message


@pytest.mark.parametrize(
    ("measured", "u", "differs"),
    [(100.0, 3.3, True), (100.0, 3.4, False), (-100.0, 0.1, True)],
)
def test_a_difference_counts_beyond_three_uncertainties(
    measured: float, u: float, differs: bool
) -> None:
    assert reached(SPEED, measured, 0.9 * measured, u).differs is differs
    assert not reached(SPEED, measured, 0.9901 * measured, 1e-9).differs
    assert reached(SPEED, measured, 0.9899 * measured, 1e-9).differs


def test_a_level_that_turns_twice_and_shows_a_speed_is_looked_at(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    kept = []
    for speed, turns in ((13.0, True), (12.0, False)):  # over a second: 2 turns are 12.57 rad
        segment = SimpleNamespace(kind=SegmentKind.STEADY, start=0, stop=1001)
        other = SimpleNamespace(kind=SegmentKind.COAST, start=0, stop=1001)
        capture = SimpleNamespace(time_s=PERIOD_S * np.arange(1001))
        one: Any = Known()
        one.solution.own = [np.zeros(0)]
        subject = record(np.full(1001, speed), SPEED)
        subject.departures = lambda *_: [np.zeros(1001)]
        named: Any = [(capture, [other, segment])]
        found = steady_levels.levels(one, [subject], named)
        assert bool(found) is turns
        kept += found
    (level,) = kept
    assert (level.start_s, level.end_s, level.current) == (0.0, pytest.approx(1.0), None)
    quiet = SimpleNamespace(kind=SegmentKind.COAST, start=0, stop=1001)
    one.solution.own, turns_fast = [np.zeros(0)] * 2, record(np.full(1001, 13.0), SPEED)
    turns_fast.departures = lambda *_: [np.zeros(1001)]
    second: Any = [(capture, [quiet]), (capture, [segment])]
    still = record(np.full(1001, 13.0), SPEED)
    still.departures = lambda *_: pytest.fail("nothing is computed without a level")
    (later,) = steady_levels.levels(one, [still, turns_fast], second)
    assert (later.capture, later.start_s) == (1, 0.0)
    one.solution.own = [np.zeros(0)]
    none: Any = [(capture, [other])]
    assert steady_levels.levels(one, [subject], none) == []
