"""Gains that nobody stated: their moves are those of readings that really are 1 % too large."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, SPEED, TORQUE, VOLTAGE, Capture, Channel
from motorid.estimate.results.estimate import Estimate
from motorid.estimate.uncertainty.unstated_gains import PART
from motorid.report import html, json_, text
from tests.exact_capture import FAULHABER, Plan, clean_capture, noisy
from tests.six_parameters import fit

PLAN = Plan(volts=(6.0, 3.0, 1.5), count=1200)
TOO_MUCH = 1.0 + PART


def unstated(capture: Capture, names: Iterable[str]) -> Capture:
    changed = {n: replace(capture.channels[n], undeclared=("gain",)) for n in names}
    return replace(capture, channels={**capture.channels, **changed})


def reading_too_much(capture: Capture, name: str) -> Capture:
    channel = capture.channels[name]
    larger = replace(channel, scale=channel.scale * TOO_MUCH)
    return replace(capture, channels={**capture.channels, name: larger})


def values(estimate: Estimate) -> dict[str, float]:
    known = {**estimate.parameters, **estimate.combinations}
    return {name: p.value for name, p in known.items() if p.value is not None}


def check(capture: Capture, gains: dict[str, str], within: float) -> None:
    """What a fit says of each gain is what it finds where that channel reads too much."""
    found = fit([unstated(capture, gains.values())])
    assert set(found.not_stated) == set(gains)
    right = values(found)
    for gain, name in gains.items():
        wrong = values(fit([reading_too_much(capture, name)]))
        assert set(found.not_stated[gain]) <= set(right)
        for parameter in right.keys() & wrong.keys():
            move = found.not_stated[gain].get(parameter, 0.0)
            back = (wrong[parameter] - right[parameter]) / right[parameter]
            assert move / right[parameter] == pytest.approx(-back, abs=within), parameter


@pytest.fixture(scope="module")
def run() -> Capture:
    return noisy(clean_capture(FAULHABER, PLAN), 1, 1e-3, 1e-4, 1e-3)


@pytest.mark.slow
def test_the_moves_are_those_of_readings_that_are_too_large(run: Capture) -> None:
    gains = {"current gain": CURRENT, "encoder or speed gain": POSITION, "voltage gain": VOLTAGE}
    check(run, gains, 1e-3)


@pytest.mark.slow
def test_a_stated_gain_is_none_of_them(run: Capture) -> None:
    assert fit([run]).not_stated == {}
    exact = replace(run.channels[CURRENT], undeclared=("offset", "delay", "filter", "aperture"))
    assert fit([replace(run, channels={**run.channels, CURRENT: exact})]).not_stated == {}


@pytest.mark.slow
def test_a_balance_without_a_voltage_says_the_same() -> None:
    t = np.arange(0.0, 3.0, 2e-3)
    speed = 100.0 * np.sin(2 * np.pi * t) + 40.0 * np.sin(5 * np.pi * t)
    slope = 200.0 * np.pi * np.cos(2 * np.pi * t) + 200.0 * np.pi * np.cos(5 * np.pi * t)
    noise = 1e-5 * np.random.default_rng(0).standard_normal(len(t))
    torque = 1e-5 * slope + 2e-5 * speed + 1e-3 * np.sign(speed) + noise
    capture = of(t, {TORQUE: torque, SPEED: speed})
    check(capture, {"torque gain": TORQUE, "encoder or speed gain": SPEED}, 1e-3)
    drawn = of(t, {CURRENT: torque / 0.02, SPEED: speed})
    check(drawn, {"current gain": CURRENT, "encoder or speed gain": SPEED}, 1e-3)


@pytest.mark.slow
def test_a_coast_down_says_the_same() -> None:
    t = np.arange(0, 1.2, 1e-3)
    speed = np.maximum(300.0 * np.exp(-t / 0.4) - 60.0, 0.0)
    speed += 0.05 * np.random.default_rng(0).standard_normal(len(t))
    check(of(t, {SPEED: speed}), {"encoder or speed gain": SPEED}, 1e-3)
    volts = of(t, {VOLTAGE: 0.02 * speed})
    check(volts, {"voltage gain": VOLTAGE}, 1e-3)


def test_steady_points_say_the_same() -> None:
    volts, load = (x.ravel() for x in np.meshgrid([6.0, 12.0, 18.0], np.linspace(0, 0.2, 9)))
    current = (load + 5e-3) / 0.03
    noise = 0.02 * np.random.default_rng(0).standard_normal(27)
    table = of(
        np.arange(27.0),
        {VOLTAGE: volts + noise, CURRENT: current, SPEED: (volts - 1.2 * current) / 0.03},
    )
    table = replace(table, provenance={"static": True})
    gains = {"current gain": CURRENT, "encoder or speed gain": SPEED, "voltage gain": VOLTAGE}
    check(table, gains, 2e-3)


def of(t: np.ndarray, columns: dict[str, np.ndarray]) -> Capture:
    units = {TORQUE: "N·m", SPEED: "rad/s", CURRENT: "A", VOLTAGE: "V"}
    channels = {n: Channel(n, units[n], column) for n, column in columns.items()}
    return Capture((1e9 * t).astype(np.int64), 1e9, channels)


@pytest.mark.slow
def test_no_report_calls_an_unstated_gain_nothing(run: Capture) -> None:
    current = replace(run.channels[CURRENT], gain_uncertainty=0.005)
    half = replace(run, channels={**run.channels, CURRENT: current})
    found = fit([unstated(half, (VOLTAGE,))])
    lines = {line.split()[0]: line for line in text.render(found).splitlines() if line.strip()}
    assert "not stated" in lines["K"]
    assert "≥ 0.50 %" in lines["J"]
    assert "voltage gain: R −1.0 %" in text.render(found)
    page = html.render(found)
    assert "voltage gain: R −1.0 %" in page
    assert "not stated" in page
    document = json_.to_dict(found)
    assert document["not_stated"]["voltage gain"]["K"] == found.not_stated["voltage gain"]["K"]
    json.dumps(document)
    assert "not stated" not in text.render(fit([half]))
