"""What a misfit and a fault of unknown size may move, by the parts of a program and by its norm."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import POSITION, Capture, Channel
from motorid.estimate.diagnosis import misfit, reach
from motorid.estimate.results.estimate import Diagnostic, Parameter, Suspect
from motorid.estimate.results.status import Status
from motorid.estimate.solver.problem import Linearised, Solution, Unknown

RNG = np.random.default_rng(4)
N = 240


def solution(residual: np.ndarray, columns: np.ndarray) -> Solution:
    line = Linearised(
        residual, columns, np.zeros((N, 0)), columns, np.zeros(0), (), (slice(0, N),), np.ones(1)
    )
    return Solution(
        (Unknown("R", 2.0, log=True), Unknown("T0", 0.1)), np.array([2.0, 0.1]), (np.zeros(0),),
        (), columns.T @ columns, np.zeros(2, dtype=bool), lambda: (line,), 0.0, 1, True,
    )  # fmt: skip


def test_parts_that_each_want_another_answer_disagree(monkeypatch: pytest.MonkeyPatch) -> None:
    """A step of R up in one part and down in another: the sum of squares of what each pulls."""
    columns = RNG.standard_normal((N, 2))
    part = np.arange(N) * 4 // N
    for away in (0.0, 3.0):
        residual = columns[:, 0] * away * np.array([1.0, -1.0, 1.0, -1.0])[part]
        found = solution(residual, columns)
        monkeypatch.setattr(reach, "by_part", lambda *_: [part])
        inverse = np.linalg.inv(columns.T @ columns)
        pulls = [inverse @ (columns[part == k].T @ residual[part == k]) for k in range(4)]
        spread = np.sum(np.square(pulls), axis=0) - reach.BY_NOISE * np.diag(inverse)
        wanted = 2.0 * np.sqrt(np.maximum(spread, 0.0)) * [2.0, 1.0]
        moves = reach.disagreement([], found)
        assert list(moves.values()) == pytest.approx(wanted.tolist())
        assert (moves["R"] > 0.0) is (away > 0.0)


def test_a_log_is_cut_evenly_where_it_has_too_few_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    pieces = reach._pieces([slice(0, 80), slice(80, 160)], 160)
    assert np.bincount(pieces).tolist() == [20] * 8
    assert (np.diff(pieces[:80]) >= 0).all()
    assert pieces[80] == 0
    columns = RNG.standard_normal((N, 2))
    eighths = np.arange(N) * 8 // N
    found = solution(5.0 * columns[:, 0] * (-1.0) ** eighths, columns)
    monkeypatch.setattr(reach, "by_part", lambda *_: [np.arange(N) * 2 // N])
    as_two = reach.disagreement([], found)
    monkeypatch.setattr(reach, "by_part", lambda *_: [eighths])
    assert reach.disagreement([], found) == pytest.approx(as_two)


def test_three_parts_of_a_program_show_a_disagreement(monkeypatch: pytest.MonkeyPatch) -> None:
    """By what each of them pulls: of a first that is off alone, the pieces of a log say less."""
    columns = np.ones((N, 2)) * [1.0, 0.0] + RNG.standard_normal((N, 2)) * [0.0, 1.0]
    thirds = np.arange(N) * 3 // N
    residual = np.array([4.0, -4.0, 0.0])[thirds]
    monkeypatch.setattr(reach, "by_part", lambda *_: [thirds])
    inverse = np.linalg.inv(columns.T @ columns)
    pulls = [inverse @ (columns[thirds == k].T @ residual[thirds == k]) for k in range(3)]
    spread = np.square(pulls).sum(axis=0) - 2.0 * np.diag(inverse)
    found = reach.disagreement([], solution(residual, columns))
    assert found["R"] == pytest.approx(2.0 * 2.0 * np.sqrt(spread[0]))


def test_a_fault_may_hide_a_part_of_the_norm_beyond_noise(monkeypatch: pytest.MonkeyPatch) -> None:
    columns = RNG.standard_normal((N, 2))
    found = solution(np.zeros(N), columns)
    m = SimpleNamespace(block=SimpleNamespace(count=60.0))
    record: Any = SimpleNamespace(measured=[m])
    left = np.full(N, 2.0)
    monkeypatch.setattr(misfit, "residuals", lambda *_: [[left]])
    deviations = np.sqrt(np.diag(np.linalg.inv(columns.T @ columns)))
    for noise, share in ((1.0, 0.75), (4.0, 0.0), (9.0, 0.0)):
        monkeypatch.setattr(misfit, "noise_variance", lambda *_, v=noise: v)
        moves = reach.hidden([record], found)
        wanted = np.sqrt(60.0 * share) / 3.0 * deviations * [2.0, 1.0]
        assert list(moves.values()) == pytest.approx(wanted.tolist())


def parameter(value: float | None, half: float = 0.2) -> Parameter:
    if value is None:
        return Parameter("R", "", None, None, None, None, None, Status.NOT_IDENTIFIABLE)
    ends = (value - half, value + half)
    return Parameter("R", "", value, half / 2, 0.0, half / 2, ends, Status.ESTIMATED)


def test_a_lack_names_what_it_moves_by_more_than_half_an_interval() -> None:
    known = {"R": parameter(2.0), "K": parameter(-4.0), "J": parameter(None)}
    said = reach._movable({"R": 0.11, "K": 0.12, "J": 9.0, "X": 9.0}, known)
    assert said == "it can move R by 5.5 %, K by 3 %"
    assert reach._movable({"R": 0.09}, known) == "the parts of the program agree on every parameter"


LACK = Diagnostic("lack_of_fit", "warning", "it lacks")
STEADY = Diagnostic("steady_speed", "warning", "off", {"K": 0.5})


def of_lack(
    monkeypatch: pytest.MonkeyPatch, said: list[Diagnostic], found: list[Suspect] | None = None,
    beyond: float = 0.04,
) -> tuple[Diagnostic, ...]:  # fmt: skip
    def moves(**given: float) -> Any:
        def of(records: Any, answer: Any) -> dict[str, float]:
            assert (records, answer) == ([], None)
            return given

        return of

    monkeypatch.setattr(reach, "disagreement", moves(R=0.5, T0=0.01))
    monkeypatch.setattr(reach, "hidden", moves(R=0.3, T0=0.02))
    monkeypatch.setattr(reach, "unexplained", lambda *_: [SimpleNamespace(beyond=beyond)])
    nothing: Any = None
    return reach.of_lack(said, found or [], [], nothing, {"R": parameter(2.0)})


def test_the_first_of_several_lacks_moves_by_the_larger_of_both(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    first, second, steady = of_lack(monkeypatch, [LACK, LACK, STEADY])
    assert first.moves == {"R": 0.5, "T0": 0.02}
    assert second.moves == {}
    assert steady.moves == {"K": 0.5}
    assert first.message == second.message == "it lacks; it can move R by 25 %"
    small = of_lack(monkeypatch, [LACK], beyond=0.029)
    assert small[0].moves == {}
    assert small[0].message == first.message
    assert of_lack(monkeypatch, [STEADY]) == (STEADY,)


def suspect(code: str = "samples_dropped", **facts: Any) -> Suspect:
    return Suspect(code, "time", "so", "do", **{"strength": "named", **facts})


def test_a_fault_that_states_its_moves_stands_for_the_misfit(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found = of_lack(monkeypatch, [LACK, STEADY], [suspect(moves={"R": 1.0})])
    assert found == (LACK, replace(STEADY, moves={}))


def test_only_named_faults_without_moves_of_their_own_are_sized(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(reach, "disagreement", lambda *_: {"R": 0.5, "T0": 0.0, "K": 1e-4})
    monkeypatch.setitem(reach.MOVING, "samples_dropped", lambda share: share)
    nothing: Any = None
    shares: Any = [0.01, 0.04]
    known = {"K": parameter(0.05), "J": parameter(2e-5), "B": parameter(None)}
    others = [
        suspect(moves={"R": 1.0}), suspect(allowed=True), suspect("current_offset"),
        suspect(strength="not excluded"),
    ]  # fmt: skip
    assert reach.sized(others, shares, nothing, known) == tuple(others)
    (one,) = reach.sized([suspect()], shares, nothing, known)
    assert one.moves == pytest.approx({"R": 0.5, "K": 0.04 * 0.05, "J": 2 * 0.04 * 2e-5})
    assert reach.sized([*others, suspect()], shares, nothing, known)[:4] == tuple(others)


def test_lost_counts_and_samples_are_shares_of_all(monkeypatch: pytest.MonkeyPatch) -> None:
    channel = Channel(POSITION, "rad", np.r_[np.arange(51.0), np.arange(49.0, -1.0, -1.0)],
                      resolution=0.5)  # fmt: skip
    capture = Capture(np.arange(101), 1e3, {POSITION: channel})
    record: Any = SimpleNamespace(capture=capture, timeline=None)
    jumps = SimpleNamespace(lost=10.0, dropped=5)
    monkeypatch.setattr(reach.lost_samples, "find", lambda *_: jumps)
    assert reach._counts(record) == pytest.approx(10.0 / 200.0)
    assert reach._time(record) == pytest.approx(5.0 / 101.0)
    monkeypatch.setattr(reach.lost_samples, "find", lambda *_: None)
    assert (reach._counts(record), reach._time(record), reach._nothing(record)) == (0.0, 0.0, 0.0)
