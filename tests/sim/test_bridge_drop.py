"""A bipolar bridge's drop: what its switches take from the motor, and what a fit is told of it."""

from __future__ import annotations

import math

import pytest

from motorid.capture.model import Wiring
from motorid.estimate.effects.brush_and_heating import (
    DECLARED,
    DROP_SHARE,
    bridge_drop,
    expected_drop,
)
from motorid.sim.bench import BRIDGE_BEND_A, Bench
from motorid.sim.chain import draw_chain
from motorid.sim.options import parse_url
from motorid.wire.enums import Decay, StepKind

DROP_V, OHM, SUPPLY_V = 1.4, 1.15, 12.0  # of an L298, by its data sheet's typical figures


@pytest.mark.parametrize("duty", [1.0, -1.0, 0.08])
def test_the_switches_drop_what_an_l298s_do(duty: float) -> None:
    url = f"sim://?motor=maxon-amax22&bridge_drop={DROP_V}&bridge_resistance={OHM}&heating=no&ambient=25"
    options = parse_url(f"{url}&supply={SUPPLY_V}&supply_resistance=0&supply_capacitance=0")
    bench = Bench(options, draw_chain(options))
    bench.stall()
    bench.command(StepKind.DRIVE_DUTY, duty, Decay.SYNCHRONOUS_SLOW)
    bench.run(400)
    before = bench.integrals()
    bench.run(400)
    seconds, amperes, volts, _ = (b - a for a, b in zip(before, bench.integrals(), strict=True))
    current, terminal = amperes / seconds, volts / seconds
    assert terminal == pytest.approx(options.specimen.resistance_ohm * current, rel=1e-3)
    if abs(duty) == 1.0:
        lost = DROP_V * current / math.hypot(current, BRIDGE_BEND_A) + OHM * current
        assert duty * SUPPLY_V - terminal == pytest.approx(lost, rel=1e-4)
        assert 1.0 < abs(current) < 2.0
    else:  # the mean voltage lies below the drop: next to nothing flows
        assert abs(current) < 0.05


def test_a_fit_expects_it_where_the_voltage_is_the_sources() -> None:
    wiring = Wiring(brush_drop_v=0.5, brush_drop_uncertainty_v=0.1, bridge_drop_v=1.4)
    assert expected_drop(wiring, 12.0) == (0.5, 0.1)
    assert bridge_drop(wiring) == pytest.approx((1.4, DECLARED * 1.4))
    stated = Wiring(bridge_drop_v=1.4, bridge_drop_uncertainty_v=0.2)
    assert bridge_drop(stated) == (1.4, 0.2)
    assert expected_drop(stated, 12.0) == pytest.approx((0.0, DROP_SHARE * 12.0))
