"""Blocks of a record: means by hand, which are driven and settled, and which tell nothing."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.fit import block_regression, sign_check
from motorid.estimate.fit.block_regression import BLOCK, FEWEST, Blocks, blocks
from tests.estimate.fit.read_record import PERIOD_S, record

COUNT = 10 * BLOCK + 5  # of which the last whole block has no end
MIDDLES = BLOCK * np.arange(9) + (BLOCK - 1) / 2.0  # samples


def turning(count: int = COUNT, moving: str = "position", **how: Any) -> Any:
    """A current of .5 A that rises by .01 A a sample, a speed of 3 rad/s that does by 40 rad/s²."""
    at = np.arange(float(count))
    keep = np.append(np.arange(0, count - 1, 2), count - 1)
    t = PERIOD_S * at
    turned = {"position": 3.0 * t + 20.0 * t**2, "speed": 3.0 + 40.0 * t}
    current = (keep, (0.5 + 0.01 * at)[keep])
    return record(count, **how, current=current, **{moving: (np.arange(count), turned[moving])})


def test_blocks_are_means_of_their_samples() -> None:
    """Volts at the terminals behind .5 ohm; the current less its offset at rest, of .2 A."""
    found = blocks([turning()])
    assert found is not None
    amperes = 0.3 + 0.01 * MIDDLES
    assert found.current == pytest.approx(amperes)
    assert found.volts == pytest.approx(2.0 + 0.1 * MIDDLES - 0.5 * amperes)
    block_s = BLOCK * PERIOD_S
    assert found.speed == pytest.approx(3.0 + 40.0 * block_s * (np.arange(9) + 0.5))
    assert found.acceleration == pytest.approx(40.0)
    assert found.period_s.tolist() == [block_s]
    assert found.runs == (slice(0, 9),)


def test_a_current_without_an_unknown_offset_is_as_it_was_read() -> None:
    one = turning()
    one.unknowns = ()
    found = blocks([one])
    assert found is not None
    assert found.current == pytest.approx(0.5 + 0.01 * MIDDLES)


def test_a_measured_speed_is_the_mean_of_its_readings() -> None:
    found = blocks([turning(moving="speed")])
    assert found is not None
    assert found.speed == pytest.approx(3.0 + 40.0 * PERIOD_S * MIDDLES)
    assert found.acceleration == pytest.approx(40.0)


def test_a_position_comes_before_a_speed() -> None:
    one = turning()
    one.measured.append(turning(moving="speed").measured[1])
    one.measured[2].values = np.full(COUNT, 7.0)
    found = blocks([one])
    assert found is not None
    assert found.speed[0] == pytest.approx(3.0 + 40.0 * BLOCK * PERIOD_S / 2.0)


def test_a_block_is_driven_throughout_and_settled_away_from_a_command() -> None:
    one = turning(parts=(0, 100))
    one.driven[10] = False
    found = blocks([one])
    assert found is not None
    assert found.driven.tolist() == [False] + [True] * 8
    assert np.flatnonzero(found.settled).tolist() == [2, 3, 4, 8]  # 100 is in the sixth, of 96 on
    one = turning()
    one.driven[4 * BLOCK :] = False
    found = blocks([one])
    assert found is not None
    assert np.flatnonzero(found.settled).tolist() == [2, 3]


def test_records_follow_each_other_each_with_its_run() -> None:
    short = turning(9 * BLOCK)
    short.timeline.period_s = 2.0 * PERIOD_S
    found = blocks([short, turning()])
    assert found is not None
    assert found.runs == (slice(0, 8), slice(8, 17))
    assert found.period_s == pytest.approx([2.0 * BLOCK * PERIOD_S, BLOCK * PERIOD_S])
    assert found.current[8] == pytest.approx(0.3 + 0.01 * MIDDLES[0])
    assert blocks([]) is None


def test_every_record_needs_a_signed_current_a_motion_and_some_length() -> None:
    good = turning()
    still, dead = turning(), turning()
    del still.measured[1]
    del dead.measured[0]
    short = turning(BLOCK * (FEWEST + 1) - 1)
    for one in (still, dead, short, turning(unsigned=True)):
        assert blocks([one]) is None
        assert blocks([good, one]) is None
    assert blocks([turning(BLOCK * (FEWEST + 1))]) is not None


def laws(current: float = 1.0, speed: float = 1.0, volts: float = 1.0, n: int = 60) -> Blocks:
    """Blocks of a motor whose channels have these signs, with noise of a thousandth."""
    rng = np.random.default_rng(5)
    t = np.arange(n)
    w = 100.0 * np.sin(t / 5.0) + 60.0
    turned = np.gradient(w)
    i = 0.02 * turned + 1e-3 * w + 0.2 * np.sign(w)
    v = 2.0 * i + 0.05 * w
    noise = 1.0 + 1e-3 * rng.standard_normal((2, n))
    whole = np.ones(n, dtype=bool)
    return Blocks(
        volts * v * noise[0], current * i * noise[1], speed * w, speed * turned, whole, whole,
        (slice(0, n),), np.array([1.0]),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("signs", "which"),
    [
        ({}, ""), ({"current": -1.0}, "current"), ({"speed": -1.0}, "encoder"),
        ({"volts": -1.0}, "voltage"), ({"current": -1.0, "speed": -1.0}, "voltage"),
        ({"n": FEWEST}, ""), ({"n": FEWEST, "volts": -1.0}, "voltage"),
        ({"n": FEWEST - 1, "volts": -1.0}, ""),
    ],
)  # fmt: skip
def test_two_of_three_coefficients_below_nothing_name_a_channel(
    signs: dict[str, Any], which: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sign_check, "blocks", lambda _: laws(**signs))
    assert sign_check.wrong([]) == which


def test_a_coefficient_within_its_noise_names_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not even where the two that would tell are clear: the third may have any sign."""
    turned = laws(volts=-1.0)
    spoilt = np.random.default_rng(1).standard_normal(60) * 50.0
    noisy = replace(turned, acceleration=spoilt)
    monkeypatch.setattr(sign_check, "blocks", lambda _: noisy)
    assert sign_check.wrong([]) == ""
    monkeypatch.setattr(sign_check, "blocks", lambda _: None)
    assert sign_check.wrong([]) == ""


@pytest.mark.parametrize(("R", "K"), [(-2.0, 0.05), (2.0, -0.05)])
def test_neither_constant_may_be_below_nothing(R: float, K: float) -> None:
    b = laws()
    turned = replace(b, volts=R * b.current + K * b.speed)
    assert block_regression.electrical(turned, b.settled) is None
    assert block_regression.usual(turned) is None


def test_blocks_that_are_not_asked_for_have_no_word() -> None:
    """In either law; and what departs is measured by the median of those that are settled."""
    b = laws()
    exact = 2.0 * b.current + 0.05 * b.speed
    use = np.arange(60) >= 20
    spoilt = replace(b, volts=np.where(use, exact, 5.0 * exact), settled=use)
    assert block_regression.usual(spoilt) == pytest.approx((2.0, 0.05))
    torque = 3.0 * b.acceleration + 0.5 * b.speed + 2.0 * np.sign(b.speed)
    other = replace(b, current=np.where(use, torque, -torque))
    found = block_regression.mechanical(other, 0.1, use)
    assert found == pytest.approx({"J": 0.3, "B": 0.05, "T0": 0.2})
