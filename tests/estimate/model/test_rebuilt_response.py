"""What a run is simulated with when its clock, its source or its channels are others."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION
from motorid.estimate.effects.action import Setup
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.rebuilt_response import rebuilt
from motorid.estimate.results.estimate import PARAMETERS
from tests.exact_capture import FAULHABER, Plan, clean_capture


@pytest.fixture(scope="module")
def record() -> MotorRecord:
    return MotorRecord(clean_capture(FAULHABER, Plan(count=800)), PARAMETERS, {})


def asked(record: MotorRecord, setup: Setup) -> dict[str, Any]:
    """What the response is made of."""
    found: dict[str, Any] = {}

    def respond(period_s: float, volts: Any, outputs: Any, stretches: Any, pwm_s: float) -> Any:
        found.update(period_s=period_s, volts=volts, stretches=stretches, pwm_s=pwm_s)
        found.update({m.block.name: outputs[m.row] for m in record.measured})

    rebuilt(record, setup, respond)
    return found


def plain(record: MotorRecord) -> Setup:
    return Setup(record.timeline.count, [])


def test_as_declared_nothing_is_another(record: MotorRecord) -> None:
    found = asked(record, plain(record))
    assert found["period_s"] == record.timeline.period_s
    np.testing.assert_array_equal(found["volts"], record.volts)
    assert found[CURRENT] == record.outputs[record.block(CURRENT).row]  # type: ignore[union-attr]


def test_a_clock_stretches_every_time(record: MotorRecord) -> None:
    setup = plain(record)
    setup.clock = 1.01
    before, after = asked(record, plain(record)), asked(record, setup)
    assert after["period_s"] == pytest.approx(1.01 * before["period_s"], rel=1e-12)
    for name in (CURRENT, POSITION):
        assert after[name].aperture_s == pytest.approx(1.01 * before[name].aperture_s)
        assert after[name].delay_s == pytest.approx(1.01 * before[name].delay_s)


def test_a_gain_is_the_sources_and_what_is_added_is_beside_it(record: MotorRecord) -> None:
    setup = plain(record)
    setup.source_gain = 1.02
    setup.add_volts(0.5)
    before, after = asked(record, plain(record)), asked(record, setup)
    assert after["volts"] == pytest.approx(1.02 * before["volts"] + 0.5)
    for one, two in zip(before["stretches"], after["stretches"], strict=True):
        assert two.swing_v == pytest.approx(1.02 * one.swing_v)
        assert two.clamp_v == pytest.approx(1.02 * one.clamp_v)


def test_a_block_is_late_and_smooth_alone(record: MotorRecord) -> None:
    setup = plain(record)
    setup.late_s[CURRENT], setup.filter_s[CURRENT] = 3e-6, 5e-6
    before, after = asked(record, plain(record)), asked(record, setup)
    assert after[CURRENT].delay_s == pytest.approx(before[CURRENT].delay_s + 3e-6)
    assert after[CURRENT].filter_s == pytest.approx(before[CURRENT].filter_s + 5e-6)
    assert after[POSITION] == before[POSITION]


def test_a_low_pass_of_second_order_has_the_first_one_in_it(record: MotorRecord) -> None:
    setup = plain(record)
    setup.filter_s[CURRENT], setup.second_s[CURRENT] = 5e-6, 4e-6
    assert asked(record, setup)[CURRENT].filter_s == 0.0


def test_a_part_begins_with_its_kick(record: MotorRecord) -> None:
    setup = plain(record)
    setup.kicks[1] = 2.0
    found = asked(record, setup)["stretches"]
    kicked = [k for k, s in enumerate(found) if s.kick_rad_s]
    assert kicked == [record.first[1]]
    assert found[kicked[0]].kick_rad_s == 2.0
