"""A log's voltage behind a low-pass about as slow as the winding, of which nobody says anything."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bench.mistakes.log_cases import filtered
from bench.mistakes.logs import STATIONS, Log, answer
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.timing.voltage_late import VOLTAGE_LATE
from motorid.estimate.effects.unstated.voltage_second_order import VOLTAGE_SECOND_ORDER
from motorid.estimate.effects.unstated.voltage_smoothing import VOLTAGE_SMOOTHING
from motorid.estimate.fit.logs import smoothed_voltage
from motorid.estimate.fit.multistart import settled
from motorid.estimate.fit.parameter_bounds import merged
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.intersample_voltage import JOINED
from motorid.estimate.signals.time_grid import IRREGULAR
from tests.estimate.fit.logs.test_log_fit import MOTOR, PERIOD_S, logged
from tests.estimate.fit.logs.test_log_fit import smoothed as low_pass

FREE = ("R", "L", "K", "B", "J", "T0")


def joined(folder: Path, **spoilt: Any) -> MotorRecord:
    """A record of the log, its voltage joined by straight lines."""
    return MotorRecord(logged(folder, **spoilt), FREE, {}, JOINED)


@pytest.mark.slow
@pytest.mark.parametrize("samples", [0.7, 2.0, 6.0])
def test_readings_go_on_after_a_jump_as_an_exponential_does(samples: float, tmp_path: Path) -> None:
    record = joined(tmp_path, v=low_pass(samples))
    found = smoothed_voltage._goes_on(record)
    assert found == pytest.approx(np.exp(-1.0 / samples), abs=0.08)


def test_where_it_jumps_at_once_nothing_is_tried(tmp_path: Path) -> None:
    record = joined(tmp_path)
    assert abs(smoothed_voltage._goes_on(record)) < 0.02
    assert smoothed_voltage.begun([record], None, FREE, {}, {}) == []  # type: ignore[arg-type]


@pytest.mark.slow
def test_the_likeliest_start_ends_at_the_low_pass_and_the_motor(tmp_path: Path) -> None:
    record = joined(tmp_path, v=low_pass(2.0))
    start = {name: 0.9 * getattr(MOTOR, name) for name in FREE}
    solution = settled([record], FREE, start)
    found = smoothed_voltage.begun([record], solution, FREE, merged(start, solution), {})
    (best,), ended = min(found, key=lambda fit: fit[1].objective)
    size_s = ended.own[0][best.instances.index(Instance(VOLTAGE_SMOOTHING))]
    assert size_s == pytest.approx(2.0 * PERIOD_S, rel=0.1)
    for name in ("R", "K", "J"):
        assert merged(start, ended)[name] == pytest.approx(getattr(MOTOR, name), rel=0.01), name


@pytest.mark.study
def test_a_voltage_as_slow_as_the_winding(tmp_path: Path) -> None:
    """Two low-passes of 1 ms beside L/R of 4 ms: R was .8 %, 3 half-widths, and L 7 % off."""
    station = STATIONS[2]
    found = answer(Log(chain={"v": filtered(1, 2)}), station, tmp_path, 1).parameters
    for name in ("R", "L", "K", "J"):
        low, high = found[name]["interval_95"]
        middle, wide = (low + high) / 2, high - low  # twice the half-width
        assert abs(getattr(station.motor, name) - middle) < wide, name
    assert abs(found["R"]["value"] / station.motor.R - 1.0) < 5e-3


def test_an_inductance_that_is_given_begins_no_search_for_it(tmp_path: Path) -> None:
    record, held = joined(tmp_path, v=low_pass(2.0)), tuple(n for n in FREE if n != "L")
    assert smoothed_voltage.begun([record], None, held, {}, {"L": 1e-3}) == []  # type: ignore[arg-type]


class Begun:
    """Instead of records and searches: where each fit begins, and how likely it is said to be."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, goes_on: float, late: float = 0.5) -> None:
        self.sizes, self.late, self.likely = dict[int, tuple[float, int]](), late, 1.0
        self.starts = list[tuple[str, float]]()
        monkeypatch.setattr(smoothed_voltage, "MotorRecord", self.record)
        for name in ("settled", "widened"):
            monkeypatch.setattr(smoothed_voltage, name, getattr(self, name))
        monkeypatch.setattr(smoothed_voltage, "_goes_on", lambda _: goes_on)
        monkeypatch.setattr(smoothed_voltage, "_delay_s", lambda *_: late * PERIOD_S)
        monkeypatch.setattr(smoothed_voltage, "_smooth", self.smooth)
        monkeypatch.setattr(smoothed_voltage.default, "period_s", lambda _: PERIOD_S)

    def record(self, capture: Any, _free: Any, _fixed: Any, shape: str) -> Any:
        return SimpleNamespace(capture=capture, shape=shape)

    def smooth(self, record: Any, size_s: float, order: int) -> None:
        self.sizes[id(record)] = (size_s, order)
        record.size_s, record.order = size_s, order

    def settled(self, records: Any, _free: Any, start: Any) -> Any:
        self.starts.append((records[0].shape, start["L"] / start["R"] / PERIOD_S))
        return start

    def widened(self, records: Any, _free: Any, start: Any, _solution: Any) -> Any:
        rise = start["L"] / start["R"] / PERIOD_S
        return SimpleNamespace(fair=abs(rise - self.likely), rise=rise)

    def found(self, likely: float = 1.0, jitter: float = 0.0) -> list[Any]:
        self.likely = likely
        first: Any = [SimpleNamespace(capture="run", timeline=SimpleNamespace(jitter=jitter))]
        solution: Any = SimpleNamespace(own=[None])
        return smoothed_voltage.begun(first, solution, FREE, {"R": 2.0, "L": 1.0}, {})


@pytest.mark.parametrize("likely", [1.0, 3.0])
def test_each_start_leaves_the_delay_what_it_is(
    likely: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A low-pass of the voltage and the winding's time constant are apart by the delay."""
    monkeypatch.setattr(smoothed_voltage, "LOW_PASS", SimpleNamespace(unknown=lambda _: 1))
    seen = Begun(monkeypatch, math.exp(-1.0 / 2.0))
    fits = seen.found(likely)
    for (record,), ended in fits:
        assert record.size_s == pytest.approx((ended.rise - seen.late) * PERIOD_S)
    rises = [ended.rise for _, ended in fits]
    first = [r for (record,), _ in fits for r in [record] if (r.shape, r.order) == ("curved", 1)]
    assert rises[: len(first)] == pytest.approx([2.5, 1.0, 3.0])  # .3 would need one of below 0
    assert all(rise == pytest.approx(likely) for rise in rises[len(first) :])
    ways = {(record.shape, record.order) for (record,), _ in fits}
    assert ways == {(s, n) for s in ("curved", JOINED, "held") for n in (1, 2)}
    assert len(fits) == len(first) + 5


def test_nothing_is_begun_where_it_would_be_a_guess(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(smoothed_voltage, "LOW_PASS", SimpleNamespace(unknown=lambda _: 1))
    short, long = math.exp(-1.0 / 0.38), math.exp(-1.0 / 0.42)  # of .4 samples
    assert Begun(monkeypatch, short).found() == []
    assert Begun(monkeypatch, long).found()
    assert Begun(monkeypatch, long).found(jitter=2.0 * IRREGULAR) == []
    endless = Begun(monkeypatch, 1.0)  # no longer than 20 samples
    assert max(ended.rise for _, ended in endless.found()) == pytest.approx(20.0, rel=0.03)
    late = Begun(monkeypatch, long, late=2.8)  # of which .4 and less would be left
    assert [ended.rise for _, ended in late.found()] == pytest.approx([3.22] * 6, abs=0.01)
    monkeypatch.setattr(smoothed_voltage, "LOW_PASS", SimpleNamespace(unknown=lambda _: None))
    assert Begun(monkeypatch, long).found() == []  # somebody states it


@pytest.mark.parametrize(("late_s", "named"), [(0.0, False), (3e-4, True)])
def test_the_delay_is_the_stamps_and_the_windings(late_s: float, named: bool) -> None:
    late = Instance(VOLTAGE_LATE)
    record: Any = SimpleNamespace(instances=(late,) if named else ())
    found = smoothed_voltage._delay_s(record, np.full(int(named), late_s), {"R": 2.0, "L": 4e-3})
    assert found == pytest.approx(late_s + 2e-3)


@pytest.mark.parametrize("order", [1, 2])
def test_a_low_pass_of_second_order_begins_as_two_like_ones(order: int, tmp_path: Path) -> None:
    record = joined(tmp_path, v=low_pass(2.0))
    smoothed_voltage._smooth(record, 2e-3, order)
    begins = {u.name: (u.start, u.prior_sd) for u in record.unknowns}
    assert begins[VOLTAGE_SMOOTHING.name] == (2e-3, 2e-3)
    second = begins.get(VOLTAGE_SECOND_ORDER.name)
    assert second == ((1e-3, 1e-3) if order == 2 else None)


def going_on(volts: list[float] | None, *jumps: int) -> float:
    """``jumps``: the first reading after each."""
    off = np.array(jumps, dtype=np.int64)
    wave = None if volts is None else SimpleNamespace(volts=np.array(volts), steps_off=off)
    record: Any = SimpleNamespace(sensed=SimpleNamespace(waveform=wave))
    return smoothed_voltage._goes_on(record)


def test_a_voltage_goes_on_after_a_jump_by_what_its_low_pass_leaves() -> None:
    """exp(-T/V), of jumps either way by their squares; none of one that began before."""
    share = math.exp(-1.0 / 1.5)
    since = np.arange(1, 20)
    up = [0.0] * 3 + (4.0 * (1.0 - share**since)).tolist()
    down = (up[-1] - 9.0 * (1.0 - share**since)).tolist()
    assert going_on(up + down, 3, 22) == pytest.approx(share)
    assert going_on([0.0, 0.0, 3.0, 3.0, 3.0, 3.0], 2) == 0.0
    mixed = [0.0, 0.0, 3.0, 4.5, 4.5, 4.5, 6.5, 6.5, 6.5]
    assert going_on(mixed, 2, 6) == pytest.approx(3.0 * 1.5 / (9.0 + 4.0))
    begun = [0.0, 1.0, 3.0, 4.0, 4.0, 4.0, 7.0, 8.0, 8.0]  # the first goes up by itself
    assert going_on(begun, 2, 6) == pytest.approx(1.0 / 3.0)


def test_a_voltage_without_jumps_goes_on_by_nothing() -> None:
    assert going_on(None) == 0.0
    assert going_on([0.0, 1.0, 2.0, 3.0]) == 0.0
    assert going_on([0.0, 0.0, 2.0], 2) == 0.0  # nothing was read after it
    assert going_on([0.0, 2.0, 3.0, 3.0], 1) == 0.0  # nor before
    assert going_on([2.0, 2.0, 2.0, 2.0, 2.0], 2) == 0.0
