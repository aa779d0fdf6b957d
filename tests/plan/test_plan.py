"""Plans for the simulated rigs: within every limit, short, and kept by the simulator."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bench.bench_plan import confirm
from motorid.acquire.record import capture
from motorid.errors import RigError, UsageError
from motorid.estimate.uncertainty.intervals import NORMAL_95
from motorid.motor.parameters import Motor, mechanical_time_constant, no_load_speed
from motorid.plan.motors import CORNERS, Spread, middle, motors, of_nameplate
from motorid.plan.wants import USUAL, wanted
from motorid.program import StepKind
from motorid.quality.product import load_product
from motorid.report import plan as report
from motorid.rig import Nameplate, Rig, load_rig
from motorid.sim import truth
from motorid.workflow.plan import plan_run


def rig_of(name: str = "sim", options: str = "") -> Rig:
    rig = load_rig(name)
    return replace(rig, port=f"{rig.port}&speed=max{options}")


def weakest_motors(spread: Spread) -> tuple[Motor, ...]:
    """The middle, and of the corners those in which R and K are least."""
    least = spread["R"][0], spread["K"][0]
    return tuple(m for m in motors(spread) if m == middle(spread) or least == (m.R, m.K))


@pytest.mark.slow
@pytest.mark.usefixtures("one_motor", "best_shape")
def test_the_simulated_rig_keeps_the_promise(tmp_path: Path) -> None:
    """Eight specimens: the median of what fits state, and the RMS error of what they find.

    Of the nameplate's motor; ``bench/bench_plan.py`` has the promise for the worst of its kind.
    """
    usual = plan_run(rig_of(), ())
    assert usual.seconds < 0.2  # the packaged rig's own program takes 2.1 s
    assert all(p.met for p in usual.promises)
    rows = confirm(rig_of(), usual, 8, tmp_path)
    assert [row.name for row in rows] == [p.want.name for p in usual.promises]
    assert [row for row in rows if not row.kept] == []


@pytest.mark.study
@pytest.mark.usefixtures("one_motor")
def test_a_tighter_want_takes_longer() -> None:
    tight = plan_run(rig_of(), ("B=10%",))
    loose = plan_run(rig_of(), ("B=30%",))
    assert loose.seconds < tight.seconds
    assert all(p.met for p in (*tight.promises, *loose.promises))


@pytest.mark.slow
@pytest.mark.usefixtures("one_shape")
def test_currents_and_speeds_keep_within_the_limits_of_the_worst_motor(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """By the equations of a motor from rest, not by the code that refuses programs. Of the corners
    those are tried in which R and K are least: no other current or speed is higher.
    """
    monkeypatch.setattr("motorid.plan.motors.motors", weakest_motors)
    rig, wants = rig_of(), ("R=2%", "K=2%")
    free = plan_run(rig, wants)
    rig = replace(rig, limits=replace(rig.limits, current_a=1.0))
    plan = plan_run(rig, wants)
    assert len(plan.predictions) == 3
    volts = max(abs(step.level) for step in plan.program.steps)
    weakest = min(p.motor.R for p in plan.predictions)
    assert volts / weakest < 1.0
    assert max(no_load_speed(p.motor, volts) for p in plan.predictions) < rig.limits.speed_rad_s
    assert volts < max(abs(step.level) for step in free.program.steps)


@pytest.mark.slow
@pytest.mark.usefixtures("one_motor", "one_shape")
def test_a_board_with_few_steps_gets_few(tmp_path: Path) -> None:
    rig = rig_of(options="&max_steps=3")
    plan = plan_run(rig, ("R=0.5%", "L=1%"))
    assert len(plan.program.steps) <= 3
    capture(rig, plan.program, tmp_path / "run.h5")


@pytest.mark.slow
@pytest.mark.usefixtures("one_motor", "one_shape")
def test_a_slow_link_gets_a_rate_that_it_carries(tmp_path: Path) -> None:
    """115,200 baud is 11,520 bytes a second: six for three channels, and the frames."""
    rig = rig_of(options="&baud=115200")
    plan = plan_run(rig, ("R=1%",))
    assert 1000 < plan.bench.clock_hz / plan.bench.period_ticks < 11_520 / 6
    assert rig.sampling.rate_hz == 10_000


@pytest.mark.slow
@pytest.mark.usefixtures("one_motor", "one_shape")
def test_what_instruments_forbid_is_said_with_the_cause() -> None:
    plan = plan_run(rig_of(options="&gain_uncertainty=0.02"), ("R=1%", "K=1%"))
    kept = {p.want.name: p for p in plan.promises}
    assert kept["R"].instrument_limited
    assert kept["K"].met
    assert kept["R"].reach > NORMAL_95 * 0.02
    text = report.render(plan, ("current",), 9)
    assert "R to 1.0 % cannot be met however long the run" in text
    assert "current gain" in text


@pytest.mark.slow
@pytest.mark.usefixtures("one_shape")
def test_a_first_run_narrows_the_spread(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    spreads: list[Spread] = []

    def watched(spread: Spread) -> tuple[Motor, ...]:
        spreads.append(spread)
        return (middle(spread),)

    monkeypatch.setattr("motorid.plan.motors.motors", watched)
    rig = rig_of(options="&seed=3")
    first = capture(rig, rig.program, tmp_path / "first.h5")
    plan = plan_run(rig, ("R=1%", "J=2%"), first=first)
    true = truth(rig.port)
    for name in ("R", "K", "J"):
        low, high = spreads[-1][name]
        assert low <= getattr(plan.predictions[0].motor, name) <= high
        assert high / low < 1.1
        assert 0.98 * true[name] < high
        assert low < 1.02 * true[name]


@pytest.mark.slow
@pytest.mark.usefixtures("one_shape")
def test_a_product_gets_steady_turns_in_both_directions() -> None:
    rig, product = rig_of("sim-line"), load_product("sim-disc")
    plan = plan_run(rig, (), product=product)
    for way in (1, -1):
        assert any(
            all(
                step.duration_s > 3 * mechanical_time_constant(p.motor)
                and abs(step.level) / p.motor.K * step.duration_s > 6 * 2 * np.pi
                for p in plan.predictions
            )
            for step in plan.program.steps
            if step.kind is StepKind.DRIVE_VOLTS and step.level * way > 0
        )
    assert all(p.met for p in plan.promises)
    # what the packaged product runs came from such a plan
    assert plan.program.duration_s == pytest.approx(product.program.duration_s, rel=0.15)


def test_corners_are_orthogonal_and_cover_the_label() -> None:
    np.testing.assert_array_equal(CORNERS @ CORNERS.T, 8 * np.eye(6))
    spread = of_nameplate(load_rig("sim").nameplate)
    found = motors(spread)
    assert len(found) == 9
    assert {m.R for m in found[1:]} == set(spread["R"])
    assert found[0] == middle(spread)


def test_a_label_that_says_too_little_is_said() -> None:
    with pytest.raises(RigError, match="lacks torque_constant_nm_a and inertia_kg_m2"):
        of_nameplate(Nameplate(resistance_ohm=1.0, voltage_v=12.0))


@pytest.mark.parametrize(
    ("channels", "words"),
    [
        (("terminal_voltage", "position"), "tells R, L, B, J, T0 .* the current measured"),
        (("current", "terminal_voltage"), "the speed or the position measured"),
    ],
)
def test_channels_that_hide_a_parameter_are_refused_at_once(
    channels: tuple[str, ...], words: str
) -> None:
    rig = rig_of()
    rig = replace(rig, sampling=replace(rig.sampling, channels=channels))
    with pytest.raises(RigError, match=words):
        plan_run(rig, ())


def test_no_program_within_impossible_limits() -> None:
    rig = rig_of()
    rig = replace(rig, limits=replace(rig.limits, run_time_s=0.01))
    with pytest.raises(RigError, match="no program within the rig's limits"):
        plan_run(rig, ())


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("X=1%", "NAME one of R, L, K"),
        ("R", "NAME=NUMBER"),
        ("R=0%", "between 0 and 100 %"),
        ("J=1e-3", "between 0 and 3.9e-07 kg·m²"),
        ("R=1e%", "no number"),
    ],
)
def test_wants_that_are_none(text: str, words: str) -> None:
    with pytest.raises(UsageError, match=words):
        wanted((text,), middle(of_nameplate(load_rig("sim").nameplate)))


def test_wants_in_percent_and_in_units_are_the_same() -> None:
    expected = middle(of_nameplate(load_rig("sim").nameplate))
    percent = wanted(USUAL, expected)
    units = {n: getattr(expected, n) for n in ("R", "T0")}
    by_value = wanted((f"R={0.01 * units['R']!r}", f"T0={0.1 * units['T0']!r}"), expected)
    assert by_value[0].reach == pytest.approx(percent[0].reach)
    assert by_value[1].reach == pytest.approx(percent[5].reach)
