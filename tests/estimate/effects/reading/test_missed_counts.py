"""A counter that misses a share of its counts above a rate: physics, and a fit that finds it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, SPEED, Capture
from motorid.estimate.diagnosis.fault import Hypothesis
from motorid.estimate.diagnosis.faults import encoder_bandwidth
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.reading import missed_counts
from motorid.estimate.effects.reading.missed_counts import MISSED_COUNTS
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.status import Status
from tests.estimate.effects.benches import POINT, record, start, usual
from tests.exact_capture import FAULHABER, Plan, clean_capture, ended, noisy
from tests.six_parameters import fit

PLAN = Plan(volts=(6.0, -4.5, 3.0, -6.0, 1.5), count=4000)
TOP = 6.0 / FAULHABER["K"]  # rad/s
COUNTS = 2048  # a turn


def hypothesis(*records: MotorRecord) -> Hypothesis:
    (found,) = encoder_bandwidth.hypotheses(records)
    return found


def test_a_rate_has_a_place_within_half_a_step() -> None:
    for rate in (0.3, 1.0, 47.0, 900.0):
        near = missed_counts.rate_of(missed_counts.place_of(rate))
        assert near == pytest.approx(rate, rel=0.51 / missed_counts.STEPS)


def test_it_misses_at_rates_above_and_of_either_sign() -> None:
    rates = np.array([0.0, 90.0, 100.0, -100.0, 110.0, -1e6])
    share = missed_counts.missed_share(rates, 100.0)
    assert share == pytest.approx([0.0, 0.0, 0.5, 0.5, 1.0, 1.0], abs=1e-4)


def test_a_position_falls_behind_by_what_it_turned_above_the_rate() -> None:
    """2 s at 50 rad/s, 3 s at 200 rad/s, read at uneven times."""
    elapsed = np.array([0.5, 0.5, 1.5, 1.0, 1.0, 1.0])
    position = np.cumsum(elapsed * np.array([0.0, 50.0, 50.0, 200.0, 200.0, 200.0]))
    behind = missed_counts.behind(position, elapsed, 100.0)
    assert behind == pytest.approx([0.0, 0.0, 0.0, 200.0, 400.0, 600.0])


@pytest.mark.parametrize(("name", "block"), [("measured", POSITION), ("moving", SPEED)])
def test_its_quantity_acts_as_its_hypothesis(name: str, block: str) -> None:
    subject, own = record(name), start(record(name))
    guess = hypothesis(subject)
    rate = missed_counts.rate_of(missed_counts.place_of(0.7 * guess.sizes[-1][1]))
    place = missed_counts.place_of(rate)
    assert guess.place is not None
    assert guess.place(np.array([0.01, rate])) == place
    moved = subject.fitted(POINT, own, {Instance(MISSED_COUNTS, place): 0.01})
    change = dict(zip((m.block.name for m in subject.measured), moved, strict=True))
    found = guess.effect(subject, POINT, own, np.array([0.01, rate]))
    for m, expected in zip(subject.measured, found, strict=True):
        shown = change[m.block.name] - usual(name)[m.block.name]
        if m.block.name == block:
            assert shown == pytest.approx(expected, abs=1e-3 * np.abs(expected).max())
            assert np.abs(shown).max() > 1e-3 * np.ptp(usual(name)[block])
        elif m.block.name == CURRENT:
            assert not shown.any()
    assert MISSED_COUNTS.prior(subject, 0) is None  # no fit has it by itself


def test_chance_gives_it_a_variance_of_whole_cycles() -> None:
    """Of n cycles that are missed by chance, n is the variance too."""
    subject = record("measured")
    block = subject.block(POSITION)
    assert block is not None
    fine = replace(block, channel=replace(block.channel, resolution=1e-3))
    counted = subject.twin()
    counted.measured = tuple(fine if m is block else m for m in subject.measured)
    guess, size = hypothesis(counted), np.array([0.01, 100.0])
    assert guess.scatter is not None
    own = start(subject)
    of = [m.block.name for m in counted.measured].index(POSITION)
    cycles = guess.effect(counted, POINT, own, size)[of] / 4e-3
    assert guess.scatter(counted, POINT, own, size)[of] == pytest.approx(np.abs(cycles) * 4e-3**2)
    assert not guess.scatter(subject, POINT, own, size)[of].any()  # counts that nobody states
    assert "counts a second" in guess.words(size).evidence
    assert "counts a second" not in hypothesis(subject).words(size).evidence


def beside_a_counter(share: float, seed: int = 3) -> Capture:
    """Whose counter misses whole cycles by chance above .6 of the top speed."""
    capture = noisy(ended(clean_capture(FAULHABER, PLAN)), 1, 1e-3, 0.0)
    position = capture.channels[POSITION]
    step = 2.0 * math.pi / COUNTS
    moved = np.diff(position.values, prepend=0.0)
    fast = np.abs(moved) > 0.6 * TOP * capture.period_s
    cycles = np.random.default_rng(seed).poisson(share * np.abs(moved) / (4.0 * step))
    missed = np.cumsum(np.where(fast, np.sign(moved) * cycles * 4.0 * step, 0.0))
    shown = np.floor((position.values - missed) / step) * step
    counted = replace(position, raw=shown, resolution=step)
    return replace(capture, channels={**capture.channels, POSITION: counted})


@pytest.mark.slow
def test_a_fit_names_it_and_estimates_it_with_the_motor() -> None:
    found = fit([beside_a_counter(0.004)])
    (said,) = [s for s in found.suspects if s.strength == "named"]
    assert (said.code, said.allowed) == ("counts_missed", True)
    size = found.nuisance[MISSED_COUNTS.name]
    assert size.total is not None
    assert size.value == pytest.approx(0.004, abs=4.0 * size.total)
    assert size.total < 0.002
    for name in ("R", "K", "J", "T0"):
        p = found.parameters[name]
        assert p.total is not None
        assert p.status is Status.ESTIMATED
        assert p.value == pytest.approx(FAULHABER[name], abs=3.0 * p.total)


@pytest.mark.slow
def test_a_counter_that_follows_is_not_accused() -> None:
    assert [s.code for s in fit([beside_a_counter(0.0)]).suspects if s.strength == "named"] == []
