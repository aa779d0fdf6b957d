"""Priors, bounds and scales of what a motor and its channels declare, on subjects made by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Channel, Wiring
from motorid.estimate.effects.friction.load_friction import LOAD_FRICTION
from motorid.estimate.effects.friction.quadratic_friction import QUADRATIC_FRICTION
from motorid.estimate.effects.friction.windage import WINDAGE
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Scope, Use, instances
from motorid.estimate.effects.reading.current_filter import CURRENT_FILTER
from motorid.estimate.effects.reading.current_nonlinearity import CURRENT_NONLINEARITY
from motorid.estimate.effects.reading.current_offset import CURRENT_OFFSET
from motorid.estimate.effects.reading.motion_gain import MOTION_GAIN
from motorid.estimate.effects.reading.position_origin import POSITION_ORIGIN
from motorid.estimate.effects.registry import REGISTRY
from motorid.estimate.effects.rotor.cogging import COGGING
from motorid.estimate.effects.rotor.encoder_eccentricity import ENCODER_ECCENTRICITY
from motorid.estimate.effects.rotor.encoder_error import ENCODER_ERROR
from motorid.estimate.effects.rotor.k_ripple import K_RIPPLE
from motorid.estimate.effects.rotor.r_ripple import R_RIPPLE
from motorid.estimate.effects.timing.current_delay import CURRENT_DELAY
from motorid.estimate.effects.timing.motion_delay import MOTION_DELAY
from motorid.estimate.effects.timing.voltage_jump import VOLTAGE_JUMP
from motorid.estimate.effects.timing.voltage_late import VOLTAGE_LATE
from motorid.estimate.effects.unstated import default
from motorid.estimate.effects.unstated.current_lag import CURRENT_LAG
from motorid.estimate.effects.unstated.speed_second_order import SPEED_SECOND_ORDER
from motorid.estimate.effects.unstated.speed_smoothing import SPEED_SMOOTHING
from motorid.estimate.effects.unstated.voltage_smoothing import VOLTAGE_SMOOTHING
from tests.estimate.effects.made_subjects import MOTOR, TOP_V, block, prior, subject


@pytest.mark.parametrize("quantity", REGISTRY, ids=lambda q: q.name)
def test_a_quantity_says_of_what_it_is_one_and_what_a_fit_does_with_it(
    quantity: InfluenceQuantity,
) -> None:
    assert isinstance(quantity.scope, Scope)
    assert isinstance(quantity.use, Use)
    assert 0.0 < quantity.step <= 1e-3
    for text in (quantity.name, quantity.unit, quantity.remedy):
        assert text.strip() == text != ""


# friction, iron and what repeats, by the motor


def test_friction_is_expected_by_that_of_the_motor_at_its_top_speed() -> None:
    """8 V over .05: 160 rad/s, at which 6.4 mN·m are viscous and 6 dry."""
    top = TOP_V / 0.05
    viscous = 4e-5 * top
    assert QUADRATIC_FRICTION.scale(subject()) == pytest.approx((viscous + 6e-3) / top**2)
    assert WINDAGE.scale(subject()) == pytest.approx(viscous / top**2)
    sd, mean, start = prior(WINDAGE, subject()) or (0, 0, 0)
    assert (sd, mean, start) == (pytest.approx(0.25 * viscous / top**2), 0.0, None)
    assert prior(LOAD_FRICTION, subject()) == (0.025, 0.0, None)
    assert COGGING.scale(subject()) == pytest.approx(viscous + 6e-3)
    assert prior(COGGING, subject()) == (pytest.approx(viscous + 6e-3), 0.0, None)
    slick = subject(judged_at=MOTOR * [1, 1, 1, 0, 1, 0])
    least = 1e-3 * 0.05 * TOP_V / 2.0  # of the stall torque
    assert WINDAGE.scale(slick) == pytest.approx(least / top**2)
    assert COGGING.scale(slick) == pytest.approx(least)


def test_nothing_is_expected_before_a_motor_is_known() -> None:
    bare = subject(judged_at=None)
    assert prior(WINDAGE, bare) is prior(LOAD_FRICTION, bare) is None
    assert WINDAGE.scale(bare) == QUADRATIC_FRICTION.scale(bare) == COGGING.scale(bare) == 1.0


def test_windage_stays_in_the_budget_of_a_log_and_where_no_motion_is_read() -> None:
    """Nobody chose the speeds of a log; without one nothing tells it from B."""
    log = SimpleNamespace(waveform="a log's")
    assert not WINDAGE.kept(subject(block(POSITION)))
    assert not WINDAGE.kept(subject(block(SPEED)))
    assert WINDAGE.kept(subject(block(CURRENT)))
    assert WINDAGE.kept(subject(block(SPEED), sensed=log))
    assert not LOAD_FRICTION.kept(subject(block(SPEED), sensed=log))


def test_every_commutator_ripples_and_every_disc_is_off_its_centre() -> None:
    """A commutator of three bars by a tenth; a disc of 10 mm by .2 mm."""
    assert prior(K_RIPPLE, subject()) == prior(R_RIPPLE, subject()) == (0.1, 0.0, None)
    assert prior(ENCODER_ERROR, subject()) == (0.2 / 10.0, 0.0, None)


def test_a_stated_disc_errs_by_its_amplitude_whatever_its_angle() -> None:
    """At the shaft of the motor, behind a gear; a cosine and a sine of √½ each."""
    wiring = Wiring(encoder_eccentricity_rad=0.02, gear_ratio=3.0)
    turned = block(POSITION, (0.0, 1.5, 3.0))
    one = subject(turned, capture=SimpleNamespace(wiring=wiring))
    assert prior(ENCODER_ECCENTRICITY, one) == (pytest.approx(0.02 / 2**0.5), 0.0, None)
    assert ENCODER_ECCENTRICITY.scale(one) == 0.02
    assert [at.place for at in instances(ENCODER_ECCENTRICITY, one)] == [0, 1]
    (act,) = ENCODER_ECCENTRICITY.acts
    course: Any = act
    assert course.course(one, 0, None) == pytest.approx(3.0 * np.cos([0.0, 0.5, 1.0]))
    assert course.course(one, 1, None) == pytest.approx(3.0 * np.sin([0.0, 0.5, 1.0]))
    assert prior(ENCODER_ECCENTRICITY, subject(turned)) is None
    assert ENCODER_ECCENTRICITY.scale(subject()) == 1.0
    without = subject(capture=SimpleNamespace(wiring=wiring))
    assert prior(ENCODER_ECCENTRICITY, without) is None


# readings


@pytest.mark.parametrize(
    ("filter_s", "delay_s", "modelled"), [(4e-6, 9e-6, 4e-6), (9e-6, 4e-6, 4e-6), (0.0, 4e-6, 0.0)]
)
def test_a_filters_parts_are_of_ten_per_cent(
    filter_s: float, delay_s: float, modelled: float
) -> None:
    """Evenly; as far as the delay holds it, and no farther than four deviations."""
    one = subject(block(CURRENT, filter_s=filter_s, delay_s=delay_s))
    sd = 0.1 / math.sqrt(3.0) * modelled
    assert prior(CURRENT_FILTER, one) == ((pytest.approx(sd), 0.0, None) if modelled else None)
    assert CURRENT_FILTER.bounds(one) == pytest.approx((-4.0 * sd, 4.0 * sd))
    assert CURRENT_FILTER.told(one) is bool(modelled)
    assert CURRENT_FILTER.scale(one) == modelled
    assert prior(CURRENT_FILTER, subject()) is None
    assert CURRENT_FILTER.bounds(subject()) == (0.0, 0.0)


@pytest.mark.parametrize(("rest", "told"), [(9, False), (10, True)])
@pytest.mark.parametrize("stated", [0.0, 0.2])
def test_a_zero_is_told_by_ten_readings_at_rest_or_by_its_channel(
    rest: int, told: bool, stated: float
) -> None:
    values = [0.5] * (rest - 1) + [0.75] + [6.0, 9.0]
    current = block(CURRENT, values, offset_uncertainty=stated)
    driven = np.arange(rest + 2) >= rest
    found = prior(CURRENT_OFFSET, subject(current, driven=driven))
    sd = stated or math.inf
    assert found == ((sd, 0.0, 0.5) if told else (sd, 0.0, None) if stated else None)
    assert CURRENT_OFFSET.scale(subject(current)) == 8.5


def test_a_logs_zero_that_nobody_states_is_a_hundredth_of_its_extent() -> None:
    waveform = SimpleNamespace(period_s=1e-3)
    sensed = SimpleNamespace(waveform=waveform)
    current = block(CURRENT, (1.0, 5.0, 2.0), undeclared=frozenset({"offset"}))
    one = subject(current, sensed=sensed)
    assert prior(CURRENT_OFFSET, one) == (pytest.approx(0.04), 0.0, None)
    unsigned = block(CURRENT, unsigned=True, offset_uncertainty=0.1)
    assert prior(CURRENT_OFFSET, subject(unsigned)) is None
    assert prior(CURRENT_OFFSET, subject()) is None


def test_a_course_is_of_its_own_shape_and_full_scale() -> None:
    bent = {"nonlinearity": 2e-3, "nonlinearity_shape": "s", "full_scale": 20.0}
    one = subject(block(CURRENT, **bent))
    assert prior(CURRENT_NONLINEARITY, one) == (2e-3, 0.0, None)
    for lacking in ({"nonlinearity": 0.0}, {"nonlinearity_shape": None}, {"full_scale": 0.0}):
        assert prior(CURRENT_NONLINEARITY, subject(block(CURRENT, **{**bent, **lacking}))) is None
    assert prior(CURRENT_NONLINEARITY, subject()) is None


def test_a_motions_gain_is_that_of_the_channel_that_shows_it() -> None:
    speed = block(SPEED, gain_uncertainty=2e-3, delay_uncertainty_s=3e-6, delay_s=9e-6)
    angle = block(POSITION, gain_uncertainty=1e-3, delay_uncertainty_s=1e-6, delay_s=4e-6)
    assert prior(MOTION_GAIN, subject(speed, angle)) == (1e-3, 0.0, None)
    assert prior(MOTION_GAIN, subject(speed)) == (2e-3, 0.0, None)
    assert prior(MOTION_DELAY, subject(speed, angle)) == (1e-6, 0.0, None)
    assert prior(MOTION_DELAY, subject(speed)) == (3e-6, 0.0, None)
    assert MOTION_DELAY.bounds(subject(speed)) == (pytest.approx(-9e-6), math.inf)
    for one in (subject(), subject(block(SPEED))):
        assert prior(MOTION_GAIN, one) is prior(MOTION_DELAY, one) is None
    assert MOTION_DELAY.bounds(subject()) == (0.0, math.inf)


def test_a_run_begins_at_the_angle_that_it_shows() -> None:
    assert prior(POSITION_ORIGIN, subject(block(POSITION, (7.0, 1.0, 2.0)))) == (math.inf, 0.0, 7.0)
    assert prior(POSITION_ORIGIN, subject()) is None


# times


@pytest.mark.parametrize(
    ("delay_s", "sd", "filter_s", "bounds"),
    [
        (9e-6, 2e-6, 0.0, (-8e-6, 8e-6)), (9e-6, 3e-6, 0.0, (-9e-6, 12e-6)),
        (9e-6, 2e-6, 4e-6, (-5e-6, 8e-6)), (0.0, 2e-6, 0.0, (0.0, 8e-6)),
    ],
)  # fmt: skip
def test_a_current_is_read_no_earlier_than_at_once_and_within_four_deviations(
    delay_s: float, sd: float, filter_s: float, bounds: tuple[float, float]
) -> None:
    current = block(CURRENT, delay_s=delay_s, delay_uncertainty_s=sd, filter_s=filter_s)
    assert CURRENT_DELAY.bounds(subject(current)) == pytest.approx(bounds)
    assert CURRENT_DELAY.bounds(subject()) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("sd", "shows", "told"),
    [(3e-6, True, True), (3.1e-6, True, False), (3e-6, False, False), (0.0, True, False)],
)
def test_a_delay_is_told_by_ripple_where_it_may_be_off_either_way(
    sd: float, shows: bool, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By three deviations, of 9 µs."""
    from motorid.estimate.effects.timing import current_delay

    asked: list[Any] = []
    monkeypatch.setattr(current_delay, "shows_ripple", lambda *of: asked.append(of) or shows)
    current = block(CURRENT, delay_s=9e-6, delay_uncertainty_s=sd)
    one = subject(current, capture=SimpleNamespace(wiring=Wiring(pwm_hz=2e4)))
    assert CURRENT_DELAY.told(one) is told
    assert all(of == (current.channel, 1e-4, 2e4) for of in asked)
    assert not CURRENT_DELAY.told(subject())


def log(window_s: float = 0.0, jumps: int = 0, **facts: Any) -> Any:
    channel = Channel(VOLTAGE, "V", np.zeros(3), **facts)
    waveform = SimpleNamespace(period_s=1e-3, window_s=window_s, jumps=[None] * jumps)
    return SimpleNamespace(waveform=waveform, channel=channel)


def test_a_logs_stamps_may_be_off_by_a_sample() -> None:
    """Or by what is stated; means whose delay is stated, by that alone, and not at all by none."""
    unknown: Any = frozenset({"delay"})
    loose = log(delay_uncertainty_s=1e-4, undeclared=unknown)
    cases = [
        (log(delay_uncertainty_s=1e-4), 1e-3), (log(delay_uncertainty_s=2e-3), 2e-3),
        (log(5e-4, delay_uncertainty_s=1e-4), 1e-4), (log(5e-4), None), (loose, 1e-3),
        (log(5e-4, undeclared=unknown), 1e-3),
        (SimpleNamespace(waveform=loose.waveform, channel=None), 1e-3),
    ]  # fmt: skip
    for sensed, sd in cases:
        found = prior(VOLTAGE_LATE, subject(sensed=sensed))
        assert found == (None if sd is None else (sd, 0.0, None))
    assert VOLTAGE_LATE.scale(subject(sensed=loose)) == 1e-3
    assert prior(VOLTAGE_LATE, subject()) is None
    assert VOLTAGE_LATE.scale(subject()) == 1.0


def test_a_jump_lies_anywhere_within_what_hides_it() -> None:
    one = subject(sensed=log(jumps=3))
    assert [at.place for at in instances(VOLTAGE_JUMP, one)] == [0, 1, 2]
    assert prior(VOLTAGE_JUMP, one, 2) == (pytest.approx(12.0**-0.5), 0.5, None)
    assert VOLTAGE_JUMP.bounds(one) == (0.0, 1.0)
    assert instances(VOLTAGE_JUMP, subject()) == []


@pytest.mark.parametrize("quantity", [CURRENT_LAG, SPEED_SMOOTHING, VOLTAGE_SMOOTHING])
def test_a_logs_channel_is_off_by_a_third_of_a_sample_where_nobody_states_it(
    quantity: InfluenceQuantity,
) -> None:
    silent: Any = frozenset({"delay", "filter"})
    blocks = [block(name, undeclared=silent) for name in (CURRENT, SPEED)]
    one = subject(*blocks, sensed=log(undeclared=silent))
    assert prior(quantity, one) == (pytest.approx(0.3e-3), 0.0, None)
    assert quantity.bounds(one) == pytest.approx((-0.5, 0.5))  # 500 samples
    stated = subject(block(CURRENT), block(SPEED), sensed=log())
    assert prior(quantity, stated) is None
    assert prior(quantity, subject(*blocks)) is None  # no log
    assert (
        prior(quantity, subject(sensed=SimpleNamespace(waveform=one.sensed.waveform, channel=None)))
        is None
    )
    assert SPEED_SECOND_ORDER.bounds(one) == pytest.approx((0.0, 0.5))
    assert default.period_s(subject()) == 0.0
    assert default.whole(subject(), 0.7e-3) == 0.7e-3
