"""What a nuisance's prior gives of an uncertainty, and the sentence where it is most of R's."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import pytest

from motorid.capture.model import Capture, Phase
from motorid.estimate.effects.influence_quantity import Use
from motorid.estimate.effects.registry import used
from motorid.estimate.fit import joint_fit
from motorid.estimate.uncertainty.budget import of_priors
from motorid.program import Decay, Program, Step, StepKind
from tests.exact_capture import FAULHABER, Plan, clean_capture, noisy
from tests.six_parameters import fit

ALL_BUT_R = {name: value for name, value in FAULHABER.items() if name != "R"}

UNDETECTED = [quantity.name for quantity in used(Use.UNDETECTED)]


@cache
def run() -> Capture:
    """Rest, one level, a coast."""
    return noisy(clean_capture(FAULHABER, Plan(volts=(6.0,), count=4000)), 1, 5e-3, 1e-3, 5e-3)


def steady() -> Capture:
    """Its level alone, long after the start."""
    first, last = 1000, 1760
    whole = run()
    step = Step(StepKind.DRIVE_VOLTS, 1.0, 6.0, Decay.SYNCHRONOUS_SLOW)
    return replace(
        whole,
        ticks=whole.ticks[first:last] - whole.ticks[first],
        channels={n: replace(c, raw=c.raw[first:last]) for n, c in whole.channels.items()},
        program=Program((step,)),
        phases=(Phase(0, 0),),
    )


def dropping(capture: Capture, volts: float, uncertainty_v: float) -> Capture:
    wiring = replace(
        capture.wiring, brush_drop_v=volts, brush_drop_uncertainty_v=uncertainty_v
    )  # fmt: skip
    return replace(capture, wiring=wiring)


@pytest.mark.slow
def test_a_prior_that_is_off_moves_the_answer_by_what_it_gives() -> None:
    u = 1e-3
    fits = [joint_fit.solved([dropping(run(), v, u)], {}, ()) for v in (0.01, 0.01 + u)]
    records, solution = fits[0]
    (shift,) = of_priors(solution, records).shifts["brush drop"]
    foretold = abs(shift[0]) * solution.slopes[0]
    assert abs(fits[1][1].values[0] - solution.values[0]) == pytest.approx(foretold, rel=0.1)


def said(capture: Capture, **options: dict[str, float]) -> list[str]:
    found = fit([capture], **options)
    return [d.message for d in found.diagnostics if d.code == "drop_or_resistance"]


@pytest.mark.slow
def test_brushes_that_nobody_declared_are_named_where_they_are_most_of_the_resistance() -> None:
    (sentence,) = said(steady(), fix=ALL_BUT_R)
    assert "declare it (brush_drop_v of the rig), or add a level" in sentence
    assert said(run()) == []  # the start from rest tells them apart
    assert said(dropping(steady(), 0.0, 0.0), fix=ALL_BUT_R) == []
    (sentence,) = said(dropping(steady(), 0.1, 0.05), fix=ALL_BUT_R)
    assert "declare" not in sentence


def shares_of(captures: Sequence[Capture]) -> tuple[dict[str, float], str]:
    """Of R's variance by cause, and the remark on the budget."""
    found = fit(captures, fix=ALL_BUT_R)
    lines = found.budget["R"]
    total = found.parameters["R"].total or 0.0
    assert sum(u**2 for u in lines.values()) == pytest.approx(total**2, rel=1e-9)
    (remark,) = (d.message for d in found.diagnostics if d.code == "budget")
    return {cause: u**2 / total**2 for cause, u in lines.items()}, remark


@pytest.mark.slow
@pytest.mark.parametrize("runs", [1, 3])
def test_the_budget_names_the_brushes_however_many_runs_share_them(runs: int) -> None:
    """Their prior is one for all runs: more of them do not make it better known."""
    shares, remark = shares_of([steady()] * runs)
    brushes = shares.get("brush drop", 0.0) + shares.get("brush bend", 0.0)
    left = 1.0 - sum(shares.get(name, 0.0) for name in UNDETECTED)
    assert brushes > 0.7 * left
    assert shares["noise"] < 0.3
    assert "brush_drop_v" in remark
