"""Which fit of a log is taken, which begins where, and what its rivals keep: on fits of which the
objective is given.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.registry import SECOND_ORDER, WITHOUT_WORD
from motorid.estimate.effects.timing.voltage_late import VOLTAGE_LATE
from motorid.estimate.fit.logs import log_fit, log_shapes, log_unknowns
from motorid.estimate.signals.intersample_voltage import Rival
from motorid.estimate.solver.problem import Solution, Unknown
from tests.estimate.fit.made_fits import (
    LAG,
    NAMES,
    PERIOD_S,
    SMOOTHING,
    fit,
    known,
    record,
    solution,
)

# the likeliest


def test_the_likeliest_has_the_others_as_rivals_by_how_much_they_are_behind() -> None:
    one, best, other = fit(30.0), fit(10.0, "held"), fit(25.0, "curved")
    records, found = log_shapes.likeliest([one, best, other])
    assert found.objective == 10.0
    assert records is best[0]
    assert [(float(r.values[0]), r.behind) for r in records[0].rivals] == [
        (30.0, 20.0),
        (25.0, 15.0),
    ]
    assert all(np.isnan(r.late_s) for r in records[0].rivals)


def test_a_rival_says_how_late_its_voltage_is() -> None:
    late = Instance(VOLTAGE_LATE)
    best, other = fit(10.0), ([record(instances=(LAG, late))], solution(12.0, None, (3.0, -2e-3)))
    records, _ = log_shapes.likeliest([best, other])
    assert [r.late_s for r in records[0].rivals] == [2e-3]


def test_a_fit_takes_another_ones_place_where_it_is_likelier() -> None:
    before = [record(rivals=(Rival(np.zeros(3), 5.0),), left_open=("a",))], solution(30.0)
    kept = log_fit._instead(before, fit(30.0))
    assert kept is before
    records, found = log_fit._instead(before, fit(28.0))
    assert found.objective == 28.0
    assert records[0].left_open == ("a",)
    assert [r.behind for r in records[0].rivals] == [7.0]


def test_what_noise_of_the_voltage_leaves_speaks_against_no_fit() -> None:
    """Of 30 that one is left, noise makes 15: it is likelier than one of 20 without any."""

    def noisy() -> Any:
        return [record()], replace(solution(30.0), noise=15.0)

    one, other = noisy(), fit(20.0, "held")
    records, found = log_shapes.likeliest([other, one])
    assert found is one[1]
    assert [r.behind for r in records[0].rivals] == [5.0]
    assert log_fit._instead(fit(20.0), noisy())[1].objective == 30.0
    kept = fit(14.0)
    assert log_fit._instead(kept, noisy()) is kept
    assert log_fit._best_of_each_shape([fit(20.0), one])[0] is one
    before = [record(rivals=(Rival(np.zeros(3), 3.0),))], solution(20.0)
    records, _ = log_unknowns.with_rivals_of(before, noisy())
    assert [r.behind for r in records[0].rivals] == [8.0]


def test_what_larger_priors_leave_open_is_the_difference_of_the_covariances() -> None:
    narrow = np.diag([1.0, 4.0, 2.0])
    turned = np.linalg.qr(np.arange(9.0).reshape(3, 3) + np.eye(3))[0]
    more = turned @ np.diag([0.5, 0.2, 0.0]) @ turned.T
    wide = np.linalg.inv(np.linalg.inv(narrow) + more)
    ways = log_fit._less_known(solution(0.0, narrow), solution(0.0, wide))
    total = sum((np.outer(way, way) for way in ways), np.zeros((3, 3)))
    assert total == pytest.approx(more, abs=1e-7)
    none = log_fit._less_known(solution(0.0, wide), solution(0.0, narrow))
    assert sum(float(way @ way) for way in none) == pytest.approx(0.0, abs=1e-7)


def test_of_each_shape_the_likeliest_is_kept_in_their_order() -> None:
    fits = [fit(30.0), fit(10.0, "held"), fit(20.0), fit(40.0, "held"), fit(15.0, "curved")]
    best = log_fit._best_of_each_shape(fits)
    assert [(one[0][0].shape, one[1].objective) for one in best] == [
        ("held", 10.0), ("curved", 15.0), ("joined", 20.0),
    ]  # fmt: skip


@pytest.mark.parametrize(("each", "over"), [((1000, 1000), False), ((1000, 1001), True)])
def test_searches_are_exhausted_by_all_their_responses(each: tuple[int, int], over: bool) -> None:
    most = log_fit.MOST_TRIED
    fits = [
        ([record(simulated=3), record(simulated=n * most // 2000)], solution(1.0)) for n in each
    ]
    if over:
        fits[0][0][1].simulated += 1
    assert log_fit._exhausted(fits) is over


# other places to begin


def begun_elsewhere(
    monkeypatch: pytest.MonkeyPatch, free: Sequence[str] = NAMES, simulated: int = 1,
    gains: Sequence[float] = (),
) -> tuple[list[Any], list[Any]]:  # fmt: skip
    """Where searches begin: (shape, whole samples, L) each; and the fits."""
    left, seen = list(gains), []

    def like(near: Any, records: Any, whole: bool = False) -> Any:
        records[0].whole = whole
        return records

    def settled(records: Any, _free: Any, start: Any) -> Solution:
        gain = left.pop(0) if left else 0.0
        seen.append((records[0].shape, records[0].whole, start["L"], start["R"]))
        return solution(100.0 - gain)

    monkeypatch.setattr(log_fit, "like", like)
    monkeypatch.setattr(log_fit, "settled", settled)
    monkeypatch.setattr(log_fit, "widened", lambda _r, _f, _s, found: found)

    def fresh(shape: Any) -> list[Any]:
        return [record(shape, simulated)]

    before = [record("held", simulated)], replace(solution(100.0), values=np.array([2.0, 9.0, 3.0]))
    found = log_fit._begun_elsewhere(before, free, {"R": 5.0, "L": 8.0, "K": 1.0}, fresh)
    return seen, found


def test_other_inductances_are_tried_first_then_other_shapes_and_whole_samples(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen, found = begun_elsewhere(monkeypatch)
    inductances = [L for _, _, L, _ in seen[:3]]
    assert inductances == pytest.approx([rise * PERIOD_S * 2.0 for rise in log_shapes.RISES])
    assert {(shape, whole) for shape, whole, *_ in seen[:3]} == {("held", False)}
    ways = [(shape, whole) for shape, whole, *_ in seen[3:]]
    expected = [(s, w) for s in log_fit.PLAIN for w in (False, True) if (s, w) != ("held", False)]
    assert ways[: len(expected)] == expected
    again = ways[len(expected) :]
    assert len(again) == log_fit.RESTARTED
    assert all(whole for _, whole in again)
    assert len(found) == 1 + len(seen)


def test_a_held_inductance_is_not_searched_elsewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    seen, _ = begun_elsewhere(monkeypatch, ("R", "K"))
    assert seen[0][:2] == ("joined", False)


def test_another_start_must_be_better_by_a_little(monkeypatch: pytest.MonkeyPatch) -> None:
    """The values of the first fit have R = 2, those of others R = its objective."""
    for gain, resistance in ((0.9, 2.0), (1.1, 98.9)):
        seen, _ = begun_elsewhere(monkeypatch, gains=(0.0, gain, 0.0))
        assert seen[3][3] == pytest.approx(resistance)


def test_what_there_was_no_room_for_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    seen, found = begun_elsewhere(monkeypatch, simulated=log_fit.MOST_TRIED // 5)
    assert len(seen) == 5
    ways = 2 * len(log_fit.PLAIN) - 1
    assert {one[0][0].untried for one in found} == {ways - 2}


# what was found, in the next fit


def test_a_quantity_is_found_beyond_twice_what_is_usual() -> None:
    one, own = known((LAG, -2.1, 1.0), (SMOOTHING, 1.9, 1.0))
    assert log_unknowns._find([one], replace(solution(0.0), own=(own,)))
    assert set(one.found) == {LAG}
    assert one.found[LAG].start == -2.1
    assert one.found[LAG].prior_sd == 2.1
    calm, own = known((LAG, 0.5, 1.0))
    assert not log_unknowns._find([calm], replace(solution(0.0), own=(own,)))
    assert calm.found == {}


def test_priors_are_widened_until_nothing_more_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    one, own = known((LAG, 3.0, 1.0))
    starts: list[Any] = []

    def settled(_records: Any, _free: Any, start: Any, _worth: float) -> Solution:
        starts.append(start)
        one.unknowns = (Unknown(LAG.name, 0.0, prior_sd=3.0),)
        return replace(solution(77.0), own=(own,))

    monkeypatch.setattr(log_unknowns, "settled", settled)
    found = log_unknowns.widened([one], NAMES, {"J": 1.0}, replace(solution(5.0), own=(own,)))
    assert found.objective == 77.0
    assert starts == [{"J": 1.0, "R": 5.0, "L": 2.0, "K": 3.0}]
    again, own = known((LAG, 3.0, 1.0))
    calls: list[int] = []
    monkeypatch.setattr(
        log_unknowns, "settled",
        lambda *_: calls.append(1) or replace(solution(1.0), own=(own,)),
    )  # fmt: skip
    log_unknowns.widened([again], NAMES, {}, replace(solution(5.0), own=(own,)))
    assert len(calls) == log_unknowns.ROUNDS


def test_only_what_nobody_stated_is_found() -> None:
    other = Instance(next(q for q in SECOND_ORDER if q in WITHOUT_WORD))
    offset = SimpleNamespace(quantity=SimpleNamespace(), name="current offset")
    one, own = known((offset, 9.0, 1.0), (other, 9.0, 1.0))  # type: ignore[arg-type]
    log_unknowns._find([one], replace(solution(0.0), own=(own,)))
    assert set(one.found) == {other}


def test_a_new_record_begins_with_the_sizes_that_were_found() -> None:
    before, own = known((LAG, 2.6e-3, 1e-3), (SMOOTHING, 1.2e-3, 1e-3), found=[LAG])
    sizes = log_unknowns.found_sizes(before, own, record())
    assert {one: unknown.start for one, unknown in sizes.items()} == {
        LAG: 2.6e-3,
        SMOOTHING: 1.2e-3,
    }
    whole = log_unknowns.found_sizes(before, own, record(), whole=True)
    assert whole[LAG].start == pytest.approx(3 * PERIOD_S)
    assert whole[SMOOTHING].start == pytest.approx(1 * PERIOD_S)
    none, own = known((LAG, 2.6e-3, 1e-3))
    assert log_unknowns.found_sizes(none, own, record()) == {}


def test_what_is_found_or_of_some_size_has_moved() -> None:
    assert log_unknowns.moved(*known((LAG, 0.6, 1.0)))
    assert log_unknowns.moved(*known((LAG, -0.6, 1.0)))
    assert not log_unknowns.moved(*known((LAG, 0.4, 1.0)))
    assert log_unknowns.moved(*known((LAG, 0.1, 1.0), found=[LAG]))
    assert not log_unknowns.moved(record(), np.zeros(0))


def test_readings_of_all_channels_and_records_count() -> None:
    measured = [SimpleNamespace(values=np.zeros(n)) for n in (3, 4)]
    assert log_unknowns.readings([record(measured=measured), record(measured=measured[:1])]) == 10


def test_rivals_of_the_one_before_are_farther_behind_by_the_gain() -> None:
    before = [record(rivals=(Rival(np.array([8.0]), 3.0),))], solution(20.0)
    records, _ = log_unknowns.with_rivals_of(before, fit(15.0))
    assert [(r.values[0], r.behind) for r in records[0].rivals] == [(8.0, 8.0)]
