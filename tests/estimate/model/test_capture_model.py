"""One capture as the likelihood sees it: its model is the motor's, and it stays what it was."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, VOLTAGE, Capture, Channel
from motorid.errors import DataError
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.reading.current_gain import CURRENT_GAIN
from motorid.estimate.effects.reading.current_offset import CURRENT_OFFSET
from motorid.estimate.effects.source.brush_drop import BRUSH_DROP
from motorid.estimate.effects.source.voltage_offset import VOLTAGE_OFFSET
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.responses_at_hand import REMEMBERED
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.signals.measurements import EMF
from motorid.estimate.solver.problem import Unknown
from tests.estimate.effects.benches import PWM_HZ
from tests.estimate.effects.benches import record as benched
from tests.exact_capture import FAULHABER, Plan, clean_capture

Floats = NDArray[np.float64]
POINT = np.array(list(FAULHABER.values()))
OFFSET, GAIN = Instance(CURRENT_OFFSET), Instance(CURRENT_GAIN)


@cache
def capture() -> Capture:
    """With a gain of the current that is known to 1 %."""
    made = clean_capture(FAULHABER, Plan(count=400))
    current = replace(made.channels[CURRENT], gain_uncertainty=0.01)
    return replace(made, channels={**made.channels, CURRENT: current})


def record(free: tuple[str, ...] = PARAMETERS, **fixed: float) -> MotorRecord:
    return MotorRecord(capture(), free, fixed)


def begin(one: MotorRecord) -> Floats:
    return np.array([u.start for u in one.unknowns])


def test_the_model_at_the_true_motor_is_what_was_measured() -> None:
    one = record()
    found = one.departures(POINT, begin(one))
    for m, left in zip(one.measured, found, strict=True):
        assert np.abs(left).max() < 1e-4 * np.abs(m.values).max(), m.block.name
    for left, weighed in zip(found, one.residuals(POINT, begin(one)), strict=True):
        assert (weighed == 0.0).all() == (left == 0.0).all()


def test_what_is_fixed_is_no_unknown_and_has_its_place() -> None:
    one = record(("K", "J"), **{n: FAULHABER[n] for n in ("R", "L", "B", "T0")})
    moved = one.motor(np.array([5.0, 7.0]))
    six = dict(zip(PARAMETERS, moved.tolist(), strict=True))
    assert six == {**FAULHABER, "K": 5.0, "J": 7.0}
    assert one.emf_constant(np.array([5.0, 7.0])) == 5.0
    with pytest.raises(KeyError, match="T_lc"):
        one.unknown("T_lc", 1.0)


@pytest.mark.parametrize("left", [(CURRENT, POSITION), (VOLTAGE,)])
def test_a_capture_without_a_voltage_or_without_all_else_is_refused(left: tuple[str, ...]) -> None:
    channels = {n: c for n, c in capture().channels.items() if n in left}
    shut = {VOLTAGE: Channel(VOLTAGE, "V", np.full(400, 6.0))} if VOLTAGE in left else channels
    bare = Capture(capture().ticks, capture().clock_hz, shut)
    with pytest.raises(DataError, match="no voltage" if VOLTAGE not in left else "neither"):
        MotorRecord(bare, PARAMETERS, {})


def test_an_offset_of_a_reading_needs_no_new_response_and_one_of_the_drive_does() -> None:
    one = record()
    own = begin(one)
    assert one.simulated == 0
    before = one.fitted(POINT, own)
    assert one.simulated == 1
    places = {i: k for k, i in enumerate(one.instances)}
    moved = own.copy()
    moved[places[OFFSET]] += 0.25
    shifted = one.fitted(POINT, moved)
    assert one.simulated == 1
    current = [m.block.name for m in one.measured].index(CURRENT)
    assert shifted[current] == pytest.approx(before[current] + 0.25)
    for k, (a, b) in enumerate(zip(before, shifted, strict=True)):
        assert k == current or (a == b).all()
    moved[places[Instance(VOLTAGE_OFFSET)]] += 0.1
    one.fitted(POINT, moved)
    assert one.simulated == 2


def test_the_latest_responses_are_remembered() -> None:
    one = record()
    own = begin(one)
    motors = [POINT * (1.0 + 0.01 * k) for k in range(REMEMBERED + 1)]
    first = [one.readings(m, own) for m in motors[:REMEMBERED]]
    assert all((one.readings(m, own) == y).all() for m, y in zip(motors, first, strict=False))
    assert one.simulated == REMEMBERED
    one.readings(motors[0], own)  # used again: the second is the oldest now
    one.readings(motors[-1], own)
    assert one.simulated == REMEMBERED + 1
    one.readings(motors[0], own)
    assert one.simulated == REMEMBERED + 1
    one.readings(motors[1], own)
    assert one.simulated == REMEMBERED + 2


def test_sizes_beside_the_unknowns_act_and_are_not_kept() -> None:
    one = record()
    own = begin(one)
    usual = one.fitted(POINT, own)
    current = [m.block.name for m in one.measured].index(CURRENT)
    raised = one.fitted(POINT, own, {GAIN: 0.1})
    assert raised[current] == pytest.approx(1.1 * usual[current])
    assert one.fitted(POINT, own)[current] == pytest.approx(usual[current])


def test_a_quantity_is_an_unknown_or_propagated_and_never_both() -> None:
    one = record()
    count = len(one.unknowns)
    declared = dict(one.propagated)
    assert declared[GAIN].prior_sd == pytest.approx(0.01)
    assert not set(declared) & set(one.instances)
    one.estimate(GAIN)
    assert (one.instances[-1], one.unknowns[-1].prior_sd) == (GAIN, pytest.approx(0.01))
    assert GAIN not in dict(one.propagated)
    assert list(one.sizes(np.arange(float(count + 1))))[-1] == GAIN.name
    assert one.sizes(np.arange(float(count + 1)))[GAIN.name] == float(count)
    one.propagate(GAIN)
    assert len(one.unknowns) == count
    assert set(dict(one.propagated)) == set(declared)


def test_what_is_found_keeps_the_prior_that_it_was_given() -> None:
    one = record()
    wide = Unknown(GAIN.name, 0.3, prior_sd=9.0)
    narrow = replace(one.unknowns[0], prior_sd=1e-9, start=4.0)
    one._take(
        [(one.instances[0], narrow), *list(zip(one.instances, one.unknowns, strict=True))[1:]]
    )
    one.find({GAIN: wide})
    assert one.found == {GAIN}
    assert one.unknowns[-1] == wide
    one.renew()
    assert one.unknowns[-1] == wide
    again, usual = one.unknowns[0], record().unknowns[0]
    assert (again.prior_mean, again.prior_sd) == (usual.prior_mean, usual.prior_sd)
    assert again.start == 4.0


def test_another_record_goes_on_where_one_ended() -> None:
    one, other = record(), record()
    one.find({GAIN: Unknown(GAIN.name, 0.3, prior_sd=9.0)})
    one.untried, one.as_stamped = 3, {"R": 2.0}
    one.left_open = (POINT,)
    ended = np.arange(float(len(one.unknowns)))
    one.outlying = True
    other.go_on(one, ended)
    assert other.outlying
    assert (other.found, other.untried, other.as_stamped) == ({GAIN}, 3, {"R": 2.0})
    assert other.left_open is one.left_open
    assert other.instances == one.instances
    assert begin(other).tolist() == ended.tolist()
    assert other.unknowns[-1].prior_sd == 9.0


def test_another_voltage_for_once_leaves_the_record_as_it_was() -> None:
    one = record()
    own = begin(one)
    usual = one.fitted(POINT, own)
    halved = one.fitted_with(POINT, own, 0.5 * one.volts)
    fresh = record()
    fresh.volts = 0.5 * fresh.volts
    fresh.response.excite(fresh.volts, fresh.stretches)
    for a, b in zip(halved, fresh.fitted(POINT, own), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-12)
    for a, b in zip(one.fitted(POINT * 1.01, own), record().fitted(POINT * 1.01, own), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-12)
    for a, b in zip(one.fitted(POINT, own), usual, strict=True):
        assert (a == b).all()


def test_a_twin_has_a_life_of_its_own() -> None:
    one = record()
    own = begin(one)
    usual = one.fitted(POINT, own)
    twin = one.twin()
    twin.volts = np.zeros_like(twin.volts)
    twin.response.excite(twin.volts, twin.stretches)
    rests = twin.fitted(POINT, own)
    current = [m.block.name for m in one.measured].index(CURRENT)
    assert np.abs(rests[current]).max() < 0.1 * np.abs(usual[current]).max()
    for a, b in zip(one.fitted(POINT * 1.0, own), usual, strict=True):
        assert (a == b).all()


def test_an_open_bridge_shows_the_speed_in_volts() -> None:
    one = record()
    (emf,) = (k for k, m in enumerate(one.measured) if m.block.name == EMF)
    readings = one.readings(POINT, begin(one))
    shown = one.shown(readings, POINT, begin(one))
    assert shown[EMF] == pytest.approx(FAULHABER["K"] * one.measured[emf].of(readings))
    assert set(shown) == {m.block.name for m in one.measured}


def test_a_magnitude_has_no_sign() -> None:
    """Backwards, of a channel that shows magnitudes alone."""
    made = clean_capture(FAULHABER, Plan((-6.0, -3.0), count=400))
    current = made.channels[CURRENT]
    bare = replace(current, raw=np.abs(current.raw), unsigned=True)
    one = MotorRecord(replace(made, channels={**made.channels, CURRENT: bare}), PARAMETERS, {})
    signed = MotorRecord(made, PARAMETERS, {})
    shown = one.shown(one.readings(POINT, begin(one)), POINT, begin(one))[CURRENT]
    true = signed.shown(signed.readings(POINT, begin(signed)), POINT, begin(signed))[CURRENT]
    assert true.min() < -0.1
    assert (shown >= 0.0).all()
    (read,) = (m for m in one.measured if m.block.name == CURRENT)
    np.testing.assert_allclose(shown, np.abs(read.of(one.readings(POINT, begin(one)))))


def test_without_pwm_nothing_swings() -> None:
    one = record()
    assert one.loss is not None
    assert not one.ripples
    assert one.pwm_period_s == 0.0


def test_pwm_makes_a_current_swing_where_brushes_are_unknowns() -> None:
    subject = benched("measured")
    assert subject.pwm_period_s == pytest.approx(1.0 / PWM_HZ)
    assert subject.loss is not None
    assert subject.ripples is True


def test_brushes_drop_as_much_as_their_unknown_says() -> None:
    """All of it at a large current, signed like it."""
    one = record()
    own = begin(one)
    own[one.instances.index(Instance(BRUSH_DROP))] += 0.4
    more = one.brush_drop(POINT, own, np.array([-50.0, 0.0, 50.0]))
    usual = one.brush_drop(POINT, begin(one), np.array([-50.0, 0.0, 50.0]))
    assert more - usual == pytest.approx([-0.4, 0.0, 0.4], rel=0.01)
