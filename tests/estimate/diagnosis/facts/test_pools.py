"""Captures that are fitted together: bounds of what tells motors and benches apart."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from motorid.capture.model import CURRENT, Capture, Stated
from motorid.estimate.diagnosis.facts import compare, pooled
from motorid.estimate.results.estimate import Diagnostic
from tests.estimate.diagnosis.facts.test_bench_facts import MOTOR, run, together


def scaled(capture: Capture, factor: float, gain_uncertainty: float = 0.0) -> Capture:
    """The same, whose current has another scale."""
    channel = capture.channels[CURRENT]
    other = replace(channel, scale=factor * channel.scale, gain_uncertainty=gain_uncertainty)
    return replace(capture, channels={**capture.channels, CURRENT: other})


@pytest.mark.parametrize(
    ("factor", "uncertainty", "named"),
    [
        (1.0009, 0.0, False), (1.0011, 0.0, True), (0.9988, 0.0, True),
        (-1.0, 0.0, False),  # a channel that is turned round is no gain
        (1.068, 0.01, False), (1.076, 0.01, True),  # 5 √2 hundredths
    ],
)  # fmt: skip
def test_gains_of_one_board_differ_beyond_their_uncertainty_or_a_thousandth(
    factor: float, uncertainty: float, named: bool
) -> None:
    runs = [scaled(run(), factor, uncertainty), scaled(run(), 1.0, uncertainty)]
    said = together(runs)
    assert bool(said) is named
    if named:
        assert f"the scale of the current (by {100 * abs(factor - 1):.2g} %)" in said[0].message
        assert said[0].message.startswith("runs 1 and 2 are of one board and differ in the scale")


def test_imports_scale_as_their_columns_ask_and_a_scale_of_nothing_is_none() -> None:
    imported = [replace(c, provenance={"serial": ""}) for c in (run(), scaled(run(), 2.0))]
    assert together(imported) == []
    assert together([scaled(run(), 0.0), run()]) == []
    bare = {n: c for n, c in run().channels.items() if n != CURRENT}
    assert together([replace(run(), channels=bare), scaled(run(), 2.0)]) == []


def test_neighbours_of_one_board_are_compared_and_all_differences_said() -> None:
    same = run(gear_ratio=2.0)
    other = scaled(run(counts_per_turn=100.0), 0.8)
    (said,) = together([same, replace(same), other])
    assert said.message.startswith("runs 2 and 3 are of one board and differ in wiring.counts")
    assert "wiring.gear_ratio (2 and 1); the scale of the current (by 25 %): fit" in said.message
    name = {"identity": {"board": "c"}, "board_serial": "A1", "serial": ""}
    assert together([same, replace(other, provenance=name)]) == []


@pytest.mark.parametrize(
    ("ohms", "named"), [((2.0, 2.019), False), ((2.0, 2.021), True), ((2.0, 0.0, 2.0), False)]
)
def test_nameplates_of_one_motor_agree_to_a_hundredth(ohms: tuple[float, ...], named: bool) -> None:
    runs = [replace(run(), stated=Stated({"resistance_ohm": r} if r else {})) for r in ohms]
    said = together(runs)
    assert bool(said) is named
    if named:
        assert "state nameplate.resistance_ohm as 2 and as 2.021, and" in said[0].message
        assert said[0].severity == "warning"


def test_one_capture_agrees_with_itself_and_the_motor_farthest_off_counts() -> None:
    assert together([run(serial="M17")]) == []
    R = {"M17": 2.0, "M18": 2.5, "M19": 1.0}

    def fitted(captures: Any) -> Any:
        known = {c.provenance["serial"] for c in captures}
        value = R[known.pop()] if len(known) == 1 else 1.5
        J = None if value == 2.5 else MOTOR["J"].value
        changed = {"R": replace(MOTOR["R"], value=value), "J": replace(MOTOR["J"], value=J)}
        return SimpleNamespace(parameters={n: p for n, p in {**MOTOR, **changed}.items()
                                           if n != "L" or len(captures) > 1})  # fmt: skip

    runs = [run(serial=name) for name in ("M17", "M18", "", "M19", "M18")]
    (said,) = pooled.findings(runs, fitted(runs), fitted)
    assert "name 3 serial numbers (run 1 of M17; runs 2, 5 of M18; run 4 of M19)" in said.message
    assert said.moves["R"] == pytest.approx(1.0)  # of M18; M17 and M19 are .5 off
    assert said.moves["J"] == said.moves["L"] == math.inf  # no value, no such parameter
    assert said.moves["K"] == 0.0


def test_every_comparison_is_made_of_every_capture(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[Any, ...]] = []
    one, two = run(), run()
    estimate: Any = SimpleNamespace(parameters="parameters", combinations="combinations")

    def notes(name: str) -> Any:
        def given(*what: Any) -> Any:
            asked.append((name, *what))
            yield Diagnostic(name, "info", "")

        return given

    each = ("swapped_columns", "supply_current", "doubled_rows", "supply", "aliasing",
            "commanded", "unreached_command")  # fmt: skip
    for name in (*each, "pooled", "unit_mistakes", "plate"):
        monkeypatch.setattr(getattr(compare, name), "findings", notes(name))
    fit: Any = "fit"
    codes = [d.code for d in compare.findings([one, two], estimate, fit)]
    assert codes == ["pooled", *each, *each, "unit_mistakes", "plate"]
    short = ("swapped_columns", "supply_current", "unreached_command")
    for capture, where, calls in ((one, " in run 1", asked[1:8]), (two, " in run 2", asked[8:15])):
        for name, *what in calls:
            middle = [] if name in short else ["parameters"]
            assert what == [capture, *middle, where]
    assert asked[0] == ("pooled", [one, two], estimate, "fit")
    assert asked[-2:] == [
        ("unit_mistakes", [one, two], "parameters", "combinations"),
        ("plate", [one, two], estimate),
    ]
    asked.clear()
    list(compare.findings([one], estimate, fit))
    assert {call[-1] for call in asked[1:8]} == {""}
