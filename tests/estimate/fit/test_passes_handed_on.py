"""What passes of fit and source are handed, what a change is, and which bounds a search has."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.timing.current_delay import CURRENT_DELAY
from motorid.estimate.effects.timing.motion_delay import MOTION_DELAY
from motorid.estimate.fit import alternating_fit, parameter_bounds, promotion
from motorid.estimate.fit.alternating_fit import Change
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.solver.levenberg_marquardt import ENOUGH, MAX_ITERATIONS
from motorid.estimate.solver.problem import Derivatives, Unknown
from tests.estimate.fit.given_answers import START, record, solution

DELAY, MOTION = Instance(CURRENT_DELAY), Instance(MOTION_DELAY)

# a change


def change(*shift: float) -> Change:
    return Change(np.array(shift), np.array([0.5, 2.0]))


def test_a_size_is_of_the_parameter_that_moved_most_by_its_noise() -> None:
    assert change(0.3, -1.0).size == pytest.approx(0.6)
    assert change(0.1, -1.0).size == pytest.approx(0.5)
    assert Change(np.zeros(0), np.zeros(0)).size == 0.0


@pytest.mark.parametrize(("was", "now"), [(0.0, 1.0), (1.0, 0.0)])
def test_a_pass_beside_one_that_moved_nothing_is_as_slow_as_any(was: float, now: float) -> None:
    left = change(now * 0.5, 0.0).left(change(was * 0.5, 0.0))
    slow = alternating_fit.SLOWEST
    assert left == pytest.approx(now * slow / (1.0 - slow))


def test_what_is_ahead_goes_on_the_way_of_the_last_pass() -> None:
    """Of a pass of half the one before, as much again is to come; one of none leads nowhere."""
    ahead = change(0.2, 0.4).ahead([change(0.4, 0.8)])
    assert ahead.shift == pytest.approx([0.2, 0.4])
    assert change(0.0, 0.0).ahead([change(0.4, 0.0)]).shift.tolist() == [0.0, 0.0]
    alone = change(0.2, 0.0).ahead([])
    assert alone.shift[0] == pytest.approx(0.2 * 0.95 / 0.05)


def test_passes_that_swing_are_within_the_farthest_they_were() -> None:
    """Six of them, whose way back is less than half of their way: sums from the last one on."""
    swings = [change(x * 0.5, 0.0) for x in (9.0, 1.0, -1.5, 1.2, -0.9, 1.1, -1.0)]
    ahead = swings[-1].ahead(swings[:-1])
    # from the last: -1, .1, -.8, .4, -1.1, -.1
    assert ahead.shift[0] / 0.5 == pytest.approx(-1.1)
    few = swings[-1].ahead(swings[2:-1])  # five are not enough to tell
    assert abs(few.shift[0]) / 0.5 == pytest.approx(0.909090909 / (1 - 0.909090909))


@pytest.mark.parametrize(("last", "hovers"), [(-2.1, True), (-1.9, False)])
def test_passes_that_lead_away_by_half_of_their_way_do_not_hover(last: float, hovers: bool) -> None:
    """Six in all, of 6 + 2 in deviations: on the one side of 4 away, or on the other."""
    swings = [change(x * 0.5, 0.0) for x in (1.2, 1.2, 1.2, 1.2, 1.2, last)]
    ahead = swings[-1].ahead(swings[:-1])
    assert (abs(float(ahead.shift[0])) / 0.5 < 10.0) is hovers


# what passes are handed


def handed(monkeypatch: pytest.MonkeyPatch, decided: bool, **facts: Any) -> list[Any]:
    """What the records of a search of one pass and the search are asked with."""
    seen: list[Any] = []
    one: Any = SimpleNamespace(
        driving=SimpleNamespace(decided=decided), loss="loss", names=PARAMETERS, simulated=5,
        volts=np.zeros(3), decide=lambda _: None, unsettled=None,
        retake_sources=lambda *of: seen.append(of) or setattr(one, "volts", one.volts + 1.0),
    )  # fmt: skip
    other = SimpleNamespace(**{**vars(one), **facts})

    def again(*of: Any) -> Any:
        seen.append(of)
        return of[3]

    monkeypatch.setattr(alternating_fit, "again", again)
    monkeypatch.setattr(alternating_fit, "vanished", lambda *_: False)
    before = replace(solution(1.0), own=(np.array([1.0]), np.array([2.0])))
    records: Any = [one, other]
    alternating_fit.in_turn(records, PARAMETERS, START, before, 0.25)
    assert seen[2][:2] == (records, PARAMETERS)
    assert (seen[2][2], seen[2][3], seen[2][5]) == (START, before, 0.25)
    return seen


@pytest.mark.parametrize("decided", [False, True])
def test_sources_are_judged_by_each_records_own_unknowns(
    decided: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And go on from what was judged before once their forms are decided."""
    seen = handed(monkeypatch, decided)
    (values, own, mixer), (_, more, other) = seen[:2]
    assert values.tolist() == list(START.values())
    assert (own.tolist(), more.tolist()) == ([1.0], [2.0])
    assert (mixer is not None) is decided
    assert (mixer is not other) is decided


def test_one_record_without_losses_or_with_more_names_is_enough(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of two: then few passes are made, and those roughly, or near enough to be judged; one
    undecided record decides anew.
    """
    bare: dict[str, Any] = {"loss": None}
    wide: dict[str, Any] = {"names": (*PARAMETERS, "T_q")}
    for facts, end in ((bare, (1.0, 100)), (wide, (0.1, 25))):
        seen = handed(monkeypatch, False, **facts)
        searches = [(of[4], of[6]) for of in seen if len(of) == 7]
        assert searches
        assert set(searches) == {end}
    undecided = handed(monkeypatch, True, driving=SimpleNamespace(decided=False))
    assert undecided[0][2] is None


def test_a_capture_that_spent_its_responses_ends_all(monkeypatch: pytest.MonkeyPatch) -> None:
    """What was spent before does not count; one of two is enough."""
    calls: list[Any] = []
    monkeypatch.setattr(alternating_fit, "vanished", lambda *_: False)
    one = record(7000)
    vars(one).update(loss="loss", names=PARAMETERS, volts=np.zeros(3), decide=lambda _: None)
    busy = SimpleNamespace(**vars(one))
    one.retake_sources = lambda *_: None
    busy.retake_sources = lambda *_: vars(busy).update(
        simulated=busy.simulated + alternating_fit.MOST_SIMULATED // 3 + 1
    )
    before = replace(solution(1.0), own=(np.zeros(0), np.zeros(0)))
    monkeypatch.setattr(
        alternating_fit, "again",
        lambda *of: calls.append(of) or replace(before, values=before.values + len(calls) % 2),
    )  # fmt: skip
    records: Any = [one, busy]
    alternating_fit.in_turn(records, PARAMETERS, START, before)
    assert len(calls) == 3


@pytest.mark.parametrize(
    ("names", "last", "count"),
    [
        ((*PARAMETERS, "T_q"), 2.0, 6),  # as far as ever: in vain
        ((*PARAMETERS, "T_q"), 0.5, 7),  # less, and seen to be none with the next
        (PARAMETERS, 2.0, alternating_fit.MOST_PASSES - 1),  # the six parameters are given all
    ],
)
def test_passes_to_the_end_of_a_wider_model_stop_where_they_swing_in_vain(
    names: tuple[str, ...], last: float, count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The sixth is as large as the first, or smaller; what is left is said of every record."""
    one = record()
    vars(one).update(
        loss="loss", names=names, volts=np.zeros(3), decide=lambda _: None,
        retake_sources=lambda *_: None,
    )  # fmt: skip
    monkeypatch.setattr(alternating_fit, "vanished", lambda *_: False)
    before = replace(solution(0.0), own=(np.zeros(0),))
    sizes = iter([1.0, -1.0, 1.0, -1.0, 1.0, -last, *[2.0, -2.0] * 20])
    calls: list[Any] = []

    def again(*of: Any) -> Any:
        calls.append(of)
        return replace(of[3], values=of[3].values + next(sizes))

    monkeypatch.setattr(alternating_fit, "again", again)
    alternating_fit.in_turn([one], names, START, before, thorough=True)
    assert len(calls) == count
    assert one.unsettled is not None


def test_a_search_goes_on_from_a_solution_in_as_many_steps_as_are_given(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: list[Any] = []
    unknowns = [Unknown(name, value, 0.0) for name, value in START.items()]
    monkeypatch.setattr(alternating_fit, "unknowns_of", lambda *of: seen.append(of) or unknowns)
    monkeypatch.setattr(alternating_fit, "maximise", lambda *of: seen.append(of))
    records, before = [record()], solution(1.0, K=0.07)
    alternating_fit.again(records, PARAMETERS, START, before)
    alternating_fit.again(records, PARAMETERS, START, before, 0.5, 2e-3, 7)
    assert seen[0] == (records, PARAMETERS, {**START, "K": 0.07})
    assert seen[1] == (unknowns, records, MAX_ITERATIONS, ENOUGH, before)
    held, *rest = seen[3]
    assert rest == [records, 7, 0.5, before]
    assert [(u.start, u.lower, u.upper) for u in held if u.name == "L"] == [(2e-3,) * 3]
    assert [u for u in held if u.name != "L"] == [u for u in unknowns if u.name != "L"]


def test_a_search_from_a_start_is_rough_and_undecided(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[Any] = []
    one = record()
    one.decide = lambda decided: seen.append(decided)
    monkeypatch.setattr(alternating_fit, "unknowns_of", lambda *of: seen.append(of) or [])
    monkeypatch.setattr(
        alternating_fit, "maximise", lambda *of, **how: seen.append((*of, how)) or "rough"
    )
    monkeypatch.setattr(alternating_fit, "in_turn", lambda *of: seen.append(of) or "turned")
    found: Any = alternating_fit.with_sources([one], PARAMETERS, START)
    assert found == "turned"
    assert seen == [
        ([one], PARAMETERS, START), False, ([], [one], {"enough": alternating_fit.ROUGH}),
        ([one], PARAMETERS, START, "rough", 0.0),
    ]  # fmt: skip


# bounds


def test_a_search_goes_on_from_a_rough_one_with_its_derivatives_and_undecided(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: list[Any] = []
    one = record()
    one.decide = lambda decided: seen.append(decided)
    monkeypatch.setattr(
        alternating_fit, "again", lambda *of, **how: seen.append((*of, how)) or "nearer"
    )
    monkeypatch.setattr(alternating_fit, "in_turn", lambda *of: seen.append(of) or "turned")
    rough = solution(1.0)
    found: Any = alternating_fit.going_on([one], PARAMETERS, START, rough, 7)
    assert found == "turned"
    assert seen == [
        False, ([one], PARAMETERS, START, rough, alternating_fit.ROUGH, {"most": 7}),
        ([one], PARAMETERS, START, "nearer"),
    ]  # fmt: skip


def run(period_s: float = 1e-3, volts: float = 12.0, current: float = 2.0, **facts: Any) -> Any:
    """A record of a current of which a third flows while nothing drives it."""
    values = current * np.array([1.0, -1.0, 1.0, 50.0, 70.0])
    m = SimpleNamespace(block=SimpleNamespace(name="current"), values=values, keep=np.arange(5))
    other = SimpleNamespace(
        block=SimpleNamespace(name="speed"), values=1e3 * values, keep=np.arange(5)
    )
    return SimpleNamespace(**{
        "volts": np.array([0.0, -volts, volts / 2.0]), "measured": [other, m], "foretold": None,
        "driven": np.array([True, True, True, False, False]),
        "timeline": SimpleNamespace(period_s=period_s), **facts,
    })  # fmt: skip


def test_a_typical_torque_and_speed_are_the_largest_of_all_captures() -> None:
    """By the middle current while it is driven, and by the highest voltage over K."""
    torque, speed = parameter_bounds.typical([run(), run(volts=6.0, current=3.0)], START)
    assert torque == pytest.approx(0.05 * 3.0)
    assert speed == pytest.approx(12.0 / 0.05)
    still, quiet = run(current=0.0, volts=0.0), run(measured=[])
    assert parameter_bounds.typical([still], START) == (START["T0"], 1.0)
    assert parameter_bounds.typical([quiet], {**START, "T0": 0.0})[0] == 1.0


def test_what_is_searched_is_positive_by_its_logarithm_and_friction_from_nothing() -> None:
    records: Any = [run(2e-3), run(1e-3)]
    found = {u.name: u for u in parameter_bounds.unknowns_of(records, PARAMETERS, START)}
    assert list(found) == list(PARAMETERS)
    for name in ("R", "K", "J"):
        assert found[name] == Unknown(name, START[name], lower=0.0, log=True)
    torque, speed = 0.05 * 2.0, 12.0 / 0.05
    assert found["B"] == Unknown("B", START["B"], lower=0.0, scale=torque / speed)
    assert found["T0"] == Unknown("T0", START["T0"], lower=0.0, scale=torque)
    # no less than a thousandth of a sample of the finest capture
    assert found["L"] == Unknown("L", START["L"], lower=1e-3 * 2.0 * 1e-3, log=True)
    (short,) = parameter_bounds.unknowns_of(records, ["L"], {**START, "L": 3e-6})
    assert (short.start, short.lower) == pytest.approx((4e-6, 2e-6))
    assert [u.name for u in parameter_bounds.unknowns_of(records, ["J", "R"], START)] == ["J", "R"]


def test_an_inductance_that_is_foretold_is_as_good_as_held() -> None:
    records: Any = [run(foretold=SimpleNamespace(inductance_h=7e-4)), run()]
    (found,) = parameter_bounds.unknowns_of(records, ["L"], START)
    assert found.start == 7e-4
    assert (found.prior_mean, found.prior_sd) == pytest.approx((np.log(7e-4), 1e-3))
    assert found.log


def test_a_wider_model_says_what_its_own_parameters_are() -> None:
    asked: list[Any] = []
    one = run(unknown=lambda *of: asked.append(of) or Unknown("T_q", 3.0))
    found = parameter_bounds.unknowns_of([one, run()], ["R", "T_q"], {**START, "T_q": 8.0})
    assert asked == [("T_q", 8.0)]
    assert found[1] == Unknown("T_q", 3.0)


def test_what_is_left_out_is_nothing_unless_it_is_given() -> None:
    assert parameter_bounds.held_values({"R": 2.0}, ("B", "T0")) == {"B": 0.0, "T0": 0.0, "R": 2.0}
    assert parameter_bounds.held_values({"B": 2.0}, ("B",)) == {"B": 2.0}
    assert parameter_bounds.searched({"B": 0.0, "R": 1.0}) == ["L", "K", "J", "T0"]


# promotion


def doubtful(*propagated: Instance, told: bool = True) -> Any:
    unknowns = {
        DELAY: Unknown("delay", 0.0, prior_sd=3.0),
        MOTION: Unknown("motion", 0.0, prior_sd=5.0),
    }
    one = SimpleNamespace(
        propagated=tuple((i, unknowns[i]) for i in propagated), says=told, asked=[],
        weighed=lambda parts: [2.0 * part for part in parts],
    )  # fmt: skip
    one.estimate = one.asked.append
    return one


@pytest.fixture
def told(monkeypatch: pytest.MonkeyPatch) -> None:
    """A quantity is told by records that say so."""
    known = type(CURRENT_DELAY)
    monkeypatch.setattr(known, "told", property(lambda _: lambda run: run.says), raising=False)


@pytest.mark.usefixtures("told")
def test_a_candidate_is_propagated_in_every_record_and_told_by_each() -> None:
    both, one = doubtful(DELAY, MOTION), doubtful(MOTION)
    assert promotion._candidates([both, one]) == [MOTION]
    assert promotion._candidates([one, both]) == [MOTION]
    assert promotion._candidates([both, both]) == [DELAY, MOTION]
    assert promotion._candidates([both, doubtful(DELAY, MOTION, told=False)]) == []
    assert promotion._candidates([doubtful(DELAY, told=False), both]) == []


@pytest.mark.usefixtures("told")
def test_the_first_that_pays_becomes_an_unknown_of_every_record(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tangents: list[Any] = []
    paid: list[Any] = []

    def tangent(run: Any, values: Any, own: Any, one: Instance) -> Any:
        tangents.append((run, own.tolist(), one))
        return [np.full(2, float(own[0])), np.full(1, 7.0)]

    def pays(columns: Any, deviations: Any, _: Any) -> bool:
        paid.append((np.array(columns).tolist(), deviations))
        return len(paid) == 2

    monkeypatch.setattr(promotion, "tangent", tangent)
    monkeypatch.setattr(promotion, "_pays", pays)
    records: Any = [doubtful(DELAY, MOTION), doubtful(MOTION, DELAY)]
    table = Derivatives(
        np.zeros(6), (np.array([1.0]), np.array([2.0])), ("a", "b"), (np.zeros((1, 3)),) * 2,  # type: ignore[arg-type]
    )  # fmt: skip
    before = replace(solution(1.0), own=(np.array([1.0]), np.array([2.0])), derivatives=table)
    after, found = promotion.promoted(records, before)
    assert found == [MOTION]
    assert tangents[:2] == [(records[0], [1.0], DELAY), (records[1], [2.0], DELAY)]
    columns = [[2.0, 2.0, 14.0], [4.0, 4.0, 14.0]]
    assert paid == [(columns, [3.0, 3.0]), (columns, [5.0, 5.0])]
    assert [run.asked for run in records] == [[MOTION], [MOTION]]
    assert [own.tolist() for own in after.own] == [[1.0, 0.0], [2.0, 0.0]]
    lent = after.derivatives
    assert lent is not None
    assert [own.tolist() for own in lent.own] == [[1.0, 0.0], [2.0, 0.0]]
    assert [rows[1].tolist() for rows in lent.own_slopes] == columns
    bare = replace(before, derivatives=None)
    paid.clear()
    assert promotion.promoted(records, bare)[0].derivatives is None


@pytest.mark.parametrize(
    ("size", "found", "beyond"),
    [
        (1.99, [DELAY], False), (1.9981, [DELAY], True), (-0.998, [DELAY], False),
        (-0.9991, [DELAY], True), (5.0, [MOTION], False),
    ],
)  # fmt: skip
def test_a_size_within_a_thousandth_of_its_bounds_contradicts(
    size: float, found: list[Instance], beyond: bool
) -> None:
    """Between -1 and 2; one record of several is enough, other quantities are not looked at."""
    one = SimpleNamespace(instances=(DELAY,), unknowns=(Unknown("delay", 0.0, -1.0, 2.0),))
    other = replace(solution(1.0), own=(np.zeros(1), np.array([size])))
    assert promotion.contradicted([one, one], other, found) is beyond  # type: ignore[list-item]


def test_a_doubt_within_rounding_of_what_is_known_never_pays() -> None:
    """Of a column of which 1e-5 is new: 1e-10 of its square, whatever that moves."""
    rng = np.random.default_rng(3)
    base, new = rng.standard_normal((50, 1)), rng.standard_normal(50)
    new -= base[:, 0] * (base[:, 0] @ new) / (base[:, 0] @ base[:, 0])
    new *= np.linalg.norm(base) / np.linalg.norm(new)
    line = SimpleNamespace(
        orthogonal=base, own=np.zeros((50, 0)), own_information=np.zeros((0, 0)),
        sigmas=np.array([1.0]), slices=(slice(0, 50),),
    )  # fmt: skip
    known: Any = SimpleNamespace(information=base.T @ base, records=(line,))
    for share, pays in ((1e-5, False), (1e-4, True)):
        column = 1e6 * (base[:, 0] + share * new)
        assert promotion._pays([column], [1.0], known) is pays
