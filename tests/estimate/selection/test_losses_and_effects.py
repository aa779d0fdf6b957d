"""Losses that ask for a better model, effects that are seen, shafts that may be given, and what a
wider answer is made of: by hand.
"""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.effects.friction.windage import WINDAGE
from motorid.estimate.model.extended_terms import TERMS
from motorid.estimate.selection import (
    extended_results,
    seen_effects,
    shaft_resonance,
    trigger,
)
from motorid.estimate.solver.problem import Linearised, Unknown
from motorid.estimate.uncertainty.undetected import Undetected
from tests.estimate.selection.noted_stages import noting
from tests.estimate.solutions import MOTOR, solution
from tests.report.example import estimate, parameter

SIDED, COGS, TWO = (TERMS[name] for name in ("direction", "cogging", "two-masses"))
DROP, OFFSET, WARMING = (
    Unknown(n, 0.0) for n in ("brush drop", "current offset", "winding warming")
)

# losses


def lossy(seed: int) -> tuple[Any, Linearised, np.ndarray]:
    """A record with an offset between two losses, its lines, and its own sizes."""
    rng = np.random.default_rng(seed)
    shared, own = rng.standard_normal((60, 2)), rng.standard_normal((60, 3))
    precision = np.array([0.5, 2.0, 0.25])
    inverse = np.linalg.inv(own.T @ own + np.diag(precision))
    orthogonal = shared - own @ inverse @ own.T @ shared
    line = Linearised(
        np.zeros(60), shared, own, orthogonal, precision, (), (slice(0, 60),), np.ones(1)
    )
    record: Any = SimpleNamespace(unknowns=(DROP, OFFSET, WARMING))
    return record, line, rng.standard_normal(3)


def found(*runs: tuple[Any, Linearised, np.ndarray], covariance: Any = None) -> Any:
    unknowns = (Unknown("R", 2.0, log=True), Unknown("L", 3.0))
    return SimpleNamespace(
        records=[line for _, line, _ in runs], own=[own for *_, own in runs], unknowns=unknowns,
        information=np.eye(2), slopes=np.array([2.0, 1.0]), own_covariance=covariance,
    )  # fmt: skip


def test_a_loss_counts_by_its_square_in_deviations() -> None:
    """Of the losses alone, whose errors go together; 15 in all captures."""
    (record, line, own) = lossy(1)
    covariance = np.array([[4.0, 9.0, 1.0], [9.0, 50.0, 7.0], [1.0, 7.0, 9.0]])
    own[:] = (3.0, 100.0, 6.0)
    part = np.linalg.inv(covariance[np.ix_([0, 2], [0, 2])])
    wanted = np.array([3.0, 6.0]) @ part @ np.array([3.0, 6.0])
    known = found((record, line, own), covariance=[covariance])
    assert trigger._taken(record, known, 0) == pytest.approx(wanted)
    bare: Any = SimpleNamespace(unknowns=(OFFSET,))
    none: Any = SimpleNamespace(own=[np.array([9.0])], own_covariance=[np.eye(1)])
    assert trigger._taken(bare, none, 0) == 0.0
    assert not trigger.carry_loss([bare])
    assert trigger.carry_loss([bare, record])


def test_without_a_loss_parameters_move_as_a_fit_without_it_has_them() -> None:
    """Against a least squares over all records in which losses are held at nothing."""
    runs = [lossy(1), lossy(2)]
    rows, targets = [], []
    for k, (_, line, own) in enumerate(runs):
        table = np.zeros((61, 4))
        table[:60, :2], table[:60, 2 + k] = line.shared, line.own[:, 1]
        table[60, 2 + k] = np.sqrt(line.own_precision[1])
        rows.append(table)
        targets.append(np.append(line.own[:, [0, 2]] @ own[[0, 2]], 0.0))
    moves = np.linalg.lstsq(np.concatenate(rows), np.concatenate(targets), rcond=None)[0][:2]
    got = trigger._moves([record for record, *_ in runs], found(*runs))
    assert got == pytest.approx({"R": 2.0 * moves[0], "L": moves[1]})


@pytest.mark.parametrize(
    ("taken", "moves", "stands"),
    [
        ((7.0, 8.1), {"R": 0.6, "L": 0.0}, True), ((7.0, 7.9), {"R": 0.6}, False),
        ((15.0, 0.0), {"R": 0.6}, True), ((9.0, 9.0), {"R": 0.5}, False),
        ((9.0, 9.0), {"R": -0.51}, True), ((9.0, 9.0), {"L": 99.0}, False),
        ((9.0, 9.0), {"R": float("nan")}, True), ((9.0, 9.0), {}, False),
    ],
)  # fmt: skip
def test_a_loss_asks_where_it_is_no_noise_and_moves_half_of_what_matters(
    taken: tuple[float, float], moves: dict[str, float], stands: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    """But for an inductance, which losses hardly tell."""
    monkeypatch.setattr(
        trigger, "_taken", lambda record, _found, k: taken[k] if record == k else None
    )
    monkeypatch.setattr(trigger, "_moves", lambda *_: moves)
    records: Any = [0, 1]
    assert trigger.loss_stands_out(records, solution(), {"R": 1.0, "L": 1.0}) is stands


def dropping(drops: tuple[float, ...], deviation: float) -> tuple[Any, Any]:
    """Captures whose brushes drop so much (V), of which -50 mV is the least."""
    drop = replace(solution().unknowns[0], name="brush drop", lower=-0.05, upper=2.0)
    other = replace(drop, name="winding warming")
    records = [SimpleNamespace(unknowns=(other, drop)) for _ in drops]
    own = tuple(np.array([-9.0, v]) for v in drops)
    covariance = tuple(np.diag([1.0, deviation**2]) for _ in drops)
    return records, SimpleNamespace(own=own, own_covariance=covariance)


@pytest.mark.parametrize(
    ("drops", "deviation", "gives"),
    [
        ((-0.026,), 0.006, True), ((-0.026,), 0.007, False), ((-0.024,), 0.001, False),
        ((0.05,), 0.001, False), ((-0.05, -0.048, -0.05), 0.001, True),
        ((-0.05, -0.048, 0.02), 0.001, False), ((-0.05, -0.02, -0.03), 0.001, False),
        ((), 1.0, False),
    ],
)  # fmt: skip
def test_brushes_seem_to_give_voltage_where_every_capture_says_so(
    drops: tuple[float, ...], deviation: float, gives: bool
) -> None:
    assert trigger.drop_gives(*dropping(drops, deviation)) is gives


def test_a_drop_that_was_declared_above_none_gives_nothing() -> None:
    records, found = dropping((0.0,), 0.001)
    (record,) = records
    above = tuple(replace(one, lower=0.1) for one in record.unknowns)
    assert not trigger.drop_gives([SimpleNamespace(unknowns=above)], found)  # type: ignore[list-item]


# effects that are seen


def seen(share: float, times: float, half: float = 0.2, **other: Any) -> Any:
    """What is said of an effect that moves T0, of 2, by a share of it."""
    T0 = replace(parameter("T0", "N·m", 2.0), interval_95=(2.0 - half, 2.0 + half), **other)
    one = replace(estimate(), parameters={"T0": T0})
    at = replace(solution(T0=2.0), unknowns=solution().unknowns)
    shift = np.r_[np.zeros(5), share * 2.0 / times]
    return seen_effects._said(one, Undetected(WINDAGE, shift, 0.05, times), at)


@pytest.mark.parametrize(("share", "moves"), [(0.049, False), (0.051, True), (-0.051, True)])
def test_a_move_of_half_of_half_an_interval_is_said_with_its_side(
    share: float, moves: bool
) -> None:
    """By as many deviations as are seen of it: a share of 2, of an interval of 2 ± .2."""
    said = seen(share, 5.0)
    if not moves:
        assert (said.moves, said.sides) == ({}, {})
        return
    assert said.moves == pytest.approx({"T0": 0.102})
    sides = (0.0, 0.102) if share > 0 else (0.102, 0.0)
    assert said.sides == {"T0": pytest.approx(sides)}
    assert (said.code, said.severity) == ("effect_seen", "warning")
    assert f"show {WINDAGE.name} (5.0 standard deviations)" in said.message
    assert f"it can move T0; {WINDAGE.remedy}" in said.message


def test_a_value_that_nobody_knows_does_not_move() -> None:
    assert seen(0.5, 5.0, value=None).moves == {}
    none = replace(parameter("T0", "N·m", 2.0), interval_95=None)
    for parameters in ({"T0": none}, {}):
        one = replace(estimate(), parameters=parameters)
        effect = Undetected(WINDAGE, np.full(6, 9.0), 0.05, 5.0)
        assert seen_effects._said(one, effect, solution()).moves == {}


def test_effects_that_are_seen_and_move_something_come_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: dict[str, Any] = {}
    one = estimate()
    effects = [SimpleNamespace(seen=s, moves=m) for s, m in ((5.0, "R"), (0.0, "R"), (6.0, ""))]
    monkeypatch.setattr(
        seen_effects, "_said", lambda *of: asked.setdefault("said", []).append(of) or of[1]
    )
    noting(monkeypatch, seen_effects, asked, settled=one)
    known: Any = SimpleNamespace(undetected=effects, solution="s")
    found = seen_effects.with_seen(one, known)
    assert [of[1] for of in asked["said"]] == [effects[0], effects[2]]
    assert all((of[0], of[2]) == (one, "s") for of in asked["said"])
    assert asked["settled"] == [(one, [effects[0]])]
    assert found.diagnostics == (effects[0], *one.diagnostics)


# shafts


def test_records_may_have_a_shaft_beside_the_phases_that_they_have(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What is not searched stays held; steps are those of the record."""

    class Wide:
        def __init__(self, *given: Any, first: bool) -> None:
            self.given, self.first = given, first

        def step_as(self, record: Any) -> None:
            self.steps = record

    monkeypatch.setattr(shaft_resonance, "WideRecord", Wide)
    monkeypatch.setattr(shaft_resonance, "scales_of", lambda *of: of)
    phase = COGS.phase
    assert phase is not None
    records: Any = [
        SimpleNamespace(unknowns=(OFFSET, Unknown(phase.name, 0.0))),
        SimpleNamespace(unknowns=(OFFSET,)),
    ]
    searched = replace(solution(), unknowns=solution().unknowns[:2], values=np.array([2.0, 4e-3]))
    bare: Any = shaft_resonance._bare(records, searched, {"R": 1.0, "J": 3.0, "Ks": 9.0})
    free = ("R", "L", *TWO.free)
    for record, wide, taken in zip(records, bare, ([COGS], []), strict=True):
        scales = (records, {"R": 1.0, "J": 3.0, "Ks": 9.0})
        assert wide.given == (record, free, {"J": 3.0}, taken, scales, {})
        assert (wide.first, wide.steps) == (False, record)


def test_nuisances_that_are_held_at_a_bound_explain_nothing() -> None:
    _, line, _ = lossy(3)
    residual = np.random.default_rng(4).standard_normal(60)
    rows = np.vstack([line.own, np.diag(np.sqrt(line.own_precision))])
    target = np.append(residual, np.zeros(3))

    def explained(kept: list[int]) -> float:
        rest = target - rows[:, kept] @ np.linalg.lstsq(rows[:, kept], target, rcond=None)[0]
        return float(target @ target - rest @ rest)

    assert shaft_resonance._explained(line, residual) == pytest.approx(explained([0, 1, 2]))
    held = replace(line, held=(1,))
    assert shaft_resonance._explained(held, residual) == pytest.approx(explained([0, 2]))
    none = replace(line, own=np.zeros((60, 0)), own_precision=np.zeros(0))
    assert shaft_resonance._explained(none, residual) == 0.0


def test_a_shaft_is_looked_for_along_the_same_solution(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: dict[str, Any] = {}
    line = SimpleNamespace(residual=np.full(4, 5.0))
    at: Any = replace(solution(), linearise=lambda: (line,))
    noting(
        monkeypatch, shaft_resonance, asked, _is_coloured=True, _bare="bare", _resonances=[200.0],
        _left=(60.0, np.zeros(6)),
    )  # fmt: skip
    values = {**MOTOR, "J": 3e-5}
    (one,) = shaft_resonance.springs(["r"], at, values, [COGS])  # type: ignore[list-item]
    assert asked["_is_coloured"] == [(at,)]
    assert asked["_bare"] == [(["r"], at, values)]
    assert asked["_resonances"] == [(["r"], at)]
    assert all(of[:2] == ("bare", at) for of in asked["_left"])
    assert one.gain == pytest.approx(100.0 - 60.0)
    assert one.start["Ks"] == pytest.approx(
        3e-5 * one.start["J2_share"] * (1.0 - one.start["J2_share"]) * (0.98 * 200.0) ** 2
    )


# a wider answer


def test_a_wider_answer_has_what_its_input_hides_and_what_was_not_modelled(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: dict[str, Any] = {}
    lines = [Undetected(WINDAGE, np.zeros(6), 0.05)]
    carried = SimpleNamespace(shared="shared")
    noting(monkeypatch, extended_results.errors_in_variables, asked, hidden="hidden")
    noting(monkeypatch, extended_results.budget, asked, carried=carried, lines_of={"gain": 1})
    noting(
        monkeypatch, extended_results, asked, undetected=lines, scattered="scattered",
        beside={"windage": 2}, held_values={"J": 7.0},
    )  # fmt: skip
    fitted: Any = SimpleNamespace(solution="s", records="r")
    known: Any = extended_results.findings(fitted, {"J": 7.0}, ("B",))
    assert asked["hidden"] == asked["carried"] == [("s", "r")]
    assert asked["scattered"] == asked["undetected"] == [("s", "r", "hidden")]
    assert asked["lines_of"] == [("shared", "s", "r")]
    assert asked["beside"] == [(lines,)]
    assert asked["held_values"] == [({"J": 7.0}, ("B",))]
    assert (known.solution, known.statistical) == ("s", "scattered")
    assert known.causes == {"gain": 1, "windage": 2}
    assert (known.fixed, known.without) == ({"J": 7.0}, ("B",))
    assert (known.undetected, known.hidden, known.carried) == (lines, "hidden", carried)


def test_an_alternative_names_its_terms_and_states_its_fit(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: dict[str, Any] = {}
    noting(monkeypatch, extended_results.residual_remarks, asked, chi_square=(30.0, 25))
    noting(monkeypatch, extended_results.assemble, asked, nuisance_parameters={"offset": 1})
    noting(monkeypatch, extended_results, asked, parameters={"R": 2}, _lack_of_fit=("lack",))
    records = [SimpleNamespace(simulated=n) for n in (4, 9, 2)]
    fitted: Any = SimpleNamespace(terms=(SIDED, COGS), solution="s", records=records)
    one = extended_results.alternative(fitted, "f", ["six"], "before", ["trial"], True)  # type: ignore[arg-type,list-item]
    assert (one.name, one.terms) == ("six+direction+cogging", ("direction", "cogging"))
    assert one.titles == (SIDED.title, COGS.title)
    assert one.equations == (SIDED.equation, COGS.equation)
    assert (one.asked, one.evaluations, one.trials) == (True, 9, ("trial",))
    assert (one.chi_square, one.degrees_of_freedom) == (30.0, 25)
    assert (one.parameters, one.nuisance, one.lack_of_fit) == ({"R": 2}, {"offset": 1}, ("lack",))
    assert asked["chi_square"] == [("s", records)]
    assert asked["nuisance_parameters"] == [("f", records)]
    assert asked["parameters"] == [("f", fitted)]
    assert asked["_lack_of_fit"] == [(fitted, ["six"], "before")]


def stated(value: float, noise: float, known: float = 0.0, **how: Any) -> Any:
    facts = {"log": False, "bound": False, "lower": -1.0, **how}
    return extended_results._stated("x", "m", value, (noise, known), np.inf, **facts)


def test_what_is_at_a_bound_is_nothing_or_unknown() -> None:
    """At nothing where nothing is its bound; else data do not determine it."""
    none = stated(0.0, 3.0, 4.0, bound=True, lower=0.0)
    assert (none.value, none.total, none.status) == (0.0, 5.0, "at_bound")
    assert none.interval_95 == pytest.approx((0.0, 1.96 * 5.0), rel=1e-3)
    for how in ({"lower": -1.0}, {"lower": 0.0, "log": True}):
        assert stated(0.0, 3.0, bound=True, **how).value is None
    upper = stated(0.95, 1e-3, bound=True, lower=0.0)
    assert upper.value is None
    assert ": below" not in upper.note
    assert stated(0.95, 1e-3, lower=0.0).value == 0.95
    assert stated(0.0, 3.0, lower=0.0).value is None


def test_an_end_of_an_interval_is_no_lower_than_may_be() -> None:
    low, high = stated(1.0, 0.3, lower=0.9).interval_95
    assert (low, high) == pytest.approx((0.9, 1.0 + 1.96 * 0.3), rel=1e-3)
    low, high = stated(-1.0, 0.2).interval_95
    assert (low, high) == pytest.approx((-1.0, -1.0 + 1.96 * 0.2), rel=1e-3)


def test_a_channel_without_readings_lacks_nothing() -> None:
    assert extended_results._rms(np.zeros(0)) == 0.0
    assert extended_results._rms(np.array([3.0, -4.0])) == pytest.approx(np.sqrt(12.5))
