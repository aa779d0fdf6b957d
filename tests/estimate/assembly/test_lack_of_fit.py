"""What no model explains is in the intervals, as far as the parts of the program disagree."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.assembly import lack_of_fit
from motorid.estimate.results.estimate import Diagnostic, Suspect
from motorid.estimate.results.status import Status
from tests.report.example import estimate

LACK = Diagnostic("lack_of_fit", "warning", "the model lacks an effect")
OTHER = Diagnostic("few_runs", "info", "one run")


def told(
    monkeypatch: pytest.MonkeyPatch, *said: Diagnostic, suspects: tuple[Suspect, ...] = (),
    times: float = 2.1, **shares: float,
) -> Any:  # fmt: skip
    """An estimate with these findings, whose parts disagree by such shares of half-widths."""
    one = replace(estimate(), diagnostics=said, suspects=suspects)
    moves = {}
    for name, share in shares.items():
        low, high = one.parameters[name].interval_95 or (0.0, 0.0)
        moves[name] = share * (high - low) / 2.0
    block = SimpleNamespace(name="current", count=4)
    measured = [SimpleNamespace(block=block, noise=sd, resolution=0.0) for sd in (0.0, 0.3)]
    left = [[np.full(4, 9.0), np.full(4, 0.3 * times)]]
    monkeypatch.setattr(lack_of_fit.misfit, "residuals", lambda *_: left)
    records: Any = [SimpleNamespace(measured=measured, sensed=SimpleNamespace(waveform=None))]
    monkeypatch.setattr(lack_of_fit, "disagreement", lambda *_: {**moves, "unknown": 1.0})
    return one, lack_of_fit.with_lack(one, records, "solution")  # type: ignore[arg-type]


def test_what_the_parts_disagree_by_is_in_the_interval(monkeypatch: pytest.MonkeyPatch) -> None:
    one, found = told(monkeypatch, OTHER, LACK, LACK, R=1.5, J=0.4)
    before, after = one.parameters["R"], found.parameters["R"]
    assert after.status is Status.DOUBTFUL
    low, high = before.interval_95
    wide_low, wide_high = after.interval_95
    assert wide_high - high == pytest.approx(1.5 * (high - low) / 2.0)
    assert low - wide_low == pytest.approx(1.5 * (high - low) / 2.0)
    assert found.parameters["J"] == one.parameters["J"]  # less than half of its half-width
    first = found.diagnostics[1]
    assert set(first.moves) == {"R"}
    assert found.diagnostics[2] == LACK  # one of several stands for all


def test_what_was_explained_or_sized_before_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    for said, suspects in (
        ((OTHER,), ()),
        ((replace(LACK, moves={"K": 1.0}),), ()),
        ((LACK,), (Suspect("current_lag", "current", "so", "do", "named", {"R": 0.1}),)),
    ):
        one, found = told(monkeypatch, *said, suspects=suspects, R=9.0)
        assert found is one
    one, found = told(monkeypatch, LACK, R=0.3)
    assert found is one
    one, found = told(monkeypatch, LACK, times=1.9, R=9.0)  # less than twice the noise
    assert found is one
