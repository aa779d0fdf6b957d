"""Supplies and windows of a voltage: where each remark begins, and what it moves."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import SUPPLY, SUPPLY_BEFORE, VOLTAGE, Capture
from motorid.estimate.diagnosis.facts import supply
from motorid.estimate.diagnosis.facts.pwm import aliasing
from motorid.estimate.results.estimate import Diagnostic
from motorid.program import Decay, StepKind
from tests.estimate.diagnosis.facts.test_bench_facts import MOTOR, by_duty, read, run


def said_of(capture: Capture, where: str = "") -> list[Diagnostic]:
    return list(supply.findings(capture, MOTOR, where))


def test_a_supply_is_held_against_its_reading_first() -> None:
    capture = run(supply_voltage_v=9.0)
    (said,) = said_of(read(capture, 7.0), " in run 2")
    assert said.message.startswith(
        "the rig states wiring.supply_voltage_v = 9, but the board read its supply before the run "
        "as 7 V, by which the fit goes in run 2; correct the rig"
    )
    assert "the scale of its voltage is off by -22.2%" in said.message
    volts = capture.channels[VOLTAGE]
    during = replace(volts, name=SUPPLY, raw=np.full(len(capture), 7.0))
    (said,) = said_of(replace(capture, channels={**capture.channels, SUPPLY: during}))
    assert "but the supply's channel shows 7 V, by which the fit goes" in said.message
    assert said_of(replace(run(), wiring=replace(run().wiring, supply_voltage_v=0.0))) == []


@pytest.mark.parametrize(("stated", "named"), [(5.72, False), (5.70, True)])
def test_a_motors_voltage_is_at_most_a_twentieth_above_its_supply(
    stated: float, named: bool
) -> None:
    """6 V, of which 1/1.05 is 5.714."""
    said = said_of(run(supply_voltage_v=stated))
    assert bool(said) is named
    if named:
        assert said[0].moves["L"] == pytest.approx(MOTOR["L"].value * 0.5 * (6.0 / 5.7 - 1.0))
        assert "the terminal voltage reaches 6 V, so that L may be off" in said[0].message
    silent = {n: p for n, p in MOTOR.items() if n != "L"}
    (bare,) = supply.findings(run(supply_voltage_v=5.0), silent)
    assert bare.moves == {}
    known = read(run(supply_voltage_v=5.0), 5.1)
    assert said_of(known) == []  # what was read is not inferred


@pytest.mark.parametrize(("stated", "named"), [(9.3, False), (9.5, True), (8.0, False)])
def test_a_voltage_over_its_duty_misses_the_supply_by_a_seventh(stated: float, named: bool) -> None:
    """8 V: of 9.3 it misses .14, of 9.5 .16."""
    said = said_of(by_duty(run(supply_voltage_v=stated), 8.0))
    assert bool(said) is named
    if named:
        assert said[0].moves["L"] == pytest.approx(MOTOR["L"].value * 0.5 * (1.0 - 8.0 / 9.5))
        assert "over its duty is 8 V, so that L may be off" in said[0].message


def test_only_duties_that_are_large_and_held_by_both_switches_tell_a_supply() -> None:
    assert said_of(run(supply_voltage_v=12.0)) == []  # volts of any supply
    small = by_duty(run(supply_voltage_v=100.0), 31.0)  # duties of .194 and .097
    assert said_of(small) == []
    large = by_duty(run(supply_voltage_v=100.0), 29.0)
    assert len(said_of(large)) == 1
    assert large.program is not None
    steps = [replace(s, decay=Decay.FAST) if s.level else s for s in large.program.steps]
    assert said_of(replace(large, program=replace(large.program, steps=tuple(steps)))) == []
    bare = {n: c for n, c in large.channels.items() if n != VOLTAGE}
    assert said_of(replace(large, channels=bare)) == []
    assert said_of(replace(large, program=None, phases=())) == []


def test_a_parts_later_half_is_read() -> None:
    capture = run(supply_voltage_v=9.0)
    part: Any = SimpleNamespace(start=100, stop=300)
    assert supply._samples(capture, part) == slice(200, 300)
    assert SUPPLY_BEFORE not in capture.provenance


# ---------------------------------------------------------------- windows over part of a PWM period


def test_what_a_part_of_a_period_may_do() -> None:
    """2.5 times its share of the level, and to friction anything."""
    found = aliasing.Aliased(4.0, 0.4)
    assert found.share == pytest.approx(0.1)
    six = {**MOTOR, "L": replace(MOTOR["L"], value=None)}
    moves = aliasing.moves(found, six)
    assert moves == pytest.approx(
        {"R": 0.25 * (MOTOR["R"].value or 0.0), "K": 0.25 * (MOTOR["K"].value or 0.0),
         "J": 0.25 * (MOTOR["J"].value or 0.0), "B": math.inf, "T0": math.inf}
    )  # fmt: skip
    assert aliasing.moves(aliasing.Aliased(1.0, 0.5), MOTOR)["K"] == MOTOR["K"].value


def test_a_harmless_error_is_not_said(monkeypatch: pytest.MonkeyPatch) -> None:
    capture = run(supply_voltage_v=7.0)
    for share, count in ((0.009, 0), (0.011, 1)):
        one = aliasing.Aliased(1.0, share)
        monkeypatch.setattr(aliasing, "aliased", lambda _, one=one: one)
        said = list(aliasing.findings(capture, MOTOR, " in run 2"))
        assert len(said) == count
        assert all(" in run 2: let the board average" in one.message for one in said)
        monkeypatch.setattr(aliasing, "beat_hz", lambda *_: None)
        assert list(aliasing.findings(capture, MOTOR)) == []
        monkeypatch.undo()


def test_nothing_is_seen_in_part_without_a_pwm_a_supply_or_readings() -> None:
    whole = run(supply_voltage_v=7.0)
    volts = replace(whole.channels[VOLTAGE], aperture_s=0.4 / 20e3)
    seen = replace(whole, channels={**whole.channels, VOLTAGE: volts})
    worst = aliasing.aliased(seen)
    assert worst is not None
    assert worst.level_v == pytest.approx(3.0)  # of 3 and 6 V, the larger share of itself
    for wiring in ({"pwm_hz": 0.0}, {"supply_voltage_v": 0.0}):
        assert aliasing.aliased(replace(seen, wiring=replace(seen.wiring, **wiring))) is None
    bare = {n: c for n, c in seen.channels.items() if n != VOLTAGE}
    assert aliasing.aliased(replace(seen, channels=bare)) is None
    part: Any = SimpleNamespace(level=7.0, kind=StepKind.DRIVE_VOLTS, decay=Decay.SYNCHRONOUS_SLOW)
    assert aliasing._of_part(part, 7.0, volts, 20e3) is None  # all of the supply
