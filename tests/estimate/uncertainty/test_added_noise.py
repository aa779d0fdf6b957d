"""What a log's noise of the voltage leaves of a fit's objective: by records of which all is given,
and of logs with and without it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, VOLTAGE, Capture
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.signals.voltage_jumps import count_of, rounding, scatter
from motorid.estimate.solver.problem import Block, Solution
from motorid.estimate.uncertainty import added_noise
from tests.estimate.effects.benches import measured
from tests.estimate.solutions import solution
from tests.estimate.uncertainty.test_log_voltage_noise import NOISE_V, TRUE, log

Floats = NDArray[np.float64]

# logs of a motor under a sine


def judged(record: MotorRecord, **values: float) -> Solution:
    """At the true motor but for these, and with nothing late."""
    there = replace(
        solution(100.0, **{**TRUE, **values}), own=(np.array([u.start for u in record.unknowns]),)
    )
    return added_noise.judged([record], there)


def noise(capture: Capture, **values: float) -> float:
    return judged(MotorRecord(capture, PARAMETERS, {}), **values).noise


def of_currents(record: MotorRecord) -> float:
    """Sum of squares that the true motor leaves."""
    (place,) = (k for k, m in enumerate(record.measured) if m.block.name == CURRENT)
    own = np.array([unknown.start for unknown in record.unknowns])
    left = record.residuals(np.array(list(TRUE.values())), own)[place]
    return float(left @ left)


def loud(noise_v: float) -> Capture:
    """Its current is so noisy that no inductance shows in what is left of it."""
    capture = log(noise_v)
    current = capture.channels[CURRENT]
    more = 0.5 * np.random.default_rng(3).standard_normal(len(current.raw))
    channels = {**capture.channels, CURRENT: replace(current, raw=current.raw + more)}
    return replace(capture, channels=channels)


@pytest.mark.parametrize("shape", ["joined", "curved", "held"])
def test_noise_is_what_it_has_left_of_the_currents_chi_square(shape: str) -> None:
    """As the same log without any says."""
    with_noise, without = (
        MotorRecord(log(volts), PARAMETERS, {}, shape)  # type: ignore[arg-type]
        for volts in (NOISE_V, 0.0)
    )
    left, usual = of_currents(with_noise), of_currents(without)
    count = len(with_noise.measured[0].values)
    share = (left - usual) / left
    assert share > 0.3
    found = judged(with_noise)
    assert found.noise == pytest.approx(share * count, rel=0.2)  # one noise, by draws of another
    assert found.objective == 100.0
    assert found.fair == 100.0 - found.noise
    assert abs(judged(without).noise) < 1e-3 * found.noise


@pytest.mark.slow
def test_a_fit_that_passes_less_of_a_noise_is_left_less_of_it() -> None:
    """By a larger inductance here: of white noise its winding passes as much as R/L."""
    capture = loud(0.3)
    small, usual, large = (noise(capture, L=times * TRUE["L"]) for times in (0.25, 1.0, 4.0))
    assert small > 1.1 * usual
    assert usual > 1.3 * large
    assert large > added_noise.LITTLE


def test_nothing_but_the_current_is_judged() -> None:
    capture = log(NOISE_V)
    others = {name: one for name, one in capture.channels.items() if name != CURRENT}
    assert noise(replace(capture, channels=others)) == 0.0


def test_what_is_no_log_has_no_noise() -> None:
    """A program says what drove the motor, whatever was read beside."""
    assert noise(measured()) == 0.0


def test_a_log_without_scatter_has_none() -> None:
    capture = log(NOISE_V)
    volts = capture.channels[VOLTAGE]
    still = replace(volts, raw=np.full(len(volts.raw), 3.0))
    found = noise(replace(capture, channels={**capture.channels, VOLTAGE: still}))
    assert found == 0.0


@pytest.mark.parametrize(("times", "draws"), [(1.0, 2 * added_noise.PAIRS), (30.0, 2)])
def test_where_a_pair_leaves_little_no_more_are_drawn(
    times: float, draws: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of so large an inductance."""
    driven, drive = list[Floats](), added_noise._with

    def counted(record: MotorRecord, noise: Floats) -> MotorRecord | None:
        driven.append(noise)
        return drive(record, noise)

    monkeypatch.setattr(added_noise, "_with", counted)
    found = noise(log(NOISE_V), L=times * TRUE["L"])
    assert len(driven) == draws
    assert (found < added_noise.LITTLE) is (draws == 2)
    assert all(np.array_equal(one, -other) for one, other in zip(driven[::2], driven[1::2]))  # noqa: B905


# noise that is given


COUNT = 40
WAY = np.sin(np.arange(float(COUNT)))  # of a current, by 1 V more
LEFT = 3.0 * np.cos(2.0 * np.arange(float(COUNT)))  # of it as the log is


class Made:
    """A record whose current follows a volt more by ``gain``, times the first parameter and an
    unknown of its own. The speed beside it follows by a thousand times as much.
    """

    def __init__(self, gain: float, floor: float = 1e-9, volts: float = 0.0) -> None:
        self.gain, self.floor, self.volts = gain, floor, volts
        self.current, self.sensed = "readings of the current", SimpleNamespace(waveform="a log's")
        self.measured = ["readings of the speed", self.current]
        self.blocks = Block("speed", 1e-9, COUNT), Block(CURRENT, floor, COUNT)

    def block(self, name: str) -> Any:
        assert name == CURRENT
        return self.current

    def residuals(self, shared: Floats, own: Floats) -> list[Floats]:
        moved = self.volts * WAY
        return [1e3 * moved, LEFT - self.gain * shared[0] * own[0] * moved]

    def under(self, volts: Floats) -> Made:
        return Made(self.gain, self.floor, float(volts[0]))


def left(monkeypatch: pytest.MonkeyPatch, noises: Sequence[float], *records: Made) -> float:
    """With these V in turn, of every record; its first parameter is 2, its own 1, 2, ..."""

    def given(record: Made, draws: int, levels: bool) -> Iterator[Floats]:
        assert (draws, levels) == (added_noise.PAIRS, False)
        yield from (np.array([volts]) for volts in noises)

    monkeypatch.setattr(added_noise, "_noises", given)
    monkeypatch.setattr(added_noise, "_with", lambda record, volts: record.under(volts))
    own = tuple(np.array([1.0 + k]) for k in range(len(records)))
    return added_noise.judged(records, replace(solution(R=2.0), own=own)).noise  # type: ignore[arg-type]


def chi_square(amperes: float) -> float:
    """Of a current that follows by so much, in units of what is left."""
    return float(np.sum((amperes * WAY) ** 2) / np.mean(LEFT**2))


def test_no_residual_correlates_with_a_draw_and_its_opposite(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Several pairs are averaged, and records add up; each follows by unknowns of its own."""
    one, other = Made(0.5), Made(0.8)
    assert left(monkeypatch, [1.5], one) == pytest.approx(chi_square(1.5))
    assert left(monkeypatch, [-1.5], one) == pytest.approx(chi_square(1.5))
    several = np.mean([chi_square(volts) for volts in (1.5, 2.0, 0.1)])
    assert left(monkeypatch, [1.5, 2.0, 0.1], one) == pytest.approx(several)
    both = chi_square(0.7) + chi_square(0.7 * 0.8 * 2.0 * 2.0)
    assert left(monkeypatch, [0.7], one, other) == pytest.approx(both)


def test_the_first_pair_alone_says_whether_more_are_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    volts = np.sqrt(added_noise.LITTLE / chi_square(1.0))
    little, much = 0.99 * volts, 1.01 * volts
    assert left(monkeypatch, [little, 9.0], Made(0.5)) == pytest.approx(chi_square(little))
    several = np.mean([chi_square(much), chi_square(little), chi_square(2.0)])
    assert left(monkeypatch, [much, little, 2.0], Made(0.5)) == pytest.approx(several)


def test_a_current_off_by_less_than_its_floor_is_judged_by_that(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    floor = 4.0
    assert np.mean(LEFT**2) < floor**2
    expected = chi_square(3.0) * np.mean(LEFT**2) / floor**2
    assert left(monkeypatch, [3.0], Made(0.5, floor)) == pytest.approx(expected)


def test_no_more_is_noise_than_there_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """A chi-square of as much as there are readings."""
    assert chi_square(9.0) > COUNT
    assert left(monkeypatch, [9.0], Made(0.5)) == COUNT
    half = (COUNT + chi_square(1.5)) / 2.0
    assert left(monkeypatch, [9.0, 1.5], Made(0.5)) == pytest.approx(half)


# what is drawn


def stepped() -> Floats:
    """V (2000,) of a converter's steps of .1, on levels of 100 readings each."""
    rng = np.random.default_rng(4)
    level = np.repeat(3.0 * (-1.0) ** np.arange(20) + 0.1 * rng.integers(0, 5, 20), 100)
    return np.asarray(level + 0.1 * (rng.random(2000) < 0.1))


def drawn(volts: Floats, levels: bool, waveform: str | None = "of a log") -> list[Floats]:
    record: Any = SimpleNamespace(
        capture=SimpleNamespace(get={VOLTAGE: SimpleNamespace(values=volts)}.get),
        sensed=SimpleNamespace(waveform=waveform),
    )
    return list(added_noise._noises(record, 3, levels))


def test_what_a_converters_steps_leave_of_each_level_is_drawn_where_it_is_asked_for() -> None:
    volts = stepped()
    step, deviation = count_of(volts), scatter(volts)
    assert step == pytest.approx(0.1)
    hidden = rounding(np.sqrt(deviation**2 - step**2 / 12.0), step)
    by_level = {levels: np.reshape(drawn(volts, levels), (60, 100)) for levels in (True, False)}
    for found in by_level.values():
        within = found - found.mean(axis=1)[:, None]
        assert within.std() == pytest.approx(deviation, rel=0.05)
    off = {levels: float(found.mean(axis=1).std()) for levels, found in by_level.items()}
    assert off[False] == pytest.approx(deviation / 10.0, rel=0.3)  # chance of 100 readings
    assert off[True] == pytest.approx(hidden, rel=0.3)
    assert hidden > 5.0 * deviation / 10.0


def test_draws_differ_and_are_the_same_the_next_time() -> None:
    volts = log(NOISE_V).channels[VOLTAGE].values
    first, again = drawn(volts, True), drawn(volts, True)
    assert len(first) == 3
    assert np.array_equal(first, again)
    alike = np.corrcoef(first) - np.eye(3)
    assert np.abs(alike).max() < 0.1


def test_of_no_log_and_of_no_noise_nothing_is_drawn() -> None:
    assert drawn(stepped(), True, waveform=None) == []
    assert drawn(np.full(3000, 3.0), True) == []


def test_a_reading_that_is_missing_has_no_noise() -> None:
    volts = log(NOISE_V).channels[VOLTAGE].values.copy()
    volts[100:200] = np.nan
    for one in drawn(volts, True):
        assert (one[100:200] == 0.0).all()
        assert np.count_nonzero(one) == len(volts) - 100
        assert one.std() == pytest.approx(NOISE_V, rel=0.1)
