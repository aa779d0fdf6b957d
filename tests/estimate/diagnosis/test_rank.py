"""Which fault is named, among those that promise to explain what a fit leaves."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.diagnosis import misfit, rank, refit
from motorid.estimate.diagnosis.fault import Hypothesis, Words
from motorid.estimate.diagnosis.rank import Trial
from motorid.estimate.diagnosis.refit import Refit
from motorid.estimate.results.estimate import Suspect
from tests.estimate.solutions import MOTOR, solution


def hypothesis(guard: bool = False) -> Hypothesis:
    def words(size: np.ndarray) -> Words:
        return Words("current", f"it is {size[0]:g} s late", "declare it")

    return Hypothesis("current_lag", _none, ((1.0,),), (1.0,), (0.0,), (9.0,), words, guard)


def _none(*_: Any) -> list[np.ndarray]:
    return []


def trial(
    gain: float = 1.0, share: float = 0.9, shift: float = 0.1, seen: bool = False,
    guard: bool = False, size: float = 3e-4, far: float = 0.0, clear: bool = False,
    chance: float = 0.0,
) -> Trial:  # fmt: skip
    values = np.array([v * (1 + (shift if n == "R" else 0.0)) for n, v in MOTOR.items()])
    found = Refit(values, np.array([size]), 1.0, solution())
    shifts = {"R": shift, "K": -shift / 2}
    return Trial(hypothesis(guard), found, gain, share, shifts, far, clear, seen, chance)


def suspect(code: str, allowed: bool = False) -> Suspect:
    return Suspect(code, "current", "so", "do", "named", allowed=allowed)


@pytest.mark.parametrize(
    ("one", "named"),
    [
        (trial(gain=0.75, share=0.16), True),  # much for each reading
        (trial(gain=0.65, share=0.16), False),
        (trial(gain=0.75, share=0.14), False),  # but a small part of what there is
        (trial(gain=0.75, share=0.14, seen=True), True),
        (trial(gain=0.11, share=0.31), True),  # or less, and much of all there is
        (trial(gain=0.11, share=0.29), False),
        (trial(gain=0.09, share=0.99), False),
        (trial(gain=0.11, share=0.01, seen=True), True),  # or the plain laws show it
        (trial(gain=0.09, share=0.01, seen=True), False),
        (trial(gain=9.0, shift=0.001), False),  # it moves nothing
        (trial(gain=9.0, shift=0.001, far=2.1), True),  # but beyond what is uncertain
        (trial(gain=0.01, share=0.6, shift=0.001, far=2.1, clear=True), True),  # small, and sure
        (trial(gain=0.01, share=0.6, shift=0.1, far=1.9, clear=True), False),
        (trial(gain=0.01, share=0.49, shift=0.1, far=2.1, clear=True), False),
        (trial(gain=0.01, share=0.6, far=2.1), False),
        (trial(gain=9.0, shift=-0.003), True),
        (trial(gain=9.0, size=8.9), True),
        (trial(gain=9.0, size=9.0), False),  # such faults end there: it stands in for another
        (trial(gain=9.0, size=0.0), False),
        (trial(gain=9.0, chance=0.24), True),
        (trial(gain=9.0, chance=0.26), False),  # noise of a voltage makes a quarter of its size
        (trial(gain=9.0, chance=0.26, seen=True), False),
        (trial(gain=0.01, share=0.6, shift=0.001, far=2.1, clear=True, chance=0.26), False),
    ],
)
def test_a_fault_convinces_by_what_it_explains_and_moves(one: Trial, named: bool) -> None:
    assert one.convincing is named


def test_less_than_what_is_declared_leaves_open_is_no_fault() -> None:
    one = trial(gain=2.0, size=3e-4)
    for least, named in ((2.9e-4, True), (3.1e-4, False)):
        found = replace(one, hypothesis=replace(one.hypothesis, least=least))
        assert found.convincing is named


def test_a_vague_fault_explains_most_of_a_small_misfit() -> None:
    for share, named in ((0.7, False), (0.8, True)):
        one = trial(gain=0.01, share=share, far=2.1, clear=True)
        assert one.convincing
        found = replace(one, hypothesis=replace(one.hypothesis, vague=True))
        assert found.convincing is named


def test_what_the_model_lacks_is_no_fault(monkeypatch: pytest.MonkeyPatch) -> None:
    def first(*found: Trial) -> Trial | None:
        monkeypatch.setattr(rank, "trials", lambda *_: list(found))
        return rank.tried([], solution(), {})

    best = trial(gain=2.0)
    assert first(best, trial()) is best
    assert first(trial(gain=2.0, guard=True), best) is None
    assert first(trial(gain=0.01), best) is None  # the best of all has the word
    assert first() is None


def test_some_findings_let_a_fit_go_on() -> None:
    assert rank.spoiling([suspect("samples_dropped")])
    assert not rank.spoiling([suspect("current_offset"), suspect("supply_limited")])
    assert not rank.spoiling([suspect("samples_dropped", allowed=True)])
    assert not rank.spoiling([])


def test_a_named_fault_says_what_it_explains_and_moves() -> None:
    said = rank._said(trial(share=0.62), [], solution(), " (run 2)")
    assert said.evidence == (
        "it is 0.0003 s late; that explains 62 % of the misfit, and taken into account moves R by "
        "+10.0% (run 2)"
    ).replace("62 %", "62%")
    assert said.strength == "named"
    assert said.moves["R"] == pytest.approx(0.1 * MOTOR["R"])
    assert said.moves["L"] == 0.0


@pytest.mark.parametrize(("share", "rest"), [(0.3, 0.7), (0.49, 0.51), (0.51, 0.0), (1.2, 0.0)])
def test_the_rest_of_a_misfit_may_hide_more_than_its_fault(
    share: float, rest: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []

    def hidden(records: Any, solution: Any, left: float) -> dict[str, float]:
        asked.append((records, left))
        return {name: 0.2 * value * (name in {"R", "L"}) for name, value in MOTOR.items()}

    monkeypatch.setattr(rank.reach, "hidden", hidden)
    record: Any = object()
    said = rank._said(trial(shift=0.1, share=share), [record], solution(), "")
    assert asked == ([([record], pytest.approx(rest))] if rest else [])
    assert said.moves["R"] == pytest.approx((0.2 if rest else 0.1) * MOTOR["R"])
    assert said.moves["L"] == pytest.approx(0.2 * MOTOR["L"] if rest else 0.0)
    assert said.moves["J"] == 0.0


@pytest.mark.parametrize("share", [0.25, 0.05])
def test_a_share_of_a_parameter_that_is_the_faults_own_may_be_missing_in_it(share: float) -> None:
    found = trial(shift=0.1)
    own = replace(found.hypothesis, belongs=lambda size: {"J": share, "R": share * size[0] / 3e-4})
    values = np.array([v * (1.0 + 0.1 * (n == "R")) for n, v in MOTOR.items()])
    said = rank._said(replace(found, hypothesis=own), [], solution(), "")
    assert said.moves["J"] == pytest.approx(share * MOTOR["J"])
    R = values[list(MOTOR).index("R")]
    assert said.moves["R"] == pytest.approx(max(share * R, 0.1 * MOTOR["R"]))
    assert said.moves["L"] == 0.0
    nowhere = replace(own, belongs=lambda size: {"no such": 0.5})
    assert "no such" not in rank._said(replace(found, hypothesis=nowhere), [], solution(), "").moves


def runs(monkeypatch: pytest.MonkeyPatch, *excesses: float) -> int | None:
    left = iter(excesses)
    monkeypatch.setattr(misfit, "residuals", lambda *_: [])
    monkeypatch.setattr(misfit, "excess", lambda *_: next(left))
    some: Sequence[Any] = [SimpleNamespace() for _ in excesses]
    return rank._odd(some, [solution() for _ in excesses])


def test_the_run_that_misfits_far_more_is_looked_at_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    assert runs(monkeypatch, 0.1, 0.9, 0.2) == 1
    assert runs(monkeypatch, 0.1, 0.45, 0.2) is None  # not twice the others', and a little
    assert runs(monkeypatch, 0.0, 0.0, 0.11) == 2
    assert runs(monkeypatch, 0.0, 0.0, 0.09) is None
    assert runs(monkeypatch, 5.0) is None  # of one run there is no other


def test_a_fit_begins_with_another_motor_where_that_has_values() -> None:
    at = refit.at(solution(), {"R": 3.0, "J": -1.0, "other": 5.0}, 1e-4)
    assert dict(zip(MOTOR, at.values.tolist(), strict=True)) == {**MOTOR, "R": 3.0}


def test_an_inductance_that_vanished_begins_where_readings_tell_it() -> None:
    period_s = 1e-4
    gone = refit.at(solution(L=0.04 * 2.0 * period_s), {}, period_s)
    assert gone.values[1] == pytest.approx(0.3 * 2.0 * period_s)
    there = refit.at(solution(L=0.06 * 2.0 * period_s), {}, period_s)
    assert there.values[1] == 0.06 * 2.0 * period_s


def test_without_a_current_a_fit_begins_at_the_solution_alone() -> None:
    record = SimpleNamespace(
        names=tuple(MOTOR), motor=lambda values: values, timeline=SimpleNamespace(period_s=1e-4),
        measured=(), capture=SimpleNamespace(path=None, get=lambda _: None),
        sensed=SimpleNamespace(waveform=None),
    )  # fmt: skip
    starts = refit.starts([record], solution())  # type: ignore[list-item]
    assert len(starts) == 1
    assert starts[0].values == pytest.approx(list(MOTOR.values()))
    assert math.isfinite(starts[0].objective)


def rivals(
    monkeypatch: pytest.MonkeyPatch, gains: Sequence[float], least: float = 10.0,
    seen: bool = False, lacks: float = 0.0,
) -> list[tuple[Any, Any, Any, bool]]:  # fmt: skip
    """Hypotheses of such gains, by a screen that is given; and one of the blocks."""

    def score(name: Any) -> Any:
        gain = lacks if name == "model" else gains[name]
        return SimpleNamespace(hypothesis=name, gain=gain, size=("size", name))

    start = SimpleNamespace(size="its size", motor={"R": 7.0})
    blocks = SimpleNamespace(seen=lambda _: ("slips", start) if seen else None)
    module = SimpleNamespace(hypotheses=lambda _: range(len(gains)))
    monkeypatch.setattr(rank, "SEEN", (blocks,))
    monkeypatch.setattr(rank, "SCREENED", (module,))
    monkeypatch.setattr(rank, "Screen", lambda *_: SimpleNamespace(best=score))
    monkeypatch.setattr(rank, "model_alternatives", SimpleNamespace(hypotheses=lambda _: ["model"]))
    records: Any = [SimpleNamespace(timeline=SimpleNamespace(period_s=1e-4))]
    return list(rank._rivals(records, solution(), least))


def test_rivals_promise_enough_and_a_share_of_the_best(monkeypatch: pytest.MonkeyPatch) -> None:
    assert [r[0] for r in rivals(monkeypatch, [9.0, 200.0, 11.0, 21.0])] == [1, 3]
    assert [r[0] for r in rivals(monkeypatch, [9.0, 50.0, 11.0])] == [1, 2]
    assert [r[0] for r in rivals(monkeypatch, [50.0, 60.0, 70.0, 80.0, 90.0])] == [4, 3, 2, 1]
    for hypothesis, size, begin, by_blocks in rivals(monkeypatch, [50.0]):
        assert (hypothesis, size, begin, by_blocks) == (0, ("size", 0), None, False)


def test_what_the_blocks_show_begins_with_its_own_motor(monkeypatch: pytest.MonkeyPatch) -> None:
    ((hypothesis, size, begin, by_blocks),) = rivals(monkeypatch, [1.0], seen=True)
    assert (hypothesis, size, by_blocks) == ("slips", "its size", True)
    assert begin is not None
    own, usual = begin
    assert own.values[0] == 7.0
    assert usual.values == pytest.approx(list(MOTOR.values()))


def test_what_the_model_lacks_is_tried_where_a_fault_is(monkeypatch: pytest.MonkeyPatch) -> None:
    assert rivals(monkeypatch, [1.0], lacks=50.0) == []
    found = rivals(monkeypatch, [20.0], lacks=50.0)
    assert [r[0] for r in found] == [0, "model"]
    assert len(found[1][2]) == 1
    assert [r[0] for r in rivals(monkeypatch, [20.0], lacks=9.0)] == [0]
    assert [r[0] for r in rivals(monkeypatch, [100.0], lacks=49.0)] == [0]  # half of the best
    assert [r[0] for r in rivals(monkeypatch, [100.0], lacks=51.0)] == [0, "model"]


def test_each_runs_readings_say_of_which_run_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("lost_samples", "lost_rows", "repeated_readings", "at_supply",
                 "current_zero", "current_limited_supply"):  # fmt: skip
        module = SimpleNamespace(suspects=lambda *_, code=name: [suspect(code)])
        room = rank.encoder_bandwidth if name == "lost_samples" else rank
        monkeypatch.setattr(room, name, module)
    one: Any = SimpleNamespace(capture=None, timeline=None, judged_at=None)
    alone, both = rank.direct([one]), rank.direct([one, one])
    assert [s.evidence for s in alone] == ["so"] * 6
    assert [s.evidence for s in both] == ["so (run 1)"] * 6 + ["so (run 2)"] * 6
    assert len({s.code for s in alone}) == 6


def accused(
    monkeypatch: pytest.MonkeyPatch, seen: Sequence[Suspect], found: Trial | None,
    odd: int | None = None,
) -> tuple[tuple[Suspect, ...], rank.Convicted | None]:  # fmt: skip
    monkeypatch.setattr(rank, "direct", lambda _: list(seen))
    for fitted in (rank.unstated_channels, rank.pulse_distortion, rank.high_pass_filter):
        monkeypatch.setattr(fitted, "suspects", lambda *_: [])
    records: Any = ["one", "two", "three"]
    some = records if odd is None else records[odd : odd + 1]
    monkeypatch.setattr(rank, "_odd_one_out", lambda *_: (some, solution(), odd))
    monkeypatch.setattr(rank, "tried", lambda *_: found)
    return rank.suspects(records, solution(), {})


def test_a_convicted_fault_is_named_after_what_the_readings_show(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    harmless = suspect("supply_limited")
    said, convicted = accused(monkeypatch, [harmless], trial())
    assert said[0] is harmless
    assert convicted is not None
    assert said[1] is convicted.suspect
    assert convicted.records == (0, 1, 2)
    assert "(run" not in convicted.suspect.evidence
    _, convicted = accused(monkeypatch, [], trial(), odd=1)
    assert convicted is not None
    assert convicted.records == (1,)
    assert convicted.suspect.evidence.endswith("(run 2)")


def test_nothing_is_tried_where_the_readings_spoil_the_fit_or_say_it_already(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    lost = suspect("samples_dropped")
    assert accused(monkeypatch, [lost], trial()) == ((lost,), None)
    same = replace(suspect("current_lag"), allowed=True)
    assert accused(monkeypatch, [same], trial()) == ((same,), None)
    assert accused(monkeypatch, [], None) == ((), None)
