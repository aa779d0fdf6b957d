"""Scores of runs, stretches and channels, by hand: spreads, degrees, colour, and unstated gains."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, SPEED, TORQUE, VOLTAGE, Channel
from motorid.estimate.results.estimate import Parameter
from motorid.estimate.results.status import Status
from motorid.estimate.solver.problem import Linearised
from motorid.estimate.uncertainty import (
    covariance,
    log_scatter,
    uneven_residuals,
    unstated_gains,
)
from motorid.estimate.uncertainty.between_run_variance import pull, spread_of
from motorid.estimate.uncertainty.covariance import Known, Statistical, covariance_of, statistical
from motorid.estimate.uncertainty.log_scatter import STRETCHES
from tests.estimate.uncertainty.linear_records import P, drawn, followed, solved


def of_one(scores: Any, informations: Any) -> tuple[float, float]:
    """Spread and degrees of a single parameter."""
    pulls = [(np.array([s]), np.array([[h]])) for s, h in zip(scores, informations, strict=True)]
    spread, degrees = spread_of(pulls, np.array([[1.0 / sum(informations)]]))
    return float(spread[0]), float(degrees[0])


def test_equal_runs_spread_as_the_mean_of_so_many_with_one_degree_less() -> None:
    """Answers of four runs alone, of 2, 4, 7 and 3: the variance of their mean."""
    answers, information = np.array([2.0, 4.0, 7.0, 3.0]), 5.0
    spread, degrees = of_one(information * (answers - answers.mean()), [information] * 4)
    assert spread == pytest.approx(answers.var(ddof=1) / 4)
    assert degrees == pytest.approx(3.0)
    moved = of_one(information * (answers - 1.0), [information] * 4)  # about a bound
    assert moved == pytest.approx((spread, degrees))


@pytest.mark.parametrize("informations", [(1.0, 2.0, 3.0, 6.0), (4.0, 1.0, 1.0, 1.0, 1.0)])
def test_unequal_runs_have_the_degrees_of_a_quadratic_form(informations: Any) -> None:
    """Of white noise: the covariance of what is left of the scores, its trace and its square's."""
    h = np.array(informations)
    left = np.diag(h) - np.outer(h, h) / h.sum()
    scores = np.arange(len(h)) - 1.5
    cleared = scores - h * scores.sum() / h.sum()
    spread, degrees = of_one(scores, h)
    assert spread == pytest.approx(float(cleared @ cleared) / np.trace(left) / h.sum())
    assert degrees == pytest.approx(np.trace(left) ** 2 / np.trace(left @ left))


def test_two_runs_or_one_that_tells_nearly_all_show_no_spread() -> None:
    assert of_one([3.0, -3.0], [1.0, 1.0]) == (0.0, 1.0)
    spread, degrees = of_one([3.0, -2.0, -1.0], [1.0, 1.0, 1e-9])
    assert spread == 0.0
    assert degrees == pytest.approx(1.0)
    assert of_one([1.0, -1.0, 0.0], [1.0, 1.0, 1.0])[1] == pytest.approx(2.0)


def line(residual: Any, columns: Any, *slices: slice) -> Linearised:
    columns = np.asarray(columns, dtype=np.float64)
    none = np.zeros((len(residual), 0))
    parts = slices or (slice(0, len(residual)),)
    return Linearised(
        np.asarray(residual, dtype=np.float64), columns, none, columns, np.zeros(0), (), parts,
        np.ones(len(parts)),
    )  # fmt: skip


def test_a_pull_is_the_score_of_some_residuals_with_their_information() -> None:
    one = line([1.0, -2.0, 3.0], [[1.0, 0.0], [2.0, 1.0], [0.0, 4.0]])
    score, information = pull(one, slice(1, 3))
    assert score == pytest.approx([-4.0, 10.0])
    assert information == pytest.approx(np.array([[4.0, 2.0], [2.0, 17.0]]))
    assert pull(one, np.array([True, False, False]))[0] == pytest.approx([1.0, 0.0])


def test_white_residuals_count_by_their_own_variance_and_no_less_than_one() -> None:
    """Of each channel: residuals of two deviations in one, of a half in the other."""
    columns = np.arange(1.0, 9.0)[:, None]
    one = line([2.0, -2.0, -2.0, 2.0, 0.5, -0.5, -0.5, 0.5], columns, slice(0, 4), slice(4, 8))
    expected = 4.0 * (1 + 4 + 9 + 16) + (25 + 36 + 49 + 64)
    assert covariance.score_covariance(one)[0, 0] == pytest.approx(expected)
    single = line([3.0], [[2.0]])
    assert covariance.score_covariance(single)[0, 0] == pytest.approx(36.0)


def test_a_covariance_of_few_readings_is_wider_by_what_was_fitted() -> None:
    """Twelve readings, two parameters and one nuisance: 12/9."""
    columns = np.column_stack([np.ones(12), np.tile([1.0, -1.0, 0.0], 4)])
    one = line(np.zeros(12), columns)
    solution: Any = SimpleNamespace(
        records=(one,), values=np.zeros(2), own=[np.zeros(1)], information=columns.T @ columns
    )
    found = statistical(solution)
    white = np.array([1.0 / 12.0, 1.0 / 8.0])
    assert np.diag(found.covariance) == pytest.approx(white * 12.0 / 9.0)
    assert found.lines[covariance.NOISE] == pytest.approx(white * 12.0 / 9.0)
    assert found.coloured == pytest.approx((12.0 / 9.0) ** 0.5)
    assert not found.between_runs
    assert np.isinf(found.freedom).all()
    apart = statistical(solution, Known(apart=np.diag([0.0, 0.1])))
    assert np.diag(apart.covariance) == pytest.approx(white * 12.0 / 9.0)  # the scores say so
    solution.own = [np.zeros(20)]  # more unknowns than readings
    assert np.diag(statistical(solution).covariance) == pytest.approx(12.0 * white)


def test_a_covariance_with_other_variances_has_its_correlations() -> None:
    before = np.array([[4.0, 1.2, 0.0], [1.2, 1.0, 0.0], [0.0, 0.0, 0.0]])
    after = covariance._with_variances(before, np.array([1.0, 9.0, 2.0]))
    assert np.diag(after) == pytest.approx([1.0, 9.0, 2.0])
    assert after[0, 1] == pytest.approx(0.6 * 3.0)
    assert after[0, 2] == after[1, 2] == 0.0


@pytest.mark.parametrize(
    ("runs", "parts", "total", "freedom"),
    [
        # 3 of white noise's 1: what is beyond, 2, has the runs' degrees
        ((3.0, 2.0), (1.0, 9.0), 3.0, 2.0 * 9.0 / 4.0),
        ((2.0, 2.0), (3.0, 9.0), 3.0, 9.0 * 9.0 / 4.0),  # the parts', where they show more
        ((1.5, 2.0), (1.2, 9.0), 2.0, 2.0 * 4.0 / 0.25),  # less than the colour has already
        ((0.5, 2.0), (0.7, 9.0), 2.0, np.inf),
    ],
)
def test_what_runs_and_their_parts_scatter_beyond_noise(
    runs: tuple[float, float], parts: tuple[float, float], total: float, freedom: float,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    """Of a parameter of variance 1 by white noise, 2 by that and its colour."""
    one = line([1.0, 2.0, 3.0, 4.0], np.ones((4, 1)))
    asked = []

    def spread(pulls: Any, inverse: Any) -> Any:
        asked.append([float(score[0]) for score, _ in pulls])
        size, degrees = runs if len(pulls) == 3 else parts
        return np.array([size]), np.array([degrees])

    monkeypatch.setattr(covariance, "spread_of", spread)
    solution: Any = SimpleNamespace(records=(one, one, one))
    within = Statistical(
        np.array([[2.0]]), np.full(1, np.inf), 1.0, True, {covariance.NOISE: np.full(1, 2.0)}
    )
    pieces = [np.array([0, 0, 1, 1])] * 3
    found = covariance._between(solution, np.eye(1), within, pieces)
    assert asked == [[10.0] * 3, [3.0, 7.0] * 3]
    assert found.covariance[0, 0] == pytest.approx(total)
    assert found.freedom[0] == pytest.approx(freedom)
    spreads = found.lines.get(covariance.SPREAD)
    assert (spreads is None) is (total == 2.0)
    assert spreads is None or spreads == pytest.approx([total - 2.0])
    alone = covariance._between(solution, np.eye(1), within, ())
    assert alone.covariance[0, 0] == pytest.approx(max(runs[0], 2.0))


def test_an_inverse_of_unlike_units_is_that_of_the_matrix() -> None:
    information = np.array([[4.0e8, 3.0], [3.0, 5.0e-8]])
    assert covariance_of(information) == pytest.approx(np.linalg.inv(information))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_no_two_parameters_are_told_as_more_than_one(sign: float) -> None:
    """What rounding leaves of a correlation beyond 1 is 1: of either alone nothing is known."""
    beyond = np.array([[4.0, sign * 6.06], [sign * 6.06, 9.0]])
    alike = np.array([[4.0, sign * 6.0], [sign * 6.0, 9.0]])
    assert covariance_of(beyond) == pytest.approx(covariance_of(alike))
    assert (np.diag(covariance_of(beyond)) > 1e10).all()


# ---------------------------------------------------------------- stretches of a log


def stretched(*channels: tuple[Any, Any, Any]) -> tuple[Any, Linearised]:
    """A log of 64 ticks: of each channel where it was read, its derivatives and residuals."""
    measured, slices, count = [], [], 0
    for ticks, rows, _ in channels:
        measured.append(SimpleNamespace(keep=np.asarray(ticks)))
        slices.append(slice(count, count + len(rows)))
        count += len(rows)
    record = SimpleNamespace(
        measured=measured, timeline=SimpleNamespace(count=64), rivals=[],
        sensed=SimpleNamespace(waveform="read"),
    )  # fmt: skip
    columns = np.concatenate([rows for _, rows, _ in channels])
    return record, line(np.concatenate([r for _, _, r in channels]), columns[:, None], *slices)


def test_scores_of_stretches_are_of_all_channels_at_their_ticks() -> None:
    """Two ticks a stretch; of the second channel a filter has taken the first two readings."""
    record, one = stretched(
        (range(64), np.full(64, 2.0), np.arange(64.0)), ([0, 1, 10, 63], [3.0, 5.0], [7.0, 11.0])
    )
    found = log_scatter._pulls(record, one)
    assert found.shape == (STRETCHES, 1)
    expected = np.array([2.0 * (4 * k + 1) for k in range(32)])
    expected[5] += 21.0
    expected[31] += 55.0
    assert found[:, 0] == pytest.approx(expected)


def test_stretches_that_pull_together_widen_by_what_is_beyond_white_noise() -> None:
    """64 readings of 1.5 in pairs that turn: scores of 3, of which white noise has 2."""
    turns = np.repeat(np.tile([1.5, -1.5], 16), 2)
    record, one = stretched((range(64), np.ones(64), turns))
    solution: Any = SimpleNamespace(records=(one,), information=np.array([[64.0]]), unknowns=(),
                                    values=np.zeros(0))  # fmt: skip
    found = log_scatter.shifts(solution, [record])
    assert sum(float(s[0] ** 2) for s in found) == pytest.approx((32 * 9.0 - 64.0) / 64.0**2)
    calm, quiet = stretched((range(64), np.ones(64), np.tile([0.5, -0.5], 32)))
    solution.records = (quiet,)
    assert log_scatter.shifts(solution, [calm]) == []


def test_only_what_read_its_voltage_as_a_log_has_stretches(monkeypatch: pytest.MonkeyPatch) -> None:
    record, one = stretched((range(64), np.ones(64), np.repeat(np.tile([9.0, -9.0], 16), 2)))
    solution: Any = SimpleNamespace(records=(one,), information=np.array([[64.0]]))
    monkeypatch.setattr(log_scatter, "rivals", lambda _, record: [record])
    assert len(log_scatter.shifts(solution, [record])) == 2
    record.sensed.waveform = None
    assert log_scatter.shifts(solution, [record]) == [record]


def test_a_reading_that_tells_a_direction_alone_counts_by_at_most_ten_times_its_rest() -> None:
    """Leverage is believed up to .9: a residual of 1 there may have been one of 10."""
    columns = np.zeros((5, 2))
    columns[:4, 0], columns[4, 1] = 1.0, 2.0
    left = np.array([1.0, -1.0, 1.0, -1.0, 1.0])
    white = columns.T @ columns
    one = line(left, columns)
    found = uneven_residuals.shifts([one], np.linalg.inv(white), [])
    (shift,) = found
    assert abs(shift[1]) == pytest.approx(np.sqrt((100.0 - 1.0) / 4.0))
    assert shift[0] == pytest.approx(0.0)
    known = uneven_residuals.shifts([one], np.linalg.inv(white), [np.array([0.0, 3.0])])
    assert abs(known[0][1]) == pytest.approx(np.sqrt(99.0 / 4.0 - 9.0))


@pytest.mark.parametrize(("size", "told"), [(5.1, False), (5.4, True)])
def test_readings_are_surely_left_more_by_three_deviations_of_chi_squares(
    size: float, told: bool
) -> None:
    """One reading of weight 4: 4 (s² − 1) beside 3 √(2·16), of which s² is 5.24."""
    moves = np.array([[2.0, 0.0], [0.0, 5.0]])
    shift = np.array([0.3, 0.0])
    assert uneven_residuals._told(moves, np.array([size, 1e6]), shift) == told
    assert uneven_residuals._told(moves, np.array([size, 1e6]), 100.0 * shift) == told


# ---------------------------------------------------------------- gains that nobody stated


def channel(name: str, *undeclared: str) -> Any:
    return SimpleNamespace(channel=Channel(name, "", np.zeros(2), undeclared=undeclared))


def test_a_gain_of_a_hundredth_moves_what_the_readings_move(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of every record whose channel has no word on its gain, together; in the parameter's unit."""
    records = [drawn(31, "voltage gain", "current gain"), drawn(32, "voltage gain", "current gain")]
    for record in records:
        record.changes["current gain"] *= 1e-4  # type: ignore[index]

    def tangent(record: Any, values: Any, own: Any, one: Any) -> Any:
        return record.blocks(record.changes[one.quantity.name])

    monkeypatch.setattr(unstated_gains, "tangent", tangent)
    names = {"voltage gain": records, "current gain": records[1:]}
    monkeypatch.setattr(
        unstated_gains, "_open", lambda record: [SimpleNamespace(name=name) for name, of in
                                                 names.items() if record in of],
    )  # fmt: skip
    solution = solved(records)
    solution.slopes, solution.values = np.array([2.0, 3.0]), np.array([1.0, 1.0])
    found = unstated_gains.unstated_gains(solution, records)  # type: ignore[arg-type]
    shift = -0.01 * followed(records, [record.changes["voltage gain"] for record in records])[:P]
    assert found["voltage gain"] == pytest.approx({"R": 2.0 * shift[0], "L": 3.0 * shift[1]})
    assert found["current gain"] == {}  # less than a ten-thousandth of a value
    solution.values = np.array([1e-9, 1e9])
    only = unstated_gains.unstated_gains(solution, records)  # type: ignore[arg-type]
    assert set(only["voltage gain"]) == set(only["current gain"]) == {"R"}


@pytest.mark.parametrize(
    ("voltage", "current", "moving", "names"),
    [
        ((), (), (), []),
        (
            ("gain",),
            ("gain",),
            ("gain",),
            ["voltage gain", "current gain", "encoder or speed gain"],
        ),
        (("gain",), (), ("offset",), ["voltage gain"]),
        (("offset",), ("gain",), None, ["current gain"]),
        (("gain",), None, ("gain",), ["voltage gain", "encoder or speed gain"]),
    ],
)
def test_a_gain_is_open_of_a_channel_that_is_read_and_says_nothing_of_it(
    voltage: Any, current: Any, moving: Any, names: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    motion = None if moving is None else channel(SPEED, *moving)
    monkeypatch.setattr(unstated_gains.scales, "moving", lambda _: motion)
    record: Any = SimpleNamespace(
        sensed=channel(VOLTAGE, *voltage),
        block=lambda name: (
            channel(CURRENT, *current) if name == CURRENT and current is not None else None
        ),
    )
    assert [quantity.name for quantity in unstated_gains._open(record)] == names


def test_gains_are_named_by_what_they_scale() -> None:
    def capture(**undeclared: tuple[str, ...]) -> Any:
        return SimpleNamespace(channels={n: channel(n, *u).channel for n, u in undeclared.items()})

    first = capture(current=("gain",), torque=(), position=("gain",))
    second = capture(torque=("gain",), terminal_voltage=("offset",))
    names = (CURRENT, TORQUE, VOLTAGE, POSITION, SPEED)
    assert unstated_gains.gains_of([first, second], names) == {
        "current gain": CURRENT, "torque gain": TORQUE, "encoder or speed gain": POSITION,
    }  # fmt: skip
    assert unstated_gains.gains_of([first], (TORQUE,)) == {}


def test_a_value_is_moved_by_more_than_a_ten_thousandth_of_itself() -> None:
    def known(**values: float | None) -> dict[str, Parameter]:
        return {
            n: Parameter(n, "", v, None, None, None, None, Status.ESTIMATED)
            for n, v in values.items()
        }

    before = known(R=2.0, L=-1.0, K=1.0, B=None, J=1.0, T0=1.0)
    after = known(R=1.99, L=-1.00009, K=1.00011, B=1.0, J=None, other=3.0)
    assert unstated_gains.moved(before, after) == pytest.approx({"R": -0.01, "K": 1.1e-4})
