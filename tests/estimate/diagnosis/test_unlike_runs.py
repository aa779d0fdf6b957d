"""Runs of unlike motors under one line: what each takes of the rest by a step of its own."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.diagnosis import unlike_runs
from motorid.estimate.results.estimate import Diagnostic

N = 400
NAMES, VALUES = ("R", "K"), np.array([2.0, 0.5])


def of_lines(
    monkeypatch: pytest.MonkeyPatch, *slopes: float, noise: float = 1.0, bow: float = 0.0,
    sha256: str = "", waveform: str | None = None, at_bound: bool = False, left: float = 1.0,
) -> list[Diagnostic]:  # fmt: skip
    """Readings of 1 and x; R is the height, K the slope that each run has by itself (in units of
    noise). ``bow``: what every run lacks alike; ``left``: of misfit, by all runs.
    """
    rng = np.random.default_rng(4)
    x = np.linspace(-1.0, 1.0, N)
    rows = np.column_stack([np.ones(N), x])
    common = float(np.mean(slopes))
    lines = tuple(
        SimpleNamespace(
            orthogonal=rows,
            residual=(s - common) * x + bow * (x**2 - 1.0 / 3.0) + noise * rng.standard_normal(N),
        )
        for s in slopes
    )
    records: Any = [
        SimpleNamespace(
            capture=SimpleNamespace(sha256=sha256 and sha256[k]),
            sensed=SimpleNamespace(waveform=waveform),
        )
        for k, _ in enumerate(lines)
    ]
    white = SimpleNamespace(
        records=lines, unknowns=[SimpleNamespace(name=n) for n in NAMES], values=VALUES,
        slopes=VALUES, information=len(lines) * rows.T @ rows,
    )  # fmt: skip
    held = np.array([False, at_bound])
    solution: Any = SimpleNamespace(**{**vars(white), "at_bound": held})
    monkeypatch.setattr(unlike_runs, "plain", lambda *_: white)
    monkeypatch.setattr(unlike_runs.misfit, "of_fit", lambda *_: left)
    return list(unlike_runs.findings(solution, records))


def test_what_runs_differ_in_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of logarithms: a slope of .1 is a tenth of K."""
    (said,) = of_lines(monkeypatch, 0.0, 0.1, 0.06, noise=1e-3)
    assert "each of these 3 runs suits a motor" in said.message
    assert "they differ by about 10 % in K, as of another motor" in said.message
    assert said.moves["K"] == pytest.approx(0.5 * 0.16 / 3.0, rel=0.01)
    assert said.moves["R"] < 1e-3


def test_most_must_be_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a difference d between two runs, x takes d²/12 beside what noise leaves."""
    just = np.sqrt(12.0) * 0.01
    assert of_lines(monkeypatch, 0.0, 1.1 * just, noise=0.01)
    assert not of_lines(monkeypatch, 0.0, 0.9 * just, noise=0.01)
    assert not of_lines(monkeypatch, 0.0, 0.1, noise=1e-3, bow=1.0)  # all lack that alike


def test_runs_that_differ_little_are_alike(monkeypatch: pytest.MonkeyPatch) -> None:
    assert not of_lines(monkeypatch, 0.0, 0.0049, noise=1e-5)
    assert of_lines(monkeypatch, 0.0, 0.0052, noise=1e-5)
    assert not of_lines(monkeypatch, 0.0, 0.0, noise=1.0)
    assert not of_lines(monkeypatch, 0.0, 0.1, noise=1e-3, left=0.02)  # readings left no misfit


def test_what_is_at_its_bound_is_not_compared_and_steps_tell_a_whole_at_most(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert not of_lines(monkeypatch, 0.0, 0.1, noise=1e-3, at_bound=True)
    for apart, words in ((0.98, "98 % in K"), (7.0, "100 % or more in K")):
        (said,) = of_lines(monkeypatch, 0.0, apart, noise=1e-3)
        assert f"they differ by about {words}, as of" in said.message


def test_stretches_of_one_log_are_one_run(monkeypatch: pytest.MonkeyPatch) -> None:
    assert not of_lines(monkeypatch, 0.0, 0.1, noise=1e-3, sha256="aa")
    assert of_lines(monkeypatch, 0.0, 0.1, noise=1e-3, sha256="ab", waveform="held")
    assert not of_lines(monkeypatch, 0.0, 0.1, noise=1e-3, waveform="held")  # of no file
    assert not of_lines(monkeypatch, 0.0, noise=1e-3)


@pytest.mark.parametrize(("apart", "sure"), [(0.51, True), (0.49, False)])
def test_a_difference_is_sure_beyond_five_uncertainties(apart: float, sure: bool) -> None:
    u = np.array([0.1 / np.sqrt(2.0)])
    runs = [unlike_runs.Alone(np.array([size]), u, 1.0, 1.0) for size in (0.0, apart)]
    assert unlike_runs._apart(runs, np.array([2.0])) == pytest.approx([apart / 2.0 * sure])
