"""Remarks of several runs, their codes and bounds, by records and answers made by hand."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, Capture, Channel
from motorid.estimate.diagnosis import (
    data_remarks,
    localise,
    misfit,
    rank,
    reach,
    remarks,
    residual_remarks,
    sampling_remarks,
    suspects,
)
from motorid.estimate.results.estimate import Diagnostic, Parameter
from motorid.estimate.results.status import Status
from motorid.estimate.solver.problem import Linearised
from motorid.motor.parameters import Motor
from motorid.segment import SegmentKind
from tests.estimate.made_findings import findings
from tests.estimate.solutions import MOTOR, solution


def timed(period_s: float, count: int = 10_000, volts: float = 9.0) -> Any:
    timeline = SimpleNamespace(period_s=period_s, count=count)
    return SimpleNamespace(timeline=timeline, volts=np.array([-volts, 1.0]))


@pytest.mark.parametrize(
    ("records", "words"),
    [
        # of a motor of 15.5 ms, its own
        ([timed(1e-4, volts=4.0), timed(5e-5)], "47 ms at 4.5 V, 62 ms at 9 V, 47 ms of coasting"),
        # twenty samples of the finest
        ([timed(1e-3), timed(2e-3)], "60 ms at 4.5 V, 80 ms at 9 V, 60 ms of coasting"),
        # and no longer than the longest run would last at the slowest
        ([timed(1e-5, 300), timed(2e-5, 500)], "30 ms at 4.5 V, 40 ms at 9 V, 30 ms of coasting"),
    ],
)
def test_a_run_to_add_has_the_motors_time_as_far_as_samples_show_it(
    records: list[Any], words: str
) -> None:
    (said,) = remarks._run_to_add(["J"], findings().motor(), records)
    assert (said.code, said.severity) == ("run_to_add", "info")
    assert f"such as {words} from rest" in said.message


def test_the_largest_current_is_without_a_sign_and_of_what_was_read() -> None:
    for values, largest in (([0.1, -0.4, np.nan], 0.4), ([], 0.0)):
        channel = Channel(CURRENT, "A", np.array(values))
        capture = Capture(np.arange(len(values)), 1e3, {CURRENT: channel})
        assert remarks._largest_current(capture) == pytest.approx(largest)
    assert remarks._largest_current(Capture(np.arange(3), 1e3, {})) == 0.0


def test_errors_come_before_warnings_and_these_before_remarks(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def saying(*severities: Any) -> Any:
        return lambda *_: [Diagnostic(severity, severity, "") for severity in severities]

    for module, name, said in (
        (data_remarks, "of_capture", saying("info", "warning")),
        (data_remarks, "standing", saying()),
        (data_remarks, "stopping", saying("error", "info")),
        (remarks.lagging_start, "remarks", saying("warning")),
        (sampling_remarks, "of_logs", saying()),
        (sampling_remarks, "slow_voltage", saying()),
        (remarks.repeating_remarks, "allowed_for", saying()),
    ):  # fmt: skip
        monkeypatch.setattr(module, name, said)
    for name in ("_statistics", "_budget", "_brushes", "_by_ripple", "_dropping", "_run_to_add"):
        monkeypatch.setattr(remarks, name, saying())
    answer = findings()
    answer = replace(answer, solution=replace(answer.solution, own=(np.zeros(0),)))
    record: Any = SimpleNamespace(
        untried=0, rivals=(), measured=(), capture=None, departures=lambda *_: [],
        weighed=lambda parts, filtered: parts,
    )  # fmt: skip
    known = {n: Parameter(n, "", 1.0, None, None, None, None, Status.ESTIMATED) for n in MOTOR}
    found = [d.severity for d in remarks.diagnostics(answer, [record], known)]
    assert found == ["error", "warning", "warning", "info", "info"]


def test_a_few_coarse_steps_are_counted_to_the_highest_reading() -> None:
    """Twenty of .01 A to .2 A; what was not read counts for nothing."""
    values = 0.01 * np.round(np.linspace(-20.0, 15.0, 99))
    values[5] = np.nan
    channel = Channel(CURRENT, "A", values, resolution=0.01)
    record: Any = SimpleNamespace(capture=Capture(np.arange(99), 1e3, {CURRENT: channel}))
    (said,) = data_remarks.coarse(record, "")
    assert "the current comes in 20 steps of 0.01 A to its highest reading" in said.message


@pytest.mark.parametrize(("period_s", "late_s"), [(3e-3, 0.0), (1e-3, 0.05)])
def test_warnings_of_sampling_have_a_code(period_s: float, late_s: float) -> None:
    lag = SimpleNamespace(name="lag", quantity=SimpleNamespace(name="lag", unit="s"))
    record: Any = SimpleNamespace(
        outlying=False, capture=SimpleNamespace(period_s=period_s), instances=[lag], found=[],
        sensed=SimpleNamespace(waveform="a log's"),
        unknowns=[SimpleNamespace(prior_mean=0.0, prior_sd=1e-3)],
    )  # fmt: skip
    motor = Motor.of({**MOTOR, "K": 0.1, "B": 0.0, "J": 5e-5})  # of 10 ms
    answer: Any = SimpleNamespace(
        solution=SimpleNamespace(own=[np.array([late_s])]), motor=lambda: motor
    )
    (said,) = sampling_remarks.of_logs(answer, [record])
    assert (said.code, said.severity) == (
        "delay_beyond_prior" if late_s else "few_samples", "warning",
    )  # fmt: skip
    record.outlying = True
    codes = {d.code: d.severity for d in sampling_remarks.of_logs(answer, [record])}
    assert codes["uneven_rows"] == "warning"


def test_a_band_is_of_what_stands_above_a_floor() -> None:
    """A tone beside white noise: above the noise's median it is nine tenths of the power, which
    with the floor itself would be three quarters."""
    rng = np.random.default_rng(2)
    time = np.arange(8000) * 1e-3
    noisy = np.sin(2 * np.pi * 90.0 * time) + 0.3 * rng.standard_normal(8000)
    assert localise.band(noisy, 1e-3) == pytest.approx((90.0, 90.0), abs=0.3)


def test_a_misfit_lies_in_the_segment_that_holds_most_of_it() -> None:
    """Readings are at ticks of their own: those within a segment's ticks, both ends too."""
    keep = np.arange(0, 200, 2)
    residual = 0.01 * (-1.0) ** np.arange(100)
    residual[40:60] += 1.0
    m: Any = SimpleNamespace(
        keep=keep, root_weights=None, block=SimpleNamespace(floor=0.001),
    )  # fmt: skip
    record: Any = SimpleNamespace(
        timeline=SimpleNamespace(index=2 * np.arange(100), period_s=1e-3),
        capture=SimpleNamespace(time_s=2e-3 * np.arange(100)),
    )
    kinds = (SegmentKind.REST, SegmentKind.ACCELERATION, SegmentKind.STEADY)
    edges = ((0, 40), (40, 55), (55, 100))
    segments: Any = [
        SimpleNamespace(kind=k, start=a, stop=b) for k, (a, b) in zip(kinds, edges, strict=True)
    ]
    said = localise.place(record, m, residual, segments)
    assert said == "75% of it in the acceleration segment from 0.08 to 0.108 s"  # 15: no band
    wider: Any = [SimpleNamespace(kind=SegmentKind.STEADY, start=40, stop=56)]
    assert "80% of it in the steady segment from 0.08 to 0.11 s, " in localise.place(
        record, m, residual, wider
    )
    assert localise.place(record, m, residual, []) == ""
    m.block.floor = 1.0  # of a variance of 1, above which one reading is by what others are below
    m.keep = np.arange(0, 8, 2)
    first: Any = [SimpleNamespace(kind=SegmentKind.STEADY, start=0, stop=1)]
    assert localise.place(record, m, np.array([2.0, 0.0, 0.0, 0.0]), first) == ""


def test_a_lack_of_fit_is_half_as_much_again_as_the_declared_noise() -> None:
    channel = Channel(CURRENT, "A", np.zeros(50), noise=0.1)
    m: Any = SimpleNamespace(
        channel=channel, block=SimpleNamespace(name=CURRENT, count=40.0, floor=0.01),
        root_weights=None, keep=np.arange(50), noise=channel.noise, resolution=channel.resolution,
    )  # fmt: skip
    record: Any = None
    for size, said in ((0.14, False), (0.16, True)):
        residual = size * (0.8**0.5) * (-1.0) ** np.arange(50)  # worth 40 readings
        found = residual_remarks.lack_of_fit(record, m, residual, [], " in run 2")
        if said:
            (one,) = found
            assert (one.code, one.severity) == ("lack_of_fit", "warning")
            assert one.message.startswith(
                "the residual of the current is 0.16 A rms in run 2, 1.6 times its declared noise: "
                "the model lacks"
            )
        else:
            assert found == []


@pytest.mark.parametrize(
    ("rho", "count", "said"), [(0.3, 400, True), (0.15, 400, False), (0.15, 4000, True),
                               (0.08, 40_000, False)],
)  # fmt: skip
def test_a_correlation_stands_out_of_its_chance_and_of_a_tenth(
    rho: float, count: int, said: bool
) -> None:
    """Of n readings chance is 1/√n, of which four deviations are 0.2 of 400."""
    angle = np.arccos(rho)
    series = np.cos(angle * np.arange(count)) * 2.0**0.5
    found = residual_remarks.neighbour_correlation(series)
    assert bool(found) is said
    assert found == [] or found == [pytest.approx(rho, abs=0.02)]
    assert residual_remarks.neighbour_correlation(np.zeros(50)) == []


def test_colour_is_one_sentence_of_all_runs() -> None:
    one = residual_remarks.coloured("current", [0.25])
    assert "residuals of the current are correlated (+0.25); the" in one.message
    both = residual_remarks.coloured("current", [0.25, -0.5, 0.1])
    assert "are correlated (-0.50 to +0.25) in 3 runs; the" in both.message
    assert (both.code, both.severity) == ("coloured_residuals", "info")


def test_a_chi_square_is_of_the_declared_noise_in_full() -> None:
    """Of a channel that declares none: as many as there are readings."""
    loud, silent = (
        SimpleNamespace(noise=noise, resolution=0.0, block=SimpleNamespace(count=count))
        for noise, count in ((0.5, 3.0), (0.0, 7.0))
    )
    record: Any = SimpleNamespace(
        measured=[loud, silent], departures=lambda values, own: None,
        weighed=lambda parts, filtered: [np.array([1.0, 2.0, 0.0]), np.full(7, 9.0)],
    )  # fmt: skip
    answer: Any = SimpleNamespace(own=[None, None], values=None, unknown_count=6)
    chi, freedom = residual_remarks.chi_square(answer, [record, record])
    assert chi == pytest.approx(2.0 * (5.0 / 0.25 + 7.0))
    assert freedom == 20 - 6


def test_runs_that_spread_their_misfit_are_fitted_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each from its own part of the solution; where that names none, all of them stay together."""
    records: Any = ["one", "two"]
    lines = tuple(
        Linearised(np.full(1, k), *(np.zeros((1, 1)),) * 3, np.zeros(1), (), (), np.ones(1))
        for k in (1.0, 2.0)
    )
    whole = replace(
        solution(), own=(np.array([1.0]), np.array([2.0])), linearise=lambda: lines,
        own_covariance=(np.array([[1.0]]), np.array([[2.0]])),
    )  # fmt: skip
    fitted: list[Any] = []

    def refit(some: Any, starts: Any) -> Any:
        ((record,), (start,)) = some, starts
        fitted.append((record, start.own[0][0], start.own_covariance[0][0, 0], len(start.own)))
        assert [line.residual[0] for line in start.records] == [start.own[0][0]]
        return SimpleNamespace(search=f"alone {record}")

    def excess(left: Any) -> Any:
        monkeypatch.setattr(misfit, "residuals", lambda some, answer: (tuple(some), answer))
        monkeypatch.setattr(misfit, "excess", lambda some, seen: left(some, seen[1]))

    monkeypatch.setattr(rank, "refit", refit)
    excess(lambda some, answer: 0.5 if isinstance(answer, str) and some == ["two"] else 0.11)
    found = rank._odd_one_out(records, whole)
    assert found == (["two"], "alone two", 1)
    assert fitted == [("one", 1.0, 1.0, 1), ("two", 2.0, 2.0, 1)]
    excess(lambda some, answer: 0.11)
    assert rank._odd_one_out(records, whole) == (records, whole, None)
    fitted.clear()
    excess(lambda some, answer: 0.09)
    assert rank._odd_one_out(records, whole)[2] is None
    assert rank._odd_one_out(records[:1], whole)[2] is None
    assert fitted == []  # nothing to explain


def test_an_angle_that_stays_has_lost_no_share_of_its_counts(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    channel = Channel("position", "rad", np.full(5, 3.0), resolution=0.5)
    record: Any = SimpleNamespace(
        capture=Capture(np.arange(5), 1e3, {"position": channel}), timeline=None
    )
    monkeypatch.setattr(reach.lost_samples, "find", lambda *_: SimpleNamespace(lost=3.0, dropped=2))
    assert reach._counts(record) == 0.0
    assert reach._time(record) == pytest.approx(0.4)
    once = replace(channel, raw=np.array([3.0, 3.0, 3.5, 3.5, 3.5]))  # by a count in all
    record.capture = Capture(np.arange(5), 1e3, {"position": once})
    assert reach._counts(record) == pytest.approx(3.0)
    bare: Any = SimpleNamespace(capture=Capture(np.arange(5), 1e3, {}), timeline=None)
    assert reach._counts(bare) == 0.0


def test_without_a_loss_what_was_given_stays_given(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []

    def solved(captures: Any, held: Any, without: Any) -> Any:
        asked.append((captures, held, without))
        return "records", "solution"

    monkeypatch.setattr(suspects, "solved", solved)
    monkeypatch.setattr(suspects, "lossless", lambda capture: f"lossless {capture}")
    monkeypatch.setattr(suspects, "findings", lambda *given: given)
    monkeypatch.setattr(suspects.intervals, "parameters", lambda found: found)

    def known(value: float | None, status: Status) -> Parameter:
        return Parameter("", "", value, None, None, None, None, status)

    given = {
        "R": known(2.0, Status.ESTIMATED), "K": known(0.05, Status.FIXED),
        "L": known(None, Status.FIXED), "B": known(0.0, Status.AT_BOUND),
    }  # fmt: skip
    records: Any = [SimpleNamespace(capture="one"), SimpleNamespace(capture="two")]
    found: Any = suspects.without_loss(records, given)
    assert asked == [(["lossless one", "lossless two"], {"K": 0.05}, ())]
    assert found == ("records", "solution", {"K": 0.05}, ())
