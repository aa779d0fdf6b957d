"""A log sampled too slowly, or stamped by another clock, is said to be."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bench.foreign.plant import Motor, turn
from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture, Channel, Phase
from motorid.errors import DataError
from motorid.estimate.diagnosis import sampling_remarks
from motorid.estimate.results.estimate import Parameter, Status
from motorid.estimate.signals.time_grid import Part, lay
from motorid.estimate.signals.voltage_sensing import sense
from motorid.estimate.signals.voltage_window import Window
from motorid.motor.parameters import Motor as MotorOf
from motorid.program import Decay, Program, Step, StepKind
from tests.six_parameters import fit

MOTOR = Motor()
TRUE = turn(MOTOR, lambda t, w: 6.0 if 0.1 < t < 0.5 else 0.0, 0.8)
NOISE = {VOLTAGE: 0.01, CURRENT: 5e-3, SPEED: 0.1}


def codes(period_s: float, late_s: float = 0.0) -> set[str]:
    rng = np.random.default_rng(0)
    stamps = np.arange(1e-3, 0.79, period_s)
    volts = TRUE.at(TRUE.volts, stamps - late_s)
    series = {VOLTAGE: volts, CURRENT: TRUE.at(TRUE.current, stamps),
              SPEED: TRUE.at(TRUE.speed, stamps)}  # fmt: skip
    channels = {
        name: Channel(name, unit, y + NOISE[name] * rng.standard_normal(len(y)))
        for (name, y), unit in zip(series.items(), ("V", "A", "rad/s"), strict=True)
    }
    capture = Capture(np.rint(stamps * 1e6).astype(np.int64), 1e6, channels)
    found = fit([capture])
    return {d.code for d in found.diagnostics} | {
        s.code for s in found.suspects if s.strength == "named"
    }


@pytest.mark.slow
def test_few_readings_a_motion_and_a_late_voltage_are_said() -> None:
    assert sampling_remarks.FEW * 15e-3 > 40e-3  # of the motor's mechanical time constant
    assert "few_samples" in codes(15e-3)
    assert "voltage_lag" in codes(2e-3, 20e-3)
    assert not {"few_samples", "delay_beyond_prior", "voltage_lag"} & codes(2e-3)


class Log:
    """A record as far as these remarks look at one."""

    def __init__(self, period_s: float, log: bool = True, **unknowns: tuple[str, float]) -> None:
        self.outlying = False
        self.capture = SimpleNamespace(period_s=period_s)
        self.sensed = SimpleNamespace(waveform="a log's" if log else None)
        named = unknowns.items()
        self.instances = [
            SimpleNamespace(name=n, quantity=SimpleNamespace(name=n.replace("_", " "), unit=unit))
            for n, (unit, _) in named
        ]  # fmt: skip
        self.unknowns = [SimpleNamespace(prior_mean=1e-3, prior_sd=sd) for _, (_, sd) in named]
        self.found: list[Any] = []


def said(*logs: Log, sizes: tuple[float, ...] = (), **motor: float) -> list[str]:
    """Messages, of a motor whose time constant is 10 ms."""
    values = {"R": 2.0, "L": 1e-3, "K": 0.1, "B": 0.0, "J": 5e-5, "T0": 0.0, **motor}
    solution = SimpleNamespace(own=[np.array(sizes) for _ in logs])
    found: Any = SimpleNamespace(solution=solution, motor=lambda: MotorOf.of(values))
    return [d.message for d in sampling_remarks.of_logs(found, logs)]  # type: ignore[arg-type]


def test_four_readings_in_a_time_constant_are_enough() -> None:
    assert said(Log(2.4e-3)) == []
    (few,) = said(Log(2.6e-3))
    assert "within 10 ms, which is 3.8 samples" in few
    assert few.endswith("Sample every 1 ms")
    assert said(Log(2.6e-3, log=False)) == []  # its program says when it was driven
    assert said(Log(2.6e-3), Log(2.4e-3)) == []  # the finer one shows it
    assert said(Log(2.6e-3), K=0.0) == []
    assert said(Log(2.6e-3), J=0.0) == []
    assert len(said(Log(2.6e-3), B=5e-3)) == 1  # friction makes it quicker
    assert len(said(Log(0.9))) == 1
    assert said(Log(1.1)) == []  # of an absurd motor, which no reading tells


def test_a_delay_far_from_what_was_expected_is_said_with_its_run() -> None:
    late = {"voltage_late": ("s", 2e-3)}
    assert said(Log(1e-3, **late), sizes=(8.9e-3,)) == []  # 1 ms was expected, to 2 ms
    (one,) = said(Log(1e-3, **late), sizes=(9.1e-3,))
    assert "takes voltage late to be 9.1 ms (9 samples), far beyond the 2 ms" in one
    (early,) = said(Log(1e-3, **late), sizes=(-7.1e-3,))
    assert "-7.1 ms (7 samples)" in early
    both = said(Log(1e-3, **late), Log(1e-3, **late), sizes=(9.1e-3,))
    assert [" in run 1 " in both[0], " in run 2 " in both[1]] == [True, True]
    assert said(Log(1e-3, offset=("A", 2e-3)), sizes=(9.1e-3,)) == []  # no delay
    named = Log(1e-3, **late)
    named.found = [named.instances[0]]
    assert said(named, sizes=(9.1e-3,)) == []  # it is a fault by itself


def test_readings_that_lie_far_off_are_said_to_be_stamped_wrongly() -> None:
    one, other = Log(2.4e-3), Log(2.4e-3)
    assert said(one, other) == []
    other.outlying = True
    (uneven,) = said(one, other)
    assert "their stamps may not say when they were read" in uneven


# a board's voltage behind a slow filter


def behind(filter_s: float, *steps: int, commanded: bool = False) -> list[Any]:
    """What is said of a run of steps of so many ms, whose voltage is read each ms."""
    edges = np.cumsum([10, *steps])
    parts = [Part(a, b, StepKind.DRIVE_DUTY, 0.5) for a, b in pairwise(edges.tolist())]
    window = Window(1e-3, 0.0, filter_s, filter_s)
    record: Any = SimpleNamespace(
        sensed=SimpleNamespace(window=window, commanded=commanded),
        timeline=SimpleNamespace(parts=[Part(0, 10, StepKind.COAST), *parts]),
    )
    values = {"R": 2.0, "K": 0.1, "T0": 1e-3}
    motor = {n: Parameter(n, "", v, *[None] * 4, Status.ESTIMATED) for n, v in values.items()}
    return list(sampling_remarks.slow_voltage([record], motor))


def test_a_filter_that_outlasts_the_steps_is_named_and_moves_all() -> None:
    assert behind(0.0, 100, 100) == behind(10e-3, 100, 100) == []
    (slow,) = behind(30e-3, 100, 100)
    shown = np.exp(-(36 + 30) / 30)  # the middle one of 70 that know of their own step alone
    assert (slow.code, slow.severity) == ("voltage_filter_slow", "warning")
    assert f"30 ms is too slow for the steps: {100 * shown:.0f} % and more" in slow.message
    error = sampling_remarks.TOLERANCE * shown * np.log(1 / shown)
    assert slow.moves["R"] == pytest.approx(sampling_remarks.SHIFT * error * 2.0)
    assert slow.moves["T0"] == np.inf
    (none,) = behind(120e-3, 100, 100)
    assert none.moves["R"] == np.inf


def test_few_short_steps_and_a_supply_behind_a_filter_are_no_matter() -> None:
    assert behind(10e-3, 100, 100, 15) == []
    assert len(behind(10e-3, 100, 100, 30)) == 1
    assert behind(30e-3, 100, 100, commanded=True) == []
    assert len(behind(120e-3, 100, 100, commanded=True)) == 1


def test_a_filter_that_hides_every_step_is_refused() -> None:
    """The voltage of the rest before is all that the readings show."""
    steps = [Step(StepKind.COAST, 0.01), Step(StepKind.DRIVE_DUTY, 0.03, 0.5, Decay.FAST)]
    volts = Channel(VOLTAGE, "V", np.zeros(40), filter_s=0.01, delay_s=0.01)
    capture = Capture(
        np.arange(40), 1e3, {VOLTAGE: volts}, program=Program(tuple(steps)),
        phases=(Phase(0, 0), Phase(1, 10)),
    )  # fmt: skip
    assert sense(capture, lay(capture)) is not None
    slower = replace(volts, filter_s=0.1, delay_s=0.1)
    capture = replace(capture, channels={VOLTAGE: slower})
    with pytest.raises(DataError, match=r"low-pass of 100 ms .* of 29 ms at most"):
        sense(capture, lay(capture))
