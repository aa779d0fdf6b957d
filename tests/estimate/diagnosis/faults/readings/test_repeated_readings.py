"""A converter that repeats itself, and samples that are missing: by readings with and without."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, VOLTAGE, Capture, Channel, Gap
from motorid.estimate.diagnosis.faults import lost_samples
from motorid.estimate.diagnosis.faults.readings import repeated_readings
from motorid.estimate.diagnosis.faults.readings.repeated_readings import Held
from motorid.estimate.results.estimate import Suspect
from tests.exact_capture import FAULHABER, clean_capture

STEP = 2.5e-3


def counts(spread: float = 12.0) -> np.ndarray:
    noise = np.random.default_rng(4).normal(0.0, spread, 2000)
    return np.round(2000.0 + noise)


def reading(raw: np.ndarray, **changes: object) -> Capture:
    """A capture whose current has these counts."""
    capture = clean_capture(FAULHABER)
    channel = replace(
        capture.channels[CURRENT],
        raw=raw,
        scale=STEP,
        resolution=STEP,
        **changes,  # type: ignore[arg-type]
    )
    return replace(capture, channels={**capture.channels, CURRENT: channel})


@pytest.mark.parametrize("repeat", [2, 3, 8])
def test_a_converter_that_is_read_too_often_says_how_often(repeat: int) -> None:
    raw = np.repeat(counts(), repeat)[:2000]
    assert repeated_readings.find(reading(raw)) == [Held(CURRENT, repeat, 0, 0)]
    (said,) = repeated_readings.suspects(reading(raw))
    assert (said.code, said.where) == ("readings_held", "current")
    assert f"{repeat} times over" in said.evidence


def test_a_stretch_that_stands_still_is_counted_and_placed() -> None:
    raw = counts()
    raw[700:725] = raw[699]
    capture = reading(raw)
    assert repeated_readings.find(capture) == [Held(CURRENT, 0, 25, 699)]
    (said,) = repeated_readings.suspects(capture)
    assert said.evidence.startswith("25 readings of the current repeat the one before")
    assert f"first at {capture.time_s[699]:.4g} s" in said.evidence


@pytest.mark.parametrize("spread", [0.05, 0.12, 0.3])
def test_steps_that_are_larger_than_the_noise_hold_nothing(spread: float) -> None:
    """Between two codes neighbours differ, at the middle of one hardly ever."""
    slow = 2000.0 + 3.0 * np.sin(np.arange(2000) / 150.0)
    noise = np.random.default_rng(5).normal(0.0, spread, 2000)
    assert repeated_readings.find(reading(np.round(slow + noise))) == []


def test_noise_holds_nothing() -> None:
    assert repeated_readings.find(reading(counts())) == []


def test_a_signal_without_noise_tells_nothing() -> None:
    assert repeated_readings.find(reading(np.full(2000, 2000.0))) == []
    assert repeated_readings.find(reading(counts(0.2))) == []


def test_a_reading_at_its_end_is_saturated_and_not_held() -> None:
    raw = counts()
    raw[700:725] = 4095.0
    assert repeated_readings.find(reading(raw, raw_max=4095.0)) == []


def test_a_channels_name_is_said_in_words() -> None:
    capture = reading(counts())
    current = capture.channels[CURRENT]
    volts = replace(current, name=VOLTAGE, raw=np.repeat(counts(), 2)[:2000])
    (said,) = repeated_readings.suspects(
        replace(capture, channels={**capture.channels, VOLTAGE: volts})
    )
    assert said.where == "terminal voltage"
    assert "each reading of the terminal voltage comes 2 times over" in said.evidence


@pytest.mark.parametrize(
    ("codes", "beyond"),
    [
        ((5, 6, 5, 6), [0, 0]), ((5, 6, 4, 6), [1, 1]), ((5, 7, 5, 6), [1, 1]),
        ((5, 3, 4, 3), [1, 0]), ((5, 7, 10, 12), [0, 0]), ((5, 5, 9, 9), [0, 0]),
        ((5, 9, 5), [0]), ((5, 9, 5, 1), [0, 0]),  # a signal that turns
    ],
)  # fmt: skip
def test_a_reading_stands_out_by_more_than_two_neighbouring_codes_beside_another(
    codes: tuple[int, ...], beyond: list[int]
) -> None:
    channel = Channel(CURRENT, "A", np.array(codes, float), scale=STEP, resolution=STEP)
    assert repeated_readings._beyond_flicker(channel).tolist() == [bool(one) for one in beyond]


def test_what_the_import_found_is_not_said_twice() -> None:
    capture = reading(np.repeat(counts(), 2)[:2000])
    known = {**capture.provenance, "held": {CURRENT: 2}}
    assert repeated_readings.find(replace(capture, provenance=known)) == []


def turning(increments: np.ndarray) -> Capture:
    """A capture whose position goes by these counts a sample."""
    capture = clean_capture(FAULHABER)
    raw = np.concatenate([[0.0], np.cumsum(increments)])
    place = replace(capture.channels[POSITION], raw=raw, scale=0.01, resolution=0.01)
    stopped = replace(capture, end_reason="stopped")  # whatever was planned
    return replace(stopped, channels={**capture.channels, POSITION: place})


class Line:
    """A time grid without gaps."""

    index = np.arange(2000)


def steps() -> np.ndarray:
    return 20.0 + np.round(np.random.default_rng(5).normal(0.0, 0.7, 1999))


def said(increments: np.ndarray) -> list[Suspect]:
    return lost_samples.suspects(turning(increments), Line())  # type: ignore[arg-type]


def test_an_even_motion_has_no_jumps() -> None:
    assert said(steps()) == []
    assert said(-steps()) == []


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_missing_samples_are_whole_multiples(way: float) -> None:
    increments = steps()
    increments[400] *= 3
    increments[900] *= 2
    jumps = lost_samples.find(turning(way * increments), Line())  # type: ignore[arg-type]
    assert jumps is not None
    assert jumps.places.tolist() == [401, 901]
    assert jumps.missing.tolist() == [2.0, 1.0]
    assert jumps.dropped == 3
    assert jumps.lost == 0.0
    (found,) = said(way * increments)
    assert found.code == "samples_dropped"
    assert "jumps by whole steps 2 times" in found.evidence


def test_lost_counts_are_none_of_whole_samples() -> None:
    increments = steps()
    increments[400] -= 11
    increments[900] -= 13
    (found,) = said(increments)
    assert found.code == "encoder_loses_counts"
    assert "in 2 jumps" in found.evidence
    assert f"{clean_capture(FAULHABER).time_s[401]:.4g} s" in found.evidence
    jumps = lost_samples.find(turning(increments), Line())  # type: ignore[arg-type]
    assert jumps is not None
    assert jumps.lost == pytest.approx(24.0, abs=4.0)


def test_a_position_without_known_counts_tells_nothing() -> None:
    capture = turning(steps())
    place = replace(capture.channels[POSITION], resolution=0.0)
    blind = replace(capture, channels={**capture.channels, POSITION: place})
    assert lost_samples.find(blind, Line()) is None  # type: ignore[arg-type]


def cut(samples: int, **changes: object) -> Capture:
    capture = clean_capture(FAULHABER)
    whole = replace(capture, end_reason="completed", **changes)  # type: ignore[arg-type]
    channels = {
        name: replace(one, raw=one.raw[: 2000 - samples]) for name, one in capture.channels.items()
    }
    return replace(whole, ticks=capture.ticks[: 2000 - samples], channels=channels)


def test_a_run_that_is_shorter_than_its_program() -> None:
    planned = lost_samples.short_of_program(cut(0))
    assert lost_samples.short_of_program(cut(7)) == planned + 7
    gap = Gap(100, 3, "lost")
    assert lost_samples.short_of_program(cut(7, gaps=(gap,))) == planned + 4


def test_a_run_that_was_stopped_is_no_shorter() -> None:
    capture = clean_capture(FAULHABER)
    assert lost_samples.short_of_program(replace(cut(7), end_reason="stopped")) == 0
    assert lost_samples.short_of_program(replace(cut(7), program=None)) == 0
    late = tuple(replace(phase, index=phase.index + 1) for phase in capture.phases)
    assert lost_samples.short_of_program(replace(cut(7), phases=late)) == 0


@pytest.mark.parametrize(("count", "told"), [(1500, True), (2000, False)])
def test_chance_makes_no_such_stretch_in_a_capture_of_that_length(count: int, told: bool) -> None:
    """Of three readings two are equal, 42 of 128 around: fifteen in turn by (43/130)^15 a place."""
    raw = np.tile([-6.0, -6, 6, 6, -7, 7, -8, -8, 8, 8, -7, 7], 175)[:count]
    raw[900:916] = 20.0
    found = repeated_readings._of(Channel(CURRENT, "A", raw, scale=STEP, resolution=STEP))
    assert (found is not None) is told
    assert (count * (43 / 130) ** 15 < 1e-4) is told


@pytest.mark.parametrize(("length", "stands_out"), [(27, False), (45, True)])
def test_a_stretch_of_the_commonest_code_is_judged_by_how_common_it_is(
    length: int, stands_out: bool
) -> None:
    """Noise of .7 steps about a code: half of the readings are it, 38 % equal their neighbours."""
    raw = np.round(2048.0 + np.random.default_rng(7).normal(0.0, 0.7, 20_000))
    raw[9000 : 9000 + length] = 2048.0
    channel = Channel(CURRENT, "A", raw, STEP, resolution=STEP)
    capture = clean_capture(FAULHABER)
    long = replace(capture, ticks=np.arange(len(raw)) * 100, channels={CURRENT: channel})
    assert bool(repeated_readings.find(long)) is stands_out
