"""What a held rotor's fit leaves out, supports and says, on captures and answers that are given."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture, Channel, Phase, Wiring
from motorid.errors import DataError
from motorid.estimate.model.extended_terms import TERMS
from motorid.estimate.results.estimate import Alternative, Estimate, Parameter, Suspect
from motorid.estimate.results.status import Status
from motorid.estimate.selection import held_rotor
from motorid.estimate.selection.evidence import Evidence
from motorid.program import Decay, Program, Rotor, Step, StepKind
from tests.report.example import estimate

EDDY, SATURATION = TERMS["eddy"], TERMS["saturation"]
STEPS = (
    Step(StepKind.COAST, 0.01), Step(StepKind.DRIVE_DUTY, 0.02, 0.5, Decay.SYNCHRONOUS_SLOW),
    Step(StepKind.COAST, 0.01), Step(StepKind.DRIVE_DUTY, 0.01, -0.5, Decay.SYNCHRONOUS_SLOW),
)  # fmt: skip
COUNT, STEP_RAD = 50, 0.002


def captured(
    travel_rad: float = 0.0, resolution: float = STEP_RAD, pwm_hz: float = 20e3
) -> Capture:
    """A sample a millisecond: rest, drive, coast, drive."""
    turned = np.linspace(0.0, travel_rad, COUNT)
    turned[7] = np.nan  # a reading is missing
    channels = {
        VOLTAGE: Channel(VOLTAGE, "V", np.arange(1.0, COUNT + 1)),
        CURRENT: Channel(CURRENT, "A", np.ones(COUNT), delay_uncertainty_s=3e-6),
        POSITION: Channel(POSITION, "rad", turned, resolution=resolution),
        SPEED: Channel(SPEED, "rad/s", np.zeros(COUNT)),
    }
    return Capture(
        1000 * np.arange(COUNT), 1e6, channels, wiring=Wiring(pwm_hz=pwm_hz),
        program=Program(STEPS, Rotor.CLAMPED, 30.0),
        phases=tuple(Phase(k, tick) for k, tick in enumerate((0, 10_000, 30_000, 40_000))),
    )  # fmt: skip


def test_open_terminals_after_a_drive_and_what_does_not_move_are_left_out() -> None:
    found = held_rotor.stilled(captured()).channels
    assert set(found) == {VOLTAGE, CURRENT}
    volts = found[VOLTAGE].values
    assert np.flatnonzero(np.isnan(volts)).tolist() == list(range(30, 40))
    kept = np.isfinite(volts)
    assert volts[kept] == pytest.approx(np.arange(1.0, COUNT + 1)[kept])


def test_the_ripple_in_iron_leaves_the_currents_moment_open_by_a_part_of_a_period() -> None:
    found = held_rotor.stilled(captured(pwm_hz=20e3)).channels[CURRENT]
    assert found.delay_uncertainty_s == pytest.approx(math.hypot(3e-6, 0.02 / 20e3))
    without = held_rotor.stilled(captured(pwm_hz=0.0)).channels[CURRENT]
    assert without.delay_uncertainty_s == 3e-6


@pytest.mark.parametrize(
    ("counts", "said"), [(0.0, ""), (1.4, ""), (1.6, "clamp"), (15.0, "clamp"), (16.5, "refused")]
)
def test_a_clamp_may_give_way_by_half_a_hundredth_of_a_turn(counts: float, said: str) -> None:
    """And the edge of a count may flicker; 1/200 of a turn is 15.7 counts here."""
    capture = captured(counts * STEP_RAD)
    if said == "refused":
        degrees = np.degrees(counts * STEP_RAD)
        with pytest.raises(DataError, match=rf"moved by {degrees:.2g}°: clamp it"):
            held_rotor._gave_way(capture)
        return
    remark = held_rotor._gave_way(capture)
    assert (remark is not None) is bool(said)
    if remark is not None:
        assert f"by {np.degrees(counts * STEP_RAD):.2g}°" in remark.message


def test_a_coarse_encoder_may_show_six_counts() -> None:
    coarse = 0.02
    assert held_rotor._gave_way(captured(5.9 * coarse, coarse)) is not None
    with pytest.raises(DataError, match="clamp it"):
        held_rotor._gave_way(captured(6.1 * coarse, coarse))
    capture = captured()
    for lacking in ({}, {POSITION: Channel(POSITION, "rad", np.full(COUNT, np.nan))}):
        kept = {n: c for n, c in capture.channels.items() if n != POSITION}
        assert held_rotor._gave_way(replace(capture, channels={**kept, **lacking})) is None


def weighed(gain: float, left_out: float | None = None) -> Evidence:
    return Evidence(gain, 2.0, 10.0, 9.0, left_out)


@pytest.mark.parametrize(
    ("eddy", "saturation", "kept", "tried"),
    [
        (30.0, 24.0, ("eddy", "saturation"), [("eddy", True), ("saturation", True)]),
        (30.0, 6.0, ("eddy",), [("saturation", False), ("eddy", True)]),
        (4.0, 6.0, (), [("eddy", False), ("saturation", False)]),
        (8.0, 6.0, (), [("saturation", False), ("eddy", False)]),
    ],
)
def test_terms_that_the_data_do_not_support_go_the_worst_first(
    eddy: float, saturation: float, kept: tuple[str, ...], tried: list[tuple[str, bool]],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    gains = {"eddy": eddy, "saturation": saturation}

    def fitted(terms: Any) -> Any:
        return SimpleNamespace(terms=terms, solution="s", values={"R": 2.2, "L": 3.0})

    monkeypatch.setattr(held_rotor, "weigh", lambda _f, _rest, _s, term: weighed(gains[term.name]))
    monkeypatch.setattr(held_rotor, "_refitted", lambda _f, terms: fitted(terms))
    moves = held_rotor._Moves({"R": 2.0, "L": 3.3}, {"R": 0.1, "L": 0.1, "K": 1e-9})
    found, trials = held_rotor._supported(fitted((EDDY, SATURATION)), moves)
    assert tuple(t.name for t in found.terms) == kept
    assert [(t.term, t.taken) for t in trials] == tried
    for one in trials:
        assert (one.gain, one.needed, one.size) == (gains[one.term] / 2.0, 10.0, 9.0)
        assert one.moves == pytest.approx(3.0)  # of L, by .3 in units of .1
    first = trials[0]
    other = {"eddy": "saturation", "saturation": "eddy"}[first.term]
    assert first.beside == (other,)


def parameter(name: str, value: float | None, half: float = 0.1) -> Parameter:
    if value is None:
        return Parameter(name, "", None, None, None, None, None, Status.NOT_IDENTIFIABLE)
    interval = (value - half, value + half)
    return Parameter(name, "", value, half / 2, 0.0, half / 2, interval, Status.ESTIMATED)


def better(asked: bool = False, **values: Parameter) -> Alternative:
    return Alternative(
        "eddy", ("eddy",), (EDDY.title,), (), asked, dict(values), {}, 0.0, 1,
        1, (),
    )  # fmt: skip


def plain(**values: Parameter) -> Estimate:
    one = estimate()
    parameters = {**one.parameters, **values}
    suspects = (
        Suspect("eddy", "current", "", "", "named"), Suspect("lag", "current", "", "", "named"),
    )  # fmt: skip
    return replace(one, parameters=parameters, suspects=suspects)


def test_the_better_model_is_beside_the_plain_one_and_what_it_explains_is_no_fault() -> None:
    six = plain(R=parameter("R", 2.0), L=parameter("L", 1.0))
    found = held_rotor._with(six, better(R=parameter("R", 2.0), L=parameter("L", 1.5)))
    assert found.diagnostics[0].code == "better_model"
    assert EDDY.title in found.diagnostics[0].message
    assert found.parameters["L"].status == Status.DOUBTFUL
    assert found.parameters["R"] == six.parameters["R"]
    assert [s.code for s in found.suspects] == ["lag"]
    asked = held_rotor._with(six, better(True, R=parameter("R", 2.0), L=parameter("L", 1.5)))
    assert asked.diagnostics[0].code == "model_asked"
    assert asked.parameters == six.parameters  # it was asked for, whatever the data say
    assert asked.alternative is not None
    assert found.diagnostics[1:] == asked.diagnostics[1:] == six.diagnostics


def test_a_rotor_that_stands_shows_no_mechanics_but_what_is_given() -> None:
    every = {n: parameter(n, 1.0) for n in ("R", "L", "K", "B", "J", "T0", "K_rated", "L_rated")}
    found = held_rotor._without_mechanics(better(**every), {"K": 1.0}, ("T0",)).parameters
    assert {n for n, p in found.items() if p.value is None} == {"B", "J"}
    assert found["B"].note == "the rotor was held; let it turn"
    assert (found["B"].name, found["J"].unit) == ("B", "kg·m²")
    assert "K_rated" not in found
    assert "L_rated" in found


@pytest.mark.parametrize("held", [(True,), (True, True), (False,), (False, False)])
def test_all_captures_or_none_are_of_a_held_rotor(held: tuple[bool, ...]) -> None:
    runs: list[Any] = [SimpleNamespace(program=SimpleNamespace(held=one)) for one in held]
    assert held_rotor.suits(runs) is held[0]
    with pytest.raises(DataError, match="fit them apart"):
        held_rotor.suits([*runs, SimpleNamespace(program=SimpleNamespace(held=not held[0]))])  # type: ignore[list-item]
    assert not held_rotor.suits([SimpleNamespace(program=None)])  # type: ignore[list-item]
