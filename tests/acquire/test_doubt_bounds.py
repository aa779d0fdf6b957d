"""The bounds of what no motor and no noise can do, each from both sides; by made counts."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from motorid.acquire import doubts as room
from motorid.acquire.doubts import doubts
from motorid.acquire.encoder_scale import why_too_fast
from motorid.capture.model import CURRENT, POSITION, Capture, Channel, Phase
from motorid.program import Decay, Program, Step, StepKind
from motorid.rig import Nameplate
from tests.acquire.rigs import sim_rig

NOISY = Channel(CURRENT, "A", np.zeros(1, np.int16), scale=0.5, resolution=0.5, noise=0.5)


# -- readings that repeat
@pytest.mark.parametrize(("counts", "samples"), [(0.25, 1000), (0.5, 50_000), (1.0, 1000)])
def test_noise_repeats_a_reading_so_often_once_in_a_million_runs(
    counts: float, samples: int
) -> None:
    """The likeliest count has the probability of half a count either way."""
    once = norm.cdf(0.5 / counts) - norm.cdf(-0.5 / counts)
    most = room._longest_chance(replace(NOISY, noise=0.5 * counts), samples)
    assert most is not None
    assert samples * once**most <= 1e-6 * (1 + 1e-9)
    assert samples * once ** (most - 1) > 1e-6


def test_of_large_noise_twenty_repeats_are_no_doubt_and_of_small_noise_none() -> None:
    assert room._longest_chance(replace(NOISY, noise=1.5), 1000) == 20
    assert room._longest_chance(replace(NOISY, noise=0.124), 1000) is None
    assert room._longest_chance(replace(NOISY, resolution=0.0), 1000) is None


def repeating(count: int, name: str = CURRENT, **facts: float) -> list[str]:
    """A run of 1000 readings, of which so many from the hundredth on are the same."""
    raw = (np.arange(1000) % 2).astype(np.int16)
    raw[100 : 100 + count] = 5
    channel = replace(NOISY, name=name, raw=raw, **facts)
    return doubts(Capture(np.arange(1000), 1e3, {name: channel}))


def test_a_reading_that_repeats_for_longer_than_chance_allows_is_said() -> None:
    most = math.ceil(math.log(1e-9) / math.log(norm.cdf(0.5) - norm.cdf(-0.5)))
    assert repeating(most) == []
    (said,) = repeating(most + 1)
    assert said.startswith(
        f"current reads 2.5 A without a change from 0.100 s on for {most + 1} samples"
    )
    assert repeating(500, POSITION) == []  # a count may stand
    assert repeating(500, noise=0.1) == []
    assert repeating(500, raw_max=5.0) == []  # an end of the range is another matter
    assert room._longest_repeat(replace(NOISY, raw=np.array([1, 2, 2, 2, 3, 3]))) == (1, 3)
    assert room._longest_repeat(replace(NOISY, raw=np.array([3, 3, 2]))) == (0, 2)
    assert room._longest_repeat(replace(NOISY, raw=np.array([1, 3, 3]))) == (1, 2)


@pytest.mark.parametrize("samples", [0, 1])
def test_a_run_of_one_sample_shows_nothing(samples: int) -> None:
    channel = replace(NOISY, raw=np.zeros(samples, np.int16))
    assert doubts(Capture(np.arange(samples), 1e3, {CURRENT: channel})) == []


# -- a count that stops
def stops(*parts: tuple[int, int]) -> int | None:
    """Of parts of so many samples at each count, looked at in windows of 20."""
    counts = np.concatenate([np.full(samples, at, np.int64) for samples, at in parts])
    found = {sign: room._stops(sign * counts, 20) for sign in (1, -1)}
    assert found[1] == found[-1]
    return found[1]


def test_a_count_that_never_moved_does_not_stop() -> None:
    assert stops((100, 5)) is None


def test_a_count_stands_for_more_than_two_windows() -> None:
    assert stops((1, 0), (41, 30)) == 1
    assert stops((1, 0), (40, 30)) is None
    assert stops((30, 0), (41, 30)) == 30


@pytest.mark.parametrize(("way", "moved"), [(20, True), (19, False)])
def test_a_count_that_stops_had_moved_by_twenty_in_a_window(way: int, moved: bool) -> None:
    assert (stops((20, 0), (60, way)) is not None) is moved


def test_what_moved_before_the_window_counts_for_nothing() -> None:
    # the last change is at 20: the window begins with sample 0, which stood where 1 does
    assert stops((1, 0), (19, 15), (60, 30)) == 20
    assert stops((1, 0), (20, 15), (60, 30)) is None


@pytest.mark.parametrize(("last", "abrupt"), [(15, True), (14, False)])
def test_a_stop_is_abrupt_by_its_last_quarter(last: int, abrupt: bool) -> None:
    # 100 counts in 20 samples, so many of them in the last five
    assert (stops((1, 0), (15, 100 - last), (4, 100 - last + 1), (60, 100)) == 20) is abrupt


# -- a drive that does not turn what one turned before
VOLTS = Step(StepKind.DRIVE_VOLTS, 0.1, 3.0, Decay.SYNCHRONOUS_SLOW)
DUTY = Step(StepKind.DRIVE_DUTY, 0.1, 0.5, Decay.SYNCHRONOUS_SLOW)


def stands(*drives: tuple[Step, int, int], flicker: int = 0) -> list[str]:
    """Steps, each with its samples and the counts by which it turns evenly; doubts about them."""
    counts, begins, at = [], [], 0
    for _, samples, way in drives:
        begins.append(sum(map(len, counts)))
        counts.append(at + np.linspace(0, way, samples).round().astype(np.int64))
        at += way
    raw = np.concatenate(counts)
    raw[-1:] += flicker
    steps = tuple(step for step, _, _ in drives)
    phases = tuple(Phase(n, begin) for n, begin in enumerate(begins))
    channel = Channel(POSITION, "rad", raw)
    plan = Program(steps)
    return doubts(
        Capture(np.arange(len(raw)), 1e3, {POSITION: channel}, program=plan, phases=phases)
    )


def level(volts: float) -> Step:
    return replace(VOLTS, level=volts)


def test_the_least_level_that_turned_the_motor_should_again() -> None:
    turned = [(level(3.0), 100, 50), (level(-2.0), 100, -50), (level(4.0), 100, 50)]
    (said,) = stands(*turned, (level(2.0), 100, 0))
    assert said.startswith("the encoder stands still from 0.300 s on while the bridge drives")
    assert stands(*turned, (level(-2.5), 100, 0)) != []
    assert stands(*turned, (level(1.9), 100, 0)) == []
    assert stands(*turned, (level(0.0), 100, 0)) == []
    assert stands(*turned, (DUTY, 100, 0)) == []  # of which nobody knows
    assert stands((DUTY, 100, 50), (DUTY, 100, 0)) != []
    assert stands(*turned, (Step(StepKind.COAST, 0.1), 100, 0)) == []


@pytest.mark.parametrize(("way", "turned"), [(20, True), (19, False)])
def test_twenty_counts_are_a_turning_motor(way: int, turned: bool) -> None:
    assert bool(stands((VOLTS, 100, way), (VOLTS, 100, 0))) is turned


@pytest.mark.parametrize(("samples", "doubted"), [(40, False), (41, True)])
def test_a_drive_of_two_windows_is_too_short_to_tell(samples: int, doubted: bool) -> None:
    assert bool(stands((VOLTS, 100, 50), (VOLTS, samples, 0))) is doubted


@pytest.mark.parametrize(("flicker", "doubted"), [(1, True), (-1, True), (2, False)])
def test_an_edge_may_flicker(flicker: int, doubted: bool) -> None:
    found = stands((VOLTS, 100, 50), (VOLTS, 100, 0), flicker=flicker)
    assert bool(found) is doubted


# -- a speed that cannot be
def turning(counts: float, samples: int = 14, *, volts: float | None = 1.0) -> Capture:
    """At 1 kHz, by so many hundredths of a radian in the second of its steps of 12 samples."""
    raw = np.zeros(samples, np.int64)
    raw[-1] = counts
    plan = None if volts is None else Program((level(volts),))
    channel = Channel(POSITION, "rad", raw, scale=0.01)
    return Capture(np.arange(samples), 1e3, {POSITION: channel}, program=plan)


FAST = replace(
    sim_rig(program=Program((level(2.0),))), nameplate=Nameplate(torque_constant_nm_a=0.1)
)


@pytest.mark.parametrize(
    ("counts", "volts", "impossible"),
    [
        (14, 1.0, False), (15, 1.0, True), (-15, 1.0, True),  # 1.2 V / .1 V s over 12 ms: .144 rad
        (28, None, False), (29, None, True),  # by the rig's program, of 2 V
    ],
)  # fmt: skip
def test_a_speed_beyond_what_the_highest_level_allows_is_said(
    counts: int, volts: float | None, impossible: bool
) -> None:
    said = why_too_fast(FAST, turning(counts, volts=volts))
    assert bool(said) is impossible
    if counts == 15:
        assert said.startswith("; the encoder says ")
        assert " rad/s at 1 V, " in said
    geared = replace(FAST, wiring=replace(FAST.wiring, gear_ratio=0.5))
    assert why_too_fast(geared, turning(counts, volts=volts)) == ""


def test_a_run_too_short_for_a_speed_says_nothing() -> None:
    assert why_too_fast(FAST, turning(99, 12)) == ""
    assert why_too_fast(FAST, turning(99, 13)) != ""
    assert why_too_fast(FAST, replace(turning(99), channels={})) == ""
    assert why_too_fast(replace(FAST, nameplate=Nameplate()), turning(99)) == ""
