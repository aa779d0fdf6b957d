"""What is remarked on an answer that was made by hand."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, Gap, Wiring
from motorid.estimate.diagnosis import data_remarks, remarks
from motorid.estimate.effects.brush_and_heating import BENT, DROP
from motorid.estimate.effects.source.brush_drop import BRUSH_DROP
from motorid.estimate.results.estimate import Diagnostic
from motorid.estimate.uncertainty import intervals
from motorid.program import StepKind
from tests.estimate.made_findings import RELATIVE, findings
from tests.exact_capture import FAULHABER, clean_capture

RISE_S = 3e-3 / 2.0  # L/R of the findings


def record(period_s: float = 1e-4, **changes: Any) -> Any:
    given = {
        "timeline": SimpleNamespace(period_s=period_s, count=2000, parts=()), "foretold": None,
        "capture": clean_capture(FAULHABER), "volts": np.array([0.0, 6.0, -9.0]),
        "shown_parts": [SimpleNamespace(discontinuous=False)], "rivals": (),
    }  # fmt: skip
    return SimpleNamespace(**{**given, **changes})


def wired(**facts: Any) -> Any:
    return replace(clean_capture(FAULHABER), wiring=Wiring(**facts))


def only(found: list[Diagnostic]) -> Diagnostic:
    (one,) = found
    return one


@pytest.mark.parametrize(("drop", "bent", "said"), [(0.02, 0.0, True), (0.006, 0.0, False),
                                                    (0.008, 0.008, True)])  # fmt: skip
def test_an_unknown_drop_is_named_where_it_is_most_of_the_uncertainty(
    drop: float, bent: float, said: bool
) -> None:
    found = findings(causes={DROP: {"R": drop}, BENT: {"R": bent}})  # noise .01
    names = [one.code for one in remarks._brushes(found, [record()])]
    assert names == (["drop_or_resistance"] if said else [])


def test_its_remedy_depends_on_what_was_declared() -> None:
    found = findings(causes={DROP: {"R": 0.05}})
    undeclared = only(remarks._brushes(found, [record()]))
    assert undeclared.message.endswith(BRUSH_DROP.remedy)
    declared = record(capture=wired(brush_drop_v=0.4))
    assert only(remarks._brushes(found, [declared])).message.endswith("the two; add a level")
    both = only(remarks._brushes(found, [declared, record()]))
    assert both.message.endswith(BRUSH_DROP.remedy)


def test_an_inductance_by_ripple_says_where_it_comes_from() -> None:
    told = SimpleNamespace(by="swing", shift={"L": 0.07})
    one = only(remarks._by_ripple(findings(), [record(foretold=told), record(RISE_S)]))
    assert "L/R is 15 sample periods" in one.message
    assert "the current's swing within the PWM periods, to 7 %" in one.message
    assert "at the PWM frequency" in one.message
    assert remarks._by_ripple(findings(), [record()]) == []


@pytest.mark.parametrize(("pulsed", "part", "said"), [(True, 0.19, True), (True, 0.21, False),
                                                      (False, 0.19, False)])  # fmt: skip
def test_so_does_one_that_readings_tell_by_what_happens_within_them(
    pulsed: bool, part: float, said: bool
) -> None:
    pulses = [SimpleNamespace(discontinuous=False), SimpleNamespace(discontinuous=pulsed)]
    found = remarks._by_ripple(findings(), [record(RISE_S / part, shown_parts=pulses)])
    assert ["the current's pulses within" in one.message for one in found] == [True] * said


def test_a_bridge_that_drops_moves_what_its_bend_hides() -> None:
    dropping = record(RISE_S / 2, capture=wired(bridge_drop_v=2.5))
    one = only(remarks._dropping(findings(), [dropping]))
    most = float(np.abs(clean_capture(FAULHABER).channels[CURRENT].values).max())
    assert one.moves == {"L": 3e-3, "R": pytest.approx(0.25 * 2.5 / most)}
    assert one.severity == "warning"
    assert "L/R is 2 sample periods, and the bridge drops 2.5 V" in one.message


@pytest.mark.parametrize(("drop", "periods"), [(0.0, 2.0), (2.5, 4.1)])
def test_no_drop_or_a_slow_rise_hides_nothing(drop: float, periods: float) -> None:
    one = record(RISE_S / periods, capture=wired(bridge_drop_v=drop))
    assert remarks._dropping(findings(), [one]) == []


@pytest.mark.parametrize(
    ("widest", "between", "codes"),
    [
        (1.31, True, ["widened"]),
        (1.3, True, []),
        (1.29, True, []),
        (1.0, False, ["few_runs"]),
        (2.0, False, ["widened", "few_runs"]),
    ],
)
def test_what_widened_and_what_one_run_cannot_show(
    widest: float, between: bool, codes: list[str]
) -> None:
    found = findings()
    known = replace(found.statistical, coloured=widest, between_runs=between)
    said = remarks._statistics(replace(found, statistical=known))
    assert [one.code for one in said] == codes


def test_parameters_that_share_what_is_not_known() -> None:
    found = findings(correlation={("B", "T0"): -0.99, ("R", "K"): 0.99})
    pairs = remarks._inseparable(found, intervals.parameters(found))
    assert pairs == [("B", "T0", pytest.approx(-0.99))]  # K is known well enough
    one = only(remarks._told_apart(pairs))
    assert one.message.endswith("by their correlation: B and T0 (-0.990).")
    assert remarks._told_apart([]) == []
    loose = findings({**RELATIVE, "K": 0.02, "R": 0.02}, correlation={("R", "K"): 0.979})
    assert remarks._inseparable(loose, intervals.parameters(loose)) == []


def test_the_largest_cause_of_each_variance_and_what_to_mend_first() -> None:
    one = only(remarks.budget({
        "R": {"noise": 3.0, "winding temperature": 4.0}, "K": {"noise": 2.0, "clock": 1.0},
        "J": {"noise": 5.0}, "B": {"noise": 0.0},
    }))  # fmt: skip
    assert one.message.startswith(
        "Largest part of each variance: noise for K (80 %), J (100 %); winding temperature for R "
        "(64 %). To narrow most, "
    )
    assert remarks.budget({"B": {"noise": 0.0}}) == []


def test_the_run_to_add_is_in_the_motors_own_volts() -> None:
    motor = findings().motor()
    one = only(remarks._run_to_add(["J"], motor, [record()]))
    assert "9 V" in one.message
    assert remarks._run_to_add([], motor, [record()]) == []


def part(kind: StepKind, level: float, **changes: Any) -> Any:
    return SimpleNamespace(
        **{"kind": kind, "level": level, "discontinuous": False, "still": False, **changes}
    )


def test_where_the_motor_stood_still() -> None:
    parts = (
        part(StepKind.DRIVE_VOLTS, 0.5, still=True), part(StepKind.DRIVE_VOLTS, -0.5, still=True),
        part(StepKind.DRIVE_VOLTS, 6.0),
    )  # fmt: skip
    one = record(timeline=SimpleNamespace(parts=parts))
    assert "levels -0.5, 0.5," in only(data_remarks.standing([one, one])).message
    moving = record(timeline=SimpleNamespace(parts=parts[2:]))
    assert data_remarks.standing([moving]) == []


def stamped(**changes: Any) -> list[str]:
    line = {"lost": 0, "past": None, "jitter": 0.0, "coarser": 1.0, "parts": (), "period_s": 1e-4}
    one = record(
        timeline=SimpleNamespace(**{**line, **changes}), sources=(),
        sensed=SimpleNamespace(resolution=0.0),
    )  # fmt: skip
    return [f"{d.severity} {d.code}" for d in data_remarks.of_capture(one, "")]


def test_stamps_that_are_not_as_they_should_be() -> None:
    some = np.zeros(3)
    assert stamped() == []
    assert stamped(lost=3) == ["warning lost_samples"]
    assert stamped(jitter=0.1) == ["warning jitter"]
    assert stamped(jitter=0.01) == []
    assert stamped(lost=3, past=some, jitter=0.1) == ["info lost_samples", "info irregular_stamps"]
    assert stamped(past=some) == []
    assert stamped(coarser=2.1) == ["info coarse_grid"]
    assert stamped(coarser=1.9) == []


def test_readings_at_the_end_of_a_range_and_used_one_by_one() -> None:
    capture = clean_capture(FAULHABER)
    current = capture.channels[CURRENT]
    most = float(np.sort(current.raw)[-3])
    clipped = replace(capture, channels={
        **capture.channels, CURRENT: replace(current, raw_max=most),
    })  # fmt: skip
    line = SimpleNamespace(lost=0, past=None, jitter=0.0, coarser=1.0, period_s=1e-4, parts=(
        SimpleNamespace(open=True), SimpleNamespace(open=False), SimpleNamespace(open=False),
    ))  # fmt: skip
    as_read = SimpleNamespace(as_read=True)
    one = record(
        timeline=line, capture=clipped, sources=(as_read, as_read, SimpleNamespace(as_read=False)),
        sensed=SimpleNamespace(resolution=0.01),
    )  # fmt: skip
    found = {d.code: d for d in data_remarks.of_capture(one, " in run 2")}
    assert found["saturated"].message.startswith("3 readings of the current are at the end")
    assert found["saturated"].severity == "warning"
    assert found["voltage_readings"].message.startswith("in 1 driven part in run 2 ")
    assert found["voltage_readings"].severity == "info"


def test_a_capture_without_a_channel_has_none_of_its_readings_left_out() -> None:
    capture = replace(clean_capture(FAULHABER), channels={})
    line = SimpleNamespace(lost=0, past=None, jitter=0.0, coarser=1.0, period_s=1e-4, parts=())
    one = record(
        timeline=line, capture=capture, sources=(), sensed=SimpleNamespace(resolution=0.01)
    )
    assert data_remarks.of_capture(one, "") == []


def gapped(*gaps: tuple[int, int], program: bool = False) -> int:
    """Samples of a log that only came at a slower pace."""
    known = tuple(Gap(index, samples, "") for index, samples in gaps)
    capture = replace(clean_capture(FAULHABER), gaps=known)
    return data_remarks._slower(capture if program else replace(capture, program=None))


def test_a_logger_that_went_on_more_slowly_has_lost_nothing() -> None:
    slow = [(k, 3) for k in range(100, 110)]
    assert gapped(*slow) == 30
    assert gapped(*slow, (500, 3)) == 30  # one pause by itself is a loss
    assert gapped((50, 7), *slow, (110, 4)) == 30
    assert gapped((100, 3), (101, 3)) == 6
    assert gapped((100, 3), (102, 3)) == 0
    assert gapped((100, 3)) == 0
    assert gapped(*slow, program=True) == 0


def test_a_current_that_stops_is_said_with_its_share_and_its_levels() -> None:
    parts = (
        part(StepKind.DRIVE_DUTY, 0.3, discontinuous=True), part(StepKind.DRIVE_DUTY, 0.8),
        part(StepKind.DRIVE_DUTY, -0.3, discontinuous=True),
    )  # fmt: skip
    timeline = SimpleNamespace(parts=parts, stopped=np.arange(10) < 4)
    bare = replace(clean_capture(FAULHABER), channels={})
    one = record(driven=np.arange(10) < 8, timeline=timeline, capture=bare)
    said = only(data_remarks.stopping([one, one]))
    assert "in 50 % of the driven time (levels -0.3, 0.3): there" in said.message
    assert "left out" not in said.message
    flowing = record(driven=np.ones(10, bool), capture=bare,
                     timeline=SimpleNamespace(parts=parts, stopped=np.zeros(10, bool)))  # fmt: skip
    assert data_remarks.stopping([flowing]) == []


def test_only_the_voltage_of_a_log_is_unknown_between_stamps() -> None:
    with_program = record(sensed=SimpleNamespace(waveform=None))
    log = record(sensed=SimpleNamespace(waveform="read"))
    assert data_remarks.unseen_voltage([with_program]) == []
    assert only(data_remarks.unseen_voltage([with_program, log])).severity == "warning"


def test_all_that_is_found_is_said_the_gravest_first(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[str, str]] = []
    lacks = True

    def remark(code: str, severity: str) -> Diagnostic:
        return Diagnostic(code, severity, "")  # type: ignore[arg-type]

    def lack(
        run: Any, m: Any, _residual: Any, segments: Any, where: str, driven: float
    ) -> list[Diagnostic]:
        asked.append((m.block.name, where))
        assert driven == (0.1 if m.block.name == "current" else 0.2)
        assert segments == (["segments of it"] if where in ("", " in run 1") else ["others"])
        return [remark(f"lack of {m.block.name}", "warning")] if lacks else []

    def said(code: str) -> Any:
        return lambda *_: [remark(code, "info")]

    for module, names in (
        (remarks, ("_statistics", "_budget", "_brushes", "_by_ripple", "_dropping", "_run_to_add")),
        (remarks.data_remarks, ("of_capture", "stopping", "standing")),
        (remarks.lagging_start, ("remarks",)),
        (remarks.sampling_remarks, ("of_logs", "slow_voltage")),
        (remarks.repeating_remarks, ("allowed_for",)),
    ):  # fmt: skip
        for name in names:
            monkeypatch.setattr(module, name, said(name))
    monkeypatch.setattr(remarks.residual_remarks, "lack_of_fit", lack)
    monkeypatch.setattr(
        remarks.input_noise, "where_lacking", lambda runs, *_: [[0.1, 0.2] for _ in runs]
    )
    monkeypatch.setattr(
        remarks.residual_remarks, "neighbour_correlation", lambda r: [0.5] if r[0] > 0 else []
    )
    monkeypatch.setattr(
        remarks.residual_remarks, "coloured", lambda name, rhos: remark(f"{name} {rhos}", "info")
    )
    monkeypatch.setattr(remarks, "_inseparable", lambda *_: [])

    def run(untried: int = 0) -> Any:
        measured = [SimpleNamespace(block=SimpleNamespace(name=n)) for n in ("current", "speed")]
        return record(
            measured=measured, untried=untried, departures=lambda *_: None,
            weighed=lambda *_, filtered: [np.array([1.0]), np.array([-1.0])],
        )  # fmt: skip

    answer = findings()
    solution = replace(answer.solution, own=(None, None), converged=False, promised=1.0)  # type: ignore[arg-type]
    answer = replace(answer, solution=solution)
    parameters = intervals.parameters(answer)
    named: Any = [("", ["segments of it"]), ("", ["others"])]
    found = remarks.diagnostics(answer, [run(), run(2)], parameters, named)
    assert asked == [(n, f" in run {k}") for k in (1, 2) for n in ("current", "speed")]
    order = [d.severity for d in found]
    assert order == sorted(order, key=["error", "warning", "info"].index)
    assert found[0].code == "not_converged"
    bounded = next(d for d in found if d.code == "search_bounded")
    assert "2 other starts were left out" in bounded.message
    codes = [d.code for d in found]
    assert codes.count("of_capture") == 2
    assert "current [0.5, 0.5]" in codes  # of both runs together
    assert not any(code.startswith("speed") for code in codes)
    assert {"_statistics", "_budget", "_dropping", "stopping", "standing", "of_logs"} <= set(codes)
    near = replace(answer, solution=replace(solution, promised=0.9))
    told = {d.code: d for d in remarks.diagnostics(near, [run(), run()], parameters, named)}
    assert "not_converged" not in told
    assert told["search_unfinished"].severity == "info"
    assert "0.9 of chi-square" in told["search_unfinished"].message
    settled = replace(answer, solution=replace(solution, own=(None,), converged=True))  # type: ignore[arg-type]
    asked.clear()
    alone = remarks.diagnostics(settled, [run(1)], parameters, named[:1])
    assert asked == [("current", ""), ("speed", "")]
    assert "not_converged" not in {d.code for d in alone}
    assert "1 other start was left out" in next(
        d.message for d in alone if d.code == "search_bounded"
    )
    lacks = False  # there is nothing that another start might explain
    told = {d.code for d in remarks.diagnostics(settled, [run(1)], parameters, named[:1])}
    assert "search_bounded" not in told
    told = {d.code for d in remarks.diagnostics(answer, [run(1), run()], parameters, named)}
    assert "search_bounded" in told


@pytest.mark.parametrize(
    ("steps", "noise", "said"), [(40, 2.0, True), (100, 0.1, True), (100, 2.0, False),
                                 (400, 0.1, False)],
)  # fmt: skip
def test_readings_in_few_steps_are_coarse_and_so_are_some_more_without_noise(
    steps: int, noise: float, said: bool
) -> None:
    """``noise`` in steps."""
    capture = clean_capture(FAULHABER)
    current = capture.channels[CURRENT]
    step = float(np.abs(current.values).max()) / steps
    rough = current.values + noise * step * np.random.default_rng(2).normal(size=len(capture))
    coarse = replace(current, raw=np.round(rough / step), scale=step, resolution=step)
    one = record(capture=replace(capture, channels={**capture.channels, CURRENT: coarse}))
    found = data_remarks.coarse(one, " in run 2")
    assert [(d.code, d.severity) for d in found] == ([("coarse_readings", "info")] if said else [])
    assert all(f"{step:.3g} A" in d.message and "coarse in run 2" in d.message for d in found)
