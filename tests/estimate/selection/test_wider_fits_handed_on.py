"""What a wider fit and the narrower one in it are handed, and how many steps they have."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.model.extended_terms import ADDED, TERMS
from motorid.estimate.selection import evidence, extended_fit
from motorid.estimate.selection.extended_fit import Begun, Fitted
from motorid.estimate.solver.allowance import Allowance, opened
from motorid.estimate.solver.autoregression import prominence
from motorid.estimate.solver.problem import Derivatives
from motorid.motor import tally
from tests.estimate.selection.noted_stages import noting
from tests.estimate.solutions import MOTOR, solution

SIDED, COGS = TERMS["direction"], TERMS["cogging"]


def test_a_fit_is_near_once_sources_and_noise_are_those_of_its_rough_end(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: dict[str, Any] = {}
    planned: list[Any] = []

    def record(name: str) -> Any:
        return SimpleNamespace(
            plan=lambda values, own: planned.append((name, float(values[0]), own.tolist())),
            starting=lambda sizes: planned.append((name, sizes)), integrated=5_000,
        )  # fmt: skip

    own = (np.array([1.0]), np.array([2.0]))
    first, white = replace(solution(R=5.0), own=own), solution(K=0.07)
    noting(
        monkeypatch, extended_fit, seen, sizes_by_name=[{"a": 1.0}, {"a": 2.0}],
        _weighed=solution(J=9.0),
    )  # fmt: skip
    noting(monkeypatch, extended_fit.alternating_fit, seen, going_on=white)
    records: Any = (record("one"), record("two"))
    begun = Begun((SIDED,), records, ("R",), {**MOTOR, "N_c": 3.0})
    found = begun.nearly(Fitted((SIDED,), records, first, ("R",), {}))
    assert planned == [
        ("one", 5.0, [1.0]), ("one", {"a": 1.0}), ("two", 5.0, [2.0]), ("two", {"a": 2.0}),
    ]  # fmt: skip
    start = {**MOTOR, "R": 5.0, "N_c": 3.0}
    assert seen["sizes_by_name"] == [(records, first)]
    most = extended_fit.alternating_fit.JUDGED_STEPS  # less than 10⁷ steps, of which each takes 10⁴
    assert seen["going_on"] == [(records, ("R",), start, first, most)]
    lent = replace(first, derivatives=Derivatives(np.zeros(6), (), (), ()))
    begun.nearly(Fitted((SIDED,), records, lent, ("R",), {}))
    begun.nearly(Fitted((SIDED,), records, lent, ("R",), {}), lent=False)
    handed = [of[3].derivatives for of in seen["going_on"][1:]]
    assert handed == [lent.derivatives, None]

    near = extended_fit.alternating_fit.JUDGED
    assert seen["_weighed"][0] == (records, ("R",), start, white, near, most)
    assert (found.terms, found.records, found.free) == ((SIDED,), records, ("R",))
    assert found.start == {**MOTOR, "K": 0.07, "N_c": 3.0}
    assert found.solution.values[4] == 9.0


def test_a_fit_says_what_judging_it_took(monkeypatch: pytest.MonkeyPatch) -> None:
    noting(monkeypatch, extended_fit, {}, _weighed=solution(), _most=7)
    monkeypatch.setattr(
        extended_fit.alternating_fit, "going_on", lambda *_: tally.add(40) or solution()
    )
    begun = Begun((SIDED,), (), ("R",), MOTOR)
    with opened():
        tally.add(100)
        assert begun.nearly(Fitted((SIDED,), (), solution(), ("R",), {})).took == 40


def test_passes_leave_two_fifths_of_what_is_left_to_what_follows(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Where that is more than six sets of derivatives, of 4 responses here."""
    left: list[float] = []
    for most in (50.0, 100.0):
        allowance = Allowance(most=most)
        monkeypatch.setattr(extended_fit, "current", lambda a=allowance: a)
        monkeypatch.setattr(
            extended_fit.alternating_fit, "in_turn",
            lambda *_, a=allowance, **__: left.append(a.left) or solution(),
        )  # fmt: skip
        noting(monkeypatch, extended_fit.alternating_fit, {}, again=solution())
        noting(monkeypatch, extended_fit, {}, _weighed=solution())
        records: Any = (SimpleNamespace(unknowns=(1, 2)),)
        extended_fit.finished(Fitted((SIDED,), records, solution(), ("R",), MOTOR))
    assert left == [50.0 - 24.0, 100.0 - 40.0]


@pytest.mark.parametrize(
    ("steps", "most"),
    [(1, 25), (400_000, 25), (500_000, 20), (2_000_000, 12), (10**9, 12)],
)
def test_long_responses_get_fewer_iterations(steps: int, most: int) -> None:
    """Ten million steps of all records, but twelve at least, and 25 at most."""
    halves: Any = [SimpleNamespace(integrated=n) for n in (steps - steps // 3, steps // 3)]
    assert extended_fit._most(halves) == most


def test_a_fit_to_its_end_settles_as_one_of_six_does(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: dict[str, Any] = {}
    settled, white, end = solution(R=3.0), solution(K=0.09), solution(J=8.0)
    noting(monkeypatch, extended_fit.alternating_fit, seen, in_turn=settled, again=end)
    noting(monkeypatch, extended_fit, seen, _weighed=white)
    records: Any = (SimpleNamespace(unknowns=(1, 2)),)
    near = Fitted((SIDED,), records, solution(B=1.0), ("R",), {"N_c": 3.0})
    found = extended_fit.finished(near)
    values = {**MOTOR, "B": 1.0, "N_c": 3.0}
    assert seen["in_turn"] == [(records, ("R",), values, near.solution, ("thorough", True))]
    assert seen["_weighed"] == [(records, ("R",), values, settled)]
    then = {**values, **MOTOR, "K": 0.09}
    assert seen["again"] == [(records, ("R",), then, white, ("enough", extended_fit.AT_THE_END))]
    assert (found.solution, found.start, found.terms) == (end, {"N_c": 3.0}, (SIDED,))
    assert found.settled


@pytest.mark.parametrize(
    ("most", "begun", "settled"), [(15.9, 0, False), (39.0, 1, False), (40.9, 1, True)]
)
def test_a_fit_is_carried_as_far_as_there_is_room(
    most: float, begun: int, settled: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its derivatives take 4 responses: 16 to begin with; its passes leave 24 for what follows."""
    allowance = Allowance(most=most)
    monkeypatch.setattr(extended_fit, "current", lambda: allowance)

    def passes(*_: Any, **__: Any) -> Any:
        allowance.count.responses += 16
        allowance.ends()
        return solution()

    monkeypatch.setattr(extended_fit.alternating_fit, "in_turn", passes)
    seen: dict[str, Any] = {}
    noting(monkeypatch, extended_fit.alternating_fit, seen, again=solution())
    noting(monkeypatch, extended_fit, seen, _weighed=solution())
    records: Any = (SimpleNamespace(unknowns=(1, 2)),)
    near = Fitted((SIDED,), records, solution(B=1.0), ("R",), {"N_c": 3.0})
    found = extended_fit.finished(near)
    assert (len(seen.get("again", ())), found.settled) == (begun, settled)
    assert (found.solution is near.solution) is not bool(begun)
    assert allowance.kept == 0.0


def test_noise_is_weighed_with_steps_as_fine_as_it_needs(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: dict[str, Any] = {}
    planned: list[Any] = []
    noting(monkeypatch, extended_fit.multistart, seen, whitened="whitened")
    lent = Derivatives(np.zeros(6), (), (), ())
    white = replace(solution(R=3.0), own=(np.array([4.0]),), derivatives=lent)
    one: Any = SimpleNamespace(plan=lambda *of: planned.append(of))
    found: Any = extended_fit._weighed([one], ("R",), MOTOR, white, 0.5, 7)
    assert found == "whitened"
    assert (planned[0][0].tolist(), planned[0][1].tolist()) == (
        [3.0, *list(MOTOR.values())[1:]],
        [4.0],
    )
    ((records, free, start, anew, enough, most),) = seen["whitened"]
    assert (records, free, start, enough, most) == ([one], ("R",), {**MOTOR, "R": 3.0}, 0.5, 7)
    assert anew.derivatives is None
    extended_fit._weighed([one], ("R",), MOTOR, white)
    assert seen["whitened"][1][4:] == (extended_fit.ENOUGH, extended_fit.MAX_ITERATIONS)


# a narrower fit in a wider one


@pytest.mark.parametrize(("behind", "settled"), [(1999.0, True), (2001.0, False)])
def test_a_narrower_fit_that_is_out_of_the_question_is_not_settled(
    behind: float, settled: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: dict[str, Any] = {}
    noting(
        monkeypatch, evidence, seen, unknowns_of="unknowns",
        maximise=solution(100.0 + behind, K=7.0), again=solution(50.0),
    )  # fmt: skip
    made: list[Any] = []

    class Wide:
        def __init__(self, *given: Any) -> None:
            self.given, self.unknowns = given, ()
            made.append(self)

        def follow(self, other: Any) -> None:
            self.followed = other

        def starting(self, sizes: Any) -> None:
            self.sizes = sizes

    monkeypatch.setattr(evidence, "WideRecord", Wide)
    theirs = [
        SimpleNamespace(
            scales=f"scales {k}", priors="priors", unknowns=(SimpleNamespace(name="a"),)
        )
        for k in (0, 1)
    ]
    own = (np.array([1.0]), np.array([2.0]))
    free = ("R", "K", "d_T0", "T_c")
    wide: Any = Fitted(
        (SIDED, COGS), tuple(theirs), replace(solution(100.0), own=own), free,  # type: ignore[arg-type]
        {**MOTOR, "d_T0": 0.3, "T_c": 0.2, "N_c": 7.0},
    )  # fmt: skip
    found = evidence._nested(wide, (SIDED,), solution(R=9.0))
    assert found.free == ("R", "K", "d_T0")
    start = {**MOTOR, "R": 9.0, "d_T0": 0.3, "T_c": ADDED["T_c"].absent, "N_c": ADDED["N_c"].absent}
    fixed = {n: v for n, v in start.items() if n not in found.free}
    for k, one in enumerate(made):
        assert one.given == (
            theirs[k], found.free, fixed, (SIDED,), f"scales {k}", "priors", k == 0,
        )  # fmt: skip
        assert one.followed is theirs[k]
        assert one.sizes == {"a": k + 1.0}
    assert seen["unknowns_of"] == [(made, found.free, start)]
    assert seen["maximise"] == [("unknowns", made, ("enough", evidence.COARSE))]
    assert ("again" in seen) is settled
    assert found.solution.objective == (50.0 if settled else 100.0 + behind)
    if settled:
        ((records, names, near, before),) = seen["again"]
        assert (records, names, near["K"]) == (made, found.free, 7.0)
        assert before.objective == 100.0 + behind
        assert found.start["K"] == 7.0


def test_a_cost_is_of_readings_that_count_and_colour_of_the_worst_block() -> None:
    """By each block of each record: of one with memory several readings count as one."""
    white = np.random.default_rng(1).standard_normal(2000)
    red = np.convolve(np.random.default_rng(2).standard_normal(2010), np.ones(6), "valid")[:2000]
    blocks = (SimpleNamespace(count=300.0), SimpleNamespace(count=500.0))
    parts = (slice(0, 2000), slice(2000, 4000))
    first: Any = SimpleNamespace(residual=np.r_[white, white], slices=parts, blocks=blocks)
    second: Any = SimpleNamespace(residual=np.r_[white, red], slices=parts, blocks=blocks)
    colour = prominence(red)
    assert colour > 3.0
    found: Any = SimpleNamespace(records=(first, second))
    assert evidence.inflation(found) == pytest.approx(colour)
    assert evidence._each(found) == pytest.approx(np.log(1600.0 / colour))
    none: Any = SimpleNamespace(records=())
    assert evidence.inflation(none) == 1.0
