"""Inductances held one after the other: what each search is handed, and whose noise judges it."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.fit import alternating_fit
from motorid.estimate.fit import subsample_inductance as subsample
from motorid.estimate.fit.subsample_inductance import CLOSE, COARSE
from tests.estimate.fit.given_answers import START, note, record, solution

FREE, FIXED = ("R", "L", "K"), {"J": 2e-5}


def search(*before: Any, near: Any = None) -> Any:
    found: Any = subsample._Search(before or (record(),), FREE, FIXED, START, near or solution(1.0))
    return found


def test_each_is_held_in_records_of_its_own_from_the_same_values(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """And the responses of its busiest record are counted."""
    seen: list[Any] = []
    spent = iter((30, 50, 7, 8))
    monkeypatch.setattr(
        subsample, "MotorRecord",
        lambda *given: SimpleNamespace(given=given, simulated=next(spent)),
    )  # fmt: skip
    note(monkeypatch, subsample, "_as_of", seen, "near")
    note(monkeypatch, subsample, "with_inductance", seen, "solution")
    before = [record(), record()]
    before[0].capture, before[1].capture, before[1].shape = "one", "two", "held"
    one = search(*before)
    records, found = one.held(4e-5)
    assert found == "solution"
    assert [r.given for r in records] == [
        ("one", FREE, FIXED, "joined"), ("two", FREE, FIXED, "held"),
    ]  # fmt: skip
    assert seen == [
        ("_as_of", records, tuple(before), one.near),
        ("with_inductance", records, FREE, START, "near", 4e-5),
    ]
    others, _ = one.held(5e-5)
    assert one.trials == [records, others]
    assert (one.spent(), one.spent(records), one.spent(others)) == (58, 8, 50)


def test_places_are_judged_in_the_noise_of_the_likeliest(monkeypatch: pytest.MonkeyPatch) -> None:
    """Once each; derivatives of other weights are not lent."""
    seen: list[Any] = []
    monkeypatch.setattr(subsample.prewhitening, "whiten", lambda *of: seen.append(("whiten", *of)))
    monkeypatch.setattr(subsample.prewhitening, "thin", lambda *of: seen.append(("thin", *of)))
    note(monkeypatch, subsample, "again", seen, solution(7.0))

    def place_of(place: int) -> Any:
        one = record()
        one.place, one.weigh_as = place, lambda other: seen.append((place, other.place))
        return [one], replace(solution(float(place)), derivatives="lent")  # type: ignore[arg-type]

    held = {n: place_of(n) for n in (-200, -212)}
    worse = search()._by_noise_of(-200, held.__getitem__)
    like, at = held[-200]
    assert seen == [("whiten", like, at), ("thin", like, at)]
    assert worse(-212) == worse(-212) == 7.0
    assert seen[2] == (-212, -200)
    _, records, free, known, near, how = seen[3]
    assert (records, free, known) == (held[-212][0], FREE, START)
    assert near.derivatives is None
    assert near.objective == -212.0
    assert how == ("held_h", pytest.approx(math.exp(-212 * CLOSE)))
    assert len(seen) == 4


def valleyed(
    monkeypatch: pytest.MonkeyPatch, depths: dict[int, dict[int, float]], period_s: float = 2.5e-4
) -> tuple[float | None, list[int]]:
    """What is taken where each place judges all others so, and which places judged."""
    judges: list[int] = []

    def by_noise_of(_: Any, likeliest: int, __: Any) -> Any:
        judges.append(likeliest)
        return lambda place: depths[likeliest].get(place, 1e4 + abs(place))

    monkeypatch.setattr(
        subsample._Search, "compared",
        lambda _, henry: ([], solution(abs(math.log(henry) / CLOSE + 240.0))),
    )  # fmt: skip
    monkeypatch.setattr(subsample._Search, "_by_noise_of", by_noise_of)
    return search(record(period_s=period_s), record(period_s=1.0)).by_ripple(), judges


def bowl(centre: int, steep: float = 1.0) -> dict[int, float]:
    return {n: steep * (n - centre) ** 2 for n in range(-400, 0)}


def test_the_noise_is_that_of_the_likeliest_by_its_own_noise(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Judged anew where another place turns out likelier, twice at most."""
    found, judges = valleyed(monkeypatch, {-240: bowl(-240)})
    assert judges == [-240]
    assert found == pytest.approx(math.exp(-240 * CLOSE))
    found, judges = valleyed(monkeypatch, {-240: bowl(-252), -252: bowl(-252)})
    assert judges == [-240, -252]
    assert found == pytest.approx(math.exp(-252 * CLOSE))
    depths = {-240: bowl(-252), -252: bowl(-264), -264: bowl(-252)}
    found, judges = valleyed(monkeypatch, depths)
    assert judges == [-240, -252]
    assert found == pytest.approx(math.exp(-264 * CLOSE))


@pytest.mark.parametrize("centre", [-249, -246, -242, -241, -239, -235, -231])
def test_steps_get_finer_about_the_likeliest(centre: int, monkeypatch: pytest.MonkeyPatch) -> None:
    found, _ = valleyed(monkeypatch, {n: bowl(centre) for n in range(-264, -215, COARSE)})
    assert found == pytest.approx(math.exp(centre * CLOSE))


def test_a_place_far_off_that_is_as_likely_leaves_none(monkeypatch: pytest.MonkeyPatch) -> None:
    for depth, given in ((29.0, False), (31.0, True)):
        twice = bowl(-240) | {-276: depth}
        found, _ = valleyed(monkeypatch, {-240: twice})
        assert (found is not None) is given


def test_a_valley_that_jumps_about_must_be_clearer(monkeypatch: pytest.MonkeyPatch) -> None:
    """By five times as much as it jumps; a bowl of 60 at its neighbours."""
    smooth = bowl(-240, 60.0 / COARSE**2)
    assert valleyed(monkeypatch, {-240: smooth})[0] is not None
    jumping = dict(smooth)
    for n, step in zip((-246, -243, -242, -241, -239, -238, -237, -234), (1, -1) * 4, strict=True):
        jumping[n] += 18.0 * step
    jumping[-240] -= 20.0
    assert valleyed(monkeypatch, {-240: jumping})[0] is None


def test_the_shortest_period_says_which_are_held(monkeypatch: pytest.MonkeyPatch) -> None:
    """From 2 of L/R in samples down to a hundredth; the resistance is 2 ohms."""
    asked: list[float] = []

    def held(_: Any, henry: float) -> Any:
        asked.append(henry)
        return [], solution(-henry)

    monkeypatch.setattr(subsample._Search, "compared", held)
    monkeypatch.setattr(subsample._Search, "_by_noise_of", lambda *_: lambda place: -float(place))
    assert search(record(period_s=1.0), record(period_s=1e-3)).by_ripple() is None
    tau = 2.0 * 1e-3
    assert 2.0 * tau * math.exp(-COARSE * CLOSE) < max(asked) <= 2.0 * tau
    assert 0.01 * tau <= min(asked) < 0.01 * tau * math.exp(COARSE * CLOSE)
    steps = np.diff(np.log(sorted(asked)))
    assert steps == pytest.approx(COARSE * CLOSE)


def test_a_search_from_a_held_one_ends_as_any_other(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[Any] = []
    rough, turned, promoted, repeated = (solution(x) for x in (4.0, 3.0, 2.0, 1.0))
    note(monkeypatch, subsample, "again", seen, rough)
    note(monkeypatch, subsample, "in_turn", seen, turned)
    note(monkeypatch, subsample, "with_promoted", seen, promoted)
    note(
        monkeypatch,
        subsample,
        "with_repeated",
        seen,
        replace(repeated, values=repeated.values + 1.0),
    )
    note(monkeypatch, subsample, "whitened", seen, "answer")
    before, records = [record(), record()], [record(), record()]
    before[0].rivals, before[1].rivals = ("a",), ("b",)
    held = solution(5.0, L=7e-5)
    assert search(*before).finished(records, held) == "answer"
    assert [r.rivals for r in records] == [("a",), ("b",)]
    start = {**START, "L": 7e-5}
    assert seen[0] == ("again", records, FREE, start, held, alternating_fit.ROUGH)
    assert seen[1] == ("in_turn", records, FREE, start, rough)
    assert seen[2] == ("with_promoted", records, FREE, start, turned)
    assert seen[3] == ("with_repeated", records, FREE, start, promoted)
    _, *how, last = seen[4]
    assert how == [records, FREE, {n: v + 1.0 for n, v in START.items()}]
    assert last.objective == 1.0


def test_the_worst_chain_says_how_unsure_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of several captures, beside what ripple tells it by."""
    chain = {"one": 0.06, "two": 0.15}
    monkeypatch.setattr(subsample, "_of_chain", chain.__getitem__)
    monkeypatch.setattr(subsample, "_deviation", lambda *_: 0.5)
    asked: list[float] = []
    monkeypatch.setattr(subsample, "_stays", lambda *of: asked.append(of[3]) or True)
    one, other = record(), record()
    one.capture, other.capture = "one", "two"
    monkeypatch.setattr(subsample._Search, "held", lambda *_: ([one, other], solution(1.0)))
    monkeypatch.setattr(subsample._Search, "finished", lambda *_: solution(2.0))
    assert search(one, other).ended(4e-5, "ripple") is not None
    assert asked == [pytest.approx(math.hypot(0.08, 0.15))]


def test_a_deviation_is_that_of_the_inductance_with_the_spread_of_parts(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found = solution(1.0)
    monkeypatch.setattr(subsample, "by_part", lambda *of: of)

    def statistical(one: Any, parts: Any) -> Any:
        assert (one, parts) == (found, (found, ["records"]))
        return SimpleNamespace(deviations=np.arange(6.0))

    monkeypatch.setattr(subsample, "statistical", statistical)
    assert subsample._deviation(found, ["records"]) == 1.0  # type: ignore[list-item]


@pytest.mark.parametrize(
    ("ratio", "deviation", "stays"),
    [(math.exp(0.29), 0.1, True), (math.exp(0.31), 0.1, False), (math.exp(-0.31), 0.1, False),
     (math.exp(-0.29), 0.19, True), (1.0, 0.21, False)],
)  # fmt: skip
def test_a_search_keeps_to_what_it_was_given(ratio: float, deviation: float, stays: bool) -> None:
    """Within .3 of a logarithm, and better known than to .2."""
    alone = solution(1.0, L=ratio * START["L"])
    assert subsample._stays(alone, solution(1.0), deviation, 0.2) is stays


def test_a_shift_is_of_search_coordinates() -> None:
    """Of a friction that begins at nothing the value itself, though it is searched by its log."""
    one, other = solution(1.0), solution(1.0, R=6.0, B=9e-5)
    logs = tuple(replace(u, log=u.name in ("R", "K")) for u in one.unknowns)
    moved = subsample._shift(replace(one, unknowns=logs), replace(other, unknowns=logs))
    assert moved == pytest.approx({"R": math.log(3.0), "L": 0, "K": 0, "B": 5e-5, "J": 0, "T0": 0})
    none = replace(solution(1.0, R=0.0), unknowns=logs)
    assert subsample._shift(none, replace(other, unknowns=logs))["R"] == 6.0
    assert subsample._shift(replace(other, unknowns=logs), none)["R"] == -6.0


@pytest.mark.parametrize("count", [4, 7])
def test_a_roughness_has_three_freedoms_less(count: int) -> None:
    """The rms that a parabola leaves, by numpy's own."""
    places = np.arange(100, 100 + count)
    values = np.array([3.0, -1.0, 4.0, 1.0, -5.0, 9.0, 2.0])[:count]
    left = values - np.polyval(np.polyfit(places - 100.0, values, 2), places - 100.0)
    found = subsample._roughness(dict(zip(places.tolist(), values.tolist(), strict=True)))
    assert found == pytest.approx(math.sqrt(float(left @ left) / (count - 3)))


def test_an_inductance_is_told_from_the_values_that_a_fit_has_seen(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: list[Any] = []
    note(monkeypatch, subsample, "_unsure", seen, 1.0)
    note(monkeypatch, subsample.discontinuous_current_inductance, "inductance", seen, 5e-3)
    monkeypatch.setattr(
        subsample._Search, "ended", lambda one, *how: seen.append((one, *how)) or None
    )
    records, near = [record()], solution(1.0)
    assert subsample.told(records, FREE, FIXED, START, near) is None
    ended, henry, by = seen[2]
    assert (ended.before, ended.free, ended.fixed) == (records, FREE, FIXED)
    assert (ended.known, ended.near, henry, by) == (START, near, 5e-3, "pulses")
    assert seen[0] == ("_unsure", near, records)
    assert seen[1] == ("inductance", records, near)
