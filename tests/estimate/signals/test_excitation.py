"""What drives a model, part by part: a source's volts, else those heard."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.capture.model import Wiring
from motorid.estimate.signals.excitation import excitation
from motorid.estimate.signals.source.thevenin_source import Source
from motorid.estimate.signals.time_grid import Part
from motorid.estimate.signals.voltage_sensing import Sense
from motorid.program import Decay, StepKind

N = 30
REST = Part(0, 10)
DRIVE = Part(10, N, StepKind.DRIVE_DUTY, 0.5, Decay.SYNCHRONOUS_SLOW)
WIRING = Wiring(supply_voltage_v=12.0, pwm_hz=20e3, dead_time_s=1e-6)
HEARD = Sense(np.full(N, 6.0), np.zeros(N, dtype=bool), 0.25, 0.0, True, None)


@pytest.mark.parametrize(("late", "starts"), [(10, [10]), (30, [10]), (14, [10, 14]), (99, [10])])
def test_a_part_is_cut_where_its_dead_time_ends(late: int, starts: list[int]) -> None:
    found = excitation(WIRING, 12.0, 12.0, HEARD, [REST, DRIVE], [None, None], [0, late])
    assert [s.start for s in found.stretches] == [0, *starts]
    assert found.first == (0, 1)
    assert [s.series_ohm for s in found.stretches] == [0.25] * len(found.stretches)


def test_volts_heard_are_copied() -> None:
    found = excitation(WIRING, 12.0, 12.0, HEARD, [REST, DRIVE], [None, None], [0, 0])
    assert found.volts.tolist() == HEARD.volts.tolist()
    found.volts[0] = 1.0
    assert HEARD.volts[0] == 6.0


def test_a_source_has_volts_and_a_resistance_of_its_own() -> None:
    source = Source(np.full(20, 9.0), 0.5, 0.0)
    found = excitation(WIRING, 12.0, 30.0, HEARD, [REST, DRIVE], [None, source], [0, 10])
    assert found.volts.tolist() == [6.0] * 10 + [9.0] * 20
    assert [s.series_ohm for s in found.stretches] == [0.25, 0.75]
    assert [s.clamp_v for s in found.stretches] == [30.0, 30.0]


def test_the_on_part_is_late_until_the_current_turns_within_a_period() -> None:
    """A diode drops .7 of 12 V: for its dead time of 1 us, like an edge that is 58 ns earlier."""
    late, in_time = excitation(
        WIRING, 12.0, 30.0, HEARD, [REST, DRIVE], [None, None], [0, 20]
    ).stretches[1:]
    early_s = 1e-6 * 0.7 / 12.0
    assert late.late_s == pytest.approx(1e-6 + early_s)
    assert late.duty == pytest.approx(0.5 - 20e3 * (1e-6 + 2 * early_s))
    assert in_time.late_s == pytest.approx(-early_s)
    assert in_time.duty == pytest.approx(0.5)
