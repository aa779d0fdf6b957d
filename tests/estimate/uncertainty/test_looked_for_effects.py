"""Which effects are looked for in which records, and of what a whole uncertainty is made."""

from __future__ import annotations

import sys
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.effects.influence_quantity import Use
from motorid.estimate.effects.rotor.cogging import COGGING
from motorid.estimate.effects.source.voltage_noise import VOLTAGE_NOISE
from motorid.estimate.solver.problem import Unknown
from motorid.estimate.uncertainty import budget, undetected
from motorid.estimate.uncertainty import findings as whole
from motorid.estimate.uncertainty.covariance import SCATTER, Known
from motorid.estimate.uncertainty.undetected import FOUND, Undetected
from tests.estimate.uncertainty.linear_records import (
    BLOCKS,
    LinearRecord,
    P,
    drawn,
    followed,
    solved,
    system,
)

USUAL = 0.2  # standard deviation of the prior


def one_form(name: str) -> Any:
    """A quantity with one form; that of iron is kept."""
    made = SimpleNamespace(name=name, term=f"{name} term", kept=lambda _: name == "iron")
    made.shaped = ((1.0, made),)
    return made


def looked_for(monkeypatch: pytest.MonkeyPatch, records: list[LinearRecord],
               *names: str) -> tuple[Undetected, ...]:  # fmt: skip
    """Of quantities that may be in the records whose readings they change."""

    def places(quantity: Any, record: LinearRecord) -> list[Any]:
        def unknown(of: LinearRecord) -> Unknown | None:
            assert of is record
            return Unknown("", 0.0, prior_sd=USUAL) if quantity.name in record.changes else None

        return [SimpleNamespace(unknown=unknown, name=quantity.name)]

    def tangent(record: LinearRecord, values: Any, own: Any, one: Any) -> Any:
        return record.blocks(record.changes[one.name])

    quantities = tuple(one_form(n) for n in names)
    monkeypatch.setattr(undetected, "used", lambda use: quantities if use is Use.UNDETECTED else ())
    monkeypatch.setattr(undetected, "instances", places)
    monkeypatch.setattr(undetected, "tangent", tangent)
    return undetected.undetected(solved(records), records)  # type: ignore[arg-type]


def moved(records: list[LinearRecord]) -> list[Any]:
    """What one standard deviation of drag does to the readings of each."""
    return [USUAL * record.changes.get("drag", np.zeros(sum(BLOCKS))) for record in records]


def posterior(records: list[LinearRecord]) -> tuple[float, float]:
    """Size of drag in standard deviations of its prior, and the deviation that is left of that."""
    known, H = system(records)
    each = zip(records, moved(records), strict=True)
    column = np.concatenate([record.scaled(change) for record, change in each])
    cross = known.T @ column
    every = np.block([[H, cross[:, None]], [cross[None], np.array([[column @ column + 1.0]])]])
    left = np.concatenate([record.line.residual for record in records])
    inverse = np.linalg.inv(every)
    found = inverse @ np.concatenate([known.T @ left, [column @ left]])
    return float(found[-1]), float(inverse[-1, -1]) ** 0.5


@pytest.mark.parametrize("runs", [("drag", "drag"), ("drag", "iron")])
@pytest.mark.parametrize("size", [-0.5, 0.6])
def test_an_effect_is_one_of_all_runs_that_may_have_it(
    runs: tuple[str, ...], size: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is open of it is its posterior by the readings of all; runs without it tell the rest."""
    records = [drawn(11 + k, name) for k, name in enumerate(runs)]
    for record, change in zip(records, moved(records), strict=True):
        record.residual = record.residual + size * change
    (found,) = looked_for(monkeypatch, records, "drag")
    mean, deviation = posterior(records)
    assert found.open == pytest.approx(deviation)
    assert abs(mean) < FOUND * deviation
    way = followed(records, moved(records))[:P]
    assert found.shift == pytest.approx(-way * np.hypot(deviation, max(mean, 0.0)))
    assert found.seen == 0.0


@pytest.mark.parametrize("size", [0.0, 0.6])
def test_forms_count_by_their_chances_and_by_how_likely_they_make_the_readings(
    size: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = drawn(19, "slow", "fast")
    run.changes["fast"] = 3.0 * run.changes["fast"]  # that are told better than slow ones
    run.residual = run.residual + size * USUAL * run.changes["slow"]
    forms = {}
    for name in ("slow", "fast"):
        alone = replace(run, changes={"drag": run.changes[name]})
        way = -followed([alone], moved([alone]))[:P]
        forms[name] = posterior([alone]), way
    chances = {"slow": 0.3, "fast": 0.7}
    drag = one_form("drag")
    drag.shaped = tuple((chance, one_form(name)) for name, chance in chances.items())
    monkeypatch.setattr(sys.modules[__name__], "one_form", lambda _: drag)
    (found,) = looked_for(monkeypatch, [run], "drag")
    weights, squares = [], []
    for name, ((mean, deviation), way) in forms.items():
        most = max(mean, 0.0)
        weights.append(chances[name] * deviation * np.exp((most / deviation) ** 2 / 2.0))
        squares.append(way**2 * (deviation**2 + most**2))
        assert most < FOUND * deviation
    assert abs(found.shift) == pytest.approx(np.sqrt(np.average(squares, 0, weights)))
    lower, upper = sorted(deviation for (_, deviation), _ in forms.values())
    assert lower < found.open < upper


def test_what_no_record_could_have_or_all_model_is_not_looked_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    runs = [drawn(13, "drag", "iron"), drawn(14, "iron")]
    runs[0].modelled, runs[1].modelled = ("iron term",), ("drag term", "iron term")
    found = looked_for(monkeypatch, runs, "heat", "iron", "drag")
    assert [one.quantity.name for one in found] == ["drag"]
    assert looked_for(monkeypatch, [runs[1]], "iron", "drag") == ()


def test_a_size_that_is_seen_is_held_against_the_scatter_of_its_pull(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """That of what neither parameters nor nuisances explain of it, on what is left."""
    run = drawn(17, "drag")
    run.changes = {"drag": 10.0 * run.changes["drag"]}
    run.residual = 0.8 * moved([run])[0]
    mean, deviation = posterior([run])
    asked: list[tuple[Any, Any]] = []

    def scattering(changes: Any, residuals: Any, unseen: Any) -> float:
        assert unseen == []
        asked.append((changes, residuals))
        return 4.0

    monkeypatch.setattr(undetected, "pull_scatter", scattering)
    (found,) = looked_for(monkeypatch, [run], "drag")
    assert mean > 4.0 * FOUND * deviation
    assert found.seen == pytest.approx(mean / deviation / 2.0)
    (((change,), (residual,)),) = asked
    known, _ = system([run])
    left = run.scaled(moved([run])[0]) - known @ followed([run], moved([run]))
    assert change == pytest.approx(left)
    assert residual == pytest.approx(run.line.residual)


# ---------------------------------------------------------------- all that is uncertain, together


@pytest.fixture
def parts(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Each part of an uncertainty is its own name."""
    monkeypatch.setattr(whole.errors_in_variables, "hidden", lambda *_: ("hidden",))
    monkeypatch.setattr(whole, "scattered", lambda *given: ("scattered", *given))
    shift = np.array([1.0])
    line = Undetected(SimpleNamespace(name="drag"), shift, 0.01)  # type: ignore[arg-type]
    monkeypatch.setattr(whole, "undetected", lambda *_: (line,))
    monkeypatch.setattr(budget, "carried", lambda *_: SimpleNamespace(shared={"gain": shift}))
    monkeypatch.setattr(budget, "lines_of", lambda shared, *_: {**shared, "held": shift})
    monkeypatch.setattr(whole.profile_likelihood, "intervals", lambda *_: {"B": (0.0, 1.0)})
    monkeypatch.setattr(whole.bent_valley, "shifts", lambda *_: [])
    return {"line": line}


def test_an_answer_has_every_cause_and_profiles_unless_asked(parts: dict[str, Any]) -> None:
    solution: Any = SimpleNamespace(unfinished=False)
    records: Any = ("run",)
    found = whole.findings(records, solution, {"K": 2.0}, ("B",))
    assert found.solution is solution
    assert found.statistical == ("scattered", solution, records, ("hidden",))
    assert set(found.causes) == {"gain", "held", "drag"}
    assert (found.fixed, found.without) == ({"K": 2.0}, ("B",))
    assert found.profiles == {"B": (0.0, 1.0)}
    assert found.undetected == (parts["line"],)
    assert found.hidden == ("hidden",)
    assert set(found.carried.shared) == {"gain"}
    assert whole.findings(records, solution, {}, (), profiled=False).profiles == {}
    without = whole.findings(records, solution, {}, (), answers=False)
    assert (without.undetected, set(without.causes)) == ((), {"gain", "held"})
    solution.unfinished = True
    assert whole.findings(records, solution, {}, ()).profiles == {}


@pytest.mark.parametrize(
    ("converged", "profiled", "counts"),
    [(True, True, True), (True, False, False), (False, True, False)],
)
def test_what_follows_by_no_straight_line_counts_where_likelihoods_are_followed(
    converged: bool, profiled: bool, counts: bool, parts: dict[str, Any],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    """It is asked for by the covariance that lacks it."""
    solution: Any = SimpleNamespace(unfinished=not converged)
    records: Any = ("run",)
    asked, bent = list[Any](), [np.array([2.0])]
    monkeypatch.setattr(whole.bent_valley, "shifts", lambda *a: asked.append(a) or bent)
    found = whole.findings(records, solution, {}, (), profiled=profiled)
    lacking = ("scattered", solution, records, ("hidden",))
    assert found.statistical == ((*lacking, bent) if counts else lacking)
    assert asked == ([(solution, records, lacking)] if counts else [])
    assert found.undetected == (parts["line"],)


def test_what_no_residual_shows_is_counted_by_cause(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first record has what all were settled by; every record has its own lags."""
    one, two, three, four = (np.array([float(k)]) for k in range(1, 5))
    known = Known({"drop": np.ones((1, 1))})
    monkeypatch.setattr(budget, "of_priors", lambda *_: known)
    monkeypatch.setattr(whole, "by_part", lambda *_: ("part",))
    monkeypatch.setattr(whole.log_scatter, "shifts", lambda *_: [four])
    monkeypatch.setattr(whole.uneven_residuals, "of_captures", lambda *_: [three])
    monkeypatch.setattr(whole.cogging_of_logs, "shifts", lambda *_: [one, four])
    monkeypatch.setattr(whole, "statistical", lambda *given: given)
    records: Any = [
        SimpleNamespace(left_open=[one], unsettled=two, between_ticks=None),
        SimpleNamespace(left_open=[two, three], unsettled=None, between_ticks=one),
    ]
    unseen: Any = [SimpleNamespace(shared=three)]
    monkeypatch.setattr(whole.log_scatter, "rivals", lambda *_, friction: [two] * friction)
    settled: Any = SimpleNamespace(converged=True, left=one)
    _, priors, hidden, pieces = whole.scattered(settled, records, unseen)  # type: ignore[misc]
    assert (priors, pieces) == (known, ("part",))
    assert hidden == {
        VOLTAGE_NOISE.name: [three], SCATTER: [four], budget.UNSTATED: [one, two, three],
        budget.SETTLING: [two], budget.GRID: [], budget.UNEVEN: [three], budget.BENT: (),
        budget.FRICTION: [two], budget.SEARCH: [], COGGING.name: [one, four],
    }  # fmt: skip
    records.reverse()
    bent = [two, four]
    unfinished: Any = SimpleNamespace(converged=False, left=one)
    _, _, hidden, _ = whole.scattered(unfinished, records, unseen, bent)  # type: ignore[misc]
    assert hidden[budget.SEARCH] == [one]
    assert (hidden[budget.SETTLING], hidden[budget.GRID]) == ([], [one])
    assert hidden[budget.BENT] == bent
