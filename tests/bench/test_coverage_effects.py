"""Drawn motors with iron, windage or friction under load, and what could be known of them."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.coverage import moved
from bench.coverage.bound import BRUSH, NAMES, AtTruth, Unknown, linearised
from bench.coverage.cost import counted
from bench.coverage.effect_tables import DRAWN, Row, effect_tables
from bench.coverage.rigs import draw_bench
from bench.coverage.runs import record
from bench.iron import TERMS, present
from motorid.estimate.model.extended_terms import TERMS as KNOWN
from motorid.motor.reading import Output, Quantity
from motorid.motor.response import Response
from motorid.motor.wide import AT_REST, WideResponse
from motorid.motor.wide import NAMES as OF_A_MOTOR

SEEDS = range(3000, 3012)


def test_every_effect_is_a_term_of_the_wider_model() -> None:
    assert set(TERMS.values()) <= set(KNOWN)


def test_the_rig_is_the_same_but_for_its_effects() -> None:
    for seed in SEEDS:
        with_effects, plain = draw_bench(seed, effects=True), draw_bench(seed)
        assert 1 <= len(present(with_effects.iron)) <= 3
        assert not present(plain.iron)
        assert not plain.added
        assert with_effects.stated == plain.stated
        fields = ("reaction", "reaction_bend", "saturation", "eddy", "eddy_time", "quadratic")
        same = {name: getattr(plain.options, name) for name in (*fields, "load_friction")}
        assert replace(with_effects.options, **same) == plain.options


def test_what_the_bound_knows_of_an_effect_is_what_the_simulator_does() -> None:
    for seed in SEEDS:
        bench = draw_bench(seed, effects=True)
        motor, added, iron = bench.drawn.motor, bench.added, bench.iron
        stall, idle = motor.stall_current_a, motor.voltage_v / motor.torque_constant_nm_a
        if iron.reaction:
            bend = added["reaction_bend"]
            assert added["reaction"] * (math.hypot(stall, bend) - bend) == pytest.approx(
                iron.reaction
            )
        if iron.saturation:
            share = stall**2 / (stall**2 + added["saturation_current"] ** 2)
            assert added["saturation"] * share == pytest.approx(iron.saturation)
        if iron.windage:
            torque = added["quadratic"] * idle**2
            assert torque == pytest.approx(iron.windage * motor.viscous_nm_s * idle)


@pytest.mark.slow
def test_an_effect_of_unknown_size_lets_no_more_be_known(tmp_path: Path) -> None:
    bench = draw_bench(3005, effects=True)
    assert present(bench.iron) == ("load friction",)
    runs = record(bench, tmp_path)
    at = linearised(runs.captures, runs.truth, added=bench.added)
    with_it = at.bound(without=BRUSH)
    without = linearised(runs.captures, runs.truth).bound(without=BRUSH)
    # here the gains are most of it: rounding alone moves it by a ten-thousandth
    assert all(with_it[name] > 0.999 * without[name] for name in NAMES)


@pytest.mark.parametrize("spoilt", [0.0, 50.0])
def test_what_looks_like_a_parameter_moves_that_one(
    spoilt: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An effect that is .3 steps of L in the current; of the position, what nothing explains."""
    rng = np.random.default_rng(3)
    columns = rng.normal(size=(len(NAMES) + 2, 400))
    things = [Unknown(name, 0.01) for name in NAMES]
    things += [Unknown("current gain", 0.01, 0.001), Unknown("eddy", 0.01)]
    unlike = spoilt * rng.normal(size=200)

    class Twin:
        def readings(self, change: dict[str, float]) -> dict[str, Any]:
            here = 1.0 + change.get("eddy", 0.0)
            like = 0.3 * columns[1]
            return {"current": here * like[:200], "position": here * (like[200:] + unlike)}

    monkeypatch.setattr(
        moved, "weights", lambda _: {name: np.ones(200) for name in ("current", "position")}
    )
    capture: Any = None
    twin: Any = Twin()
    at = AtTruth([twin], things, [columns])
    found = moved.moves([capture], at, {"eddy": 0.4, "eddy_time": 1e-4})
    others = {name: 0.0 for name in NAMES if name != "L"}
    assert found == {"eddy": pytest.approx({"L": 0.003, **others}, abs=1e-12 + 1e-6 * spoilt)}


def row(effects: list[str], terms: list[str], moved: list[str], *, holds: bool = True) -> Row:
    """A record of a motor whose six-parameter fit took 100 responses and whose search took 300."""
    value = {"status": "estimated", "off": 0.0, "interval": [-1.0, 1.0], "holds": holds}
    return {
        "seed": 7,
        "effects": effects,
        "feature": {figure: float(term == "ripple") for term, figure in DRAWN.items()},
        "fit": {"responses": 100},
        "moves": {effect: dict.fromkeys(moved, -0.2) for effect in effects},
        "headline": {
            "parameters": {"B": value},
            "half": {"B": 0.1},
            "responses": 300,
        },
        "better": {"terms": terms},
    }


def test_what_is_named_rightly_wrongly_or_without_an_effect_is_counted_apart() -> None:
    rows = [
        row(["windage"], ["quadratic-load"], ["B"]),
        row(["windage"], ["direction"], ["B"], holds=False),
        row(["eddy"], [], []),
        row([], ["cogging", "ripple"], []),
        row([], ["ripple"], []),
    ]
    said = effect_tables(rows)
    assert "| windage | 2 | 1 | 2 | 1 |" in said
    assert "motors whose effects matter: 2; an effect named in 1" in said
    assert "another effect: direction 1; direction or cogging in 1 of 3" in said
    assert "false offers: 1 of 2 motors without an effect (7 cogging)" in said
    assert "hold: 4 of 5; 4 of 5 that are not doubtful" in said
    assert "median 3.0, at most 3.0; above 5 in 0 of 5" in said


def test_responses_are_counted_while_asked_for_and_not_after() -> None:
    response = Response(1e-3, np.ones(10), [Output(Quantity.CURRENT)])
    motor = (1.0, 1e-3, 0.01, 1e-6, 1e-6, 1e-4)
    with counted() as count:
        first = response(motor)
    assert count.responses == 1
    assert np.array_equal(first, response(motor))
    assert count.responses == 1


def test_responses_side_by_side_are_counted_each() -> None:
    response = WideResponse(1e-3, np.ones(10), [Output(Quantity.CURRENT)])
    motor = np.array([*(1.0, 1e-3, 0.01, 1e-6, 1e-6, 1e-4), *[0.0] * (len(OF_A_MOTOR) - 6)])
    runs = [response.pose(motor * (1.0 + 0.01 * k), AT_REST) for k in range(3)]
    with counted() as count:
        answers = response.several(runs)
        response(motor)
    computed = sum(answer is not None for answer in answers)
    assert computed in (0, 3)  # none where the compiler knows no vectors
    assert count.responses == computed + 1
    response.several(runs)
    assert count.responses == computed + 1
