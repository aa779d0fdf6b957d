"""No argument of a compiled response reaches beyond its buffers: one sentence refuses it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.motor.batch import LINEAR, QUADRATIC, Record, expm
from motorid.motor.reading import Output, Quantity, Stretch
from motorid.motor.response import Response
from motorid.motor.wide import NAMES, SIX, WideResponse

H, COUNT = 1e-4, 40
MOTOR = (2.6, 180e-6, 7.68e-3, 3e-7, 3.9e-7, 3e-4)
WIDE = [dict(zip(SIX, MOTOR, strict=True)).get(name, 0.0) for name in NAMES]
SANE = Output(Quantity.CURRENT, 0.5 * H, 0.2 * H)
VOLTS = np.full(COUNT, 5.0)
NAN, INF = float("nan"), float("inf")

models = pytest.mark.parametrize("model", [Response, WideResponse])


@models
@pytest.mark.parametrize("value", [-1e-300, -0.5 * H, -H, -1.5 * H, -1e9, NAN, INF, -INF])
@pytest.mark.parametrize("name", ["aperture_s", "delay_s", "filter_s"])
def test_a_time_that_is_none_is_refused(model, name: str, value: float) -> None:
    output = replace(SANE, **{name: value})
    with pytest.raises(ValueError, match=f"output 1: {name} is"):
        model(H, VOLTS, [SANE, output])
    if name == "filter_s":
        response = model(H, VOLTS, [SANE, SANE])
        with pytest.raises(ValueError, match="output 1: filter_s is"):
            response.filter(1, value)


@models
@pytest.mark.parametrize("value", [-0.3 * H, -1e9, NAN, INF])
def test_a_delay_that_is_changed_is_refused_alike(model, value: float) -> None:
    response = model(H, VOLTS, [SANE])
    motor = MOTOR if model is Response else WIDE
    before = response(motor)
    with pytest.raises(ValueError, match=r"ahead of it|delay_s is"):
        response.delay(0, value)
    np.testing.assert_array_equal(response(motor), before)


@models
@pytest.mark.parametrize("row", [-1, 1, 10**6])
def test_a_row_that_is_none_is_refused(model, row: int) -> None:
    response = model(H, VOLTS, [SANE])
    for change in (response.delay, response.filter):
        with pytest.raises(ValueError, match=f"no output {row}"):
            change(row, H)
    with pytest.raises(ValueError, match=f"no stretch {row}"):
        response.kick(row, 1.0)


@models
@pytest.mark.parametrize("back", [1.0, COUNT - 1.0, COUNT + 0.5, 1e6, 9.9e8])
@pytest.mark.parametrize("filter_s", [0.0, 3e-5])
def test_a_delay_beyond_the_record_shows_what_was_before_it(model, back: float, filter_s) -> None:
    """Current and speed are as they were; the aperture may lie on both sides of the beginning."""
    outputs = [
        Output(Quantity.CURRENT, 7 * H, back * H, filter_s=filter_s),
        Output(Quantity.SPEED, 0.0, back * H, filter_s=filter_s),
    ]
    motor, more = (MOTOR, ()) if model is Response else (WIDE, (0.0, 0.0, 0.0))
    y = model(H, VOLTS, outputs)(motor, (0.1, 20.0, 0.0, *more))
    early = min(COUNT, int(back))
    np.testing.assert_allclose(y[0, :early], 0.1, rtol=1e-6)
    np.testing.assert_array_equal(y[1, :early], 20.0)


@models
def test_a_delay_beyond_all_count_is_refused(model) -> None:
    for output in (replace(SANE, delay_s=2e9 * H), replace(SANE, aperture_s=1e300)):
        with pytest.raises(ValueError, match="sample periods"):
            model(H, VOLTS, [output])


@models
@pytest.mark.parametrize(
    "starts", [[2], [-1], [0, 20, 10], [0, COUNT + 1], [0, 10**9], [0, -5], []]
)
def test_stretches_out_of_order_or_of_the_record_are_refused(model, starts: list[int]) -> None:
    plan = [Stretch(start, discontinuous=True) for start in starts]
    with pytest.raises(ValueError, match="stretch"):
        model(H, VOLTS, [SANE], plan)
    response = model(H, VOLTS, [SANE])
    with pytest.raises(ValueError, match="stretch"):
        response.excite(VOLTS, plan)
    assert np.isfinite(response(MOTOR if model is Response else WIDE)).all()


@models
def test_empty_stretches_and_one_at_the_end_change_nothing(model) -> None:
    motor = MOTOR if model is Response else WIDE
    plain = model(H, VOLTS, [SANE])(motor)
    plan = [Stretch(0), Stretch(10), Stretch(10), Stretch(COUNT, discontinuous=True)]
    np.testing.assert_allclose(model(H, VOLTS, [SANE], plan)(motor), plain, rtol=1e-12)


@models
@pytest.mark.parametrize(
    "name", ["series_ohm", "clamp_v", "duty", "swing_v", "late_s", "kick_rad_s"]
)
@pytest.mark.parametrize("value", [NAN, INF])
def test_a_stretch_of_no_number_is_refused(model, name: str, value: float) -> None:
    with pytest.raises(ValueError, match=f"stretch 1: {name} is"):
        model(H, VOLTS, [SANE], [Stretch(0), Stretch(5, **{name: value})])


@models
@pytest.mark.parametrize("period", [0.0, -H, NAN, INF])
def test_a_period_that_is_none_is_refused(model, period: float) -> None:
    with pytest.raises(ValueError, match="sample period"):
        model(period, VOLTS, [SANE])
    if period:
        with pytest.raises(ValueError, match="PWM period"):
            model(H, VOLTS, [SANE], pwm_period_s=period)


@models
def test_records_and_outputs_of_no_use_are_refused(model) -> None:
    for volts in (np.zeros(0), np.zeros((COUNT, 0)), np.zeros((COUNT, 2))):
        with pytest.raises(ValueError, match=r"no samples|shape"):
            model(H, volts, [SANE])
    for outputs in ([], [SANE] * 17):
        with pytest.raises(ValueError, match="outputs"):
            model(H, VOLTS, outputs)
    assert model(H, VOLTS, [SANE] * 16)(MOTOR if model is Response else WIDE).shape == (16, COUNT)
    with pytest.raises(ValueError, match="no quantity"):
        model(H, VOLTS, [replace(SANE, quantity=7)])
    with pytest.raises(ValueError, match="pwm_phase"):
        model(H, VOLTS, [replace(SANE, pwm_phase=NAN)])


@models
def test_motors_and_states_of_another_length_are_refused(model) -> None:
    response = model(H, VOLTS, [SANE])
    motor = MOTOR if model is Response else WIDE
    for values, initial in ((motor[:-1], ()), ((*motor, 1.0), ()), (motor, (0.0, 0.0))):
        with pytest.raises(ValueError, match=r"parameters|values"):
            response(values, *([initial] if initial else []))


def test_levels_and_angles_of_another_size_are_refused() -> None:
    response = WideResponse(H, VOLTS, [SANE])
    for levels in (np.zeros(3, np.uint8), np.zeros(COUNT, np.int64), np.zeros(0, np.uint8)):
        response.levels = levels
        for run in (response, response.plan):
            with pytest.raises(ValueError, match="levels"):
                run(WIDE)
    response.levels = np.full(COUNT, 255, np.uint8)  # finer than the finest is the finest
    response.angle = np.zeros(COUNT, np.float32)
    with pytest.raises(ValueError, match="angles"):
        response(WIDE)
    response.angle = np.zeros(2 * COUNT)[::2]
    with pytest.raises(ValueError, match="angles"):
        response(WIDE)
    response.angle = None
    assert np.isfinite(response(WIDE)).all()


def test_batches_whose_arrays_do_not_fit_are_refused() -> None:
    record = Record(H, VOLTS, {"current": np.zeros(COUNT)})
    assert LINEAR.squares(np.array([MOTOR[:5]]), record).shape == (1, 1)
    for wrong in (
        replace(record, measured={"current": np.zeros(3)}),
        replace(record, open=np.zeros(3, bool)),
        replace(record, input=np.zeros((COUNT, 2))),
        replace(record, input=np.zeros(0), measured={"current": np.zeros(0)}),
    ):
        with pytest.raises(ValueError, match="samples"):
            LINEAR.squares(np.array([MOTOR[:5]]), wrong)
    with pytest.raises(ValueError, match="candidates"):
        QUADRATIC.squares(np.ones((2, 3)), record)
    for shape in ((1, 7, 7), (1, 2, 3)):
        with pytest.raises(ValueError, match="matrices"):
            expm(np.zeros(shape))
