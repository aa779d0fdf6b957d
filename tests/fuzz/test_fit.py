"""Captures damaged beyond sense: each is fitted in finite numbers, or refused in one sentence."""

from __future__ import annotations

import random
from dataclasses import replace
from unittest import mock

import numpy as np
import pytest

from motorid import identify
from motorid.estimate.diagnosis.data_remarks import COARSER
from motorid.estimate.results.estimate import AUTO
from motorid.estimate.signals.time_grid import TICKS_PER_SAMPLE, lay
from tests.fuzz.fit_checks import check, seeds
from tests.fuzz.fit_damage import BASES, base, damaged, drawn
from tests.six_parameters import fit

QUICK = ("locked-rotor", "coast-down", "tachometer", "no-current", "steps")


DEAR = "steps | run speed"  # is searched for a second, and refused
SEEDS = [
    pytest.param(line, marks=pytest.mark.slow if line.startswith(DEAR) else ()) for line in seeds()
]


@pytest.mark.parametrize("line", SEEDS)
def test_what_was_found_once_holds(line: str) -> None:
    check(line)


@pytest.mark.slow
def test_a_little_of_what_the_fuzzer_does() -> None:
    rng = random.Random(7)
    words = set()
    with mock.patch("tests.fuzz.fit_damage.BASES", QUICK):
        for _ in range(12):
            words.add(check(drawn(rng), AUTO).word)
    assert words == {"fitted", "refused"}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["steps", "locked-rotor", "exact"])
def test_what_is_damaged_was_good(name: str) -> None:
    assert name in BASES
    assert check(name).word == "fitted"


@pytest.mark.slow
def test_a_broken_promise_is_seen() -> None:
    """A fit that answers with NaN, and one that warns."""
    good = fit([base("steps")])
    resistance = replace(good.parameters["R"], value=float("nan"))
    bad = replace(good, parameters={**good.parameters, "R": resistance})
    broken = pytest.raises((AssertionError, ValueError))
    with mock.patch("tests.fuzz.fit_checks.fit", return_value=bad), broken:
        check("steps")

    def overflows(*_: object, **__: object) -> np.float64:
        return np.float64(1e300) ** 2

    with mock.patch.object(identify, "_fit", overflows), pytest.raises(RuntimeWarning):
        check("steps")


def test_a_log_in_close_pairs_costs_no_grid_of_its_closest() -> None:
    capture = damaged("steps | ticks pairs")
    line = lay(capture)
    assert line.coarser > COARSER
    assert line.count <= TICKS_PER_SAMPLE * len(capture) + 2
    assert lay(base("steps")).coarser == lay(base("random-stamps")).coarser == 1.0
