"""Losses, noise of sources and warmth where a part of them is at a bound, absent, or declared."""

from __future__ import annotations

import math
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, SUPPLY, VOLTAGE, Capture, Channel, Wiring
from motorid.estimate.effects import action, source_noise, winding_temperature
from motorid.estimate.effects.action import Setup
from motorid.estimate.effects.brush_and_heating import (
    BENT,
    DROP,
    FARTHEST,
    WARMING,
    Bent,
    Loss,
    expected_drop,
    lossless,
)
from motorid.estimate.effects.source_noise import SourceNoise
from motorid.estimate.effects.winding_temperature import self_heating
from motorid.estimate.signals.source.ripple_average import Flow
from motorid.estimate.signals.source.step_transient import HEAD
from motorid.estimate.signals.source.thevenin_source import FEWEST
from motorid.estimate.signals.time_grid import Part, Timeline
from motorid.program import Decay, Program, Step, StepKind

TOP, R = 12.0, 2.0


def loss(**facts: Any) -> Loss:
    names = dict.fromkeys((DROP, BENT, WARMING), np.zeros(3))
    return Loss(
        np.ones(3, bool),
        1e-3,
        TOP,
        TOP,
        (0.4, 0.3),
        **{"capacity_j_k": None, "shapes": names, **facts},
    )


# losses


def test_a_mixture_takes_what_both_take_and_no_farther_than_a_bend_may_be() -> None:
    one = replace(loss(further=1.0, bent=Bent(0.1, 0.2)), shapes={DROP: np.array([1.0, 2.0, 3.0])})
    other = replace(loss(further=-1.0), shapes={DROP: np.array([3.0, 2.0, 1.0])})
    half = one.mixed(other, 0.5)
    assert half.shapes[DROP] == pytest.approx([2.0, 2.0, 2.0])
    assert half.further == 0.0
    assert half.bent == Bent()
    assert one.mixed(other, -0.9).further == FARTHEST
    assert other.mixed(one, -0.9).further == -FARTHEST


def test_what_is_expected_of_a_drop_is_its_means_and_deviations_together() -> None:
    assert loss(bridge=(2.0, 0.4)).expected == pytest.approx(math.hypot(2.4, math.hypot(0.3, 0.4)))
    assert loss().expected == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("asked", "before", "by", "step"),
    [
        (0.4, 0.4, 0.4, 0.4),  # nothing changed of what is asked for: nobody knows better
        (0.4, 0.8, 0.0, 0.4),  # nothing was done
        (0.4, -0.8, 0.8, 0.4),  # it went the other way
        (0.2, 0.6, 0.1, 0.2 * 0.25), (-5.0, 5.0, 5.0, -1.0), (5.0, 0.0, -5.0, 1.0),
    ],
)  # fmt: skip
def test_a_step_goes_as_far_as_the_last_one_brought(
    asked: float, before: float, by: float, step: float
) -> None:
    assert Bent(before, by).step(asked) == pytest.approx(step)


def test_without_a_current_a_loss_takes_nothing() -> None:
    found = loss(capacity_j_k=3.0).follow(Flow(np.zeros(3)), R, {}, np.zeros(3), np.zeros(3))
    for shape in found.shapes.values():
        assert shape == pytest.approx(0.0)
    # a charge of one stands for none: .00393 a kelvin, and R A²s over 3 J/K
    rise = 0.00393 * TOP / (TOP / R) * 1.0 / 3.0
    assert found.rise == pytest.approx((rise, 0.2 * rise))
    heavy = loss(capacity_j_k=1e9).follow(Flow(np.zeros(3)), R, {}, np.zeros(3), np.zeros(3))
    assert heavy.rise[1] == 1e-6  # no warming is known better


def test_a_drop_is_declared_with_or_without_its_doubt() -> None:
    assert expected_drop(Wiring(brush_drop_v=0.0, brush_drop_uncertainty_v=0.2), TOP) == (0.0, 0.2)
    assert expected_drop(Wiring(brush_drop_v=0.5), TOP) == pytest.approx((0.5, 0.15))


def test_a_lossless_motor_keeps_what_else_is_stated() -> None:
    capture = Capture(np.arange(4), 1e3, {})
    capture = replace(capture, stated=replace(capture.stated, thermal={"housing_s": 7.0}))
    one = lossless(capture)
    assert one.stated.thermal["housing_s"] == 7.0
    heavy = winding_temperature.by_figures(one.stated.thermal)
    assert heavy is not None
    assert heavy.capacity_j_k >= 1e9


def of(
    capture: Capture, parts: tuple[Part, ...], driven: np.ndarray, commanded: bool = True
) -> Loss | None:
    n = len(driven)
    line = Timeline(1e-3, n, np.arange(n), parts, 0.0)
    return Loss.of(capture, line, driven, np.where(driven, -TOP, 50.0), commanded)


def test_dead_time_is_of_parts_with_a_level_where_the_source_is_commanded() -> None:
    n = 60
    parts = (
        Part(0, 20, StepKind.COAST),
        Part(20, 40, StepKind.DRIVE_DUTY, -0.5, Decay.SYNCHRONOUS_SLOW),
        Part(40, n, StepKind.DRIVE_DUTY, 0.0, Decay.SYNCHRONOUS_SLOW),
    )
    driven = np.arange(n) >= 20
    channels = {CURRENT: Channel(CURRENT, "A", np.ones(n))}
    dead = Capture(np.arange(n) * 1000, 1e6, channels, wiring=Wiring(dead_time_s=1e-6))
    found = of(dead, parts, driven)
    assert found is not None
    assert list(found.turns) == [1]
    assert found.top_v == TOP
    instant = of(replace(dead, wiring=Wiring()), parts, driven)
    assert instant is not None
    assert not instant.turns
    measured = of(dead, parts, driven, commanded=False)
    assert measured is not None
    assert not measured.turns
    logged = (*parts[:2], replace(parts[2], kind=None))  # one part whose command nobody knows
    assert of(dead, logged, driven) is None


# actions


def test_a_second_order_is_of_its_own_block_and_of_some_size() -> None:
    run = Setup(4, [0.0] * 3)
    act = action.SecondOrderLowPass("speed")
    act(run, None, 0, 0.0)
    assert run.second_s == {}
    act(run, None, 0, 0.5)
    act(run, None, 0, 0.25)
    assert run.second_s == {"speed": 0.75}
    for log_act, name in (
        (action.LogFilter(), "log_filter_s"),
        (action.LogSecondOrder(), "log_second_s"),
    ):
        log_act(run, None, 0, 0.5)
        log_act(run, None, 0, 0.125)
        assert getattr(run, name) == 0.625
    assert not run.rebuilt


def test_volts_of_a_source_are_of_its_shape_or_of_a_part() -> None:
    run = Setup(4, [0.0] * 3)
    asked: list[Any] = []
    act = action.SourceVoltage(lambda *of: asked.append(of) or np.array([1.0, 2.0, 3.0, 4.0]))
    act(run, "subject", 7, 0.0)
    assert (asked, run.volts) == ([], 0.0)
    act(run, "subject", 7, 0.5)
    assert asked == [("subject", 7)]
    parts = SimpleNamespace(
        timeline=SimpleNamespace(parts=(None, SimpleNamespace(slice=slice(1, 3))))
    )
    action.PartVoltage()(run, parts, 1, 10.0)
    assert np.asarray(run.volts).tolist() == [0.5, 11.0, 11.5, 2.0]
    action.PartVoltage()(run, None, 9, 0.0)
    action.SourceVoltage(lambda *of: np.ones(4), taken=True)(run, "subject", 7, 0.5)
    assert np.asarray(run.volts).tolist() == [0.0, 10.5, 11.0, 1.5]
    lost = action.PartLoss(lambda subject, place: np.array([1.0, 2.0, 3.0, 4.0]) * place)
    lost(run, parts, 1, 0.25)
    assert np.asarray(run.volts).tolist() == [0.0, 10.0, 10.25, 1.5]
    lost(run, None, 9, 0.0)


def test_what_a_channel_shows_more_is_by_its_size_and_share() -> None:
    series = np.array([1.0, 2.0])
    shown = {"a": series, "b": series}
    action.Reading("a", action.plus, lambda subject: subject).show(
        shown, np.array([0.0, 1.0]), None, 3.0
    )
    assert shown["a"].tolist() == [1.0, 5.0]
    one: Any = SimpleNamespace(place=4)
    action.Added("b", lambda subject, place, y: place * y).show(shown, None, one, 0.5)
    assert shown["b"].tolist() == [3.0, 6.0]
    known: Any = SimpleNamespace(repeating=SimpleNamespace(slopes={one.place: {"b": series}}))
    action.AlongAngle().show(shown, known, 4, 2.0)
    assert shown["b"].tolist() == [5.0, 10.0]
    action.AlongAngle().show(shown, known, 5, 2.0)
    action.Reading("c", action.plus).show(shown, None, None, 1.0)
    action.Added("c", lambda *_: series).show(shown, None, one, 1.0)
    assert set(shown) == {"a", "b"}
    assert shown["b"].tolist() == [5.0, 10.0]


def test_all_that_a_log_shows_comes_later_or_smoother_together() -> None:
    run = Setup(4, [0.0] * 3, late_s={"a": 1.0}, filter_s={"b": 2.0})
    run.all_later(0.5, ["a", "b"])
    run.all_smoother(0.25, ["a", "b"])
    assert (run.log_late_s, run.late_s) == (-0.5, {"a": 1.5, "b": 0.5})
    assert (run.log_filter_s, run.filter_s) == (0.25, {"b": 2.25, "a": 0.25})


@pytest.mark.parametrize(
    "facts", [{"source_gain": 1.01}, {"clock": 0.99}, {"stretched": [(None, 1.0)]}]
)
def test_each_of_three_changes_asks_for_another_response(facts: dict[str, Any]) -> None:
    assert Setup(4, [], **facts).rebuilt
    assert not Setup(4, [], late_s={"a": 1.0}).rebuilt


# noise of a source


def noise(parts: list[Part], volts: np.ndarray, **facts: Any) -> SourceNoise:
    line = Timeline(1e-4, len(volts), np.arange(len(volts)), tuple(parts), 0.0)
    sensed: Any = SimpleNamespace(
        **{"volts": volts, "shows_emf": True, "commanded": False, "level_uncertainty": 0.0, **facts}
    )
    return SourceNoise(Capture(np.arange(len(volts)) * 100, 1e6, {}), line, sensed)


def alternating(n: int, level: float, size: float) -> np.ndarray:
    """Readings whose neighbours differ by twice a size: a scatter of √2 times that."""
    return level + size * (-1.0) ** np.arange(n)


@pytest.mark.parametrize(("samples", "known"), [(FEWEST, True), (FEWEST - 1, False)])
def test_a_part_needs_some_samples_past_its_command(samples: int, known: bool) -> None:
    n = HEAD + samples
    driven, coast = Part(0, n, StepKind.DRIVE_DUTY, 0.5), Part(n, n + HEAD + 60, StepKind.COAST)
    volts = np.r_[alternating(n, 6.0, 0.05), np.zeros(HEAD + 60)]
    found = noise([driven, coast], volts)
    assert found.levels == ((0,) if known else ())
    assert found.coasts == ((1,) if known else ())
    short = noise([driven, replace(coast, stop=n + HEAD + FEWEST - 1)], volts)
    assert short.coasts == ()
    logged = noise([replace(driven, kind=None), coast], volts)
    assert logged.levels == ()
    if known:
        scatter = 0.05 * np.sqrt(2.0)
        assert found.level_deviation(0, None) == pytest.approx(scatter / np.sqrt(samples))


def test_readings_that_stay_or_stand_alone_do_not_scatter() -> None:
    for values in ([], [3.0], [3.0, 3.0, 3.0]):
        assert source_noise._scatter(np.array(values)) == 0.0
    assert source_noise._scatter(np.array([1.0, 3.0, 1.0])) == pytest.approx(np.sqrt(2.0))


def test_a_level_is_known_no_better_than_to_a_billionth_of_it() -> None:
    n = HEAD + 100
    quiet: Any = SimpleNamespace(noise=0.0)
    for volts, least in ((6.0, 6e-9), (-6.0, 6e-9), (0.0, 1e-9)):
        one = noise([Part(0, n, StepKind.DRIVE_DUTY, 0.5)], np.full(n, volts))
        assert one.level_deviation(0, quiet) == pytest.approx(least)


def test_a_quick_motor_averages_no_jitter_beyond_a_sample() -> None:
    """A lag shorter than a sample counts as one: the source jumps once in it."""
    n = HEAD + 100
    parts = [Part(0, n, StepKind.DRIVE_DUTY, 0.5), Part(n, 2 * n, StepKind.COAST)]
    one = noise(parts, np.r_[alternating(n, 6.0, 0.05), np.zeros(n)], shows_emf=False)
    source: Any = SimpleNamespace(noise=0.2)
    motor = [2.0, 1e-3, 0.05, 4e-5, 1e-12]
    assert one.speed_deviation(1, source, motor) == pytest.approx(0.2 / 0.05 * np.sqrt(0.5))
    slow = [2.0, 1e-3, 0.05, 4e-5, 2e-5]
    tau = 2e-5 * 2.0 / (0.05**2 + 2.0 * 4e-5)
    wanted = 0.2 / 0.05 * np.sqrt(1e-4 / (2.0 * tau))
    assert one.speed_deviation(1, source, slow) == pytest.approx(wanted)


# warmth


def run(at_s: float | None = 0.0, amperes: float = 3.0, volts: Any = 10.0, n: int = 5) -> Capture:
    """A second a sample, of a constant current."""
    began = datetime(2026, 1, 1, tzinfo=UTC)
    channels = {CURRENT: Channel(CURRENT, "A", np.full(n, amperes))}
    if volts is not None:
        channels[VOLTAGE] = Channel(VOLTAGE, "V", np.full(n, float(volts)))
    created = {} if at_s is None else {"created": (began + timedelta(seconds=at_s)).isoformat()}
    return Capture(np.arange(n), 1.0, channels, provenance=created)


STATED = {"winding_k_w": 8.0, "winding_s": 4.0}  # .5 J/K


def by_hand(*pauses: float) -> float:
    """K in the mean over the heat, of runs of four blocks of 18 J after such pauses."""
    above, warm, heat = 0.0, 0.0, 0.0
    decay = math.exp(-1.0 / 4.0)
    for pause in pauses:
        above *= math.exp(-pause / 4.0)
        for _ in range(4):
            after = above * decay + 18.0 / 0.5 * (1.0 + decay) / 2.0
            warm, heat, above = warm + 18.0 * (above + after) / 2.0, heat + 18.0, after
    return warm / heat


def test_the_first_run_begins_cold_and_later_ones_as_the_pause_leaves_them() -> None:
    """Seconds between the end of one and the beginning of the next."""
    alone = self_heating([run(1e6)], 2.0, STATED)
    assert alone is not None
    assert alone.kelvin == pytest.approx(by_hand(0.0))
    assert alone.heat_j == pytest.approx(4 * 18.0)
    both = self_heating([run(0.0), run(10.0)], 2.0, STATED)
    assert both is not None
    assert both.kelvin == pytest.approx(by_hand(0.0, 6.0))
    undated = self_heating([run(None), run(None)], 2.0, STATED)
    assert undated is not None
    assert undated.kelvin == pytest.approx(by_hand(0.0, 0.0))


def test_no_current_brings_no_heat_and_a_single_reading_tells_nothing() -> None:
    cold = self_heating([run(amperes=0.0)], 2.0, STATED)
    assert cold is not None
    assert (cold.kelvin, cold.uncertainty_k, cold.heat_j) == (0.0, 0.0, 0.0)
    assert self_heating([run(n=1)], 2.0, STATED) is None
    two = self_heating([run(n=2)], 2.0, STATED)
    assert two is not None
    assert two.heat_j == pytest.approx(18.0)


def test_the_highest_voltage_bounds_what_nobody_stated() -> None:
    """Measured, of the supply, or commanded; whichever run had it."""
    supply = replace(run(volts=None), channels={
        **run(volts=None).channels, SUPPLY: Channel(SUPPLY, "V", np.full(5, 12.0)),
    })  # fmt: skip
    step = Step(StepKind.DRIVE_VOLTS, 1.0, -8.0, Decay.SYNCHRONOUS_SLOW)
    small = Step(StepKind.DRIVE_VOLTS, 1.0, 3.0, Decay.SYNCHRONOUS_SLOW)
    commanded = replace(run(volts=None), program=Program((small, step)))
    highest = winding_temperature._highest
    assert (highest(run()), highest(supply), highest(commanded)) == (10.0, 12.0, 8.0)
    assert highest(run(volts=None)) == 0.0
    assert highest(run(volts=np.nan)) == 0.0
    assert highest(run(volts=-7.0)) == 7.0
    body = winding_temperature._lightest(2.0, 12.0)
    assert body is not None
    assert body.capacity_j_k == pytest.approx(12.0**2 / 2.0 / 150.0)
    assert winding_temperature._lightest(2.0, 0.0) is None
    both = self_heating([run(), supply], 2.0, {})
    alone = self_heating([supply, supply], 2.0, {})
    assert both is not None
    assert alone is not None
    assert both.kelvin == pytest.approx(alone.kelvin)


def test_a_long_run_is_taken_in_four_hundred_blocks() -> None:
    energy, seconds = winding_temperature._blocks(run(n=1201), np.full(1201, 3.0), 2.0)
    assert len(energy) == len(seconds) == 400
    assert sum(seconds) == pytest.approx(1200.0)
    assert energy == pytest.approx([18.0 * s for s in seconds])
    few, _ = winding_temperature._blocks(run(n=3), np.array([9.0, 1.0, 2.0]), 2.0)
    assert few == pytest.approx([2.0, 8.0])  # what flows until a reading


def test_a_model_without_a_capacity_shows_no_winding() -> None:
    def better(capacity: float | None, total: float | None = 0.1) -> Any:
        parameters = {
            "C_w": SimpleNamespace(value=capacity, total=total),
            "k_w": SimpleNamespace(value=0.5, total=0.1),
        }
        return SimpleNamespace(parameters=parameters)

    assert winding_temperature.shown_by(better(None)) is None
    assert winding_temperature.shown_by(better(0.0)) is None
    unsure = winding_temperature.shown_by(better(2.0, None))
    assert unsure is not None
    assert unsure.doubt == pytest.approx(0.2)


def test_stated_figures_of_a_rig_come_before_those_of_the_plate() -> None:
    one = run()
    stated = replace(
        one.stated, nameplate={"voltage_v": 9.0, "winding_s": 1.0}, thermal={"winding_s": 5.0}
    )
    found = winding_temperature.figures(replace(one, stated=stated))
    assert found == {"voltage_v": 9.0, "winding_s": 5.0}
