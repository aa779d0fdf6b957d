"""A reference that the motor's current pulls down: readings that rise with it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, VOLTAGE, Capture
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.source.reference_sag import REFERENCE_SAG
from motorid.estimate.model.capture_model import Floats, MotorRecord
from motorid.estimate.model.tangent import tangent
from motorid.estimate.results.estimate import PARAMETERS
from tests.estimate.effects.benches import POINT, start
from tests.exact_capture import FAULHABER, Plan, clean_capture

SAG = 3e-3  # of the gains, at the highest current
SECOND = 0.05  # of what a sag shows: its square, and what a step does within one reading
SHOWN = (CURRENT, VOLTAGE)
PLAN = Plan(volts=(6.0, -4.0, 2.0))  # both ways, and a coast


def peak_a(capture: Capture) -> float:
    """A, the highest current."""
    return float(np.abs(capture.channels[CURRENT].values).max())


def sagging(capture: Capture, share: float, names: tuple[str, ...] = SHOWN) -> Capture:
    """Whose channels of these names read so much too high at the highest current."""
    current = np.abs(capture.channels[CURRENT].values)
    gain = 1.0 + share * current / current.max()
    channels = {n: replace(c, raw=gain * c.raw) if n in names else c
                for n, c in capture.channels.items()}  # fmt: skip
    return replace(capture, channels=channels)


def judged(capture: Capture) -> MotorRecord:
    """The capture's record, its source judged at POINT."""
    subject = MotorRecord(capture, PARAMETERS, {})
    subject.retake_sources(POINT, start(subject))
    return subject


def left(subject: MotorRecord, per_a: float) -> dict[str, Floats]:
    """Readings (n,) by block, less what the motor shows beside a sag of so much per A."""
    shown = subject.fitted(POINT, start(subject), {Instance(REFERENCE_SAG): per_a})
    return {m.block.name: m.values - y for m, y in zip(subject.measured, shown, strict=True)}


def test_readings_of_a_sag_are_those_of_the_motor_beside_it() -> None:

    clean = clean_capture(FAULHABER, PLAN)
    subject, per_a = judged(sagging(clean, SAG)), SAG / peak_a(clean)
    exact, without, beside = left(judged(clean), 0.0), left(subject, 0.0), left(subject, per_a)
    for name in (CURRENT, POSITION):
        most = float(np.abs(without[name] - exact[name]).max())
        assert most > 0.0
        assert np.abs(beside[name] - exact[name]).max() < SECOND * most


@pytest.mark.parametrize("ratiometric", [False, True])
def test_a_sensor_that_follows_the_reference_shows_its_current(ratiometric: bool) -> None:
    """The volts rise all the same."""
    clean = clean_capture(FAULHABER, PLAN)
    channel = replace(clean.channels[CURRENT], ratiometric=ratiometric)
    shown = sagging(clean, SAG, (VOLTAGE,) if ratiometric else SHOWN)
    subject = judged(replace(shown, channels={**shown.channels, CURRENT: replace(
        channel, raw=shown.channels[CURRENT].raw)}))  # fmt: skip
    exact = left(judged(clean), 0.0)[CURRENT]
    beside = left(subject, SAG / peak_a(clean))[CURRENT] - exact
    without = left(subject, 0.0)[CURRENT] - exact
    assert np.abs(beside).max() < SECOND * np.abs(without).max()


def test_where_no_current_is_read_nothing_sags() -> None:
    capture = clean_capture(FAULHABER, PLAN)
    channels = {n: c for n, c in capture.channels.items() if n != CURRENT}
    subject = judged(replace(capture, channels=channels))
    change = tangent(subject, POINT, start(subject), Instance(REFERENCE_SAG))
    assert not any(part.any() for part in change)
    assert REFERENCE_SAG.scale(subject) == 1.0
