"""What is made of a current's rise that is told: L/R, L, R, where it ends, and which logs suit."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, SPEED, TORQUE, VOLTAGE, Capture, Channel
from motorid.errors import DataError
from motorid.estimate.partial import current_transient_alone as module
from motorid.estimate.partial.exponential_fit import Record, Rise
from motorid.program import Program, Step, StepKind

COUNT = 200
TIME = 1e-3 * np.arange(COUNT)
DECAY = 2.0 * np.exp(-TIME / 0.02)
TAU_S, U_S = 0.02, 0.001  # and its statistical uncertainty


def log(current: Any = DECAY, clock: float = 0.0, **channels: Any) -> Capture:
    made = {
        n: c if isinstance(c, Channel) else Channel(n, "", np.asarray(c, float))
        for n, c in {CURRENT: current, **channels}.items()
    }
    count = len(made[CURRENT].raw)
    return Capture(1000 * np.arange(count), 1e6, made, clock_uncertainty=clock)


def told(patch: pytest.MonkeyPatch, lags: tuple[float, ...] = (TAU_S,), runs: int = 1) -> Rise:
    """Runs that end at 3, 4, … A, each to a tenth of an ampere more."""
    after = 3.0 + np.arange(runs)
    variances = [U_S**2] * len(lags) + [1.0] * runs + [(0.1 * (k + 1)) ** 2 for k in range(runs)]
    fitted = tuple(DECAY + k for k in range(runs))
    rise = Rise(np.array(lags), (None,) * runs, np.zeros(runs), after, np.diag(variances), 1000,
                0.5 + np.arange(runs), 1.0, fitted, 17)  # fmt: skip
    patch.setattr(module.exponential_fit, "rise", lambda records: rise)
    return rise


def test_a_time_constant_is_as_unsure_as_its_readings_and_the_worst_clock(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    told(monkeypatch, runs=2)
    found = module.fit([log(clock=0.01), log(clock=0.03)], {})
    one = found.combinations["L/R"]
    assert (one.name, one.unit, one.value) == ("L/R", "s", TAU_S)
    assert one.statistical == pytest.approx(U_S)
    assert one.instrument == pytest.approx(0.03 * TAU_S)
    assert {p.status for p in found.parameters.values()} == {"not_identifiable"}
    assert list(found.parameters) == ["R", "L", "K", "B", "J", "T0"]
    assert found.correlation.shape == (1, 1)
    assert (found.chi_square, found.degrees_of_freedom, found.evaluations) == (1000.0, 1000, 17)
    assert found.free == ("L/R",)
    assert len(found.inputs) == 2


@pytest.mark.parametrize(
    ("fix", "name", "value"),
    [({"R": 0.5}, "L", 0.5 * TAU_S), ({"L": 4e-3}, "R", 4e-3 / TAU_S)],
)
def test_one_that_is_given_tells_the_other(
    fix: dict[str, float], name: str, value: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As far as the time constant is known."""
    told(monkeypatch)
    found = module.fit([log(clock=0.01)], fix)
    other = found.parameters[name]
    assert other.value == pytest.approx(value)
    assert other.statistical == pytest.approx(value * U_S / TAU_S)
    assert other.instrument == pytest.approx(value * 0.01)
    (given,) = fix
    assert (found.parameters[given].value, found.parameters[given].status) == (fix[given], "fixed")
    assert found.options["fix"] == fix


def test_where_each_run_ends_is_said_with_its_sign_and_its_number(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rise = told(monkeypatch, runs=2)
    rise.after[1] = -4.0
    ends = module.fit([log(), log()], {}).combinations
    assert list(ends) == ["L/R", "steady current of run 1", "steady current of run 2"]
    first, second = ends["steady current of run 1"], ends["steady current of run 2"]
    assert (first.value, first.unit, second.value) == (3.0, "A", -4.0)
    assert (first.statistical, second.statistical) == pytest.approx((0.1, 0.2))
    told(monkeypatch)
    assert list(module.fit([log()], {}).combinations) == ["L/R", "steady current"]


def test_curves_show_what_was_read_and_fitted(monkeypatch: pytest.MonkeyPatch) -> None:
    told(monkeypatch, runs=2)
    first, second = module.fit([log(), log(DECAY + 1.0)], {}).curves
    assert (first.capture, second.capture) == (0, 1)
    assert (second.channel, second.unit, second.sigma) == (CURRENT, "A", 1.5)
    assert second.time_s == pytest.approx(TIME)
    assert second.measured == pytest.approx(DECAY + 1.0)
    assert second.fitted == pytest.approx(DECAY + 1.0)
    assert first.sigma == 0.5


@pytest.mark.parametrize(
    ("tau", "refused"), [(0.9e-3, True), (1.1e-3, False), (1.5, False), (1.7, True)]
)
def test_a_constant_that_is_none_is_refused(
    tau: float, refused: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Below its uncertainty, or above four lengths of the longest record, of .4 s."""
    told(monkeypatch, (tau,), runs=2)
    long = log(np.linspace(3.0, 1.0, 401))
    if refused:
        with pytest.raises(DataError, match="shows no exponential"):
            module.fit([log(), long], {})
    else:
        assert module.fit([log(), long], {}).combinations["L/R"] is not None


def record(current: Any) -> Record:
    return module._record(log(current))


def test_readings_are_of_the_time_before_their_delay_without_those_at_the_end_of_the_range() -> (
    None
):
    raw = DECAY.copy()
    raw[7] = np.nan
    read = Channel(CURRENT, "A", raw, delay_s=2e-3, raw_max=1.5, resolution=0.02,
                   kind="mean", aperture_s=5e-4)  # fmt: skip
    found = record(read)
    kept = (raw < 1.5) & np.isfinite(raw)
    assert found.values == pytest.approx(DECAY[kept])
    assert found.time_s == pytest.approx(TIME[kept] - 2e-3)
    assert (found.aperture_s, found.quantum, found.is_position) == (5e-4, 0.02, False)


BY_TURNS = (-1.0) ** np.arange(COUNT)


@pytest.mark.parametrize(
    ("current", "changes"),
    [
        (Channel(CURRENT, "A", np.linspace(0.0, 0.9, COUNT), resolution=0.1), True),
        (Channel(CURRENT, "A", np.linspace(0.0, 0.7, COUNT), resolution=0.1), False),
        (DECAY[:12], True),
        (DECAY[:11], False),
        # .1 by turns scatter by .163: eight times that is 1.31, of which turns are .2
        (np.linspace(0.0, 1.25, COUNT) + 0.1 * BY_TURNS, True),
        (np.linspace(0.0, 1.0, COUNT) + 0.1 * BY_TURNS, False),
        (np.ones(COUNT), False),
    ],
)
def test_a_current_changes_by_eight_quanta_and_deviations(current: Any, changes: bool) -> None:
    if changes:
        assert len(record(current).values) >= 12
    else:
        with pytest.raises(DataError, match="never changes"):
            record(current)


QUIET, LOUD = 0.1 * BY_TURNS, np.where(np.arange(COUNT) == 5, 1.1, 0.1 * BY_TURNS)


@pytest.mark.parametrize(
    ("capture", "suits"),
    [
        (log(), True),
        (log(DECAY[:12]), True),
        (log(DECAY[:11]), False),
        (log(**{VOLTAGE: QUIET}), True),
        (log(**{VOLTAGE: LOUD}), False),
        (log(**{VOLTAGE: np.full(COUNT, np.nan)}), True),
        (log(**{TORQUE: QUIET}), False),
        (log(**{SPEED: np.full(COUNT, 3.0)}), True),
        (log(**{SPEED: TIME}), False),
        (replace(log(), provenance={"static": True}), False),
        (replace(log(), provenance={"static": False}), True),
        (replace(log(), program=Program((Step(StepKind.COAST, 1.0),))), False),
        (
            Capture(1000 * np.arange(COUNT), 1e6, {VOLTAGE: Channel(VOLTAGE, "V", 0.0 * TIME)}),
            False,
        ),
    ],
)
def test_logs_of_a_current_and_nothing_else_suit(capture: Capture, suits: bool) -> None:
    assert module.suits([capture]) is suits
    assert module._suits(capture) is suits
    assert module.suits([log(), capture]) is suits
