"""Staircases of volts and a speed, by their exact solution: time constant, gain and friction."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from motorid import identify
from motorid.capture.model import Capture
from motorid.errors import DataError
from motorid.estimate.partial import mechanical_fit
from motorid.estimate.partial.without_current import coasts
from motorid.estimate.partial.without_current import fit as module
from motorid.estimate.results.estimate import Diagnostic, Estimate
from motorid.estimate.results.status import Status
from tests.estimate.partial.without_current.staircase import Law, logged

LEVELS = (4.0, 9.0, 6.0, 12.0, 3.0, 8.0)


def holds(found: Estimate, truth: dict[str, float]) -> bool:
    """Every interval of the combinations holds its truth."""
    intervals = {name: found.combinations[name].interval_95 for name in truth}
    return all(i is not None and i[0] <= truth[n] <= i[1] for n, i in intervals.items())


@pytest.mark.slow
def test_a_staircase_tells_more_by_its_likelihood_than_by_a_balance() -> None:
    law, log = Law(), logged(Law(), LEVELS)
    found, balance = identify.fit([log]), mechanical_fit.fit([log])
    assert holds(found, law.truth)
    for name in ("K/(K²+RB)", "T0·R/K"):
        told, before = found.combinations[name], balance.combinations[name]
        assert told.status is Status.ESTIMATED
        assert (told.total or math.inf) < (before.total or 0.0) / 2.0, name
    assert found.parameters["R"].status is Status.NOT_IDENTIFIABLE
    assert not [one for one in found.suspects if one.strength == "named"]  # half a row is no fault
    hidden = [
        one.evidence for one in found.suspects if "its usual size would change" in one.evidence
    ]
    assert any("would change JR/(K²+RB) by" in said for said in hidden)
    assert not [said for said in hidden if " J by" in said or " K by" in said]


@pytest.mark.slow
def test_a_fan_is_named_and_the_intervals_reach_to_the_motor_with_it() -> None:
    law = Law()
    found = identify.fit([logged(law, LEVELS, fan=1.0)])
    (said,) = [one for one in found.diagnostics if one.code == "better_model"]
    assert "square of speed" in said.message
    assert "K/(K²+RB)" in said.message
    assert holds(found, law.truth)
    assert found.combinations["K/(K²+RB)"].status is Status.DOUBTFUL


@pytest.mark.slow
def test_where_no_command_lets_the_motor_coast_it_is_said_and_the_coast_is_told() -> None:
    law = Law(coasts=1.5)
    found = identify.fit([logged(law, (0.0, 9.0, 0.0, 12.0, 5.0, 0.0), rows=60)])
    assert "bridge_open" in {one.code for one in found.diagnostics}
    slows = law.gain * law.friction_v / law.tau_s
    assert holds(found, law.truth | {"B/J": 1.5, "T0/J": slows})


@pytest.mark.slow
def test_constants_that_are_given_make_parameters_of_the_combinations() -> None:
    law = Law()
    K, R = 0.038, 2.0
    found = identify.fit([logged(law, LEVELS[:4], rows=30)], fix={"K": K, "R": R})
    share = K / R
    truth = {
        "J": share * law.tau_s / law.gain,
        "B": share * (1.0 / law.gain - K),
        "T0": share * law.friction_v,
    }
    for name, true in truth.items():
        low, high = found.parameters[name].interval_95 or (math.nan, math.nan)
        assert low <= true <= high, name
    assert found.parameters["K"].status is Status.FIXED


class Ways:
    """The fits that are chosen from, none of which is made."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.monkeypatch = monkeypatch
        monkeypatch.setattr(module.mechanical_fit, "fit", lambda *_, **__: "balance")
        monkeypatch.setattr(module, "_start", lambda _: None)
        monkeypatch.setattr(module, "opened", lambda *_: "opened")
        self.whole(SimpleNamespace(answers=True))

    def whole(self, found: Any) -> None:
        """What the likelihood gives; an error is raised."""

        def given(*_: Any) -> Any:
            if isinstance(found, Exception):
                raise found
            return found

        self.monkeypatch.setattr(module, "whole", given)

    def chosen(self) -> Any:
        """What stands in the end."""
        return module._fitted([], {}, (), None)


def test_a_balance_answers_where_the_likelihood_does_not(monkeypatch: pytest.MonkeyPatch) -> None:
    ways = Ways(monkeypatch)
    assert ways.chosen() == "opened"
    ways.whole(SimpleNamespace(answers=False))
    assert ways.chosen() == "balance"
    ways.whole(DataError("no motor"))
    assert ways.chosen() == "balance"


def test_without_a_balance_the_likelihood_begins_by_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    ways = Ways(monkeypatch)

    def fails(*_: Any, **__: Any) -> None:
        raise DataError("too short")

    monkeypatch.setattr(module.mechanical_fit, "fit", fails)
    assert ways.chosen() == "opened"
    ways.whole(SimpleNamespace(answers=False))
    with pytest.raises(DataError, match="too short"):
        ways.chosen()


@pytest.mark.parametrize(
    ("braked", "free", "open_"), [(3.0, 1.0, True), (1.2, 1.0, False), (math.inf, 1.0, True),
                                  (3.0, math.inf, False)],
)  # fmt: skip
def test_a_bridge_is_open_where_a_closed_one_leaves_far_more(
    braked: float, free: float, open_: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    names = {"closed": braked, "driven": free}
    plain: Any = SimpleNamespace
    monkeypatch.setattr(module, "_fitted", lambda *_: plain(curves="closed", name="closed"))
    monkeypatch.setattr(module, "_under_drive", lambda *_: plain(curves="driven", name="driven"))
    monkeypatch.setattr(coasts, "parted", lambda _: (["driven"], ["coast"]))
    monkeypatch.setattr(coasts, "left", lambda curves: names[curves])
    monkeypatch.setattr(module, "_beside_coast", lambda found, *_: found)
    capture: Any = None
    found: Any = module._of_moving([capture], {}, (), None)
    assert (found.name == "driven") == open_


def test_captures_that_stand_are_left_out_and_said(monkeypatch: pytest.MonkeyPatch) -> None:
    still: Capture = logged(Law(), (0.0, 0.5), noise=0.0)
    moving = logged(Law(), (4.0, 9.0))
    seen: list[Any] = []

    def of_moving(captures: Any, *_: Any) -> Estimate:
        seen.extend(captures)
        return mechanical_fit.fit([moving])

    monkeypatch.setattr(module, "_of_moving", of_moving)
    found = module.fit([still, moving], {})
    assert seen == [moving]
    assert isinstance(found.diagnostics[0], Diagnostic)
    assert found.diagnostics[0].code == "standing_still"
