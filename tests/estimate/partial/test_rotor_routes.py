"""What becomes of logs whose rotor stood, part by part."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, SPEED, SUPPLY, VOLTAGE, Capture, Channel
from motorid.errors import DataError
from motorid.estimate.partial import locked_rotor
from motorid.estimate.results.estimate import Estimate
from tests.report.example import estimate, parameter

COUNT = 1024
TURNS = (-1.0) ** np.arange(COUNT)  # a noise without any slow part
UNITS = {CURRENT: "A", SPEED: "rad/s", POSITION: "rad", VOLTAGE: "V", SUPPLY: "V"}


def log(**series: Any) -> Capture:
    channels = {
        n: y if isinstance(y, Channel) else Channel(n, UNITS[n], np.asarray(y, float))
        for n, y in series.items()
    }
    return Capture(np.arange(COUNT) * 1000, 1e6, channels)


REST = log(speed=TURNS, current=2.0 * TURNS, terminal_voltage=TURNS)
UNDRIVEN = log(speed=TURNS, current=2.0 * TURNS, terminal_voltage=np.ones(COUNT))
MOVES = log(speed=np.arange(float(COUNT)), current=TURNS, terminal_voltage=TURNS)


@pytest.mark.parametrize(
    ("share", "draws"), [(0.12, False), (0.13, True), (-0.12, False), (-0.13, True)]
)
def test_a_current_follows_a_voltage_by_four_deviations(share: float, draws: bool) -> None:
    """Of 1024 readings a correlation is good to 1/32; four times that is .125."""
    other = np.tile([1.0, 1.0, -1.0, -1.0], COUNT // 4)
    volts = 3.0 + share * TURNS + np.sqrt(1.0 - share**2) * other
    one = log(current=2.0 * TURNS, terminal_voltage=volts)
    assert locked_rotor._draws_current(one) is draws
    supplied = log(current=2.0 * TURNS, supply_voltage=volts)
    assert locked_rotor._draws_current(supplied) is draws


@pytest.mark.parametrize(("mean", "noise"), [(2.3, True), (2.45, False)])
def test_eight_readings_are_enough(mean: float, noise: bool) -> None:
    """Of variance 2, by their neighbours: 8 m² is at most 2 (1 + 2 sqrt(8) + 16)."""
    assert locked_rotor.is_noise(mean + TURNS[:8], origin=False) is noise
    assert locked_rotor.is_noise(TURNS[:7], origin=False) is False
    assert locked_rotor.is_noise(np.zeros(8), origin=False) is False


class Parts:
    """Parts of a fit of a rotor at rest, which note what they are given."""

    def __init__(self, patch: pytest.MonkeyPatch, misfit: bool = False) -> None:
        self.asked: dict[str, tuple[Any, ...]] = {}
        answers = {
            "joint_fit.solved": ("records", "solution"),
            "multistart.leaves_misfit": misfit,
            "estimate": "known",
        }
        for name, answer in answers.items():
            owner: Any = locked_rotor
            *rooms, last = name.split(".")
            for room in rooms:
                owner = getattr(owner, room)
            patch.setattr(owner, last, self.noting(name, answer))
        patch.setattr(locked_rotor, "pieces", lambda captures: [*captures, "pieces"])
        patch.setattr(locked_rotor, "still_motor", lambda captures, held: {"still": held})

    def noting(self, name: str, answer: Any) -> Any:
        def part(*given: Any) -> Any:
            self.asked[name] = given
            return answer

        return part


def test_a_log_at_rest_is_fitted_for_a_rotor_that_is_held(monkeypatch: pytest.MonkeyPatch) -> None:
    parts = Parts(monkeypatch)
    assert locked_rotor.without_motion([REST, UNDRIVEN], {"K": 0.05}, ("B",)) == "known"
    pieces, still = [REST, UNDRIVEN, "pieces"], {"still": {"B": 0.0, "K": 0.05}}
    assert parts.asked["joint_fit.solved"] == (pieces, still, ())
    assert parts.asked["multistart.leaves_misfit"] == ("solution", "records")
    wanted = (pieces, "records", "solution", still, {"K": 0.05}, ("B",))
    assert parts.asked["estimate"] == wanted


@pytest.mark.parametrize(
    ("captures", "fix", "without", "misfit"),
    [
        ([REST], {"T0": 0.1}, (), False),
        ([REST], {}, ("T0",), False),
        ([REST, MOVES], {}, (), False),
        ([REST], {}, (), True),  # such as a back-EMF
    ],
)
def test_a_rotor_is_not_taken_to_stand_where_something_says_otherwise(
    captures: list[Capture], fix: dict[str, float], without: tuple[str, ...], misfit: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    Parts(monkeypatch, misfit)
    assert locked_rotor.without_motion(captures, fix, without) is None


def test_without_a_current_nothing_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    Parts(monkeypatch)
    with pytest.raises(DataError, match="determine nothing"):
        locked_rotor.without_motion([UNDRIVEN, UNDRIVEN], {}, ())


STILL = {"K": 0.05, "B": 0.0, "J": 1.0, "T0": 0.3}  # twice 3 A
UNTOLD = parameter("L", "H", None)


def rested(
    patch: pytest.MonkeyPatch, found: Estimate, log: bool = False, **how: Any
) -> tuple[Estimate, dict[str, Any]]:
    """The estimate made of one that a fit ``found``, and what its parts were given."""
    asked: dict[str, Any] = {}

    def noted(name: str, answer: Any) -> Any:
        def part(*given: Any) -> Any:
            asked[name] = given
            return answer

        return part

    patch.setattr(locked_rotor, "uncertain", noted("uncertain", "doubts"))
    patch.setattr(locked_rotor, "unjudged", noted("unjudged", found))
    patch.setattr(locked_rotor, "accused", noted("accused", "said"))
    patch.setattr(locked_rotor, "judged", noted("judged", "judged"))
    records: Any = [
        SimpleNamespace(sensed=SimpleNamespace(waveform="a log's" if k and log else None))
        for k in range(2)
    ]
    given = {"fix": {}, "without": (), **how}
    out = locked_rotor.estimate(["captures"], records, "solution", STILL, **given)  # type: ignore[list-item, arg-type]
    assert out == "judged"
    known, *others = asked["judged"]
    assert others == [records, "solution", "said"]
    assert asked["accused"] == (known, records, "solution")
    assert asked["uncertain"] == (records, "solution", STILL, (), not log)
    assert asked["unjudged"] == (["captures"], records, "doubts", STILL, (), not log)
    return known, asked


def test_a_rotor_that_stood_tells_its_winding_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    found = replace(
        estimate(), derived=dict.fromkeys(("stall_current", "no_load_speed"), UNTOLD),
    )  # fmt: skip
    known, _ = rested(monkeypatch, found, fix={"K": 0.05}, without=("B",))
    assert known.parameters["R"] == found.parameters["R"]
    assert known.parameters["K"] == found.parameters["K"]  # it was given
    assert known.parameters["B"] == found.parameters["B"]  # it was left out
    for name in ("J", "T0"):
        assert known.parameters[name].value is None
        assert "its friction holds 3 A or more; let it turn" in known.parameters[name].note
    assert set(known.derived) == {"stall_current"}
    assert known.segments == ()
    said = known.diagnostics[0]
    assert (said.code, said.severity) == ("rotor_held", "warning")
    assert said.message.startswith("nothing shows that the rotor turned")
    assert known.diagnostics[1:] == found.diagnostics
    assert known.options["fix"] == {"K": 0.05}
    assert known.options["without"] == ["B"]


def test_a_rotor_that_was_to_stand_did_so_for_its_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    known, _ = rested(monkeypatch, estimate(), held="it was clamped")
    assert known.diagnostics[0].severity == "info"
    assert known.diagnostics[0].message.startswith("it was clamped. Such a run")
    assert known.parameters["J"].note == "it was clamped; let it turn"


@pytest.mark.parametrize("from_log", [False, True])
def test_an_inductance_that_leans_is_left_out_of_logs_alone(
    from_log: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = estimate()
    L = found.parameters["L"]
    wide = replace(L, statistical=2.0 * locked_rotor.LEANS["L"] * L.value)
    some = replace(found, parameters={**found.parameters, "L": wide})
    known, _ = rested(monkeypatch, some, from_log)
    assert (known.parameters["L"].value is None) is from_log


def test_captures_that_tell_neither_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    found = estimate()
    one = replace(found, parameters={**found.parameters, "L": UNTOLD})
    assert rested(monkeypatch, one)[0].parameters["R"].value is not None
    none = replace(one, parameters={**one.parameters, "R": parameter("R", "ohm", None)})
    with pytest.raises(DataError, match="determine nothing"):
        rested(monkeypatch, none)
