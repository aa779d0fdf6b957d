"""Where the volts of a command are not reached: bounds, sentence and silence, by made blocks."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED, SUPPLY, VOLTAGE
from motorid.estimate.diagnosis.facts import unreached_command
from motorid.estimate.fit.block_regression import Blocks
from motorid.program import Decay, Step, StepKind

Floats = NDArray[np.float64]

COUNT, PERIOD_S = 60, 0.01
R, K, DROP = 2.0, 0.05, 0.1
RNG = np.random.default_rng(4)
SPEEDS = RNG.uniform(20.0, 60.0, COUNT)
HIGHEST = 10.0  # V, at the last block


def blocks(lack: float = 0.0, at: slice = slice(20, 26), level: float = 6.0, way: float = 1.0,
           amps: Floats | float = 1.5, settled: slice = slice(0, COUNT)) -> Blocks:  # fmt: skip
    """Of a motor whose command is ``level`` volts there, of which it gets less by ``lack``."""
    speed = way * SPEEDS
    current = way * RNG.uniform(0.5, 1.5, COUNT)
    there = np.zeros(COUNT, dtype=bool)
    there[at] = True
    current[there] = way * amps
    speed[there] = (way * (level - lack - DROP) - R * current[there]) / K
    volts = R * current + K * speed + way * DROP
    volts[there] += way * lack
    speed[-1] = (way * (HIGHEST - DROP) - R * current[-1]) / K
    volts[-1] = way * HIGHEST
    known = np.zeros(COUNT, dtype=bool)
    known[settled] = True
    none = np.zeros(COUNT)
    return Blocks(
        volts, current, speed, none, known, known, (slice(0, COUNT),), np.array([PERIOD_S])
    )


def said(monkeypatch: pytest.MonkeyPatch, made: Blocks | None, where: str = "") -> list[Any]:
    monkeypatch.setattr(unreached_command, "_by_command_alone", lambda _: True)
    monkeypatch.setattr(unreached_command, "MotorRecord", lambda *_: None)
    monkeypatch.setattr(unreached_command, "blocks", lambda _: made)
    capture: Any = None
    return list(unreached_command.findings(capture, where))


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_stretch_is_named_by_its_begin_its_share_and_the_current_that_stood(
    way: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    (one,) = said(monkeypatch, blocks(1.5, way=way), " in run 2")
    assert (one.code, one.severity) == ("supply_limited", "warning")
    assert one.message.startswith(
        "from 0.2 s on in run 2 the motor answers as if it got up to 25% less than the volts of "
        "its command while the current stood at 1.5 A: the supply limits"
    )
    assert not one.moves


@pytest.mark.parametrize(("spread", "stands"), [(0.08, True), (0.12, False)])
def test_a_current_stands_where_half_of_it_lies_within_a_tenth(
    spread: float, stands: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Quartiles of five readings are the second and the fourth."""
    amps = 2.0 * np.array([0.5, 1.0 - spread / 2.0, 1.0, 1.0 + spread / 2.0, 1.3])
    (one,) = said(monkeypatch, blocks(2.0, slice(20, 25), 8.0, amps=amps))
    assert ("while the current stood at 2 A" in one.message) is stands


@pytest.mark.parametrize(
    ("made", "named"),
    [
        (blocks(0.7), True), (blocks(0.5), False),  # a tenth of 6 V
        (blocks(0.55, level=3.0), True), (blocks(0.45, level=3.0), False),  # .05 of the highest
        (blocks(1.5, slice(20, 23)), True), (blocks(1.5, slice(20, 22)), False),  # in a row
        (blocks(1.5, slice(0, 6)), True),
        (blocks(1.5, slice(50, 59)), True),
        (blocks(-1.5), False),  # more than the command is another finding's
    ],
)  # fmt: skip
def test_it_lacks_much_of_its_level_for_some_blocks(
    made: Blocks, named: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    (one,) = said(monkeypatch, made)
    assert (one.code == "supply_limited") is named
    if not named:
        assert (one.severity, "supply that gives 10% less" in one.message) == ("info", True)


def test_the_first_stretch_ends_where_the_motor_gets_its_level_again() -> None:
    made = blocks()
    lacks = np.zeros(COUNT)
    lacks[[5, 6, 10, 11, 12, 13, 20, 21, 22]] = 5.0
    assert list(unreached_command._first_stretch(made, lacks)) == [10, 11, 12, 13]
    lacks[23:] = 5.0
    lacks[:20] = 0.0
    assert list(unreached_command._first_stretch(made, lacks)) == list(range(20, 60))
    assert len(unreached_command._first_stretch(made, np.zeros(COUNT))) == 0
    settled = blocks(settled=slice(0, 23))
    found = unreached_command._first_stretch(settled, np.full(COUNT, 9.0))
    assert list(found) == list(range(23))


def test_what_most_blocks_have_in_common_is_the_motor() -> None:
    """Resistance, constant and drop: what is left of the others is what they lack, with its sign
    of the level."""
    for way in (1.0, -1.0):
        found = unreached_command._lacks(blocks(1.5, way=way))
        assert found is not None
        expected = np.zeros(COUNT)
        expected[20:26] = 1.5
        assert found == pytest.approx(expected, abs=2e-3)


@pytest.mark.parametrize(("count", "told"), [(8, True), (7, False)])
def test_eight_settled_blocks_under_a_level_tell_something(count: int, told: bool) -> None:
    found = unreached_command._lacks(blocks(settled=slice(0, count)))
    assert (found is not None) is told
    still = blocks(settled=slice(0, 8))
    still.volts[0] = 0.04 * HIGHEST  # which is no level
    assert unreached_command._lacks(still) is None
    still.volts[0] = 0.06 * HIGHEST
    assert unreached_command._lacks(still) is not None


def test_nothing_is_said_of_what_has_no_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    assert said(monkeypatch, None) == []
    assert said(monkeypatch, blocks(settled=slice(0, 7))) == []


VOLTS = Step(StepKind.DRIVE_VOLTS, 0.1, 6.0, Decay.SYNCHRONOUS_SLOW)
DUTY = Step(StepKind.DRIVE_DUTY, 0.1, 0.5, Decay.SYNCHRONOUS_SLOW)
COAST = Step(StepKind.COAST, 0.1)


@pytest.mark.parametrize(
    ("channels", "steps", "moving", "alone"),
    [
        ((CURRENT, SPEED), (COAST, VOLTS), False, True),
        ((CURRENT, SPEED, VOLTAGE), (COAST, VOLTS), False, False),
        ((CURRENT, SPEED, SUPPLY), (COAST, VOLTS), False, False),
        ((SPEED,), (COAST, VOLTS), False, False),
        ((CURRENT, SPEED), (COAST, VOLTS), True, False),
        ((CURRENT, SPEED), (COAST, VOLTS), None, False),
        ((CURRENT, SPEED), (VOLTS, DUTY), False, False),
        ((CURRENT, SPEED), (COAST,), False, False),
        ((CURRENT, SPEED), None, False, False),
    ],
)
def test_only_volts_that_nobody_measured_are_held_against_current_and_motion(
    channels: tuple[str, ...], steps: Any, moving: bool | None, alone: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    """``moving``: whether the motion lacks its sign; None: there is no motion."""
    motion = None if moving is None else SimpleNamespace(unsigned=moving)
    monkeypatch.setattr(unreached_command, "motion", lambda _: motion)
    program = None if steps is None else SimpleNamespace(steps=steps)
    capture: Any = SimpleNamespace(channels=dict.fromkeys(channels), program=program)
    assert unreached_command._by_command_alone(capture) is alone
    assert alone or list(unreached_command.findings(capture)) == []
