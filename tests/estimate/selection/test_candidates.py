"""What is asked before anything is fitted, and of a model with a single term."""

from __future__ import annotations

from typing import Any

import pytest

from motorid.estimate.model.extended_terms import TERMS
from motorid.estimate.selection import shaft_resonance
from motorid.estimate.selection.extended_fit import Fitted
from motorid.estimate.selection.revision import Revision
from motorid.estimate.selection.score_test import Tried
from motorid.estimate.solver.allowance import Allowance


def test_friction_has_no_negative_size_and_a_difference_has() -> None:
    assert Tried(TERMS["quadratic-load"], {}, ()).one_sided
    assert not Tried(TERMS["direction"], {}, ()).one_sided
    assert not Tried(TERMS["cogging"], {}, ()).one_sided  # its phase says the sign


def test_a_shaft_that_is_in_the_model_is_not_looked_for_again() -> None:
    nothing: Any = None
    assert shaft_resonance.springs([], nothing, {}, [TERMS["two-masses"]]) == []


def test_a_shaft_has_the_resonance_that_was_asked_for() -> None:
    shaft = shaft_resonance._shaft({"J": 2e-6}, 0.25, 300.0)
    J2 = 2e-6 * shaft["J2_share"]
    J1 = 2e-6 - J2
    assert (shaft["Ks"] * (1 / J1 + 1 / J2)) ** 0.5 == pytest.approx(300.0)


def test_a_single_term_has_nothing_older_to_be_looked_at_again() -> None:
    nothing: Any = None
    fitted = Fitted((TERMS["direction"],), (), nothing, (), {})
    revision = Revision((), Allowance(most=0.0))
    assert revision.of(fitted) is fitted
    assert revision.left_out == ()
