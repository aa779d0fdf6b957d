"""The fit again with a convicted fault among its unknowns, on captures without noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, Capture
from motorid.estimate.diagnosis.faults.missing_samples import CODE
from motorid.estimate.diagnosis.faults.zeros.current_zero import seen
from motorid.estimate.diagnosis.repair import ZERO, repaired
from motorid.estimate.fit.joint_fit import solved
from motorid.estimate.results.estimate import Suspect
from motorid.program import Program
from tests.exact_capture import FAULHABER, clean_capture, noisy

OFFSET_A = 0.05
DECLARED_A = 1e-3
NOISE_A = 1e-3


@pytest.mark.slow
def test_a_zero_beyond_its_declaration_becomes_an_unknown() -> None:
    """With the declared prior the fit is torn between its rest and its drive."""
    good = clean_capture(FAULHABER)
    noise = np.random.default_rng(5).normal(0.0, NOISE_A, len(good))
    current = good.channels[CURRENT]
    off = replace(
        current, raw=np.asarray(current.raw) + OFFSET_A + noise, offset_uncertainty=DECLARED_A
    )
    records, solution = solved([replace(good, channels={**good.channels, CURRENT: off})], {}, ())
    assert seen(records[0]) == pytest.approx(OFFSET_A, abs=NOISE_A)
    named = Suspect(ZERO, "current", "it is off", "mend it", "named")
    found = repaired(records, solution, [named], None, {}, ())
    assert found is not None
    assert found.suspect.allowed
    assert found.suspect.without["R"] == solution.values[0]
    for unknown, value in zip(found.solution.unknowns, found.solution.values, strict=True):
        assert value == pytest.approx(FAULHABER[unknown.name], rel=0.01), unknown.name


def counted() -> Capture:
    """A run that ends with its program, whose encoder counts."""
    good, step = noisy(clean_capture(FAULHABER), 3, NOISE_A, 0.0), 2 * np.pi / 4096
    position = good.channels[POSITION]
    position = replace(position, raw=np.rint(position.values / step) * step, resolution=step)
    steps = list(good.program.steps) if good.program is not None else []
    last_s = len(good) * good.period_s - good.phases[-1].tick / good.clock_hz
    steps[-1] = replace(steps[-1], duration_s=last_s)
    channels = {**good.channels, POSITION: position}
    return replace(good, channels=channels, program=Program(tuple(steps)), end_reason="completed")


def without(capture: Capture, *places: int) -> Capture:
    """Without these samples, under stamps that count on."""
    kept = np.delete(np.arange(len(capture)), places)
    channels = {
        name: replace(channel, raw=np.asarray(channel.raw)[kept])
        for name, channel in capture.channels.items()
    }
    return replace(capture, ticks=capture.ticks[: len(kept)], channels=channels)


MISSING = Suspect(CODE, "time", "samples are missing", "count them", "named")


@pytest.mark.slow
def test_samples_that_are_missing_are_put_back() -> None:
    records, solution = solved([without(counted(), 400, 900, 901)], {}, ())
    found = repaired(records, solution, [MISSING], None, {}, ())
    assert found is not None
    assert [gap.samples for gap in found.records[0].capture.gaps] == [1, 2]
    for unknown, value in zip(found.solution.unknowns, found.solution.values, strict=True):
        assert value == pytest.approx(FAULHABER[unknown.name], rel=2e-3), unknown.name


def test_where_none_is_seen_to_be_missing_nothing_is_put_back() -> None:
    records, solution = solved([counted()], {}, ())
    assert repaired(records, solution, [MISSING], None, {}, ()) is None


def test_nothing_is_repaired_that_nobody_named() -> None:
    records, solution = solved([clean_capture(FAULHABER)], {}, ())
    hidden = Suspect("speed_scale", "encoder", "no residual", "name a disc", "not excluded")
    assert repaired(records, solution, [hidden], None, {}, ()) is None
    assert repaired(records, solution, [], None, {}, ()) is None
