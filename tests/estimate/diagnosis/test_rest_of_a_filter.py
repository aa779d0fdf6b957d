"""What a log still shows of a filter: sums of samples before, by hand, and where they matter."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE
from motorid.estimate.diagnosis import filter_rest
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.reading.current_offset import CURRENT_OFFSET
from motorid.estimate.effects.reading.smoothing import SMOOTHED
from motorid.estimate.effects.registry import WITHOUT_WORD
from motorid.estimate.fit.logs.unstated_channels import Told
from motorid.estimate.solver.problem import Unknown

PERIOD_S = 1e-3
LAG = WITHOUT_WORD[0]


def log(found: bool = True, is_log: bool = True, shown: Any = (), names: Any = ()) -> Any:
    """A log in whose fit a filter was found, or not; ``shown`` by channel."""
    waveform = SimpleNamespace(period_s=PERIOD_S) if is_log else None
    return SimpleNamespace(
        found=frozenset({Instance(LAG)}) if found else frozenset(),
        sensed=SimpleNamespace(waveform=waveform),
        fitted=lambda *_: list(shown), weighed=lambda parts: [2.0 * part for part in parts],
        measured=[SimpleNamespace(block=SimpleNamespace(name=name)) for name in names],
        instances=(), unknowns=(),
    )  # fmt: skip


def test_a_series_stood_before_it_began() -> None:
    series = np.array([3.0, 5.0, 8.0, 2.0])
    assert filter_rest._before(series, 1) == pytest.approx([3.0, 3.0, 5.0, 8.0])
    assert filter_rest._before(series, 3) == pytest.approx([3.0, 3.0, 3.0, 3.0])
    assert filter_rest._before(series, 9) == pytest.approx([3.0, 3.0, 3.0, 3.0])


@pytest.mark.parametrize(
    ("sizes", "samples"),
    [((), 1), ((2e-3,), 1), ((8e-3,), 2), ((-8e-3,), 2), ((8e-3, -17e-3), 5)],
)
def test_sums_reach_over_two_and_a_half_delays(sizes: tuple[float, ...], samples: int) -> None:
    """In twelve steps: of all that nobody stated; an offset is no delay."""
    record = log()
    record.instances = [SimpleNamespace(quantity=LAG) for _ in sizes]
    record.instances.append(SimpleNamespace(quantity=CURRENT_OFFSET))
    own = np.array([*sizes, 99.0])
    assert filter_rest._apart(record, own) == samples


@pytest.mark.parametrize(("beside", "left_out"), [(False, True), (True, False)])
def test_noise_that_was_averaged_alone_is_no_measure(beside: bool, left_out: bool) -> None:
    """Of the channel that firmware averaged, where neither lag nor low-pass was found beside it."""
    one = next(iter(SMOOTHED[CURRENT].values()))
    record = log()
    record.instances, record.unknowns = [Instance(one)], [Unknown(one.name, 2.0)]
    record.found = frozenset({Instance(one), *([Instance(LAG)] if beside else [])})
    assert filter_rest._averaged(record, CURRENT) is left_out
    assert not filter_rest._averaged(record, SPEED)


def test_a_channel_is_what_it_was_some_samples_before(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of current and motion, twelve each; a back-EMF is left alone."""
    monkeypatch.setattr(filter_rest, "_apart", lambda *_: 2)
    current, emf, speed = np.arange(40.0) ** 2, np.ones(30), np.arange(50.0)
    record = log(shown=(current, emf, speed), names=(CURRENT, "emf", SPEED))
    shown = {("values", "own"): [current, emf, speed]}
    record.fitted = lambda *given: shown[given]
    values: Any = "values"
    own: Any = "own"
    changes = list(filter_rest._changes(record, values, own))
    assert len(changes) == 24
    for k in range(1, 13):
        first, other = changes[k - 1], changes[k + 11]
        earlier = np.concatenate([np.zeros(min(2 * k, 40)), current[: -2 * k]])
        assert first[0] == pytest.approx(2.0 * (earlier - current))  # and weighed
        assert [part.any() for part in first] == [True, False, False]
        assert other[2][-1] == pytest.approx(2.0 * -2.0 * k)
        assert [part.any() for part in other] == [False, False, True]
        assert [len(part) for part in other] == [40, 30, 50]
    assert {CURRENT, SPEED, POSITION} == set(filter_rest.FILTERED)
    assert VOLTAGE not in filter_rest.FILTERED


def told(gain: float, step: Any = (0.0, 0.0), shifts: Any = ()) -> Told:
    each = tuple(np.array(shift) for shift in shifts)
    return Told(gain, 2, 1.0, 100, each, np.array(step))


def solved(records: list[Any]) -> Any:
    """R by its logarithm, at 2, and T0 at 5; variances of .01 and .04."""
    line = SimpleNamespace(sigmas=np.array([0.5, 4.0]), slices=(slice(0, 2), slice(2, 5)))
    return SimpleNamespace(
        information=np.diag([100.0, 25.0]), unknowns=(Unknown("R", 2.0, log=True),
        Unknown("T0", 5.0)), slopes=np.array([2.0, 1.0]), values=np.array([2.0, 5.0]),
        records=[line] * len(records), own=[np.zeros(1)] * len(records),
    )  # fmt: skip


def moves(monkeypatch: pytest.MonkeyPatch, records: list[Any], *heard: Told) -> dict[str, float]:
    """Of filters that are heard so of each log in turn."""
    left = list(heard)

    def of(rows: Any, line: Any, inverse: Any) -> Told:
        assert inverse == pytest.approx(np.diag([0.01, 0.04]))
        # a tenth of each change, in deviations of its channel
        assert rows == pytest.approx(np.array([[0.2, 0.4, 0.075, 0.1, 0.125]]))
        return left.pop(0)

    monkeypatch.setattr(
        filter_rest, "_changes", lambda *_: [[np.array([1.0, 2.0]), np.array([3.0, 4.0, 5.0])]]
    )
    monkeypatch.setattr(filter_rest, "heard", of)
    found = filter_rest.moves(records, solved(records))
    assert not left
    return found


def test_a_gain_beyond_chance_moves_by_its_step_and_by_what_is_open(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Two unknowns: chance gives 2, and twice as much has a deviation of 2: 14 is sure."""
    assert moves(monkeypatch, [log()], told(13.9, (1.0, 1.0))) == {}
    sure = moves(monkeypatch, [log()], told(14.1, (-0.1, 0.3)))
    assert sure == pytest.approx({"R": 0.2, "T0": 0.3})
    shifts = ((0.3, 0.0), (0.4, 0.0))  # a variance of .25 beside .01
    wide = moves(monkeypatch, [log()], told(99.0, (0.0, 0.0), shifts))
    assert wide == pytest.approx({"R": 2.0 * 1.959964 * (0.26**0.5 - 0.1)})


def test_of_several_logs_the_larger_move_counts_and_boards_have_none(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    one, other = told(99.0, (0.1, 0.3)), told(99.0, (-0.2, 0.1))
    both = moves(monkeypatch, [log(), log(found=False), log(is_log=False), log()], one, other)
    assert both == pytest.approx({"R": 0.4, "T0": 0.3})
    assert moves(monkeypatch, [log(found=False), log(is_log=False)]) == {}
