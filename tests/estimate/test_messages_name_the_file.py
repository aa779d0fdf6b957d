"""A sentence of several captures says in which of them; of one that has no file it says so too."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, SPEED, TORQUE, Capture, Channel
from motorid.errors import DataError
from motorid.estimate.fit.start_signals import signals
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.partial import electrical_only
from motorid.estimate.partial.mechanical_signals import of_capture
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.signals import log_sections
from motorid.estimate.signals.opened_bridge import Opening
from motorid.estimate.signals.time_grid import lay
from tests.exact_capture import FAULHABER, Plan, clean_capture

PATH = "bench/tuesday.h5"


def motion(**channels: Channel) -> Capture:
    return Capture(1000 * np.arange(100), 1e6, channels, path=PATH)


def turning(unit: str = "rad/s", count: int = 100) -> Channel:
    speed = np.sin(np.arange(100.0))
    speed[count:] = np.nan
    return Channel(SPEED, unit, speed)


AMPERES = Channel(CURRENT, "A", np.cos(np.arange(100.0)))
NEWTON_METRES = Channel(TORQUE, "N·m", AMPERES.raw)


def fitted_without(*names: str, still: str = "") -> Callable[[Capture], Any]:
    """What a fit of all six says where channels are missing or one never changes."""

    def run(capture: Capture) -> Any:
        channels = {n: c for n, c in capture.channels.items() if n not in names}
        if still:
            channels[still] = replace(channels[still], raw=np.zeros(len(capture)), resolution=0.1)
        return signals(MotorRecord(replace(capture, channels=channels), PARAMETERS, {}))

    return run


CLEAN = replace(clean_capture(FAULHABER, Plan(volts=(6.0,), count=100)), path=PATH)
CASES: dict[str, tuple[Capture, Callable[[Capture], Any], str]] = {
    "no drive": (motion(speed=turning()), lambda c: of_capture(c, CURRENT), "lacks current"),
    "no motion": (
        motion(current=AMPERES), lambda c: of_capture(c, CURRENT), "lacks speed and position"
    ),
    "few samples": (
        motion(current=AMPERES, speed=turning(count=9)), lambda c: of_capture(c, CURRENT),
        "holds 9 usable samples",
    ),
    "units": (
        motion(torque=NEWTON_METRES, speed=turning("m/s")), lambda c: of_capture(c, TORQUE),
        "N·m drives m/s",
    ),
    "still": (
        motion(current=AMPERES, speed=replace(turning(), raw=np.ones(100))),
        lambda c: of_capture(c, CURRENT), "speed never changes",
    ),
    "no current changes": (
        motion(current=replace(AMPERES, raw=np.ones(100))),
        lambda c: electrical_only._insist_on_current([c]), "current never changes",
    ),
    "short": (CLEAN.rows(slice(0, 15), ()), lay, "holds 15 samples"),
    "fit without a current": (CLEAN, fitted_without(CURRENT), "no channel of the current"),
    "fit without a motion": (
        CLEAN, fitted_without(POSITION, SPEED), "no channel of the position or speed"
    ),
    "fit of a still current": (CLEAN, fitted_without(still=CURRENT), "current never changes"),
    "fit of a still position": (CLEAN, fitted_without(still=POSITION), "position never changes"),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_a_refusal_names_the_file_and_what_is_wrong(case: str) -> None:
    capture, run, said = CASES[case]
    with pytest.raises(DataError) as refused:
        run(capture)
    assert PATH in str(refused.value)
    assert said in str(refused.value)
    with pytest.raises(DataError) as nameless:
        run(replace(capture, path=""))
    assert said in str(nameless.value)
    assert PATH not in str(nameless.value)
    assert "None" not in str(nameless.value)


def test_an_open_bridge_is_said_of_its_file_with_its_times() -> None:
    one = motion(current=AMPERES)
    opened = [Opening(10 * k, 10 * k + 5, 10 * k + 4) for k in range(2, 8)]
    said = log_sections._remark(one, opened).message
    assert f" in {PATH} at 0.02 to 0.023 s" in said
    shown = said.partition(": no current")[0].count(" to ")
    assert shown == log_sections.LISTED
    assert f"and {6 - shown} more" in said
    few = log_sections._remark(replace(one, path=""), opened[:shown]).message
    assert "the bridge was open at 0.02" in few
    assert "more" not in few.partition(": no current")[0]
