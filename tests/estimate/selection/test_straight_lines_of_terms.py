"""What terms gain and where they begin, against least squares over all that is unknown at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from motorid.estimate.model.extended_terms import TERMS, Term
from motorid.estimate.selection import joint_start, score_test
from motorid.estimate.selection.score_test import Candidate, Tried, begins, sums_of
from motorid.estimate.solver.problem import Block, Linearised, Unknown

Floats = NDArray[np.float64]
RNG = np.random.default_rng(12)
SIGMAS = ((0.5, 2.0), (1.5, 0.25))
LENGTHS = (40, 30)
DIRECTION, LOAD, COGGING = TERMS["direction"], TERMS["quadratic-load"], TERMS["cogging"]


def line(k: int) -> Linearised:
    """A record of two blocks, two shared parameters and an own nuisance with a prior."""
    n = sum(LENGTHS)
    shared, own = RNG.standard_normal((n, 2)), RNG.standard_normal((n, 1))
    precision = np.array([3.0 * k])
    inverse = 1.0 / (float(own[:, 0] @ own[:, 0]) + precision[0])
    orthogonal = shared - own @ (inverse * own.T @ shared)
    return Linearised(
        RNG.standard_normal(n), shared, own, orthogonal, precision,
        (Block("a", 1e-9, 40), Block("b", 1e-9, 30)), (slice(0, 40), slice(40, 70)),
        np.array(SIGMAS[k]),
    )  # fmt: skip


LINES = (line(0), line(1))


def solution() -> Any:
    information = sum(part.orthogonal.T @ part.shared for part in LINES)
    unknowns = (Unknown("R", 2.0, log=True), Unknown("T0", 0.1))
    return SimpleNamespace(records=LINES, information=information, unknowns=unknowns,
                           slopes=np.array([2.0, 1.0]), values=np.array([2.0, 0.1]))  # fmt: skip


def tried(term: Term, q: int = 1) -> Tried:
    return Tried(term, {}, tuple(RNG.standard_normal((q, sum(LENGTHS))) for _ in LINES))


def design(terms: Sequence[Tried], apart: Sequence[bool]) -> tuple[Floats, Floats]:
    """Columns of shared, own and sizes over all readings and priors, and what is left of them."""
    widths = [len(t.changes[0]) * (2 if a else 1) for t, a in zip(terms, apart, strict=True)]
    total = 4 + sum(widths)
    rows, left = [], []
    for k, one in enumerate(LINES):
        table = np.zeros((sum(LENGTHS), total))
        table[:, :2], table[:, 2 + k] = one.shared, one.own[:, 0]
        first = 4
        for term, own, width in zip(terms, apart, widths, strict=True):
            q = len(term.changes[k])
            at = first + (k * q if own else 0)
            table[:, at : at + q] = term.changes[k].T / np.repeat(one.sigmas, LENGTHS)[:, None]
            first += width
        prior = np.zeros((1, total))
        prior[0, 2 + k] = np.sqrt(one.own_precision[0])
        rows += [table, prior]
        left += [one.residual, np.zeros(1)]
    return np.concatenate(rows), np.concatenate(left)


def least(table: Floats, left: Floats) -> tuple[Floats, float]:
    found = np.linalg.lstsq(table, left, rcond=None)[0]
    rest = left - table @ found
    return found, float(rest @ rest)


def test_several_terms_at_once_are_least_squares_beside_all_else() -> None:
    terms = [tried(DIRECTION), tried(COGGING, 2), tried(LOAD)]
    lines = joint_start._Lines(terms, solution())
    two = [terms[0], terms[1]]
    found, left = least(*design(two, [False, True]))
    _, without = least(design(two, [False, True])[0][:, :4], design(two, [False, True])[1])
    assert lines.gain([0, 1]) == pytest.approx(without - left)
    sizes = lines.sizes([0, 1])
    assert sizes[0] == pytest.approx(found[4:5])
    assert sizes[1] == pytest.approx(found[5:9])  # two of each record


def test_what_one_promises_beside_another_is_what_only_it_explains() -> None:
    one, other = tried(DIRECTION), tried(COGGING, 2)
    table, left = design([one, other], [False, True])
    gain = least(np.delete(table, 4, axis=1), left)[1] - least(table, left)[1]
    a, b = (Candidate(t.term, 1.0, {}, {}, (), t.changes) for t in (one, other))
    assert joint_start.beside(a, b, solution()) == pytest.approx(gain)
    twin = replace(a, changes=tuple(-2.0 * c for c in one.changes))
    assert joint_start.beside(a, twin, solution()) == pytest.approx(0.0, abs=1e-6)


def alone(one: Tried, gain: float, scale: float) -> Candidate:
    """As a screen has it: ``gain`` is said, its size counted in ``scale``."""
    table, left = design([one], [False])
    start = {one.term.size: scale * float(least(table, left)[0][4])}
    return Candidate(one.term, gain, {}, start, (), one.changes)


def test_two_that_promise_most_together_begin_where_least_squares_see_both() -> None:
    """Not the two that promise most one by one; parameters follow both."""
    stall = TERMS["stribeck"]
    one, load, idle = tried(DIRECTION), tried(LOAD), tried(stall)
    hidden = tuple(
        one_line.residual * np.repeat(one_line.sigmas, LENGTHS) - a[0]
        for one_line, a in zip(LINES, one.changes, strict=True)
    )  # what the first leaves of the residual
    load = Tried(LOAD, {}, tuple(c[None] for c in hidden))
    table, left = design([load, one], [False, False])
    found, rest = least(table, left)
    before, whole = least(table[:, :4], left)
    assert min(found[4:]) > 0.0
    each = [alone(one, 7.0, 3.0), alone(load, 8.0, 0.5), alone(idle, 99.0, 1.0)]
    assert (both := joint_start.pair([*each, alone(tried(COGGING, 2), 5.0, 1.0)], solution()))
    assert both.terms == (LOAD, DIRECTION)
    assert both.gain == pytest.approx(whole - rest)
    assert both.start == pytest.approx({"T_lc": 0.5 * found[4], "d_T0": 3.0 * found[5]})
    moves = found[:2] - before[:2]
    assert both.shift == pytest.approx({"R": 2.0 * moves[0], "T0": moves[1]})
    assert [len(c) for c in both.changes] == [2, 2]
    assert both.changes[1][0] == pytest.approx(one.changes[1][0])
    assert joint_start.pair(each[:1], solution()) is None
    assert joint_start.pair([], solution()) is None


def test_a_size_that_cannot_be_below_nothing_is_none_or_more() -> None:
    one, load = tried(DIRECTION), tried(LOAD)
    for way in (1.0, -1.0):  # of which one is against reason
        terms = [one, Tried(LOAD, {}, tuple(way * c for c in load.changes))]
        lines = joint_start._Lines(terms, solution())
        table, left = design(terms, [False, False])
        lower = np.r_[np.full(5, -np.inf), 0.0]
        best = lsq_linear(table, left, (lower, np.full(6, np.inf)), tol=1e-14).x
        sizes = lines.sizes([0, 1])
        assert sizes[0] == pytest.approx(best[4:5], rel=1e-5)
        assert sizes[1][0] == pytest.approx(max(best[5], joint_start.FAINT), rel=1e-5)
        rest = left - table @ best
        _, without = least(table[:, :4], left)
        assert lines.gain([0, 1]) == pytest.approx(without - float(rest @ rest), rel=1e-5)


def test_sums_are_cleared_of_the_records_own_nuisance() -> None:
    changes = RNG.standard_normal((2, sum(LENGTHS)))
    one = LINES[1]
    sums = sums_of(changes, one)
    table = (changes / np.repeat(one.sigmas, LENGTHS)).T
    own = np.vstack([one.own, np.sqrt(one.own_precision)[None]])
    hat = own @ np.linalg.pinv(own)
    wide, left = np.vstack([table, np.zeros((1, 2))]), np.append(one.residual, 0.0)
    clear = wide - hat @ wide
    assert sums.squares == pytest.approx(clear.T @ clear)
    assert sums.pull == pytest.approx(clear.T @ (left - hat @ left))
    assert sums.shared == pytest.approx(table.T @ one.orthogonal)
    part = sums.of(slice(1, 2))
    assert part.squares == pytest.approx(sums.squares[1:, 1:])
    assert part.pull == pytest.approx(sums.pull[1:])
    assert part.shared == pytest.approx(sums.shared[1:])


def test_the_score_of_a_term_is_its_gain_and_what_it_moves() -> None:
    one = tried(DIRECTION)
    probe: Any = SimpleNamespace(
        names=("R", "T0"), scales=SimpleNamespace(of=lambda _: 0.25), records=LINES
    )
    (found,) = score_test._Test(probe, solution()).all([one])
    table, left = design([one], [False])
    sizes, rest = least(table, left)
    before, without = least(table[:, :4], left)
    assert found.gain == pytest.approx(without - rest)
    assert found.start == pytest.approx({DIRECTION.size: 0.25 * sizes[4]})
    # beside the term, from where the search stands: what it leaves is as good as nothing
    moves = sizes[:2] - before[:2]
    assert found.shift == pytest.approx({"R": 2.0 * moves[0], "T0": moves[1]})
    assert score_test._Test(probe, solution()).all([]) == []


def test_a_term_that_the_parameters_say_already_is_none() -> None:
    same = Tried(DIRECTION, {}, tuple(
        (part.shared[:, :1] * np.repeat(part.sigmas, LENGTHS)[:, None]).T for part in LINES
    ))  # fmt: skip
    probe: Any = SimpleNamespace(
        names=("R", "T0"), scales=SimpleNamespace(of=lambda _: 1.0), records=LINES
    )
    assert score_test._Test(probe, solution()).all([same]) == []


def test_friction_below_nothing_is_no_candidate() -> None:
    probe: Any = SimpleNamespace(
        names=("R", "T0"), scales=SimpleNamespace(of=lambda _: 1.0), records=LINES
    )
    one = tried(LOAD)
    other = Tried(LOAD, {}, tuple(-c for c in one.changes))
    found = score_test._Test(probe, solution()).all([one, other])
    assert len(found) == 1
    assert found[0].start[LOAD.size] > 0.0


def test_a_phase_of_each_record_begins_at_the_angle_of_its_two_sizes() -> None:
    probe: Any = SimpleNamespace(scales=SimpleNamespace(of=lambda _: 0.1), records=LINES)
    one = tried(COGGING, 2)
    start, own = begins(probe, one, np.array([3.0, 4.0, 0.0, -7.0]))
    assert start[COGGING.size] == pytest.approx(0.1 * (5.0 + 7.0) / 2)
    phases = (np.arctan2(4.0, 3.0), -np.pi / 2)
    assert list(own) == [COGGING.phased(float(p)) for p in phases]
    ripple = tried(TERMS["ripple"], 4)
    start, _ = begins(probe, ripple, np.array([2.0, 0.0, 1.0, 0.0, 0.0, 4.0, 0.0, -1.0]))
    assert start[TERMS["ripple"].size] == pytest.approx(0.1 * 3.0)
    assert start["k_R"] == pytest.approx((2.0 * 1.0 - 4.0 * 1.0) / 2 / 3.0)


def test_own_sizes_are_added_to_what_a_record_has() -> None:
    one = score_test.Candidate(COGGING, 1.0, {}, {}, ({"a": 1.0}, {"a": 2.0}))
    assert one.beside([{"b": 5.0}, {"a": 9.0}]) == [{"b": 5.0, "a": 1.0}, {"a": 2.0}]
    bare = score_test.Candidate(COGGING, 1.0, {}, {})
    assert bare.beside([{"b": 5.0}]) == [{"b": 5.0}]


def test_of_the_shapes_of_a_term_that_which_suits_the_others_best_begins(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Two shapes of one term; the second is most of the residual."""
    weak = tried(DIRECTION)
    strong = Tried(DIRECTION, {"x": 2.0}, tuple(
        ((part.residual + 0.1 * RNG.standard_normal(70)) * np.repeat(part.sigmas, LENGTHS))[None]
        for part in LINES
    ))  # fmt: skip
    other = tried(LOAD)
    monkeypatch.setattr(joint_start, "Probe", lambda *_: "probe")
    asked: list[Any] = []

    def everything(_: Any, terms: Any) -> list[Tried]:
        asked.append([t.name for t in terms])
        return [weak, strong, other]

    monkeypatch.setattr(joint_start, "everything", everything)
    monkeypatch.setattr(joint_start, "begins", lambda _, one, sizes: (one.shape, sizes))
    terms = [DIRECTION, LOAD, TERMS["two-masses"]]
    found = joint_start.starts([], solution(), {}, terms)
    assert asked == [["direction", "quadratic-load"]]
    assert found[DIRECTION][0] == {"x": 2.0}
    assert set(found) == {DIRECTION, LOAD}
    monkeypatch.setattr(joint_start, "everything", lambda *_: [])
    assert joint_start.starts([], solution(), {}, terms) == {}
