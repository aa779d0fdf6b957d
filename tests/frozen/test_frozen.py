"""The estimates of a fixed corpus are what they were: each number, each word."""

from __future__ import annotations

import pytest

from tests.frozen import answers, compare, fits
from tests.frozen.answers import WIDEST
from tests.frozen.cases import CASES
from tests.frozen.perturb import SEEDS, shaken

# Rounding alone moves these beyond the tolerance, so that another machine has another answer. They
# are left out here, and compared bit for bit by ``make frozen AGAINST=commit`` only.
UNSETTLED = {
    "brushes-and-cogging": "the wider model gets other terms, and T_s moves by 0.2 u",
    "drawn-12": "what rounding moves, 0.009 u, is next to the limit",
    "drawn-903": "what rounding moves is up to 0.3 u: no reading shows its L",
    "drawn-930": "what rounding moves is up to 0.02 u",
    "drawn-1123": "the search of an L that no reading shows takes other turns",
    "drawn-1449": "the drop of the wider model moves by 0.011 u",
    "log-drop-outs": "the search is said not to settle",
    "log-position": "the interval of its voltage's lag moves by 0.012 u",
}
SETTLED = {case.name: case for case in CASES if case.name not in UNSETTLED}
CHEAP = [name for name, case in SETTLED.items() if not case.dear]
# Each takes about a fifth of a second or less, so that the quick suite sees an answer that moves:
# a bridge and a log of every kind.
QUICK = {
    "diode-decay",
    "fast-decay",
    "wrong-counts",
    "sim-re35",
    "sim-pittman",
    "emulated-uno",
    "log-steps",
    "log-means",
    "log-motionless",
    "log-locked-rotor",
    "log-mechanical",
    "log-no-current",
    "log-coast-down",
    "log-tachometer",
}
EACH = [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in SETTLED]


def test_the_unsettled_and_the_quick_are_cases() -> None:
    assert {case.name for case in CASES} >= UNSETTLED.keys()
    assert SETTLED.keys() >= QUICK


@pytest.mark.parametrize("name", EACH)
def test_a_case_gives_the_recorded_answer(name: str) -> None:
    recorded = answers.load(name)
    found = compare.beyond(name, recorded.values, fits.here(name).values, recorded.tolerance)
    assert not found, "\n" + compare.table(found)


@pytest.mark.slow
@pytest.mark.parametrize(
    "seed", [SEEDS[0], *(pytest.param(seed, marks=pytest.mark.study) for seed in SEEDS[1:])]
)
@pytest.mark.parametrize("name", CHEAP)
def test_rounding_moves_no_answer(name: str, seed: int) -> None:
    """As another machine's: by no more than .01 u, and no word."""
    recorded = answers.load(name).values
    found = compare.beyond(name, recorded, shaken(SETTLED[name], seed), lambda path: WIDEST)
    assert not found, "\n" + compare.table(found)
