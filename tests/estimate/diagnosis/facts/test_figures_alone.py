"""Figures of a motor by themselves or all together: whether any has them, and what is said."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture, Channel, Wiring
from motorid.capture.units import TIME
from motorid.estimate.diagnosis.facts import unit_mistakes
from motorid.estimate.diagnosis.facts.unit_mistakes import Mistake
from motorid.estimate.results.estimate import Diagnostic, Parameter
from motorid.estimate.results.status import Status
from motorid.program import Decay, Program, Step, StepKind

MAPS = ("time = t : ms", "voltage=v/2:mV", "current=i:A", "speed=n:rpm")
UNITS = {"R": "ohm", "L": "H", "K": "N·m/A", "J": "kg·m²"}


def log(**facts: Any) -> Capture:
    """A log of four rows, each 20 ms after the one before."""
    units = {VOLTAGE: "V", CURRENT: "A", SPEED: "rad/s"}
    channels = {n: Channel(n, unit, np.array([1.0, -6.0, 3.0, 2.0])) for n, unit in units.items()}
    known = {"channels": channels, "provenance": {"maps": MAPS}, **facts}
    return Capture(20_000 * np.arange(4), 1e6, **known)


def known(status: Status = Status.ESTIMATED, **values: float | None) -> dict[str, Parameter]:
    return {
        n: Parameter(n, UNITS.get(n, "s"), v, None, None, None, None, status)
        for n, v in values.items()
    }


def alone(capture: Capture | None = None, **values: float | None) -> list[Diagnostic]:
    """What is said of figures without a whole motor."""
    given = {n.replace("_over_", "/"): v for n, v in values.items()}
    return list(unit_mistakes.findings([capture or log()], known(**given)))


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"R": 1e4}, "R is 1e+04 ohm, and motors have 0.00075 to 3.1e+03 ohm"),
        ({"R": 1e-4}, "R is 0.0001 ohm, and motors have 0.00075 to 3.1e+03 ohm"),
        ({"L": 1.0}, "L is 1 H, and motors have 6e-07 to 0.27 H"),
        ({"K": 20.0}, "K is 20 N·m/A, and motors have 7e-05 to 15 N·m/A"),
        ({"J": 1e-11}, "J is 1e-11 kg·m², and motors have 1.6e-10 kg·m² or more"),
        ({"R": 1.0, "L": 0.1}, "L/R is 0.1 s, and motors have 3.3e-07 to 0.047 s"),
        ({"R": 10.0, "J_over_K²": 1e-6}, "JR/K² is 1e-05 s, and motors have"),
    ],
)
def test_a_figure_that_no_motor_has_is_named_with_those_that_motors_have(
    values: dict[str, float], words: str
) -> None:
    (said,) = alone(log(provenance={}), **values)
    assert (said.code, said.severity) == ("unit_mistake", "warning")
    assert said.message.startswith(words)


@pytest.mark.parametrize(
    "values",
    [
        {"R": 1000.0}, {"L": 0.2}, {"K": 10.0}, {"J": 10.0}, {"R": 10.0, "L": 0.1}, {},
        {"R": None, "L": None}, {"R": 10.0, "J_over_K²": 1e-3}, {"J_over_K²": 1e-9},
        {"R": 0.0, "L": 0.1}, {"B": 1e9},
    ],
)  # fmt: skip
def test_what_some_motor_has_or_nobody_knows_is_not_named(values: dict[str, float]) -> None:
    assert alone(**values) == []


def test_a_figure_that_is_given_is_none_of_the_data() -> None:
    given = known(Status.FIXED, R=1e4)
    assert list(unit_mistakes.findings([log()], given)) == []


@pytest.mark.parametrize("name", ["JR/(K²+RB)", "J R/K²"])
def test_a_time_constant_that_is_too_short_may_be_in_another_unit(name: str) -> None:
    """5 µs in milliseconds of a clock that counts seconds; all that goes with the clock moves."""
    constants = known(**{name: 5e-6, "J/K²": 1e-6, "L": 1e-6, "L/R": 2e-6, "K/J": 3.0})
    (said,) = unit_mistakes.findings([log()], {}, constants)
    assert said.message.startswith("JR/K² is 5e-06 s, and motors have 0.00011 s or more")
    assert "perhaps the time is in s, not ms" in said.message
    moves = {"L": 1e-3, "L/R": 2e-3, "J/K²": 1e-3, name: 5e-3}
    assert said.moves == pytest.approx({n: 0.999 * v for n, v in moves.items()})
    (said,) = unit_mistakes.findings([log(provenance={"identity": {}})], {}, constants)
    assert said.message.endswith("and of the time, of the gains and of the gear")
    assert said.moves == {}


def test_how_far_a_single_figure_is_off_is_open() -> None:
    (said,) = alone(log(provenance={}), R=1e4)
    assert said.moves == {"R": math.inf}
    (said,) = alone(R=1e4)  # of a clock, a resistance tells nothing
    assert said.message.endswith("and of the time, of the gains and of the gear")
    assert said.moves == {"R": math.inf}


WRONG = Mistake(SPEED, 0.1, "the speed were in rpm, not rad/s", "give rpm", 3.0)
OTHER = Mistake(CURRENT, 1e3, "the current were in mA, not A", "give mA", 4.0)
SAME = Mistake(VOLTAGE, 1e3, "the voltage were in mV, not V", "give mA", 4.0)


def judged(monkeypatch: pytest.MonkeyPatch, narrow: float, wide: float,
           *mistakes: Mistake) -> list[Diagnostic]:  # fmt: skip
    """What is said of a motor at these distances, which these mistakes would explain."""
    monkeypatch.setattr(unit_mistakes, "distance", lambda _, wide_=False, **how:
                        wide if how.get("wide") else narrow)  # fmt: skip

    def explained(capture: Capture, motor: Any, found: float) -> list[Mistake]:
        assert found == narrow
        return list(mistakes)

    monkeypatch.setattr(unit_mistakes, "explanations", explained)
    return list(unit_mistakes.findings([log()], known(R=2.0, K=0.5, J=1e-3, L=1e-3)))


def test_a_motor_that_none_has_is_a_warning_and_moves_the_figures(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    (said,) = judged(monkeypatch, 20.0, 17.0, WRONG, OTHER)
    assert (said.code, said.severity) == ("unit_mistake", "warning")
    assert said.message == (
        "no motor of the catalogues has R 2 ohm, K 0.5 N·m/A and J 0.001 kg·m² together, at up to "
        "5.91 V; they would be usual if the speed were in rpm, not rad/s or the current were in "
        "mA, not A, or if a gear is not stated, so compare a reading with an instrument, and give "
        "rpm or give mA"
    )
    # a speed a tenth of what is true: K ten times, J a hundred times
    assert said.moves == pytest.approx({"K": 0.45, "J": 0.99e-3})


def test_a_motor_that_few_have_is_a_remark(monkeypatch: pytest.MonkeyPatch) -> None:
    (said,) = judged(monkeypatch, 20.0, 15.0, OTHER, SAME)
    assert (said.severity, said.moves) == ("info", {})
    assert said.message.startswith("few motors have R 2 ohm")
    assert "not V, so compare" in said.message  # no gear makes a current
    assert said.message.endswith("with an instrument, and give mA")  # once


def test_a_gear_makes_a_speed_too_low_and_never_too_high(monkeypatch: pytest.MonkeyPatch) -> None:
    for quantity, factor, gear in ((SPEED, 0.1, True), (POSITION, 0.5, True), (SPEED, 10.0, False),
                                   (CURRENT, 0.1, False)):  # fmt: skip
        one = replace(WRONG, quantity=quantity, factor=factor)
        (said,) = judged(monkeypatch, 20.0, 17.0, one)
        assert ("or if a gear is not stated" in said.message) is gear


@pytest.mark.parametrize(
    ("narrow", "wide", "codes"),
    [
        (50.0, 20.0, ["no_such_motor"]), (44.0, 20.0, []), (50.0, 15.0, []), (8.9, 20.0, []),
        (9.1, 20.0, []),
    ],
)  # fmt: skip
def test_what_no_unit_explains_is_named_far_from_all_motors_alone(
    narrow: float, wide: float, codes: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    said = judged(monkeypatch, narrow, wide)
    assert [one.code for one in said] == codes
    assert all(one.severity == "warning" and not one.moves for one in said)
    usual = judged(monkeypatch, 8.9, 20.0, WRONG)
    assert usual == []
    assert len(judged(monkeypatch, 9.1, 20.0, WRONG)) == 1


def test_a_motor_is_its_figures_at_the_highest_voltage_of_all_captures() -> None:
    low = log()
    volts = low.channels[VOLTAGE]
    high = replace(low, channels={**low.channels, VOLTAGE: replace(volts, raw=2 * volts.raw)})
    six = known(R=2.0, L=3e-3, K=0.05, B=1e-6, J=1e-5)
    found = unit_mistakes.figures([low, high], six)
    assert found is not None
    top = 2.0 * float(np.percentile([1.0, 6.0, 3.0, 2.0], 99))
    assert (found.top_v, found.R, found.L, found.K, found.J) == pytest.approx(
        (top, 2.0, 3e-3, 0.05, 1e-5)
    )
    for status in (Status.FIXED, Status.DOUBTFUL):
        held = unit_mistakes.figures([low], {**six, **known(status, L=3e-3)})
        assert held is not None
        assert held.L is None
    for name in ("R", "K", "J"):
        for value in (None, 0.0, -1.0):
            assert unit_mistakes.figures([low], {**six, **known(**{name: value})}) is None
    still = replace(low, channels={n: c for n, c in low.channels.items() if n != VOLTAGE})
    assert unit_mistakes.figures([still], six) is None


def test_the_highest_voltage_was_read_or_commanded() -> None:
    steps = (
        Step(StepKind.DRIVE_VOLTS, 0.1, 2.5, Decay.SYNCHRONOUS_SLOW),
        Step(StepKind.DRIVE_DUTY, 0.1, -0.5, Decay.SYNCHRONOUS_SLOW), Step(StepKind.COAST, 0.1),
    )  # fmt: skip
    commanded = log(channels={}, program=Program(steps), wiring=Wiring(supply_voltage_v=12.0))
    assert unit_mistakes.highest_v(commanded) == 6.0
    assert unit_mistakes.highest_v(replace(commanded, wiring=Wiring())) == 2.5
    assert unit_mistakes.highest_v(log(channels={})) == 0.0
    gaps = Channel(VOLTAGE, "V", np.array([np.nan, -6.0, -6.0, -6.0]))
    assert unit_mistakes.highest_v(log(channels={VOLTAGE: gaps})) == 6.0
    lost = Channel(VOLTAGE, "V", np.full(4, np.nan))
    assert unit_mistakes.highest_v(replace(commanded, channels={VOLTAGE: lost})) == 6.0


def test_maps_of_an_import_are_expressions_with_units() -> None:
    found = dict(unit_mistakes._maps(log()))
    assert found[TIME] == ("t", "ms")
    assert found[VOLTAGE] == ("v/2", "mV")
    assert found[SPEED] == ("n", "rpm")
    assert dict(unit_mistakes._maps(log(provenance={}))) == {}
    assert dict(unit_mistakes._maps(log(provenance={"maps": ["time=if(a:b):s"]}))) == {
        TIME: ("if(a:b)", "s")
    }


def test_each_other_unit_of_a_column_may_be_the_true_one() -> None:
    """The factor is of readings to what is true; what was not mapped is told to be given in SI."""
    every = list(unit_mistakes._possible(log()))
    found = {(m.quantity, m.instead): m for m in every}
    milli = found[CURRENT, "the current were in mA, not A"]
    assert (milli.factor, milli.mend) == (
        pytest.approx(1e3), "import again with --map current=i:mA",
    )  # fmt: skip
    turns = found[SPEED, "the speed were in rad/s, not rpm"]
    assert turns.factor == pytest.approx(2.0 * math.pi / 60.0)
    volts = found[VOLTAGE, "the voltage were in V, not mV"]
    assert (volts.factor, volts.mend) == (
        pytest.approx(1e-3), "import again with --map voltage=v/2:V",
    )  # fmt: skip
    assert found[TIME, "the time were in s, not ms"].factor == pytest.approx(1e-3)
    assert {m.quantity for m in every} == {TIME, CURRENT, VOLTAGE, SPEED}
    assert all(m.factor != 1.0 for m in every)
    bare = {(m.quantity, m.instead): m.mend for m in unit_mistakes._possible(log(provenance={}))}
    assert bare[VOLTAGE, "the voltage were in mV, not V"] == "give the voltage in V"
    wrong = log(provenance={"maps": ["current=i:parsec", "speed=c:counts/s"]})
    assert {m.quantity for m in unit_mistakes._possible(wrong)} == {TIME, VOLTAGE}


def test_rows_for_a_clock_are_of_any_period() -> None:
    """Of rows that count by one: periods from a third of the unit to three millionths of it."""
    rows = replace(log(), ticks=np.arange(4) * 1000)
    found = [m for m in unit_mistakes._possible(rows) if "counts the rows" in m.instead]
    assert {m.quantity for m in found} == {TIME}
    assert [math.log10(m.factor) for m in found] == pytest.approx([0.5 * k for k in range(1, 14)])
    for ticks in (20_000 * np.arange(4), np.array([0, 1000, 2000, 3001]), np.array([0])):
        channels: dict[str, Channel] = {}
        other = Capture(ticks, 1e6, channels, provenance={"maps": MAPS})
        assert not unit_mistakes._counts_rows(other, 1e-3)
    assert unit_mistakes._counts_rows(rows, 1e-3)


def test_counts_are_of_a_board_with_an_encoder() -> None:
    turns = {POSITION: Channel(POSITION, "rad", np.zeros(4))}
    board = {
        "provenance": {"identity": {}},
        "wiring": Wiring(counts_per_turn=400.0, gear_ratio=5.0),
    }
    found = list(unit_mistakes._possible(log(channels=turns, **board)))
    assert [m.factor for m in found] == [4.0, 10.0, 100.0, 0.01]
    assert found[0].instead == (
        "wiring.counts_per_turn were about 1600, not 400, or wiring.gear_ratio 1.25, not 5"
    )
    assert list(unit_mistakes._possible(log(**board))) == []
    none = {**board, "wiring": Wiring()}
    assert list(unit_mistakes._possible(log(channels=turns, **none))) == []


def test_a_wrong_scale_moves_figures_by_its_powers() -> None:
    """A clock moves a speed's figures otherwise than a position's."""
    by_speed, by_position = log(), log(channels={POSITION: Channel(POSITION, "rad", np.zeros(4))})
    assert unit_mistakes._powers(by_speed, TIME)["J"] == 1.0
    assert "K" not in unit_mistakes._powers(by_speed, TIME)
    assert unit_mistakes._powers(by_position, TIME)["K"] == 1.0
    assert unit_mistakes._powers(by_speed, CURRENT)["R"] == -1.0
    assert unit_mistakes._powers(by_speed, VOLTAGE)["R"] == 1.0
    assert unit_mistakes._powers(by_speed, SPEED)["J"] == -2.0
    assert unit_mistakes._powers(by_speed, POSITION)["J"] == -2.0
    mistake: Any = SimpleNamespace(quantity=VOLTAGE, factor=4.0)
    values = known(R=2.0, K=0.5, J=None)
    assert unit_mistakes._moves(by_speed, values, mistake) == pytest.approx({"R": 1.5, "K": 0.375})
