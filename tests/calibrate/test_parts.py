"""Meters, rest, clock, encoder and disc: what each concludes from readings whose truth is known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from motorid.acquire.clock import Pair, clock_of, with_stated
from motorid.calibration.disc import Disc, Inertia, check_disc
from motorid.calibration.encoder import encoder_of
from motorid.calibration.gain import Point, gain_of, meter
from motorid.calibration.rest import Zero, rest_of
from motorid.errors import DataError, UsageError


def test_a_meters_accuracy_is_read_as_its_data_sheet_says_it() -> None:
    found = meter("DMM", "1", "0.5% + 0.003")
    assert found.common == pytest.approx(0.005 / math.sqrt(3))
    assert found.apart == pytest.approx(0.003 / math.sqrt(3))
    assert meter("DMM", "1", "0.1%").apart == 0
    assert meter("DMM", "1", "2e-3").absolute == pytest.approx(2e-3)
    for text in ("", "0%", "good", "1%%", "-1%"):
        with pytest.raises(UsageError, match="accuracy"):
            meter("DMM", "1", text)


def test_a_meters_own_gain_stays_in_the_uncertainty() -> None:
    points = [Point(v, 1e-6, 1.01 * v, 1e-5) for v in (-2.0, -1.0, 1.0, 2.0)]
    found = gain_of(points, common=0.003)
    assert found.gain == pytest.approx(1.01, abs=1e-5)
    assert found.uncertainty == pytest.approx(0.003, rel=1e-3)
    assert found.findings("A") == []


def test_a_zero_that_is_off_and_points_that_scatter_are_said() -> None:
    off = gain_of([Point(v + 0.05, 1e-4, v, 1e-4) for v in (-2.0, -1.0, 1.0, 2.0)], 0.001)
    assert off.zero == pytest.approx(0.05, abs=1e-4)
    assert any("passes zero" in finding for finding in off.findings("A"))
    bumps = (0.02, -0.02, 0.02, -0.02)
    loose = gain_of(
        [Point(v + b, 1e-4, v, 1e-4) for v, b in zip((-2.0, -1.0, 1.0, 2.0), bumps, strict=True)],
        1e-4,
    )
    assert loose.excess > 50
    assert loose.uncertainty > abs(loose.gain - 1)
    assert any("loose contact" in finding for finding in loose.findings("A"))


def test_no_gain_comes_of_levels_that_are_alike_or_of_swapped_leads() -> None:
    for points in (
        [Point(1.0, 1e-3, 1.0, 1e-3), Point(1.002, 1e-3, 2.0, 1e-3)],
        [Point(1.0, 1e-3, 1.0, 1e-3), Point(2.0, 1e-3, 1.0, 1e-3)],
    ):
        with pytest.raises(DataError, match="too alike"):
            gain_of(points, 0.001)
    with pytest.raises(DataError, match="two different levels"):
        gain_of([Point(1.0, 1e-3, 1.0, 1e-3)], 0.001)
    with pytest.raises(DataError, match="swap"):
        gain_of([Point(1.0, 1e-3, -1.0, 1e-3), Point(2.0, 1e-3, -2.0, 1e-3)], 0.001)


def test_rest_tells_drift_from_noise() -> None:
    rng = np.random.default_rng(2)
    still = [Zero(2.0 * k, 2048 + rng.normal(0, 0.07), 1.0, 200) for k in range(12)]
    found = rest_of(still)
    assert found.offset == pytest.approx(2048, abs=4 * found.standard_error)
    assert found.uncertainty == pytest.approx(0.07, rel=0.6)
    assert not found.drifts
    warming = [Zero(z.time_s, z.mean + 0.1 * z.time_s, 1.0, 200) for z in still]
    drifting = rest_of(warming)
    assert drifting.drifts
    assert drifting.drift_per_minute == pytest.approx(6, abs=3 * drifting.drift_uncertainty)
    climb = 0.1 * np.std([z.time_s for z in still], ddof=1)
    assert drifting.uncertainty == pytest.approx(math.hypot(climb, 0.07), rel=0.1)
    with pytest.raises(DataError):
        rest_of(still[:3])


def test_a_silent_converter_hides_a_part_of_a_count() -> None:
    found = rest_of([Zero(float(k), 2048.0, 0.0, 200) for k in range(6)])
    assert found.uncertainty == pytest.approx(1 / math.sqrt(12))


def test_a_clock_is_found_through_wrapping_ticks_and_late_replies() -> None:
    rng = np.random.default_rng(3)
    scores = []
    for _ in range(200):
        rate, hz = 1 + rng.normal(0, 5e-5), 16e6
        pairs = []
        for k in range(60):
            asked = 0.5 * k + rng.uniform(0, 0.01)
            out, back = 5e-4 + rng.exponential(2e-4, 2)
            tick = int((asked + out) * hz * rate + 4.2e9) % (1 << 32)
            pairs.append(Pair(tick, asked, asked + out + back))
        found = clock_of(pairs, hz, 0.0)
        scores.append((found.rate - rate) / found.uncertainty)
    assert np.std(scores) < 1  # the bound on uneven delays is a limit, not a guess
    assert np.std(scores) > 0.1
    assert np.max(np.abs(scores)) < 3


def test_a_clock_that_was_measured_badly_falls_back_on_what_the_board_states() -> None:
    poor = clock_of([Pair(int(16e6 * k), float(k), k + 0.5 * (k % 2)) for k in range(12)], 16e6, 0)
    both = with_stated(poor, 1e-5)
    assert both.uncertainty < 1e-5
    assert both.rate == pytest.approx(1, abs=1e-5)


@pytest.mark.parametrize(
    ("declared", "word"), [(512, "four edges a line"), (8192, "only one"), (1000, "write 2048")]
)
def test_an_encoder_that_counts_otherwise_is_explained(declared: float, word: str) -> None:
    found = encoder_of(20485, -20481, 10, declared)
    assert not found.agrees
    assert word in " ".join(found.findings())


def test_an_encoder_that_agrees_backwards_and_that_loses_counts() -> None:
    assert encoder_of(20485, -20481, 10, 2048).findings() == []
    assert "counts down" in encoder_of(-20480, 20480, 10, 2048).findings()[0]
    assert "counts are lost" in " ".join(encoder_of(20480, -20100, 10, 2048).findings())
    with pytest.raises(UsageError, match="counted nothing"):
        encoder_of(0, 0, 10, 2048)


DISC = Disc(0.0975, 0.0001, 0.04, 2e-5)


def test_a_discs_inertia_and_its_uncertainty() -> None:
    assert DISC.inertia == pytest.approx(0.5 * 0.0975 * 0.02**2)
    share = math.hypot(0.0001 / 0.0975, 2 * 2e-5 / 0.04)
    assert DISC.uncertainty / DISC.inertia == pytest.approx(share)
    ring = Disc(0.0975, 0.0001, 0.04, 2e-5, 0.02, 2e-5)
    assert ring.inertia == pytest.approx(0.5 * 0.0975 * (0.02**2 + 0.01**2))


def test_a_gain_that_both_runs_share_does_not_vanish_in_their_difference() -> None:
    rotor, expected = 4e-6, DISC.inertia
    found = check_disc(
        Inertia(rotor, 1e-9, 0.002 * rotor),
        Inertia(rotor + 1.001 * expected, 1e-9, 0.002 * (rotor + expected)),
        DISC,
    )
    assert found.measured_uncertainty == pytest.approx(0.002 * expected, rel=0.02)
    assert found.outcome == "agrees"


def test_a_check_that_fails_names_what_could_do_it() -> None:
    rotor = 4e-6
    found = check_disc(
        Inertia(rotor * 1.05, 1e-9, 0.002 * rotor),
        Inertia((rotor + DISC.inertia) * 1.05, 1e-9, 0.002 * rotor),
        DISC,
    )
    assert found.outcome == "fails"
    says = found.says()
    assert "current's gain by a factor 1.05" in says
    assert "counts_per_turn (larger than it is) by a factor 1.02" in says
    narrowed = found.says({"current": 0.002, "encoder": 0.0005})
    assert "current's gain" not in narrowed
    assert "voltage's gain" in narrowed
    assert "slips" in found.says({"current": 0.002, "encoder": 0.0005, "terminal_voltage": 0.001})
