"""How a log's readings came, where nobody says so: means, low-passes of second order, jumps."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.signal import bilinear, butter, lfilter

from bench.foreign.plant import STEP_S
from bench.stranger.logs import Log, answer
from bench.stranger.plant import draw
from motorid.capture.model import SPEED
from motorid.estimate.fit.joint_fit import solved
from motorid.estimate.fit.logs import log_readings
from motorid.estimate.signals.intersample_voltage import LOOSE, LOOSE_SOURCE, MEANS
from tests.estimate.fit.logs.test_log_fit import MOTOR, PERIOD_S, Floats, logged
from tests.estimate.fit.made_fits import PERIOD_S as MADE_PERIOD_S
from tests.estimate.fit.made_fits import record, solution
from tests.six_parameters import fit

EVERY = round(PERIOD_S / STEP_S)
TRUTH = {name: getattr(MOTOR, name) for name in ("R", "L", "K", "J")}
SAMPLES = 4.0  # of the low-pass


def counted(speed: Floats) -> Floats:
    """Turned since the reading before, over that time."""
    return np.asarray(lfilter(np.full(EVERY, 1.0 / EVERY), [1.0], speed))


def behind_butterworth(current: Floats) -> Floats:
    analogue = butter(2, 1.0 / (SAMPLES * PERIOD_S), analog=True)
    return np.asarray(lfilter(*bilinear(*analogue, 1.0 / STEP_S), current))


@pytest.mark.slow
def test_a_speed_of_counted_edges_is_a_mean(tmp_path: Path) -> None:
    records, _ = solved([logged(tmp_path, w=counted)], {}, ())
    assert records[0].capture.channels[SPEED].window_s == pytest.approx(PERIOD_S, rel=1e-6)


@pytest.mark.slow
def test_behind_a_counted_speed_a_ramp_is_held_from_row_to_row(tmp_path: Path) -> None:
    """A speed that is late by half a row speaks for a voltage that is: J was .8 % off at 10 u."""
    rng = np.random.default_rng(2)
    motor = draw(rng)
    log = Log("ramp", rate=40.0 / motor.tau_s, bits=14, noise=0.3, counts=4096)
    found = answer(log, motor, rng, tmp_path)
    assert found.estimate is not None
    assert not [s for s in found.estimate["suspects"] if s["strength"] == "named"]
    inertia = found.estimate["parameters"]["J"]
    low, high = inertia["interval_95"]
    assert low < motor.truth["J"] < high
    assert inertia["value"] == pytest.approx(motor.truth["J"], rel=2e-3)


@pytest.mark.slow
def test_a_current_behind_a_low_pass_of_second_order_tells_the_inductance(tmp_path: Path) -> None:
    found = fit([logged(tmp_path, i=behind_butterworth)])
    assert "current_filtered" in {s.code for s in found.suspects if s.strength == "named"}
    size = found.nuisance["current smoothing of second order"].value or 0.0
    assert size == pytest.approx(SAMPLES * PERIOD_S, rel=0.1)
    for name, true in TRUTH.items():
        one = found.parameters[name]
        assert one.value is not None
        assert one.total is not None
        assert abs(one.value - true) < 4.0 * one.total, name
        assert one.value == pytest.approx(true, rel=0.2 if name == "L" else 0.02), name
    assert (found.parameters["L"].total or 1.0) < 0.1 * MOTOR.L  # none worse is its rival


def over_samples(count: int) -> Callable[[Floats], Floats]:
    """Means over that many samples of the log, before each stamp."""
    width = count * EVERY
    return lambda current: np.asarray(lfilter(np.full(width, 1.0 / width), [1.0], current))


@pytest.mark.slow
@pytest.mark.parametrize("count", [3, pytest.param(7, marks=pytest.mark.study)])
def test_a_current_that_is_a_mean_over_several_samples_is_known_as_one(
    tmp_path: Path, count: int
) -> None:
    found = fit([logged(tmp_path, i=over_samples(count))])
    (named,) = (s for s in found.suspects if s.code == "current_averaged")
    assert named.allowed
    assert f"({count} samples of the log)" in named.evidence
    for name in ("R", "K", "J"):
        one = found.parameters[name]
        assert one.value == pytest.approx(TRUTH[name], rel=0.01), name
    L = found.parameters["L"]
    if L.interval_95 is not None:
        low, high = L.interval_95
        assert low < TRUTH["L"] < high


@pytest.mark.slow
@pytest.mark.parametrize("count", [1, pytest.param(4, marks=pytest.mark.study)])
def test_a_current_that_is_late_by_whole_samples_is_taken_earlier(
    tmp_path: Path, count: int
) -> None:
    """Its lag was found between samples, and the speed taken for a mean. Between two jumps of a
    held voltage little tells a part of a sample from a low-pass, or from a voltage that is early.
    """

    def late(current: Floats) -> Floats:
        return np.concatenate([np.full(count * EVERY, current[0]), current[: -count * EVERY]])

    found = fit([logged(tmp_path, i=late)])
    (named,) = (s for s in found.suspects if s.code == "current_lag" and s.strength == "named")
    assert named.allowed
    said = re.search(r"\((\S+) samples of the log\)", named.evidence)
    assert said is not None
    assert float(said[1]) == pytest.approx(count, abs=0.3)
    for name, true in TRUTH.items():
        one = found.parameters[name]
        assert one.interval_95 is not None
        assert one.interval_95[0] < true < one.interval_95[1], name
        assert one.value == pytest.approx(true, rel=0.01), name


# moments of jumps, on fits of which the objective is given


def jumped(near: float, shape: str = "held", window_s: float = 0.0) -> Any:
    """Residuals of the current that are ``near`` within three samples of a jump, 1 elsewhere."""
    left = np.ones(200)
    jumps = np.array([50, 120])
    for at in jumps:
        left[at : at + 3] = near
    waveform = SimpleNamespace(
        shape=shape, steps_off=jumps, time_s=MADE_PERIOD_S * (np.arange(200.0) - 0.3),
        period_s=MADE_PERIOD_S, window_s=window_s,
    )  # fmt: skip
    current = SimpleNamespace(keep=np.arange(200))
    return record(
        sensed=SimpleNamespace(waveform=waveform), block=lambda _: current, measured=[current],
        departures=lambda *_: [left], timeline=SimpleNamespace(period_s=MADE_PERIOD_S),
    )  # fmt: skip


@pytest.mark.parametrize(("near", "asks"), [(1.2, False), (1.25, True), (-1.25, True)])
def test_larger_residuals_after_jumps_ask_for_their_moments(near: float, asks: bool) -> None:
    assert log_readings._asks(jumped(near), np.zeros(6), np.zeros(0)) is asks


def test_shapes_without_jumps_of_their_own_ask_for_none() -> None:
    assert not log_readings._asks(jumped(9.0, LOOSE), np.zeros(6), np.zeros(0))
    assert log_readings._asks(jumped(9.0, MEANS), np.zeros(6), np.zeros(0))  # it may be none
    assert log_readings._asks(jumped(9.0), np.zeros(6), np.zeros(0))
    assert not log_readings._asks(jumped(9.0, window_s=1e-4), np.zeros(6), np.zeros(0))
    calm = jumped(9.0)
    calm.sensed.waveform.steps_off = np.zeros(0, dtype=int)
    assert not log_readings._asks(calm, np.zeros(6), np.zeros(0))


def loosened(
    monkeypatch: pytest.MonkeyPatch, gain: float, asks: bool = False,
    colours: tuple[float, float] = (1.0, 1.0), shape: str = "held", jumps: int = 3,
    window_s: float = 0.0, sourced: float | None = None, jump: int = 3,
) -> tuple[Any, Any, Any, list[Any]]:  # fmt: skip
    """The fit before, the one with three moments more, the one that is taken, and what was asked;
    ``colours``: what either leaves; ``sourced``: by how much more one of a source gains, which
    has ``jump`` moments.
    """
    measured = [SimpleNamespace(values=np.zeros(1000))]
    waveform = SimpleNamespace(shape=shape, steps_off=np.arange(jumps), window_s=window_s)
    one = record(measured=measured, capture="run", unknowns=("offset",),
                 sensed=SimpleNamespace(waveform=waveform))  # fmt: skip
    before = [one], replace(solution(100.0), own=(np.zeros(1),))
    loose = [record(measured=measured, unknowns=("offset", 1, 2, 3))], solution(100.0 - gain)
    asked: list[Any] = []

    def again(captures: object, shape: str, near: object) -> Any:
        asked.append((captures, shape, near))
        if shape == LOOSE_SOURCE and sourced is not None:
            moments = ("offset", *range(1, jump + 1))
            one = record(measured=measured, unknowns=moments)
            return [one], solution(100.0 - gain - sourced)
        return loose

    ohms = 0.0 if sourced is None else 0.2
    monkeypatch.setattr(log_readings, "source_ohms_of", lambda _: ohms)
    monkeypatch.setattr(log_readings, "_asks", lambda *_: asks)
    monkeypatch.setattr(log_readings, "inflation", lambda of: colours[of is loose[1]])
    found = log_readings._loosened(before, again)
    return before, loose, found, asked


@pytest.mark.parametrize("more", [-1.0, 1.0])
def test_a_source_that_the_log_shows_is_tried_with_the_moments(
    more: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The likelier of both is taken."""
    before, loose, found, asked = loosened(monkeypatch, 50.0, asks=True, sourced=more)
    assert asked == [(["run"], LOOSE, before), (["run"], LOOSE_SOURCE, before)]
    assert found[1].objective == pytest.approx(100.0 - 50.0 - max(more, 0.0))
    assert (found is loose) is (more < 0.0)
    assert loosened(monkeypatch, 50.0, True, shape=LOOSE_SOURCE)[3] == []


@pytest.mark.parametrize(("more", "taken"), [(6.9, False), (6.92, True)])
def test_a_source_with_a_jump_more_must_pay_for_it(
    more: float, taken: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    _, loose, found, _ = loosened(monkeypatch, 50.0, asks=True, sourced=more, jump=4)
    assert (found is not loose) is taken


@pytest.mark.parametrize(("gain", "taken"), [(3 * 6.9, False), (3 * 6.92, True)])
def test_moments_of_jumps_must_pay_for_each_of_them(
    gain: float, taken: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Three unknowns more, at ln 1000 = 6.908 each."""
    before, loose, found, asked = loosened(monkeypatch, gain, asks=True)
    assert asked == [(["run"], LOOSE, before)]
    assert found is (loose if taken else before)
    before, _, found, asked = loosened(monkeypatch, gain, asks=False)
    assert asked == []
    assert found is before


@pytest.mark.parametrize(
    ("colour", "left", "gain", "tried", "taken"),
    [
        (4.0, 3.9, 50.0, True, True),
        (4.0, 4.0, 50.0, True, False),  # they are not what the residuals lack
        (3.9, 1.0, 50.0, False, False),
        (4.0, 1.0, 3 * 6.9, True, False),  # and they must pay as well
    ],
)
def test_moments_of_jumps_are_tried_of_coloured_residuals_and_must_leave_none(
    colour: float, left: float, gain: float, tried: bool, taken: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    before, loose, found, asked = loosened(monkeypatch, gain, colours=(colour, left))
    assert bool(asked) is tried
    assert found is (loose if taken else before)


@pytest.mark.parametrize(("asks", "taken"), [(True, True), (False, False)])
def test_residuals_that_ask_for_moments_may_stay_coloured(
    asks: bool, taken: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    _, loose, found, asked = loosened(monkeypatch, 50.0, asks, (9.0, 8.0))
    assert len(asked) == 1
    assert (found is loose) is taken


def test_moments_are_tried_of_every_shape_that_jumps_but_where_they_are_unknowns_already(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for shape in ("joined", "held", MEANS):
        assert len(loosened(monkeypatch, 50.0, colours=(9.0, 1.0), shape=shape)[3]) == 1
    assert loosened(monkeypatch, 50.0, colours=(9.0, 1.0), shape=LOOSE)[3] == []
    assert loosened(monkeypatch, 50.0, True, (9.0, 1.0), jumps=0)[3] == []


@pytest.mark.parametrize("asks", [True, False])
def test_stated_means_have_no_moments(asks: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    before, _, found, asked = loosened(monkeypatch, 50.0, asks, (9.0, 1.0), MEANS, window_s=1e-4)
    assert asked == []
    assert found is before
