"""Between two judgements of what drives a motor, and what a command loses that nobody reads."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.reconstructed_voltage import Course, Driving
from motorid.estimate.signals.source.pwm_bridge import bridge_prior
from motorid.motor.reading import Quantity
from tests.estimate.effects.benches import POINT, record, start


def course(one: MotorRecord) -> Course:
    """How the motor at POINT runs there, by a current of one shape."""
    count = one.timeline.count
    current = np.where(one.driven, 1.0 + np.exp(-np.arange(count) / 50.0), 0.0)
    return Course(current, current + 0.01, current - 0.02, np.zeros(count), POINT[0], POINT[1])


@pytest.mark.parametrize("name", ["measured", "commanded", "diodes"])
def test_what_is_mixed_lies_between_by_its_share(name: str) -> None:
    one = record(name).driving
    shifted = tuple(
        None if s is None else replace(s, volts=s.volts + 0.4, ohms=s.ohms + 0.2)
        for s in one.sources
    )  # fmt: skip
    heard = replace(
        one.heard, volts=one.heard.volts + 1.0, lost=np.asarray(one.heard.lost) + 0.5,
        lost_shown=np.asarray(one.heard.lost_shown) - 0.25,
    )  # fmt: skip
    other = replace(one, sources=shifted, heard=heard)
    for share in (0.0, 0.25, 1.0):
        found = one.mixed(other, share)
        assert found.heard.volts == pytest.approx(one.heard.volts + share)
        assert found.heard.lost == pytest.approx(np.asarray(one.heard.lost) + 0.5 * share)
        shown = np.asarray(one.heard.lost_shown)
        assert found.heard.lost_shown == pytest.approx(shown - 0.25 * share)
        for a, b in zip(found.sources, one.sources, strict=True):
            assert (a is None) == (b is None)
            if a is not None and b is not None:
                assert a.volts == pytest.approx(b.volts + 0.4 * share)
                assert a.ohms == pytest.approx(b.ohms + 0.2 * share)


def test_a_guess_beyond_leaves_no_resistance_below_none() -> None:
    one = record("measured").driving
    known = [k for k, s in enumerate(one.sources) if s is not None]
    less = tuple(None if s is None else replace(s, ohms=0.4 * s.ohms) for s in one.sources)
    found = one.mixed(replace(one, sources=less), 5.0)
    assert known
    assert all(found.sources[k].ohms == 0.0 for k in known)  # type: ignore[union-attr]
    gone = one.mixed(replace(one, sources=tuple(None for _ in one.sources)), 0.5)
    assert gone.sources == one.sources  # of one without a source there is nothing to mix


def test_a_run_is_read_by_what_a_course_is_made_of() -> None:
    one = record("measured").driving
    *seen, speed, mean, end = one.asked
    period_s = one.timeline.period_s
    assert [o.quantity for o in (speed, mean, end)] == [
        Quantity.SPEED, Quantity.CURRENT, Quantity.CURRENT,
    ]  # fmt: skip
    assert (speed.aperture_s, mean.aperture_s, end.aperture_s) == (period_s, period_s, 0.0)
    assert len(seen) == len(one.window.outputs)
    rows = np.arange(len(one.asked), dtype=float)[:, None] * np.ones(one.timeline.count)
    found = one.course(rows, 0.5, 3.0, 2e-3)
    assert found.emf == pytest.approx(0.5 * len(seen))
    assert found.mean == pytest.approx(len(seen) + 1.0)
    assert found.end == pytest.approx(len(seen) + 2.0)
    assert (found.resistance_ohm, found.inductance_h) == (3.0, 2e-3)


def test_only_a_command_loses_what_nobody_reads() -> None:
    """Readings show what dead time takes; of a command it has to be subtracted."""
    for name, commanded in (("measured", False), ("commanded", True)):
        one = record(name)
        here = course(one)
        found = one.driving._hearing(here, ())
        lost = np.asarray(found.heard.lost)
        assert lost[one.driven].max() > 0.0
        expected = one.driving.sensed.volts - (lost if commanded else 0.0)
        assert found.heard.volts == pytest.approx(expected)
        diodes = one.driving._lost_to_diodes(here)
        assert bool(np.any(diodes)) is commanded
        ohms = one.driving._source_ohms(here.current)
        if commanded:
            assert ohms == 0.0
            # a share of the dead time, twice a period, for each volt of the diodes
            assert 0.0 < np.abs(diodes).max() < 0.05
        else:
            prior, sd = bridge_prior(one.capture)
            assert abs(ohms - prior) < 5.0 * sd


def test_what_is_decided_stays_when_the_course_changes() -> None:
    one = record("diodes")
    here = course(one)
    kept = replace(one.driving, decided=True).judged(here, {})
    assert kept.timeline is one.driving.timeline
    assert kept.switched_late == one.driving.switched_late
    assert [None if s is None else s.form for s in kept.sources] == [
        None if s is None else s.form for s in one.driving.sources
    ]


def test_readings_that_are_missing_are_gone_from_the_source() -> None:
    one = record("held_log")
    lacking = one.timeline.count - len(one.capture)
    assert lacking > 0
    assert one.driving._gone.sum() >= lacking
    first = Driving.of(one.capture, one.timeline, one.sensed)
    assert first.sagging == {}
    assert not first.decided
    assert len(start(one)) == len(one.unknowns)
