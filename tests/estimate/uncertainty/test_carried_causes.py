"""What a cause does to parameters and nuisances, against the whole system of normal equations."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.effects.source.held_inductance import HELD_INDUCTANCE
from motorid.estimate.solver.problem import Unknown
from motorid.estimate.uncertainty import budget, errors_in_variables
from motorid.estimate.uncertainty.budget import Carried
from motorid.estimate.uncertainty.errors_in_variables import Hidden
from tests.estimate.uncertainty.linear_records import LinearRecord, M, P, drawn, followed, solved
from tests.estimate.uncertainty.linear_records import system as whole_system

GAIN, CLOCK, NOTHING = 0.02, 0.3, 0.7  # standard uncertainties


def quantity(name: str) -> Any:
    return SimpleNamespace(quantity=SimpleNamespace(name=name), name=name)


@pytest.fixture
def records(monkeypatch: pytest.MonkeyPatch) -> list[LinearRecord]:
    """Both have a gain, in two parts of their programs; the second has a clock."""

    def tangent(record: LinearRecord, values: Any, own: Any, one: Any) -> Any:
        assert (values == np.ones(P)).all()
        assert len(own) == M
        return record.blocks(record.changes[one.name])

    monkeypatch.setattr(budget, "tangent", tangent)
    made = [drawn(1, "a", "b", "clock", "none"), drawn(2, "a", "b", "clock", "none")]
    for k, record in enumerate(made):
        record.changes = {**record.changes, "none": np.zeros(50)}
        gain = SimpleNamespace(name="gain")
        known = [
            (SimpleNamespace(quantity=gain, name="a"), Unknown("", 0.0, prior_sd=GAIN)),
            (SimpleNamespace(quantity=gain, name="b"), Unknown("", 0.0, prior_sd=2.0 * GAIN)),
            (quantity("none"), Unknown("", 0.0, prior_sd=NOTHING)),
        ]
        if k:
            known.append((quantity("clock"), Unknown("", 0.0, prior_sd=CLOCK)))
        record.facts = {"propagated": known, "foretold": None}
    return made


def expected(records: list[LinearRecord], cause: str) -> Any:
    """Readings that are larger by a cause that the model lacks pull the other way."""
    if cause == "gain":
        moved = [GAIN * (r.changes["a"] + 2.0 * r.changes["b"]) for r in records]
    else:
        moved = [np.zeros(50), CLOCK * records[1].changes["clock"]]
    return -followed(records, moved)


@pytest.mark.parametrize("cause", ["gain", "clock"])
def test_a_cause_moves_parameters_and_the_nuisances_of_every_record(
    records: list[LinearRecord], cause: str
) -> None:
    found = budget.carried(solved(records), records)  # type: ignore[arg-type]
    assert set(found.shared) == set(found.own) == {"gain", "clock"}
    shift = expected(records, cause)
    assert found.shared[cause] == pytest.approx(shift[:P])
    assert np.concatenate(found.own[cause]) == pytest.approx(shift[P:])
    lines = budget.propagated(solved(records), records)  # type: ignore[arg-type]
    assert lines[cause] == pytest.approx(shift[:P])
    assert set(lines) == {"gain", "clock"}


def test_causes_of_a_nuisance_add_in_squares() -> None:
    own = {"gain": (np.array([3.0, 1.0]), np.array([0.0])), "clock": (np.array([4.0, 2.0]),
           np.array([-5.0]))}  # fmt: skip
    both = Carried({}, own)
    assert both.own_variance(0, 2) == pytest.approx([25.0, 5.0])
    assert both.own_variance(1, 1) == pytest.approx([25.0])
    assert Carried({}, {}).own_variance(0, 3) == pytest.approx(np.zeros(3))


def test_an_inductance_that_the_source_took_for_granted_is_a_line() -> None:
    held = SimpleNamespace(shift={"L": 0.1})
    record: Any = SimpleNamespace(foretold=held)
    solution: Any = SimpleNamespace(unknowns=[SimpleNamespace(name=n) for n in ("R", "L", "K")])
    gain = {"gain": np.array([1.0, 2.0, 3.0])}
    lines = budget.lines_of(gain, solution, [record])
    assert list(lines) == ["gain", HELD_INDUCTANCE.name]
    assert lines[HELD_INDUCTANCE.name] == pytest.approx([0.0, 0.1, 0.0])
    assert list(gain) == ["gain"]
    record.foretold = None
    assert list(budget.lines_of(gain, solution, [record])) == ["gain"]


def test_a_nuisance_that_is_off_its_prior_pulls_the_parameters() -> None:
    """By one standard deviation: the prior's own score is the root of its precision."""
    record = drawn(3)
    _, H = whole_system([record])
    inverse = np.linalg.inv(solved([record]).information)
    moved = np.linalg.inv(H)[:P, P:] * np.sqrt(record.precision)
    assert inverse @ budget.pulled(record.line) == pytest.approx(moved)


def test_shifts_that_cancel_are_no_less_than_if_each_were_alone() -> None:
    """Of a cause that two captures share: parameter by parameter."""
    each = np.array([[3.0, 1.0], [4.0, -1.0]])
    found = np.array(budget._together(each))
    assert (found**2).sum(axis=0) == pytest.approx([49.0, 2.0])
    (plain,) = budget._together(np.array([[3.0, 1.0], [4.0, 1.0]]))
    assert plain == pytest.approx([7.0, 2.0])


def test_the_remedy_of_a_finding_is_the_findings_own() -> None:
    assert budget.remedy("finding: supply_current") == (
        'do what the finding "supply_current" asks for'
    )


# ---------------------------------------------------------------- noise in what drives the motor

VOLTS = np.arange(6.0)
PARTS = (SimpleNamespace(start=0, stop=4, slice=slice(0, 4)),
         SimpleNamespace(start=4, stop=6, slice=slice(4, 6)))  # fmt: skip


def driven(seed: int) -> LinearRecord:
    """Readings that are linear in the volts of two parts; the first has two errors, one silent."""
    one = drawn(seed)
    gains = np.random.default_rng(seed).standard_normal((50, 6))

    def with_volts(values: Any, own: Any, volts: Any) -> Any:
        return one.blocks(gains @ volts)

    sources = (SimpleNamespace(errors=(np.array([0.2, -0.4]), np.zeros(3)), tilt=0.0), None)
    if seed % 2:
        sloped = SimpleNamespace(errors=(), tilt=np.array([0.1, 0.3]))
        sources = (None, sloped)  # type: ignore[assignment]
    one.facts = {
        "fitted": lambda values, own: with_volts(values, own, VOLTS), "fitted_with": with_volts,
        "volts": VOLTS, "sources": sources, "timeline": SimpleNamespace(parts=PARTS),
        "gains": gains, "sensed": SimpleNamespace(waveform=None), "capture": {},
    }  # fmt: skip
    return one


def test_an_error_of_the_voltage_moves_what_its_readings_move() -> None:
    """The two readings of a head in one record; the slope of the second part in the other."""
    runs = [driven(4), driven(5)]
    found = errors_in_variables.hidden(solved(runs), runs)  # type: ignore[arg-type]
    assert [one.record for one in found] == [0, 1]
    head = runs[0].gains @ [0.2, -0.4, 0.0, 0.0, 0.0, 0.0]
    tilt = runs[1].gains @ [0.0, 0.0, 0.0, 0.0, 0.1, 0.3]
    by_head = followed(runs, [head, np.zeros(50)])
    by_tilt = followed(runs, [np.zeros(50), tilt])
    assert found[0].shared == pytest.approx(by_head[:P])
    assert found[0].own == pytest.approx(by_head[P : P + M])
    assert found[1].shared == pytest.approx(by_tilt[:P])
    assert found[1].own == pytest.approx(by_tilt[P + M :])
    assert found[0].change == pytest.approx(runs[0].scaled(head))
    assert found[1].change == pytest.approx(runs[1].scaled(tilt))
    assert (np.arange(6.0) == VOLTS).all()  # as they were


def test_hidden_errors_are_shifts_and_variances_of_their_own_record() -> None:
    errors = [
        Hidden(0, np.array([1.0]), np.array([3.0, 1.0]), np.zeros(5)),
        Hidden(1, np.array([2.0]), np.array([7.0, 7.0]), np.zeros(5)),
        Hidden(0, np.array([4.0]), np.array([4.0, 2.0]), np.zeros(5)),
    ]
    assert np.concatenate(errors_in_variables.shifts(errors)) == pytest.approx([1.0, 2.0, 4.0])
    assert errors_in_variables.own_variance(errors, 0, 2) == pytest.approx([25.0, 5.0])
    assert errors_in_variables.own_variance(errors, 2, 2) == pytest.approx([0.0, 0.0])
