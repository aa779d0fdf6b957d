"""What an answer is made of: standings, curves, and findings that can stand in a set."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.estimate.results.estimate import (
    MEANING,
    PARAMETERS,
    UNITS,
    Alternative,
    Curve,
    Diagnostic,
    Suspect,
)
from motorid.estimate.results.status import Status
from tests.report import example


@pytest.mark.parametrize(
    ("status", "measured", "unknown"),
    [
        (Status.ESTIMATED, True, False), (Status.DOUBTFUL, True, False),
        (Status.FIXED, False, False), (Status.AT_BOUND, False, False),
        (Status.NOT_IDENTIFIABLE, False, True), (Status.NOT_SUPPORTED, False, True),
    ],
)  # fmt: skip
def test_a_standing_says_whether_the_data_gave_a_value(
    status: Status, measured: bool, unknown: bool
) -> None:
    assert (status.measured, status.unknown) == (measured, unknown)


def test_a_smooth_curve_is_the_fitted_one_without_its_ripple() -> None:
    zeros, fitted, ripple = np.zeros(3), np.array([1.0, 2.0, 3.0]), np.array([0.1, -0.2, 0.0])
    plain = Curve(0, "current", "A", zeros, zeros, fitted, 0.1)
    assert plain.smooth is fitted
    assert replace(plain, ripple=ripple).smooth == pytest.approx([0.9, 2.2, 3.0])


def test_findings_are_alike_by_their_words_and_moves_and_stand_in_sets() -> None:
    one = Diagnostic("code", "info", "words", {"R": 1.0}, {"R": (0.0, 1.0)})
    same = Diagnostic("code", "info", "words", {"R": 1.0}, {"R": (0.0, 1.0)})
    assert {one, same} == {one}
    assert one not in {replace(one, moves={"R": 2.0}), replace(one, sides={})}
    suspect = Suspect("code", "where", "seen", "mend", "named", {"R": 1.0}, False, {"R": 2.0})
    assert {suspect, replace(suspect)} == {suspect}
    assert suspect not in {replace(suspect, without={}), replace(suspect, allowed=True)}


def test_what_is_not_given_is_nothing() -> None:
    """Findings without moves, answers without levels: each has its own."""
    one, other = Diagnostic("a", "info", ""), Diagnostic("b", "info", "")
    assert one.moves == one.sides == {}
    assert one.moves is not other.moves
    suspect = Suspect("code", "where", "seen", "mend", "named")
    assert (suspect.moves, suspect.allowed, suspect.without) == ({}, False, {})
    wider = Alternative("auto", (), (), (), False, {}, {}, 1.0, 1, 1, ())
    assert (wider.trials, wider.at_25) == ((), {})
    answer = example.estimate()
    assert repr(answer) == answer.brief()
    assert "Estimate(" not in repr(answer)


def test_every_parameter_has_a_unit_and_a_meaning() -> None:
    assert list(UNITS) == list(MEANING) == list(PARAMETERS)
