"""Repairs one after the other, what stands beside an answer, and what is listed."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.errors import DataError
from motorid.estimate.assembly import assemble
from motorid.estimate.assembly.assemble import Accused
from motorid.estimate.results.estimate import Diagnostic, Suspect
from motorid.estimate.signals.time_grid import Part
from motorid.estimate.uncertainty.budget import Carried
from motorid.program import StepKind
from tests.report.example import estimate


def suspect(code: str, **facts: Any) -> Suspect:
    return Suspect(code, "here", "so", "do", **{"strength": "named", **facts})


class Repairs:
    """Faults that are repaired in turn; the answers of each."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, *codes: str, worst: Any = None,
                 profiled: bool = True) -> None:  # fmt: skip
        self.left, self.judged = list(codes), dict[str, Any]()
        self.asked = list[tuple[str, ...]]()
        self.worst = worst
        monkeypatch.setattr(assemble, "uncertain", lambda _r, solution, *_: f"known {solution}")
        monkeypatch.setattr(assemble, "unjudged", lambda captures, *_: f"found {captures}")
        monkeypatch.setattr(assemble, "accused", lambda *_: self.said())
        monkeypatch.setattr(assemble, "repaired", self.mend)
        monkeypatch.setattr(assemble, "judged", self.judge)
        records: Any = [SimpleNamespace(capture="run 0")]
        solution: Any = "first"
        captures: Any = ["run"]
        self.answer = assemble.answered(captures, records, solution, {}, (), profiled)

    def said(self) -> Accused:
        return Accused(self.worst, tuple(suspect(code) for code in self.left), None)

    def mend(self, _r: Any, _s: Any, found: Any, *_: Any) -> Any:
        self.asked.append(tuple(one.code for one in found))
        if not self.left:
            return None
        code = self.left.pop(0)
        n = len(self.asked)
        return SimpleNamespace(
            records=[SimpleNamespace(capture=f"run {n}")], solution=f"without {code}",
            suspect=suspect(code, allowed=True),
        )  # fmt: skip

    def judge(self, found: Any, _r: Any, solution: Any, said: Accused, refusable: bool) -> Any:
        self.judged = {"found": found, "solution": solution, "refusable": refusable,
                       "codes": [one.code for one in said.suspects]}  # fmt: skip
        return "estimate"


def test_faults_are_repaired_one_after_the_other(monkeypatch: pytest.MonkeyPatch) -> None:
    repairs = Repairs(monkeypatch, "lag", "zero")
    assert repairs.asked == [("lag", "zero"), ("lag", "zero"), ("lag", "zero")]
    assert repairs.judged == {
        "found": "found ['run 2']", "solution": "without zero", "refusable": True,
        "codes": ["lag", "zero"],
    }  # fmt: skip
    answer, records, known = repairs.answer
    assert (answer, known) == ("estimate", "known without zero")
    assert records[0].capture == "run 2"  # type: ignore[comparison-overlap]


def test_no_more_than_three_are_repaired(monkeypatch: pytest.MonkeyPatch) -> None:
    repairs = Repairs(monkeypatch, *"abcde")
    assert len(repairs.asked) == assemble.MOST_REPAIRS
    assert repairs.judged["codes"] == ["a", "b", "c", "d", "e"]


def test_nothing_is_repaired_of_what_no_motor_gives_or_of_another_method(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for how in ({"worst": "channel"}, {"profiled": False}):
        repairs = Repairs(monkeypatch, "lag", **how)  # type: ignore[arg-type]
        assert repairs.asked == []
        assert repairs.judged["solution"] == "first"
        assert repairs.judged["found"] == "found ['run']"


def test_a_fault_that_is_allowed_for_is_said_once(monkeypatch: pytest.MonkeyPatch) -> None:
    said = Accused(None, (suspect("lag"), suspect("zero")), None)
    after = said.after([suspect("zero", allowed=True)])
    assert [(s.code, s.allowed) for s in after.suspects] == [("zero", True), ("lag", False)]


def judged(monkeypatch: pytest.MonkeyPatch, worst: Any = None, refusable: bool = True,
           names: Any = assemble.UNCHANGED) -> tuple[Any, list[str]]:  # fmt: skip
    asked: list[str] = []

    def of_lack(findings: Any, *_: Any) -> Any:
        asked.append("lack")
        return findings

    monkeypatch.setattr(assemble, "refused", lambda found, _: ("refused", found.suspects))
    monkeypatch.setattr(assemble.reach, "sized", lambda found, *_: found)
    monkeypatch.setattr(assemble.reach, "of_lack", of_lack)
    monkeypatch.setattr(assemble.doubt, "settled", lambda found, findings: (found, findings))
    one = estimate()
    one = assemble.replace(one, suspects=(suspect("untold"),), diagnostics=(
        Diagnostic("lack_of_fit", "warning", "so", {"K": 2.0}),
    ))  # fmt: skip
    said = Accused(worst, (suspect("lag", moves={"K": 1.0, "R": 3.0}),), None)
    nothing: Any = None
    return assemble.judged(one, [], nothing, said, names, refusable), asked


def test_suspects_come_first_and_all_findings_settle_the_values(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    (found, findings), asked = judged(monkeypatch)
    assert [s.code for s in found.suspects] == ["lag", "untold"]
    assert [f.code for f in findings] == ["lag", "untold", "lack_of_fit"]
    assert asked == ["lack"]
    (found, _), _ = judged(monkeypatch, names={"K": "J/K²"})
    assert found.suspects[0].moves == {"J/K²": 1.0, "R": 3.0}
    assert found.diagnostics[0].moves == {"J/K²": 2.0}


def test_what_no_motor_gives_is_refused_where_the_solution_is_the_likeliest(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found, asked = judged(monkeypatch, worst="channel")
    assert found[0] == "refused"
    assert [s.code for s in found[1]] == ["lag"]
    assert asked == []
    (found, _), asked = judged(monkeypatch, worst="channel", refusable=False)
    assert asked == ["lack"]
    assert judged(monkeypatch, refusable=False)[1] == []


def driven(*parts: Part, volts: Any) -> Any:
    return SimpleNamespace(volts=np.asarray(volts, float), timeline=SimpleNamespace(parts=parts))


def test_the_nominal_voltage_is_the_highest_level() -> None:
    drive = StepKind.DRIVE_DUTY
    one = driven(Part(0, 4, drive), Part(4, 8, drive), Part(8, 12, StepKind.COAST),
                 volts=[3, 3, 3, 90, -6, -6, -6, 0, 50, 50, 50, 50])  # fmt: skip
    assert assemble.nominal_voltage([one, driven(Part(0, 3, drive), volts=[5, 5, 5])]) == 6.0
    log = driven(Part(0, 100), volts=np.r_[np.full(6, 9.0), np.full(94, -2.0)])
    assert assemble.nominal_voltage([log]) == pytest.approx(9.0)  # held for a twentieth
    brief = driven(Part(0, 100), volts=np.r_[np.full(3, 9.0), np.full(97, -2.0)])
    assert assemble.nominal_voltage([brief]) == pytest.approx(2.0)
    idle = driven(Part(0, 4, drive), volts=np.zeros(4))
    for none in (idle, driven(Part(0, 4, StepKind.COAST), volts=np.ones(4))):
        with pytest.raises(DataError, match="never driven"):
            assemble.nominal_voltage([none])


def test_correlations_are_bounded_and_none_where_nothing_varies() -> None:
    found = assemble.correlation(np.array([[4.0, 3.0, 0.0], [3.0, 9.0, 0.0], [0.0, 0.0, 0.0]]))
    assert found == pytest.approx(np.array([[1, 0.5, 0], [0.5, 1, 0], [0, 0, 0]]))
    beyond = assemble.correlation(np.array([[1.0, 1.2], [1.2, 1.0]]))
    assert beyond[0, 1] == 1.0


def test_what_was_estimated_of_each_capture_is_listed_unless_it_says_nothing() -> None:
    def quantity(name: str, listed: bool = True) -> Any:
        quantity = SimpleNamespace(listed=listed, scale=lambda _: 0.1, unit="A")
        return SimpleNamespace(name=name, quantity=quantity)

    record: Any = SimpleNamespace(
        instances=[quantity("offset"), quantity("hidden", False), quantity("open")]
    )
    spread = np.diag([0.09**2, 1.0, 1.01**2])
    solution: Any = SimpleNamespace(
        own=[np.array([0.5, 1.0, 2.0])] * 2, own_covariance=[spread] * 2
    )
    with pytest.MonkeyPatch.context() as patch:
        hidden = [np.array([0.12**2, 0, 0]), np.zeros(3)]
        patch.setattr(assemble.errors_in_variables, "own_variance", lambda _, k, n: hidden[k][:n])
        own = {"gain": (np.array([0.08, 0.0, 0.0]), np.zeros(3))}
        known: Any = SimpleNamespace(solution=solution, hidden=(), carried=Carried({}, own))
        found = assemble.nuisance_parameters(known, [record, record])
        alone = assemble.nuisance_parameters(known, [record])
    assert set(found) == {"offset of run 1", "offset of run 2"}
    one = found["offset of run 1"]
    assert (one.value, one.unit) == (0.5, "A")
    assert (one.statistical, one.instrument) == pytest.approx((0.15, 0.08))
    assert one.total == pytest.approx(0.17)
    assert one.interval_95 == pytest.approx((0.5 - 1.96 * 0.17, 0.5 + 1.96 * 0.17), rel=1e-3)
    assert found["offset of run 2"].total == pytest.approx(0.09)
    assert set(alone) == {"offset"}
