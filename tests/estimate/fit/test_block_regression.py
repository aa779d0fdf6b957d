"""The motor's laws on blocks: against numpy's least squares, with blocks that depart."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.estimate.diagnosis.faults import load_slip
from motorid.estimate.fit import block_regression
from motorid.estimate.fit.block_regression import Blocks

R, K, B, J, T0 = 2.0, 0.05, 4e-5, 2e-5, 6e-3
BLOCK_S, MOST, SHARE = 1e-3, 900.0, 0.4  # the load's acceleration; its share of the inertia


def motion() -> np.ndarray:
    """Steps both ways, as a motor answers them: (n,) rad/s of the shaft's blocks."""
    t = BLOCK_S * np.arange(120)
    up = 150 * (1 - np.exp(-t / 0.02))
    return np.concatenate([up, up[-1] * np.exp(-t / 0.02), -up, -up[-1] * np.exp(-t / 0.02)])


def of(speed: np.ndarray, share: float = 0.0) -> Blocks:
    """Blocks that obey the laws to the last digit; ``share`` of the inertia may slip."""
    acceleration = np.gradient(speed) / BLOCK_S
    behind = np.gradient(speed - load_slip.followed(speed, MOST * BLOCK_S)) / BLOCK_S
    torque = J * acceleration - share * J * behind + B * speed + T0 * np.sign(speed)
    current, n = torque / K, len(speed)
    driven = np.ones(n, dtype=bool)
    return Blocks(
        R * current + K * speed, current, speed, acceleration, driven, driven.copy(),
        (slice(0, n),), np.array([BLOCK_S]),
    )  # fmt: skip


def test_squares_are_those_of_numpy() -> None:
    rng = np.random.default_rng(1)
    columns, target = rng.normal(size=(40, 3)) * [1.0, 1e3, 1e-4], rng.normal(size=40)
    left, found, over = block_regression.squares(columns, target)
    wanted, (rest,), *_ = np.linalg.lstsq(columns, target, rcond=None)
    assert found == pytest.approx(wanted)
    assert left == pytest.approx(rest)
    variances = np.diag(np.linalg.inv(columns.T @ columns)) * rest / (40 - 3)
    assert over == pytest.approx(wanted / np.sqrt(variances))


def test_settled_blocks_give_resistance_and_constant() -> None:
    b = of(motion())
    assert block_regression.electrical(b, b.settled) == pytest.approx((R, K))
    few = np.arange(len(b.speed)) < block_regression.FEWEST - 1
    assert block_regression.electrical(b, few) is None
    assert block_regression.electrical(replace(b, volts=-b.volts), b.settled) is None


def test_blocks_that_depart_from_the_others_are_left_out() -> None:
    b = of(motion())
    noisy = b.volts + 1e-3 * np.random.default_rng(2).normal(size=len(b.volts))
    noisy[::9] *= 0.5
    spoilt = replace(b, volts=noisy)
    plain = block_regression.electrical(spoilt, spoilt.settled)
    trimmed = block_regression.usual(spoilt)
    assert plain is not None
    assert abs(plain[1] / K - 1) > 0.02
    assert trimmed == pytest.approx((R, K), rel=2e-3)


def test_the_mechanical_law_gives_inertia_and_friction() -> None:
    b = of(motion())
    whole = np.ones(len(b.speed), dtype=bool)
    assert block_regression.mechanical(b, K, whole) == pytest.approx({"J": J, "B": B, "T0": T0})
    turned = replace(b, current=-b.current)
    assert block_regression.mechanical(turned, K, whole) == {"J": 0.0, "B": 0.0, "T0": 0.0}


def test_a_load_follows_no_faster_than_it_is_held() -> None:
    speed = np.array([0.0, 1.0, 4.0, 4.0, 4.0, 2.0])
    assert load_slip.followed(speed, 1.5) == pytest.approx([0.0, 1.0, 2.5, 4.0, 4.0, 2.5])


def test_a_slipping_load_is_seen_with_its_share_and_its_rate() -> None:
    found = load_slip.start(of(motion(), SHARE))
    assert found is not None
    share, rate = found.size
    assert share == pytest.approx(SHARE, abs=0.05)
    assert rate == pytest.approx(MOST, rel=0.15)  # the rates that are tried are 25 % apart
    assert found.motor["J"] == pytest.approx(J, rel=0.1)
    assert found.motor["R"] == pytest.approx(R, rel=1e-6)
    assert found.motor["K"] == pytest.approx(K, rel=1e-6)


def test_a_load_that_holds_is_not_accused() -> None:
    b = of(motion())
    noise = 1e-3 * np.random.default_rng(3).normal(size=len(b.speed))
    assert load_slip.start(replace(b, current=b.current + noise)) is None


def test_a_load_beyond_the_inertia_is_no_load() -> None:
    assert load_slip.start(of(motion(), 1.3)) is None
    assert load_slip.start(of(motion(), 0.02)) is None


def test_a_motor_needs_so_many_blocks() -> None:
    b = of(motion())
    enough = np.arange(len(b.speed)) < block_regression.FEWEST
    assert block_regression.electrical(b, enough) == pytest.approx((R, K))
    assert block_regression.FEWEST >= 3  # two unknowns, and one to see whether they fit


@pytest.mark.parametrize(("share", "rate"), [(0.3, 500.0), (0.05, 40.0), (0.9, 2e4)])
def test_a_slipping_load_is_looked_for_about_where_the_blocks_show_it(
    share: float, rate: float
) -> None:
    begin = load_slip.Start((share, rate), {})
    found = load_slip._hypothesis([], begin)
    assert found.sizes == ((share, rate),)
    for size, scale, low, high in zip(
        found.sizes[0], found.scale, found.lower, found.upper, strict=True
    ):
        assert low < size < high
        assert 0.0 < scale <= high - low
    assert found.lower[0] <= load_slip.LEAST_SHARE
    assert 0.9 < found.upper[0] < 1.0  # the rotor itself has some inertia
    assert found.upper[1] / rate == pytest.approx(rate / found.lower[1])  # alike both ways
    words = found.words(np.array([share, rate]))
    assert f"{100 * share:.0f} % of the inertia" in words.evidence
    assert f"at {rate:.3g} rad/s²" in words.evidence


def test_a_load_that_does_not_slip_shows_no_share() -> None:
    assert load_slip.start(of(motion())) is None
    for share in (0.02, 0.2, 0.6):
        begun = load_slip.start(of(motion(), share))
        assert (begun is not None) is (share > load_slip.LEAST_SHARE)
        if begun is not None:
            assert begun.size == pytest.approx((share, MOST), rel=0.25)
            assert begun.motor["R"] == pytest.approx(R, rel=0.1)
