"""Logs of a voltage and a current alone: a fan and brushes, by an integration of its own."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from motorid.capture.model import CURRENT, VOLTAGE, Capture, Channel
from motorid.estimate.model.extended_terms import TERMS
from motorid.estimate.results.status import Status
from motorid.estimate.selection import fewer_channels as module
from tests.report.example import estimate, parameter
from tests.six_parameters import fit

Floats = NDArray[np.float64]
R, L, K, B, J, T0, VOLTS = 2.2, 1.2e-3, 0.0112, 2e-7, 2.6e-6, 1.8e-3, 12.0
FAN = 0.08 * K * VOLTS / R / (VOLTS / K) ** 2  # 8 % of the stall torque at the top speed
DROP_V = 0.4
PERIOD_S, ROWS_A_LEVEL = 6e-4, 300
LEVELS = (0.4, 0.9, 0.6, 1.0, 0.3, 0.8)
TRUTH = {"R": R, "L": L, "J/K²": J / K**2, "B/K²": B / K**2, "T0/K": T0 / K}


def logged(fan: float = 0.0, drop_v: float = 0.0, levels: int = len(LEVELS)) -> Capture:
    """Levels one way, whose changes lie between two rows."""
    rng = np.random.default_rng(2)
    state, volts, currents = np.array([0.0, 0.0]), [], []
    stamps, end = PERIOD_S * (np.arange(ROWS_A_LEVEL) + 0.4), PERIOD_S * ROWS_A_LEVEL
    for level in LEVELS[:levels]:

        def slope(_: float, x: Floats, v: float = level * VOLTS) -> list[float]:
            i, w = x
            brushes = drop_v * math.tanh(i / 0.1)
            rub = T0 if w > 0.0 else min(T0, max(K * i, 0.0))
            return [(v - R * i - brushes - K * w) / L, (K * i - B * w - fan * w**2 - rub) / J]

        found = solve_ivp(slope, (0, end), state, t_eval=[*stamps, end], rtol=1e-8, atol=1e-9,
                          method="LSODA")  # fmt: skip
        state = found.y[:, -1]
        volts.append(np.full(ROWS_A_LEVEL, level * VOLTS))
        currents.append(found.y[0, :-1])
    v, i = np.concatenate(volts), np.concatenate(currents)
    made = {VOLTAGE: ("V", v, 0.005), CURRENT: ("A", i, 0.005)}
    unstated = frozenset({"delay", "filter", "aperture"})
    channels = {
        name: replace(Channel(name, unit, y + rng.normal(0.0, sigma, len(y))), undeclared=unstated)
        for name, (unit, y, sigma) in made.items()
    }  # fmt: skip
    return Capture(np.rint(1e9 * PERIOD_S * np.arange(len(v))).astype(np.int64), 1e9, channels)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("more", "words", "names"),
    [({"fan": FAN, "levels": 4}, "square of speed", ("B/K²", "T0/K")),
     ({"drop_v": DROP_V}, "drop of the brushes", ("R",)), ({}, "", ())],
)  # fmt: skip
def test_what_the_model_lacks_is_named_once_and_the_intervals_hold_the_motor(
    more: dict[str, Any], words: str, names: tuple[str, ...]
) -> None:
    found = fit([logged(**more)])
    said = [one for one in found.diagnostics if one.code in ("better_model", "model_unsettled")]
    assert len(said) == bool(words)
    assert all(words in one.message for one in said)
    values = {**found.parameters, **found.combinations}
    for name in names:
        assert values[name].status is Status.DOUBTFUL, name
    for name, true in TRUTH.items():
        p = values[name]
        if p.value is not None and name != "L":
            low, high = p.interval_95
            assert low <= true <= high, name


# by mocks


PLAIN = replace(
    estimate(), diagnostics=("before",),
    parameters={"R": parameter("R", "Ω", 2.0), "J": parameter("J", "kg", 3.0),
                "B": parameter("B", "N", 1.0), "L": parameter("L", "H", 1.0)},
)  # fmt: skip


def test_a_model_that_tells_less_or_otherwise_makes_values_doubtful() -> None:
    wider = replace(parameter("J", "kg", 9.0), interval_95=(8.5, 9.5))
    unknown = replace(parameter("B", "N", 1.0), value=None, total=None, interval_95=None)
    others = {**PLAIN.parameters, "J": wider, "B": unknown}
    (said,) = module._said(PLAIN.parameters, others, "a fan", {"J": "J/K²", "B": "B/K²"})
    assert (said.code, said.severity) == ("better_model", "warning")
    assert set(said.moves) == {"J", "B"}
    assert said.moves["B"] == math.inf
    assert set(said.sides) == {"J"}
    assert "a fan" in said.message
    assert "J/K² 9 ±" in said.message
    assert "no B/K²" in said.message
    assert module._said(PLAIN.parameters, PLAIN.parameters, "a fan", {}) == []


class Search:
    """A search that finds ``best``, and a winding that half shows."""

    def __init__(self, patch: pytest.MonkeyPatch, best: Any) -> None:
        self.asked: dict[str, tuple[Any, ...]] = {}
        chosen = SimpleNamespace(harmless="harmless")
        answers: dict[str, Any] = {
            "looked_for": (chosen, "narrow"), "standing_out": (best, ["open"]), "reach": {"R": 0.5},
            "_warming": ["warm"], "parameters": PLAIN.parameters, "_said": ["said"],
            "known_beside": "widest",
        }  # fmt: skip
        for name, answer in answers.items():
            patch.setattr(module, name, self.noting(name, answer))
        for name in ("with_unsettled", "with_seen"):
            patch.setattr(module, name, self.passing(name))

    def noting(self, name: str, answer: Any) -> Any:
        def part(*given: Any) -> Any:
            self.asked[name] = given
            return answer

        return part

    def passing(self, name: str) -> Any:
        def part(one: Any, *given: Any, **_: Any) -> Any:
            self.asked[name] = given
            return replace(one, diagnostics=(name, *one.diagnostics))

        return part


@pytest.mark.parametrize("found", [True, False])
def test_what_is_found_and_what_half_shows_is_said(
    found: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    fitted: Any = SimpleNamespace(terms=(module.HEATING,))
    search = Search(monkeypatch, (fitted, "known") if found else None)
    doubts: Any = SimpleNamespace(solution="solution")
    records: Any = "records"
    said = module.better_models(PLAIN, records, doubts, {"K": 1.0}, ("B",), {})
    assert said == ["with_seen", "with_unsettled", *(["said"] if found else [])]
    given = search.asked["looked_for"]
    assert given[:4] == ("records", "solution", {"K": 1.0}, {"R": 0.5})
    assert {term.name for term in given[4]} == terms_but(module.WITHOUT_MOTION)
    assert search.asked["with_unsettled"] == (["open"] if found else ["open", "warm"],)
    widest = ("known" if found else doubts, "harmless", {"K": 1.0}, ("B",))
    assert search.asked["known_beside"] == widest
    assert search.asked["with_seen"] == ("widest",)


@pytest.mark.parametrize(("counted", "taken"), [(15.0, True), (9.0, False)])
def test_a_winding_counts_from_half_of_what_a_fit_needs(
    counted: float, taken: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    one = SimpleNamespace(shift={"R": -0.5})
    monkeypatch.setattr(module, "merged", lambda *_: {"R": 2.0, "K": 1.0})
    monkeypatch.setattr(module, "plain_noise", lambda *_: "white")
    monkeypatch.setattr(module, "screen", lambda *_: [one])
    told = SimpleNamespace(counted=counted, needed=20.0)
    monkeypatch.setattr(module, "foresee", lambda *_: told)
    nothing: Any = None
    found = module._warming([], nothing, {})
    assert [each.values for each in found] == ([{"R": 1.5, "K": 1.0}] if taken else [])


@pytest.mark.parametrize("shown", [module.WITHOUT_MOTION, module.WITHOUT_CURRENT])
def test_terms_that_count_turns_are_not_looked_for(shown: tuple[str, ...]) -> None:
    assert {"ripple", "cogging", "saturation", "eddy"} <= terms_but(shown)
    assert "quadratic-load" in shown


def terms_but(shown: tuple[str, ...]) -> set[str]:
    return set(TERMS) - set(shown)
