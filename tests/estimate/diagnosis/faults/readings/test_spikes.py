"""Single readings that stand alone are left out, and said."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, VOLTAGE, Capture
from motorid.estimate.diagnosis.faults.readings import spikes
from motorid.estimate.results.estimate import PARAMETERS, Estimate
from tests.exact_capture import FAULHABER, Plan, clean_capture
from tests.six_parameters import fit

PLACES = [300, 420, 780]


def run(count: int = 1200) -> Capture:
    """Two levels and a coast, with a little noise in the current and the voltage."""
    made = clean_capture(FAULHABER, Plan((6.0, 3.0), count))
    rng = np.random.default_rng(4)
    noisy = {
        n: replace(made.channels[n], raw=made.channels[n].raw + sd * rng.standard_normal(count))
        for n, sd in ((CURRENT, 2e-3), (VOLTAGE, 5e-3))
    }
    return replace(made, channels={**made.channels, **noisy})


def spiked(name: str, by: float, places: list[int] | None = None) -> Capture:
    made = run()
    channel = made.channels[name]
    raw = np.array(channel.raw, dtype=np.float64)
    raw[places or PLACES] += by / channel.scale
    return replace(made, channels={**made.channels, name: replace(channel, raw=raw)})


@pytest.mark.parametrize(("name", "by"), [(CURRENT, 0.5), (CURRENT, -0.5), (VOLTAGE, 3.0)])
def test_what_stands_alone_is_left_out(name: str, by: float) -> None:
    capture = spiked(name, by)
    assert spikes.find(capture, name).tolist() == PLACES
    (cleared,), (said,) = spikes.removed([capture])
    assert np.flatnonzero(np.isnan(cleared.channels[name].values)).tolist() == PLACES
    assert (said.code, said.strength, said.allowed) == ("spikes", "named", True)
    assert said.evidence.startswith("3 readings of the ")
    others = [n for n in capture.channels if n != name]
    assert all(cleared.channels[n] is capture.channels[n] for n in others)


def test_of_a_position_steps_are_none_and_a_garbled_reading_is_one() -> None:
    capture = spiked(POSITION, 5.0, [500])
    assert spikes.find(capture, POSITION).tolist() == [500]
    channel = capture.channels[POSITION]
    raw = np.array(run().channels[POSITION].raw, dtype=np.float64)
    raw[500:] -= 5.0 / channel.scale  # counts that are lost do not come back,
    raw[600:] -= np.diff(raw)[600] * 2.0  # nor those that turn one step round
    lost = replace(capture, channels={**capture.channels, POSITION: replace(channel, raw=raw)})
    assert len(spikes.find(lost, POSITION)) == 0


def test_neither_noise_nor_what_a_step_of_the_program_does_is_a_spike() -> None:
    good = run()
    captures, said = spikes.removed([good])
    assert captures == [good]
    assert said == ()
    begins = int(np.searchsorted(good.ticks, good.phases[-1].tick))  # the diodes conduct
    assert len(spikes.find(spiked(VOLTAGE, 3.0, [begins + 1]), VOLTAGE)) == 0
    assert len(spikes.find(spiked(VOLTAGE, 3.0, [begins + 12]), VOLTAGE)) == 1


def test_many_are_no_rare_error_and_a_log_has_other_ways() -> None:
    often = list(range(60, 1100, 20))  # 4 %
    assert len(spikes.find(spiked(CURRENT, 0.5, often), CURRENT)) == 0
    log = replace(spiked(CURRENT, 0.5), program=None, phases=())
    assert spikes.removed([log]) == ([log], ())


def named(estimate: Estimate) -> list[str]:
    return [s.code for s in estimate.suspects if s.strength == "named"]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "by"), [(CURRENT, 0.5), (VOLTAGE, 3.0)])
def test_the_answer_is_as_without_them(name: str, by: float) -> None:
    good, bad = fit([run()], model="six"), fit([spiked(name, by)], model="six")
    assert named(bad) == [*named(good), "spikes"]
    for n in PARAMETERS:
        before, after = good.parameters[n], bad.parameters[n]
        assert before.value is not None
        assert after.value is not None
        assert before.total is not None
        assert abs(after.value - before.value) < 0.5 * before.total
