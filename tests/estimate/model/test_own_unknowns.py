"""Which quantities a capture has among its unknowns, which beside them, and how priors follow."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from motorid.estimate.effects.influence_quantity import Instance, Prior, Use
from motorid.estimate.effects.reading.current_gain import CURRENT_GAIN
from motorid.estimate.effects.reading.current_offset import CURRENT_OFFSET
from motorid.estimate.effects.source.held_inductance import HELD_INDUCTANCE
from motorid.estimate.model import own_unknowns
from motorid.estimate.solver.problem import Unknown
from tests.estimate.effects.benches import record


def test_a_quantity_is_of_its_use_where_it_is_there() -> None:
    one = record("measured")
    estimated = {i.quantity for i, _ in own_unknowns.of_use(Use.ESTIMATED, one)}
    carried = {i.quantity for i, _ in own_unknowns.of_use(Use.PROPAGATED, one)}
    assert CURRENT_OFFSET in estimated
    assert CURRENT_GAIN in carried
    assert not estimated & carried
    assert HELD_INDUCTANCE not in estimated | carried  # nothing declares it


def test_those_that_are_not_there_are_left_out() -> None:
    found = own_unknowns.there(
        [Instance(HELD_INDUCTANCE), Instance(CURRENT_GAIN)], record("measured")
    )
    assert [one.quantity for one, _ in found] == [CURRENT_GAIN]


class Given:
    """A quantity somewhere, of that prior."""

    place = 0

    def __init__(self, prior: Prior | None) -> None:
        self.quantity = SimpleNamespace(prior=lambda *_: prior)


def test_priors_follow_what_drives_the_motor_but_of_what_was_found() -> None:
    follows, found, gone = Given(Prior(2.0, 3.0)), Given(Prior(2.0, 3.0)), Given(None)
    before = Unknown("x", 1.0, lower=-5.0, upper=5.0, prior_mean=0.5, prior_sd=9.0)
    pairs: Any = [(one, before) for one in (follows, found, gone)]
    known: Any = {found}
    after, *others = own_unknowns.renewed(pairs, record("measured"), known)
    assert (after.prior_mean, after.prior_sd) == (3.0, 2.0)
    assert (after.start, after.lower, after.upper) == (1.0, -5.0, 5.0)
    assert others == [before, before]
