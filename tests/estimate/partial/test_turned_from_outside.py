"""A log of a motor that something else turns: open, into loads, and what is none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid import identify
from motorid.capture.model import CURRENT, FACTS, POSITION, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.partial import turned_from_outside as module
from motorid.estimate.partial.turned_from_outside import suits

R, L, K = 1.5, 1e-3, 0.05
COUNT, PERIOD_S, FINE = 3000, 1e-3, 10
UNITS = {VOLTAGE: "V", CURRENT: "A", SPEED: "rad/s", POSITION: "rad"}
NOISE = {VOLTAGE: 0.02, CURRENT: 0.01, SPEED: 0.3, POSITION: 1e-3}


def turned(*loads: float, motion: str = SPEED, seed: int = 1) -> Capture:
    """By a hand, up and down three times; ``loads`` (ohm) one after the other, none: open."""
    time = np.arange(COUNT * FINE) * PERIOD_S / FINE
    speed = 100.0 - 80.0 * np.cos(2.0 * np.pi * time)
    current, i = np.zeros(len(time)), 0.0
    ohms = np.zeros(len(time))
    if loads:
        later = np.minimum(np.arange(len(time)) + FINE // 2, len(time) - 1)  # between two readings
        ohms = np.array(loads)[later * len(loads) // len(time)]
    for k in range(len(time) if loads else 0):
        current[k] = i
        settled, rate = -K * speed[k] / (R + ohms[k]), (R + ohms[k]) / L
        i = settled + (i - settled) * np.exp(-rate * PERIOD_S / FINE)
    volts = -ohms * current if loads else K * speed
    angle = 100.0 * time - 80.0 * np.sin(2.0 * np.pi * time) / (2.0 * np.pi)
    shown = {VOLTAGE: volts, CURRENT: current, motion: speed if motion == SPEED else angle}
    rng = np.random.default_rng(seed)
    channels = {
        n: Channel(n, UNITS[n], y[::FINE] + NOISE[n] * rng.standard_normal(COUNT),
                   undeclared=FACTS)
        for n, y in shown.items()
    }  # fmt: skip
    return Capture(np.arange(COUNT), 1.0 / PERIOD_S, channels)


@pytest.mark.parametrize("motion", [SPEED, POSITION])
def test_an_open_motor_tells_k_alone(motion: str) -> None:
    found = identify.fit([turned(motion=motion)])
    p = found.parameters["K"]
    assert p.value == pytest.approx(K, abs=3.0 * (p.total or 0.0))
    assert (p.total or 1.0) < 1e-3 * K
    assert [n for n, q in found.parameters.items() if q.value is not None] == ["K"]
    (said,) = [d for d in found.diagnostics if d.code == "turned_from_outside"]
    assert "determines only K" in said.message
    assert found.not_stated["voltage gain"] == {"K": pytest.approx(-0.01 * K, rel=0.01)}


@pytest.mark.parametrize("motion", [SPEED, POSITION])
def test_k_is_the_motors_where_a_gear_turns_the_sensor(motion: str) -> None:
    log = turned(motion=motion)
    slower = replace(log.channels[motion], scale=0.2)
    geared = replace(
        log, channels={**log.channels, motion: slower}, wiring=replace(log.wiring, gear_ratio=5.0)
    )
    found, plain = identify.fit([geared]), identify.fit([log])
    assert found.parameters["K"].value == pytest.approx(plain.parameters["K"].value)


def test_a_generator_under_two_loads_tells_k_r_and_l() -> None:
    found = identify.fit([turned(3.0, 12.0, 3.0, 12.0, 3.0, 12.0)])
    for name, true in (("K", K), ("R", R), ("L", L)):
        p = found.parameters[name]
        if name != "L" or p.value is not None:  # half a sample of a lag may be more
            assert p.value == pytest.approx(true, abs=4.0 * (p.total or 0.0))
    assert (found.parameters["R"].total or 1.0) < 0.02 * R
    assert found.parameters["J"].value is None
    assert set(found.budget["K"]) == {"noise"}


def test_under_one_load_k_and_r_are_one() -> None:
    found = identify.fit([turned(3.0)])
    assert all(p.value is None for p in found.parameters.values())
    assert "change the load" in found.diagnostics[0].message
    fixed = identify.fit([turned(3.0)], fix={"R": R})
    assert fixed.parameters["R"].value == R


def test_a_motor_that_drives_itself_or_lacks_a_channel_is_none() -> None:
    generator = turned(3.0, 12.0, 3.0, 12.0)
    current = generator.channels[CURRENT]
    driven = replace(current, raw=-current.raw)
    for other in (
        replace(generator, channels={**generator.channels, CURRENT: driven}),  # takes the energy
        replace(generator, channels={n: c for n, c in generator.channels.items() if n != SPEED}),
        generator.rows(slice(0, 40), ()),
        generator.rows(slice(500, 950), ()),  # it slows down all the time
        turned().rows(slice(500, 950), ()),  # and coasts
    ):
        assert not suits([other])
    assert suits([generator])
    assert not suits([])


def test_a_bump_measures_what_its_window_holds() -> None:
    """Of a steady state: nothing rises, and each integral is its channel's."""
    flat = {VOLTAGE: 6.0, CURRENT: 2.0, SPEED: 60.0}
    channels = {n: Channel(n, UNITS[n], np.full(400, y)) for n, y in flat.items()}
    ((first, *_),) = module._rows(Capture(np.arange(400), 1e3, channels), 8)
    assert first / first[-1] == pytest.approx([6.0, 60.0, 2.0, 0.0, 1.0], abs=1e-12)
