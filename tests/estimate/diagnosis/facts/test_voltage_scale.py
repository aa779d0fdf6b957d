"""The motor's voltage beside what drove it: a scale that is off, and none that a bridge feigns."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import CURRENT, SUPPLY, SUPPLY_BEFORE, VOLTAGE, Capture, Channel
from motorid.estimate.diagnosis.facts import voltage_scale
from motorid.estimate.results.estimate import Parameter
from motorid.estimate.results.status import Status
from motorid.program import Decay, Program, StepKind
from tests.exact_capture import FAULHABER, Plan, clean_capture

SUPPLIED = 8.0


def run(
    gain: float = 1.0, ohms: float = 0.0, dead_v: float = 0.0, duty: bool = False,
    volts: tuple[float, ...] = (6.0, 3.0), known: bool = True, **facts: float,
) -> Capture:  # fmt: skip
    """A capture whose voltage reads ``gain`` times what a lossy bridge leaves of the level."""
    made = clean_capture(FAULHABER, Plan(volts, 800))
    assert made.program is not None
    steps = tuple(
        replace(one, kind=StepKind.DRIVE_DUTY, level=one.level / SUPPLIED)
        if duty and one.kind == StepKind.DRIVE_VOLTS
        else one
        for one in made.program.steps
    )
    channel, i = made.channels[VOLTAGE], made.channels[CURRENT].values
    driven = channel.raw != 0.0
    lost = np.where(driven, ohms * i + dead_v * np.sign(i), 0.0)
    shown = replace(channel, raw=gain * (channel.raw - lost), **facts)
    provenance = {**made.provenance, SUPPLY_BEFORE: SUPPLIED} if known else made.provenance
    channels = {**made.channels, VOLTAGE: shown}
    return replace(made, program=Program(steps), channels=channels, provenance=provenance)


@pytest.mark.parametrize("duty", [False, True])
@pytest.mark.parametrize("gain", [0.9, 0.96, 1.0, 1.05, 1.3])
def test_the_scale_is_found_behind_any_bridge(gain: float, duty: bool) -> None:
    R = FAULHABER["R"]
    found = voltage_scale.scale(run(gain, 0.2 * R, 0.05, duty))
    assert found is not None
    assert found.value == pytest.approx(gain, abs=0.006)
    assert found.uncertainty == pytest.approx(voltage_scale.USUAL, rel=0.2)


def test_either_way_is_said_with_all_that_it_moves() -> None:
    R = Parameter("R", "ohm", 2.0, None, None, None, None, Status.ESTIMATED)
    for gain in (0.93, 1.06):
        (said,) = voltage_scale.findings(run(gain, 0.3), {"R": R}, " in run 2")
        assert (said.code, said.severity) == ("voltage_contradicted", "warning")
        assert f"reads {gain:.3g} times what the program gave it in run 2" in said.message
        assert said.moves["R"] == pytest.approx(2.0 * abs(gain - 1.0), rel=0.1)
    for gain in (0.975, 1.0, 1.025):
        assert list(voltage_scale.findings(run(gain, 0.3), {"R": R})) == []
    unsure = run(1.06, 0.3, gain_uncertainty=0.02)
    assert list(voltage_scale.findings(unsure, {"R": R})) == []


def test_the_supplys_own_readings_give_what_a_duty_gives() -> None:
    capture = run(1.0, duty=True, known=False)
    assert voltage_scale.scale(capture) is None  # nobody measured it
    high = Channel(SUPPLY, "V", np.full(len(capture), 1.1 * SUPPLIED), gain_uncertainty=0.005)
    found = voltage_scale.scale(replace(capture, channels={**capture.channels, SUPPLY: high}))
    assert found is not None
    assert found.value == pytest.approx(1.0 / 1.1, rel=0.005)
    assert found.uncertainty == pytest.approx(0.005, rel=0.1)


@pytest.mark.slow
def test_nothing_is_said_where_nobody_knows_what_drove_the_motor() -> None:
    good = run(1.2)
    assert voltage_scale.scale(replace(good, program=None, phases=())) is None
    for sense in ("supply", None):
        shown = replace(good.channels[VOLTAGE], sense=sense)
        channels = {**good.channels, VOLTAGE: shown}
        assert voltage_scale.scale(replace(good, channels=channels)) is None
    bare = {n: c for n, c in good.channels.items() if n != CURRENT}
    assert voltage_scale.scale(replace(good, channels=bare)) is None
    assert voltage_scale.scale(run(1.2, volts=(6.0, 6.0))) is None  # a drop looks as a scale
    assert voltage_scale.scale(run(1.2, volts=(1.0, 0.5))) is None  # dead time is most of it
    assert good.program is not None
    fast = tuple(replace(one, decay=Decay.FAST) if one.level else one for one in good.program.steps)
    assert voltage_scale.scale(replace(good, program=Program(fast))) is None
    full = run(1.2, volts=(7.9, 7.7))  # more than the supply can hold
    assert voltage_scale.scale(full) is None
