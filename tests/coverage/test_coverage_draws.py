"""The coverage study's rigs: repeatable, like real motors, true to what they state."""

from __future__ import annotations

import math

import numpy as np
import pytest

from bench.coverage.motors import LEAST_W, MOST_W, draw_motor
from bench.coverage.rigs import draw_bench
from motorid.sim.chain import draw_chain
from motorid.sim.motor import Motor, motors

COUNT = 400


def test_a_seed_is_a_rig() -> None:
    first, again, other = draw_bench(5), draw_bench(5), draw_bench(6)
    assert first == again
    assert first.rigs[0].text == again.rigs[0].text
    assert first.options != other.options


def test_an_effect_taken_out_leaves_the_rest() -> None:
    whole, without = draw_bench(5), draw_bench(5, ("brush", "dead time"))
    assert whole.options.brush_drop > 0
    assert without.options.brush_drop == without.options.dead_time == 0
    assert without.options.cogging == whole.options.cogging
    assert without.rigs == whole.rigs


@pytest.mark.slow
def test_what_is_stated_is_off_by_its_stated_uncertainty() -> None:
    off: dict[str, list[float]] = {name: [] for name in ("bridge", "lead", "ambient", "gain")}
    for seed in range(COUNT):
        bench = draw_bench(seed)
        said, options = bench.stated, bench.options
        assert options.bridge_resistance is not None
        off["bridge"].append((options.bridge_resistance - said.bridge_ohm) / said.bridge_u)
        off["lead"].append((options.lead_resistance - said.lead_ohm) / said.lead_u)
        off["ambient"].append((options.ambient - said.ambient_c) / said.ambient_u)
        current = draw_chain(options).current
        off["gain"].append((current.gain - 1) / current.gain_uncertainty)
        wiring = bench.rigs[0].wiring
        assert wiring.bridge_resistance_ohm == said.bridge_ohm
        assert wiring.bridge_resistance_uncertainty_ohm == said.bridge_u
    for name, values in off.items():
        # 4 standard errors of a mean and of a standard deviation
        assert abs(np.mean(values)) < 4 / math.sqrt(COUNT), name
        assert abs(np.std(values) - 1) < 4 / math.sqrt(2 * COUNT), name


@pytest.mark.slow
def test_motors_span_three_decades_and_hold_the_catalogue() -> None:
    rng = np.random.default_rng(1)
    drawn = [draw_motor(rng) for _ in range(2000)]
    power = np.array([d.power_w for d in drawn])
    assert power.min() < 1.05 * LEAST_W
    assert power.max() > 0.95 * MOST_W
    figures = {
        "stall power": [d.motor.voltage_v**2 / d.motor.resistance_ohm for d in drawn],
        "speed": [d.motor.voltage_v / d.motor.torque_constant_nm_a for d in drawn],
        "tau": [_tau(d.motor) for d in drawn],
        "electrical tau": [d.motor.inductance_h / d.motor.resistance_ohm for d in drawn],
    }
    for real in motors().values():
        true = {
            "stall power": real.voltage_v**2 / real.resistance_ohm,
            "speed": real.voltage_v / real.torque_constant_nm_a,
            "tau": _tau(real),
            "electrical tau": real.inductance_h / real.resistance_ohm,
        }
        for name, values in figures.items():
            low, high = np.quantile(values, [0.005, 0.995])
            assert low < true[name] < high, (real.title, name)


def _tau(motor: Motor) -> float:
    return motor.resistance_ohm * motor.inertia_kg_m2 / motor.torque_constant_nm_a**2


@pytest.mark.parametrize("seed", range(20))
def test_every_drawn_rig_is_one_that_the_tool_reads(seed: int) -> None:
    bench = draw_bench(seed)
    assert len(bench.rigs) == 3
    rate, pwm = bench.rigs[0].sampling.rate_hz, bench.options.pwm
    assert pwm % rate == 0
    window = bench.options.aperture + bench.options.delay
    assert window < 2 / rate
