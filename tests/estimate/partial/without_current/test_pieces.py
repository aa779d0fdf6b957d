"""How a log without a current is read: which suit, its rows, its means, and its coasts."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, HELD, POSITION, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.partial.mechanical_signals import COMMAND
from motorid.estimate.partial.without_current import coasts, likelihood
from motorid.estimate.partial.without_current.combinations import _grown
from motorid.estimate.results.estimate import Curve, Parameter
from motorid.estimate.results.status import Status
from tests.estimate.partial.without_current.staircase import Law, logged

LOG = logged(Law(), (4.0, 9.0), rows=20)


def changed(capture: Capture = LOG, **channels: Channel | None) -> Capture:
    """With other channels; None: without one."""
    kept = {n: c for n, c in capture.channels.items() if channels.get(n, c) is not None}
    return replace(capture, channels=kept | {n: c for n, c in channels.items() if c is not None})


@pytest.mark.parametrize(
    ("capture", "suits"),
    [
        (LOG, True),
        (changed(terminal_voltage=None, command=Channel(COMMAND, "1", np.ones(40))), True),
        (changed(current=Channel(CURRENT, "A", np.ones(40))), False),
        (changed(speed=None), False),
        (changed(speed=Channel(SPEED, "m/s", np.arange(40.0))), False),
        (changed(speed=Channel(SPEED, "rad/s", np.zeros(40))), False),
        (changed(terminal_voltage=replace(LOG.channels[VOLTAGE], unsigned=True)), False),
    ],
)
def test_which_logs_are_fitted_by_it(capture: Capture, suits: bool) -> None:
    assert likelihood.suits([capture]) is suits


def test_a_long_log_or_a_model_without_viscous_friction_is_left_to_the_balance() -> None:
    assert not likelihood.suits([LOG] * (likelihood.MOST // len(LOG) + 1))
    assert likelihood.suits([LOG], ["T0"])
    assert not likelihood.suits([LOG], ["B"])


def test_a_speed_of_which_nobody_stated_the_window_may_be_a_mean() -> None:
    (capture,) = likelihood._as_means([LOG]) or []
    speed = capture.channels[SPEED]
    assert speed.kind == "mean"
    assert speed.aperture_s == pytest.approx(0.01)
    stated = replace(LOG.channels[SPEED], undeclared=())
    assert likelihood._as_means([changed(speed=stated)]) is None


def test_a_command_is_taken_as_volts_and_repeated_readings_once() -> None:
    command = changed(terminal_voltage=None, command=Channel(COMMAND, "1", np.ones(40)))
    (capture,) = likelihood._as_read([command])
    assert (capture.channels[VOLTAGE].unit, capture.channels[VOLTAGE].sense) == ("V", "terminals")
    held = np.repeat(LOG.channels[SPEED].raw[:20], 2)
    twice = changed(speed=replace(LOG.channels[SPEED], raw=held))
    (capture,) = likelihood._as_read([replace(twice, provenance={HELD: {SPEED: 2}})])
    assert len(capture) == 20


def test_a_search_without_a_balance_begins_near_a_motor_that_turns_so() -> None:
    start = likelihood._guessed([LOG])
    assert 1.0 / start["K"] == pytest.approx(25.0, rel=0.3)
    assert start["J"] > 0.0
    angle = np.cumsum(LOG.channels[SPEED].values) * 0.01
    turned = changed(speed=None, position=Channel(POSITION, "rad", angle))
    assert likelihood._guessed([turned])["K"] == pytest.approx(start["K"], rel=0.1)


def test_two_readings_that_are_as_likely_share_what_they_differ_by() -> None:
    def found(constant_s: float, objective: float) -> Any:
        named = [SimpleNamespace(name=name) for name in ("J", "K")]
        return SimpleNamespace(unknowns=named, values=(constant_s, 1.0), objective=objective)

    best = found(0.1, 0.0)
    assert likelihood._apart(best, found(0.11, 0.0)) == pytest.approx(0.1 / np.sqrt(2.0))
    assert likelihood._apart(best, found(0.11, 20.0)) < 1e-4


def test_parts_without_a_command_that_begin_at_speed_may_be_coasts() -> None:
    log = logged(Law(coasts=1.5), (0.0, 9.0, 0.0, 12.0), rows=60)
    driven, coasting = coasts.parted(log)
    assert [len(one) for one in driven] == [120, 60]
    (coast,) = coasting
    assert 12 <= len(coast) < 60  # until it rests
    assert set(coast.channels) == {SPEED}
    assert not coasts.parted(LOG)[1]


def test_what_is_left_counts_where_the_motor_moves_and_a_balance_shows_no_motion() -> None:
    speed = np.array([0.0, 0.0, 100.0, 100.0])
    off = np.array([9.0, 9.0, 2.0, -2.0])
    curve = Curve(0, SPEED, "rad/s", np.arange(4.0), speed, speed + off, 1.0)
    assert coasts.left([curve]) == pytest.approx(2.0)
    assert coasts.left([replace(curve, channel=VOLTAGE)]) == np.inf


@pytest.mark.parametrize(
    ("power", "factors"),
    [(1.0, (0.9, 1.2)), (-1.0, (1 / 1.2, 1 / 0.9)), (-2.0, (1.2**-2, 0.9**-2))],
)
def test_a_doubtful_part_moves_the_ends_by_its_power(
    power: float, factors: tuple[float, float]
) -> None:
    first = Parameter("K", "1", 1.0, 0.0, 0.0, 0.0, (1.0, 1.0), Status.ESTIMATED)
    now = replace(first, interval_95=(0.9, 1.2), status=Status.DOUBTFUL)
    assert _grown(now, first, power) == pytest.approx(factors)
