"""What a fault of some size does to a tiny capture's readings, and which samples are put back."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, Capture, Channel, Gap
from motorid.estimate.diagnosis import fault
from motorid.estimate.diagnosis.fault import Hypothesis
from motorid.estimate.diagnosis.faults import (
    current_limited_supply,
    encoder_bandwidth,
    load_slip,
    missing_samples,
    model_alternatives,
    saturation,
)
from motorid.estimate.fit.block_regression import Start
from motorid.estimate.signals.time_grid import Part, Timeline
from motorid.program import Decay, Program, Step, StepKind
from tests.estimate.effects.benches import FAULHABER, POINT, record, start, usual


def effect(hypothesis: Hypothesis, *size: float, name: str = "measured") -> dict[str, np.ndarray]:
    subject = record(name)
    parts = hypothesis.effect(subject, POINT, start(subject), np.array(size))
    return {m.block.name: p for m, p in zip(subject.measured, parts, strict=True)}


def test_an_encoder_follows_up_to_its_limit_and_counts_on() -> None:
    angle = usual("measured")[POSITION]
    subject = record("measured")
    block = subject.block(POSITION)
    assert block is not None
    fastest = float(np.abs(np.diff(angle)).max()) / subject.timeline.period_s
    hypothesis = encoder_bandwidth._hypothesis(fastest, 1e-3)
    change = effect(hypothesis, 0.6 * fastest)
    full = subject.readings(POINT, start(subject))[block.row]
    most = 0.6 * fastest * subject.timeline.period_s
    lost = np.cumsum(np.clip(np.diff(full, prepend=full[0]), -most, most)) - (full - full[0])
    assert change[POSITION] == pytest.approx(lost[block.keep], abs=1e-12)
    assert change[POSITION].min() < -0.1 * np.ptp(angle)
    assert not change[CURRENT].any()
    assert not effect(hypothesis, 1.1 * fastest)[POSITION].any()
    bare = encoder_bandwidth._hypothesis(fastest, 0.0).words(np.array([200.0]))
    assert bare.evidence == "the encoder loses counts above 200 rad/s"


def test_a_source_at_its_end_gives_so_many_times_as_much() -> None:
    subject = record("measured")
    peak = float(np.abs(subject.volts).max())
    hypothesis = saturation._voltage(peak)
    raised = np.where(np.abs(subject.volts) > 0.985 * peak, 1.2 * subject.volts, subject.volts)
    own = start(subject)
    wanted = [
        a - b for a, b in zip(subject.fitted_with(POINT, own, raised), subject.fitted(POINT, own),
                              strict=True)
    ]  # fmt: skip
    change = effect(hypothesis, 1.2)
    for m, part in zip(subject.measured, wanted, strict=True):
        assert change[m.block.name] == pytest.approx(part)
    assert np.abs(change[CURRENT]).max() > 0.1 * np.abs(usual("measured")[CURRENT]).max()


def test_a_limited_supply_gives_what_its_current_needs_at_this_speed() -> None:
    subject = record("measured")
    limit = 0.4 * float(np.abs(usual("measured")[CURRENT]).max())
    hypothesis = current_limited_supply._hypothesis([subject], limit)
    now = usual("measured")[CURRENT]
    change = effect(hypothesis, limit)[CURRENT]
    above = np.abs(now) > 1.5 * limit
    assert above.any()
    assert np.abs(now + change)[above].max() < 1.5 * limit
    none = effect(hypothesis, 10.0 * float(np.abs(now).max()))
    assert np.abs(none[CURRENT]).max() < 1e-9
    assert hypothesis.lower[0] < limit < hypothesis.upper[0]
    assert f"no more than {limit:.3g} A" in hypothesis.words(np.array([limit])).evidence


def test_a_load_that_slips_leaves_the_motor_its_torque() -> None:
    subject = record("measured")
    begin = Start((0.4, 1e4), {})
    hypothesis = load_slip._hypothesis([subject], begin)
    change = effect(hypothesis, 0.4, 1e4)
    # the motor gets up to speed sooner, and the current falls sooner
    angle = usual("measured")[POSITION]
    speeding = slice(30, 80)
    assert change[POSITION][speeding].min() > 0.0
    assert change[POSITION][speeding].max() < 0.5 * np.ptp(angle)
    fast = effect(hypothesis, 0.4, 1e9)  # it keeps up: nothing slips
    assert np.abs(fast[POSITION]).max() < 1e-3 * np.ptp(angle)
    half = effect(hypothesis, 0.2, 1e4)
    assert half[POSITION] == pytest.approx(change[POSITION] / 2, rel=0.02, abs=1e-4)
    said = hypothesis.words(np.array([0.4, 1e4])).evidence
    assert said == "40 % of the inertia follows the shaft at 1e+04 rad/s² and no faster"
    assert (hypothesis.lower, hypothesis.upper) == ((0.02, 1e3), (0.99, 1e5))


@pytest.fixture
def bare(monkeypatch: pytest.MonkeyPatch) -> Any:
    """A capture whose record has no unknowns of what brushes and winding take."""
    subject = record("measured")
    other = subject.twin()
    monkeypatch.setattr(type(other), "loss", property(lambda _: None))
    return other


def test_without_unknowns_of_their_own_brushes_and_warmth_act_as_added_volts(
    bare: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    added: list[np.ndarray] = []
    monkeypatch.setattr(
        model_alternatives, "added_voltage", lambda _r, _v, _o, volts: added.append(volts)
    )
    own = start(bare)
    current = fault.current_of(bare, POINT, own)
    assert current is not None
    R = FAULHABER["R"]
    model_alternatives.brush_drop(bare, POINT, own, np.array([0.3]))
    soft = model_alternatives.BEND * float(np.abs(bare.volts).max()) / R
    assert added[0] == pytest.approx(-0.3 * current / np.hypot(current, soft))
    model_alternatives._warming(bare, POINT, own, np.array([0.1]))
    heat = np.cumsum(current**2)
    assert added[1] == pytest.approx(-R * 0.1 * current * heat / heat[-1])
    monkeypatch.setattr(model_alternatives, "current_of", lambda *_: None)
    for act in (model_alternatives.brush_drop, model_alternatives._warming):
        assert not any(part.any() for part in act(bare, POINT, own, np.array([0.1])))


def test_an_added_voltage_acts_to_first_order() -> None:
    subject, own = record("measured"), start(record("measured"))
    volts = np.where(np.arange(subject.timeline.count) > 100, 0.05, 0.0)
    exact = fault.changed_voltage(subject, POINT, own, subject.volts + volts)
    found = fault.added_voltage(subject, POINT, own, volts)
    for a, b in zip(exact, found, strict=True):
        assert b == pytest.approx(a, rel=0.05, abs=0.02 * float(np.abs(a).max()))
    twice = fault.added_voltage(subject, POINT, own, 2.0 * volts)
    for a, b in zip(found, twice, strict=True):
        assert b == pytest.approx(2.0 * a, rel=1e-6, abs=1e-9)
    none = fault.added_voltage(subject, POINT, own, 0.0 * volts)
    assert not any(part.any() for part in none)


# samples put back


def run(count: int = 60, seconds: float = 0.08) -> Capture:
    drive = Step(StepKind.DRIVE_DUTY, seconds, 0.5, Decay.SYNCHRONOUS_SLOW)
    channels = {POSITION: Channel(POSITION, "rad", np.arange(float(count)))}
    return Capture(1000 * np.arange(count), 1e6, channels, program=Program((drive,)))


LINE = Timeline(1e-3, 60, np.arange(60), (Part(0, 60),), 0.0)


def put_back(
    monkeypatch: pytest.MonkeyPatch, missing: list[float], nearly: list[float], short: int,
    counts: float = 0.0,
) -> Capture | None:  # fmt: skip
    places = np.array([10, 30, 50])[: len(missing)]
    jumps = SimpleNamespace(
        places=places, missing=np.array(missing), nearly=np.array(nearly), counts=np.array([counts])
    )
    monkeypatch.setattr(missing_samples.lost_samples, "find", lambda *_: jumps)
    monkeypatch.setattr(missing_samples.lost_samples, "short_of_program", lambda _: short)
    return missing_samples.put_back(run(), LINE)


def test_later_stamps_follow_every_place_that_lacks_samples(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found = put_back(monkeypatch, [2.0, 3.0], [2.1, 2.9], 5)
    assert found is not None
    steps = np.diff(found.ticks)
    assert np.flatnonzero(steps != 1000).tolist() == [9, 29]
    assert steps[[9, 29]].tolist() == [3000, 4000]
    assert [(g.index, g.samples) for g in found.gaps] == [(10, 2), (30, 3)]
    assert found.gaps[0].reason == missing_samples.REASON


def test_an_unclear_place_has_what_the_others_leave_of_the_program(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def samples(*given: Any) -> list[int] | None:
        found = put_back(monkeypatch, *given)
        return None if found is None else [gap.samples for gap in found.gaps]

    assert samples([2.0, 0.0], [2.0, 1.6], 4) == [2, 2]
    assert samples([2.0, 0.0], [2.0, 1.6], 3) == [2, 1]
    assert samples([0.0, 0.0], [1.4, 2.3], 4) == [2, 2]  # the first is nearer to one more
    assert samples([0.0, 0.0], [0.2, 2.0], 3) == [1, 2]  # at least one
    assert samples([0.0, 2.0], [1.0, 2.0], 5) is None  # one more is too far from its jump
    assert samples([2.0, 3.0], [2.0, 3.0], 6) is None
    assert samples([2.0], [2.0], 0) is None
    assert samples([2.0], [2.0], 2, -1.0) is None  # counts were lost, too


def test_known_gaps_stay_in_their_order(monkeypatch: pytest.MonkeyPatch) -> None:
    jumps = SimpleNamespace(
        places=np.array([30]), missing=np.array([2.0]), nearly=np.array([2.0]), counts=np.zeros(1)
    )
    monkeypatch.setattr(missing_samples.lost_samples, "find", lambda *_: jumps)
    monkeypatch.setattr(missing_samples.lost_samples, "short_of_program", lambda _: 2)
    gapped = replace(run(), gaps=(Gap(5, 1, "known"), Gap(40, 1, "known")))
    found = missing_samples.put_back(gapped, LINE)
    assert found is not None
    assert [gap.index for gap in found.gaps] == [5, 30, 40]


def test_rows_of_a_log_are_put_back_where_all_are_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    log = replace(run(), program=None)

    def rows(*lost: float) -> Capture | None:
        found = SimpleNamespace(places=np.array([20, 40])[: len(lost)], rows=np.array(lost))
        monkeypatch.setattr(missing_samples.lost_rows, "find", lambda _: found)
        return missing_samples.put_back(log, LINE)

    found = rows(1.0, 2.0)
    assert found is not None
    assert [(g.index, g.samples) for g in found.gaps] == [(20, 1), (40, 2)]
    assert rows(1.0, 0.0) is None  # a stretch, of unknown length
    monkeypatch.setattr(missing_samples.lost_rows, "find", lambda _: None)
    assert missing_samples.put_back(log, LINE) is None
