"""What each quantity reads of an estimate that was made by hand."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pytest

from motorid.estimate.effects.rotor.cogging import COGGING
from motorid.estimate.results.estimate import Estimate, MeasuredLevel, Repeats, Rise
from motorid.estimate.results.status import Status
from motorid.motor.parameters import FIGURES, Motor
from motorid.quality import ripple
from motorid.quality.quantities import QUANTITIES, Context, of_parameter, quantity
from motorid.quality.ripple import Window
from motorid.quality.temperature import Temperature
from motorid.quality.verdict import Reading
from tests.quality.made_estimate import VALUES, curve, estimate, parameter


@dataclass
class Made:
    """A product of which only this is looked at."""

    voltage_v: float = 5.0
    segments: int = 4
    commutations_per_turn: int = 8
    temperature: Temperature = Temperature(magnet_per_k=-0.002, rise_k=10.0)  # noqa: RUF009


def read(
    name: str, made: Estimate, windows: Sequence[Window] | None = None, product: Made | None = None
) -> Reading:
    context = Context(made, product or Made())
    if windows is not None:
        context.__dict__["windows"] = tuple(windows)
    found = quantity(name)
    assert found is not None
    return found.read(context)


def with_parameter(name: str, **changes: object) -> Estimate:
    whole = estimate()
    one = replace(whole.parameters[name], **changes)  # type: ignore[arg-type]
    return replace(whole, parameters={**whole.parameters, name: one})


@pytest.mark.parametrize("name", VALUES)
def test_a_parameter_as_it_was_found(name: str) -> None:
    found = read(name, estimate())
    assert (found.value, found.problem) == (VALUES[name], "")
    assert found.uncertainty == pytest.approx(0.005 * VALUES[name])


@pytest.mark.parametrize(
    ("status", "value", "note", "problem"),
    [
        (Status.ESTIMATED, None, "", "these data do not tell it"),
        (Status.ESTIMATED, None, "why", "why"),
        (Status.NOT_IDENTIFIABLE, 1.0, "", "these data do not tell it"),
        (Status.NOT_SUPPORTED, 1.0, "why", "why"),
        (Status.DOUBTFUL, 1.0, "why", "why"),
        (Status.FIXED, 1.0, "why", "it was given, not measured: fit without fixing it"),
        (Status.AT_BOUND, 0.0, "why", ""),
    ],
)
def test_a_parameter_that_is_not_judged(
    status: Status, value: float | None, note: str, problem: str
) -> None:
    found = of_parameter(parameter("R", value, 0.1, status, note))
    assert (found.unit, found.problem) == ("ohm", problem)
    assert (found.value, found.uncertainty) == ((None, None) if problem else (value, 0.1))


def cold() -> tuple[float, float]:
    """R of a winding 5 K above 25 °C, by 20 °C and 10 K of heating; K of magnets 5 K below."""
    return 2.0 / (1 + 0.00393 * 5.0), 0.01 / (1 + 0.002 * 5.0)


def test_resistance_and_constant_at_25_degrees() -> None:
    """An ambient known to 0.3 K and a rise known to 0.5 K move R by 0.39 % a kelvin."""
    made = {n: parameter(n, v) for n, v in VALUES.items()}
    made |= {n: replace(made[n], interval_95=(0.99 * VALUES[n], 1.01 * VALUES[n])) for n in "RK"}
    resistance, constant = (read(f"{n}_25", estimate(parameters=made)) for n in "RK")
    assert (resistance.value, constant.value) == pytest.approx(cold())
    assert (resistance.unit, constant.unit) == ("ohm", "N·m/A")
    doubt = math.hypot(0.00393 * 0.3, 0.00393 * 0.5, 5e-5 * 5.0) / (1 + 0.00393 * 5.0)
    assert resistance.uncertainty == pytest.approx(cold()[0] * math.hypot(0.005, doubt))


@pytest.mark.parametrize("gone", ["value", "total"])
def test_what_is_unknown_as_run_is_unknown_at_25(gone: str) -> None:
    found = read("R_25", with_parameter("R", **{gone: None}))
    assert found.uncertainty is None
    assert found.value == (2.0 if gone == "total" else None)


def test_25_degrees_need_an_ambient_and_a_rise() -> None:
    found = read("R_25", estimate(inputs=({},)))
    assert found.problem == "the ambient is not known: give it in the rig file"
    unknown = Made(temperature=Temperature(magnet_per_k=0.0))
    assert read("R_25", estimate(), product=unknown).problem == found.problem
    own = estimate(rise=Rise(10.0, 0.5, 1.0, "measured"))
    assert Context(own, unknown).warmth == Context(estimate(), Made()).warmth is not None
    assert found.unit == "ohm"


def test_a_motor_at_25_degrees_is_the_one_as_run_but_for_two() -> None:
    context = Context(estimate(), Made())
    assert context.as_run == Motor.of(VALUES)
    assert context.motor is not None
    found = context.motor.R, context.motor.K
    assert found == pytest.approx(cold())
    assert replace(context.motor, R=2.0, K=0.01) == context.as_run
    assert context.resistance == 2.0
    for name in VALUES:
        lacks = Context(with_parameter(name, value=None), Made())
        assert lacks.as_run is lacks.motor is None
    assert Context(estimate(inputs=({},)), Made()).motor is None


def test_a_doubtful_parameter_is_named_with_its_note() -> None:
    context = Context(with_parameter("K", status=Status.DOUBTFUL, note="moved"), Made())
    assert context.doubt("R", "K") == "K is moved"
    assert context.doubt("R", "J") == ""


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_at_25_degrees(name: str) -> None:
    """Relative uncertainty of the estimate's own, beside what 0.583 K of R and K does."""
    own = parameter(name, 100.0, 2.0)
    found = read(name, estimate(derived={name: own}))
    of = FIGURES[name].of
    resistance, constant = cold()
    here = Motor.of({**VALUES, "R": resistance, "K": constant})
    doubt = math.hypot(0.3, 0.5)
    warm = {"R": resistance * (1 + 0.00393 * doubt), "K": constant * (1 - 0.002 * doubt)}
    moved = of(Motor.of({**VALUES, **warm}), 5.0) - of(here, 5.0)
    value = of(here, 5.0)
    assert (found.unit, found.value) == (FIGURES[name].unit, pytest.approx(value))
    assert found.uncertainty == pytest.approx(math.hypot(0.02 * value, moved), rel=1e-6)


def test_a_figure_that_is_not_judged() -> None:
    own = parameter("Kv", 100.0, 2.0)
    unknown = "the parameters it follows from are unknown"
    for derived in ({}, {"Kv": replace(own, value=None)}, {"Kv": replace(own, total=None)}):
        assert read("Kv", estimate(derived=derived)).problem == unknown
    assert read("Kv", estimate(derived={"Kv": own}, inputs=({},))).problem == unknown
    doubtful = replace(own, status=Status.DOUBTFUL, note="K: moved; R: off")
    assert read("Kv", estimate(derived={"Kv": doubtful})).problem == "R: off"


# ---- of steady stretches -----------------------------------------------------------------------


def window(sign: float, current: Sequence[float], slope: float = 0.0, scatter: float = 0.0,
           mean: float = 0.5, level: float = 5.0) -> Window:  # fmt: skip
    """Two turns of four readings; the position gains ``slope`` of the angle."""
    angle = sign * np.linspace(0.0, 4 * np.pi, len(current))
    position = slope * angle + scatter * np.resize([1.0, -1.0, -1.0, 1.0], len(current))
    return Window(angle, np.asarray(current), position, sign * level, sign * mean, sign * 300.0)


def test_a_current_that_differs_with_the_direction() -> None:
    """Means of 0.02 and of -0.01 along the motion, over a level of (0.5 + 0.7 + 0.6)/3 A."""
    ahead = [window(1.0, [0.01, 0.03, 0.01, 0.03]), window(1.0, [0.03, 0.01] * 2, mean=0.7)]
    back = window(-1.0, [0.01, 0.03, -0.01, 0.01], mean=0.6)
    found = read("direction_current", estimate(), [*ahead, back])
    assert found.value == pytest.approx((0.02 + 0.01) / 0.6)
    noise = math.hypot(0.01 / math.sqrt(8), math.sqrt(2e-4) / 2)
    assert found.uncertainty == pytest.approx(noise / 0.6)
    made = {"current offset": parameter("current offset", 0.0, 4e-3),
            "current offset 2": parameter("current offset 2", 0.0, 3e-3),
            "voltage offset": parameter("voltage offset", 0.0, 9.0)}  # fmt: skip
    unsure = read("direction_current", estimate(nuisance=made), [*ahead, back])
    assert unsure.uncertainty == pytest.approx(math.hypot(noise, 8e-3) / 0.6)


def test_a_motor_that_creeps_has_a_direction_too() -> None:
    """At half a radian a second, as behind a worm gear."""
    slow = [replace(window(sign, [0.01, 0.03] * 2), speed=0.5 * sign) for sign in (1.0, -1.0)]
    assert read("direction_current", estimate(), slow).value == pytest.approx(0.04 / 0.5)


def test_a_speed_that_differs_with_the_direction() -> None:
    """Slopes of 0.03 and 0.01 ahead, of -0.01 back, over a level of (5 + 5 + 8)/3 V."""
    ahead = [window(1.0, [0.0] * 8, slope) for slope in (0.03, 0.01)]
    back = window(-1.0, [0.0] * 8, -0.01, level=8.0)
    made = {"voltage offset": parameter("voltage offset", 0.0, 0.03),
            "current offset": parameter("current offset", 0.0, 9.0)}  # fmt: skip
    found = read("direction_speed", estimate(nuisance=made), [*ahead, back])
    assert found.value == pytest.approx(0.03)
    variance = 0.0
    for one, count in ((ahead[0], 2), (ahead[1], 2), (back, 1)):
        turned = one.angle - one.angle.mean()
        variance += float(one.position.var() / (turned @ turned)) / count**2
    assert found.uncertainty == pytest.approx(math.hypot(math.sqrt(variance), 0.06 / 6.0))


STEADY = "the run holds no steady stretch of two turns with current and position"
OF_STRETCHES = {
    "ripple_commutation": "R", "ripple_turn": "R", "ripple_segment": "R", "friction_turn": "J",
    "unbalance": "K",
}  # fmt: skip


@pytest.mark.parametrize("name", OF_STRETCHES)
def test_what_stretches_need(name: str) -> None:
    """A stretch, and parameters that are known and not doubtful."""
    one = [window(1.0, 0.01 * np.cos(np.linspace(0.0, 90.0, 200)))]
    assert read(name, estimate(), one).value is not None
    assert read(name, estimate(), []).problem.startswith(STEADY)
    parameter_ = OF_STRETCHES[name]
    unknown = with_parameter(parameter_, value=None)
    assert read(name, unknown, one).problem.startswith(STEADY)
    doubtful = with_parameter(parameter_, status=Status.DOUBTFUL, note="moved")
    assert read(name, doubtful, one).problem == f"{parameter_} is moved"
    assert read(name, doubtful, one).unit == QUANTITIES[name].unit
    all_of_them = replace(estimate(), parameters={
        n: parameter(n, v, status=Status.DOUBTFUL, note="moved") for n, v in VALUES.items()
    })  # fmt: skip
    first = "R" if name.startswith("ripple") else "K"
    assert read(name, all_of_them, one).problem == f"{first} is moved"


def test_ripple_over_a_turn_and_by_commutation() -> None:
    """Amplitudes 0.05 A at twice a turn and 0.02 A at eight times, at 2 ohm and 5 V."""
    angle = np.linspace(0.0, 20 * np.pi, 2000)
    current = 0.05 * np.cos(2 * angle + 0.3) + 0.02 * np.sin(8 * angle) + 0.01 * np.cos(16 * angle)
    one = [Window(angle, current, np.zeros(2000), 5.0, 0.5, 300.0)]
    turn, commutation = (read(f"ripple_{n}", estimate(), one) for n in ("turn", "commutation"))
    assert (turn.value, turn.note) == (pytest.approx(0.02, rel=1e-3), "2 times a turn")
    assert (commutation.value, commutation.note) == (pytest.approx(0.008, rel=1e-3), "")
    assert commutation.uncertainty == pytest.approx(0.0, abs=1e-5)  # twice eight is fitted as well


def test_the_worst_segment_is_counted_from_one() -> None:
    angle = np.linspace(0.0, 20 * np.pi, 4000, endpoint=False)
    place = (angle * 4 / (2 * np.pi)).astype(int) % 4
    one = Window(angle, 0.1 * (place == 2), np.zeros(4000), 5.0, 0.5, 300.0)
    found = read("ripple_segment", estimate(), [one])
    assert (found.value, found.note) == (pytest.approx(0.04), "segment 3 of 4 from the start")


def test_torque_over_a_turn_and_unbalance() -> None:
    angle = np.linspace(0.0, 20 * np.pi, 2000)
    one = Window(angle, 0.05 * np.cos(angle), np.zeros(2000), 5.0, 0.5, 300.0)
    turn, unbalance = (read(n, estimate(), [one]) for n in ("friction_turn", "unbalance"))
    assert turn.value == pytest.approx(2 * 0.05 * 0.01, rel=1e-3)
    assert unbalance.value == pytest.approx(0.05 * 0.01, rel=1e-3)
    found = ripple.turn_torque([one], 0.01, 4e-7)
    assert turn.uncertainty == found.peak_to_peak_sd
    assert unbalance.uncertainty == found.unbalance_sd


# ---- of the fit itself -------------------------------------------------------------------------


def test_cogging_is_the_sum_of_what_was_found() -> None:
    """Two of 3 and 4 mN·m by noise of 0.1 and 0.2, J to 2 %, and 1 % of the shape."""
    made = tuple(
        Repeats(name, times, amplitude, u, "N·m")
        for name, times, amplitude, u in (
            (COGGING.name, 6, 3e-3, 1e-4), (COGGING.name, 12, 4e-3, 2e-4), ("else", 1, 9.0, 9.0),
        )
    )  # fmt: skip
    sure = with_parameter("J", total=8e-9)
    found = read("cogging", replace(sure, repeating=made))
    u = math.hypot(1e-4, 2e-4, 0.02 * 7e-3, 0.01 * 7e-3)
    assert (found.value, found.uncertainty) == pytest.approx((7e-3, u))
    assert (found.note, found.unit) == ("6 and 12 times a turn", COGGING.unit)
    for gone in ({"total": None}, {"value": 0.0}):
        unknown = replace(with_parameter("J", **gone), repeating=made)
        expected = math.hypot(1e-4, 2e-4, 0.01 * 7e-3)
        assert read("cogging", unknown).uncertainty == pytest.approx(expected)
    doubtful = replace(with_parameter("J", status=Status.DOUBTFUL, note="moved"), repeating=made)
    assert read("cogging", doubtful).problem == "J is moved"
    none = read("cogging", replace(doubtful, repeating=made[2:]))
    assert (none.value, none.uncertainty) == (0.0, 0.0)


def test_a_shape_is_the_worst_rms_of_its_channel() -> None:
    """Of 8 readings off by 0.3, beside 4 off by 0.1: 0.3 to a quarter."""
    made = estimate(
        curves=(
            curve("current", [1.1] * 4, [1.0] * 4), curve("current", [0.7, 1.3] * 4, [1.0] * 8, 1),
            curve("position", [5.0] * 2, [3.0] * 2),
        )
    )  # fmt: skip
    current, position = (read(f"shape_{n}", made) for n in ("current", "position"))
    assert (current.value, current.uncertainty) == pytest.approx((0.3, 0.3 / 4))
    assert (position.value, position.uncertainty) == pytest.approx((2.0, 1.0))
    assert (current.unit, position.unit) == ("A", "rad")
    assert read("shape_current", estimate()).problem == "the captures hold no current"


def test_a_fit_without_degrees_of_freedom_has_one() -> None:
    found = read("curve_shape", estimate(chi_square=9.0, degrees_of_freedom=0))
    assert (found.value, found.uncertainty) == pytest.approx((3.0, math.sqrt(0.5)))


def test_the_scatter_of_the_current_is_the_worst_capture_s() -> None:
    rng = np.random.default_rng(4)
    fitted = np.ones(600)
    one, other = (curve("current", 1 + u * rng.standard_normal(600), fitted) for u in (0.01, 0.03))
    found = read("brush_noise", estimate(curves=(one, other)))
    assert (found.value, found.uncertainty) == ripple.brush_noise(other)
    short = curve("current", fitted[:20], fitted[:20])
    for curves in ((), (one, short)):
        said = read("brush_noise", estimate(curves=curves)).problem
        assert said == "too little of the run carries current: accelerate longer"


def test_a_measured_level_is_a_quantity() -> None:
    level = MeasuredLevel(0, 0.1, 0.2, 5.0, 0.02, 400.0, 0.5, 0.2, 0.004)
    back = replace(level, voltage_v=-5.0, speed_rad_s=-390.0)
    made = estimate(levels=(level, back))
    assert read("measured_speed", made).value == pytest.approx(400.0)
    assert read("measured_speed@-5", made).value == pytest.approx(390.0)
    found = quantity("measured_current@-5")
    assert found is not None
    assert (found.unit, found.meaning) == ("A", "current as measured at -5 V")
    assert quantity("measured_torque") is None
    assert quantity("R_25") is QUANTITIES["R_25"]
