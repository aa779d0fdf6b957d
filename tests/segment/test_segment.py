"""Segments against simulated truth, and properties that must hold for any capture."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motorid.capture.model import Capture, Channel, Gap
from motorid.segment import Segment, SegmentKind, segment
from tests.growth import growth
from tests.segment.truth import LARGE, OPEN, SMALL, Motor, Run, drive, record

REST, STEADY, COAST = SegmentKind.REST, SegmentKind.STEADY, SegmentKind.COAST
ACCELERATION, BRAKE = SegmentKind.ACCELERATION, SegmentKind.BRAKE
PROGRAM = [
    (0.1, 0.0), (0.3, 6.0), (0.5, OPEN), (0.2, -3.0), (0.2, -6.0), (0.2, 6.0), (0.3, 0.0),
]  # fmt: skip
KINDS = [
    REST, ACCELERATION, STEADY, COAST, BRAKE, ACCELERATION, STEADY, ACCELERATION, STEADY,
    BRAKE, ACCELERATION, STEADY, BRAKE, REST,
]  # fmt: skip
NAMES = {"small": SMALL, "large": LARGE}


@cache
def run_of(name: str, rate_hz: float) -> Run:
    return drive(NAMES[name], PROGRAM, rate_hz)


def kinds(segments: tuple[Segment, ...]) -> list[SegmentKind]:
    return [s.kind for s in segments]


def covers(segments: tuple[Segment, ...], n: int) -> bool:
    edges = [0, *(s.stop for s in segments)]
    return edges[-1] == n and all(
        s.start == e and s.stop > s.start for s, e in zip(segments, edges[:-1], strict=True)
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rate_hz", "counts", "noise", "speed"),
    [
        (10_000, 2048, 1e-3, False),
        (10_000, 2048, 5e-3, False),
        (10_000, 64, 1e-3, False),
        (1_000, 2048, 1e-3, False),
        (1_000, 2048, 1e-3, True),
        (10_000, 2048, 1e-3, True),
        (200, 2048, 1e-3, False),
    ],
)
def test_every_step_of_a_run_is_named(
    rate_hz: float, counts: int, noise: float, speed: bool
) -> None:
    capture = record(run_of("small", rate_hz), counts=counts, noise=noise, speed=speed)
    segments = segment(capture)
    assert covers(segments, len(capture))
    assert kinds(segments) == KINDS


@pytest.mark.slow
@pytest.mark.parametrize("name", ["small", "large"])
@pytest.mark.parametrize("seed", range(4))
def test_edges_fall_on_the_events(name: str, seed: int) -> None:
    run = run_of(name, 10_000)
    segments = segment(record(run, seed=seed))
    begins = {s.start for s in segments}
    for edge in run.edges[1:]:  # each step changes the current at once
        assert min(abs(edge - b) for b in begins) <= 3
    speed = np.abs(run.speed) / np.abs(run.speed).max()
    assert segments[-1].kind is REST
    assert speed[segments[-1].start] < 0.01
    assert speed[segments[-1].start - 100] > 0.002


@pytest.mark.parametrize("name", ["small", "large"])
def test_steady_state_is_steady(name: str) -> None:
    run = run_of(name, 10_000)
    for s in segment(record(run)):
        if s.kind is STEADY:
            speed = run.speed[s.slice]
            assert np.ptp(speed) < 0.03 * np.abs(run.speed).max()


def test_steady_begins_where_a_hundredth_of_the_change_remains() -> None:
    run = run_of("small", 10_000)
    steady = next(s for s in segment(record(run)) if s.kind is STEADY)
    remaining = 1 - run.speed[steady.start] / run.speed[steady.stop - 1]
    assert 0.003 < remaining < 0.02


def test_coast_has_no_current_and_starts_when_it_is_gone() -> None:
    run = run_of("large", 10_000)
    coast = next(s for s in segment(record(run)) if s.kind is COAST)
    assert np.all(run.current[coast.slice] == 0)
    assert coast.start - run.edges[2] <= 2


def test_a_short_circuit_brake_is_no_coast() -> None:
    run = drive(SMALL, [(0.1, 0.0), (0.3, 6.0), (0.4, 0.0)], 10_000)
    assert kinds(segment(record(run))) == [REST, ACCELERATION, STEADY, BRAKE, REST]


def test_a_long_coast_of_a_motor_with_little_friction() -> None:
    motor = Motor(J=4e-6, T0=2e-5, B=1e-8)
    run = drive(motor, [(0.1, 0.0), (2.0, 6.0), (3.0, OPEN)], 1_000)
    assert kinds(segment(record(run))) == [REST, ACCELERATION, STEADY, COAST]


def test_without_a_current_slowing_down_is_brake_and_says_so() -> None:
    whole = record(run_of("small", 1_000))
    bare = dataclasses.replace(whole, channels={"position": whole.channels["position"]})
    found = segment(bare)
    assert COAST not in kinds(found)
    assert all("may be coasting" in s.reason for s in found if s.kind is BRAKE)
    assert BRAKE in kinds(found)


def test_a_stalled_motor_rests() -> None:
    run = drive(SMALL, [(0.1, 0.0), (0.2, 0.03), (0.1, 0.0)], 10_000)
    assert kinds(segment(record(run))) == [REST]
    assert np.abs(run.current).max() > 0


@pytest.mark.slow
@settings(max_examples=25)
@given(
    shift=st.integers(-(2**40), 2**40),
    sign=st.sampled_from([1.0, -1.0]),
    offset=st.integers(-400, 400),
)
def test_time_shift_sign_and_offset_change_nothing(shift: int, sign: float, offset: int) -> None:
    capture = record(run_of("small", 1_000))
    current, position = capture.channels["current"], capture.channels["position"]
    moved = Capture(
        capture.ticks + shift,
        capture.clock_hz,
        {
            "current": dataclasses.replace(current, raw=sign * current.raw + offset),
            "position": dataclasses.replace(position, raw=sign * position.raw),
        },
    )
    assert segment(moved) == segment(capture)


@pytest.mark.parametrize("delay", [1, 5])
def test_a_late_current_does_not_upset_the_names(delay: int) -> None:
    assert kinds(segment(record(run_of("small", 10_000), delay=delay))) == KINDS


@pytest.mark.slow
@settings(max_examples=60)
@given(
    n=st.integers(0, 400),
    seed=st.integers(0, 2**31),
    gaps=st.lists(st.integers(1, 399), max_size=5),
    missing=st.lists(st.integers(0, 399), max_size=20),
    kind=st.sampled_from(["noise", "walk", "constant", "zero"]),
)
def test_any_capture_is_covered_once(
    n: int, seed: int, gaps: list[int], missing: list[int], kind: str
) -> None:
    rng = np.random.default_rng(seed)
    noise = rng.standard_normal(n)
    speed = {"noise": noise, "walk": np.cumsum(noise), "constant": np.full(n, 3.0)}.get(kind)
    speed = np.zeros(n) if speed is None else speed
    speed[[m for m in missing if m < n]] = np.nan
    current = Channel("current", "A", rng.standard_normal(n))
    channels = {"speed": Channel("speed", "rad/s", speed), "current": current}
    inside = tuple(Gap(g, 3, "lost") for g in sorted(set(gaps)) if g < n)
    segments = segment(Capture(np.arange(n), 1000.0, channels, gaps=inside))
    assert covers(segments, n)
    edges = {s.start for s in segments}
    assert all(g.index in edges for g in inside)
    for s in segments:
        assert np.isnan(speed[s.slice]).any() <= (s.kind is SegmentKind.REJECTED)


def test_missing_and_saturated_readings_are_rejected_with_the_reason() -> None:
    whole = record(run_of("small", 1_000))
    current = whole.channels["current"]
    raw = np.asarray(current.raw, dtype=np.float64).copy()
    raw[500:520] = np.nan
    raw[700:712] = 4000
    broken = dataclasses.replace(current, raw=raw, raw_max=4000.0)
    capture = dataclasses.replace(whole, channels={**whole.channels, "current": broken})
    rejected = [s for s in segment(capture) if s.kind is SegmentKind.REJECTED]
    assert [(s.start, s.stop) for s in rejected] == [(500, 520), (700, 712)]
    assert "current has no reading" in rejected[0].reason
    assert "end of its converter's range" in rejected[1].reason


def test_a_jump_of_the_clock_is_a_gap_even_if_not_declared() -> None:
    whole = record(run_of("small", 1_000))
    ticks = whole.ticks + np.where(np.arange(len(whole)) >= 1100, 50_000, 0)
    segments = segment(dataclasses.replace(whole, ticks=ticks))
    assert 1100 in {s.start for s in segments}


def test_without_motion_everything_is_rejected_with_the_reason() -> None:
    capture = Capture(np.arange(50), 1000.0, {"current": Channel("current", "A", np.ones(50))})
    (only,) = segment(capture)
    assert only.kind is SegmentKind.REJECTED
    assert "neither speed nor position" in only.reason


@pytest.mark.slow
def test_a_hundred_thousand_samples_take_little_time() -> None:
    run = run_of("small", 10_000)
    capture = record(dataclasses.replace(
        run, current=np.tile(run.current, 6)[:100_000], speed=run.speed,
        position=np.concatenate([run.position + k * run.position[-1] for k in range(6)])[:100_000],
    ))  # fmt: skip
    assert len(capture) == 100_000
    tenth = record(run_of("small", 10_000 * 10_000 / len(run.current)))
    assert len(tenth) == pytest.approx(10_000, rel=0.01)
    # at most in proportion, and some for caches; squared it would be 100
    assert growth(lambda: segment(tenth), lambda: segment(capture)) < 15
