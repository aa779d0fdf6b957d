"""The records under a model of every term: what is held in it, and which way the motor turns."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.extended_terms import ADDED, TERMS
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.selection.score_derivatives import BACKWARDS, Probe
from tests.estimate.effects.benches import POINT, record, start

SIX = dict(zip(PARAMETERS, POINT.tolist(), strict=True))


@pytest.mark.parametrize("held", [(), ("K",), ("B", "T0")])
def test_what_the_fit_holds_stays_and_every_term_is_absent(held: tuple[str, ...]) -> None:
    free = tuple(n for n in PARAMETERS if n not in held)
    one = MotorRecord(record("measured").capture, free, {n: SIX[n] for n in held})
    one.retake_sources(np.array([SIX[n] for n in free]), start(one))
    solution: Any = SimpleNamespace(
        unknowns=[SimpleNamespace(name=n) for n in free], own=[start(one)]
    )
    probe = Probe([one], solution, SIX)
    (wide,) = probe.records
    shared, _ = probe._vectors(0, {}, {})
    values = dict(zip((*PARAMETERS, *ADDED), wide.motor(shared), strict=False))
    assert {n: values[n] for n in PARAMETERS} == pytest.approx(SIX)
    narrow = one.fitted(np.array([SIX[n] for n in free]), start(one))
    for a, b in zip(probe._base[0], narrow, strict=True):
        assert a == pytest.approx(b, abs=2e-5 * np.abs(b).max())


def probe(*angles: np.ndarray, names: tuple[str, ...] = PARAMETERS) -> Probe:
    """With the rotor's angle of every record given."""
    made = object.__new__(Probe)
    vars(made).update(_angles=list(angles), names=names)
    return made


def turning(*speeds: float) -> np.ndarray:
    return np.cumsum(np.repeat(speeds, 10))


@pytest.mark.parametrize(
    ("angles", "both"),
    [
        ((turning(1.0, -1.0),), True), ((turning(1.0, 0.3),), False),
        ((turning(-2.0), turning(1.0)), True),  # one record each way
        ((turning(-1.0, 0.9 * BACKWARDS),), False), ((turning(-1.0, 1.1 * BACKWARDS),), True),
        ((turning(1.0, -0.9 * BACKWARDS),), False), ((turning(1.0, -1.1 * BACKWARDS),), True),
        ((turning(10.0), turning(0.1, -0.3)), False),  # of the fastest of all records
        ((turning(10.0), turning(0.1, -0.6)), True),
    ],
)  # fmt: skip
def test_a_side_is_told_where_the_motor_turns_both_ways(
    angles: tuple[np.ndarray, ...], both: bool
) -> None:
    assert probe(*angles).tells(TERMS["direction"]) is both


@pytest.mark.parametrize("held", [(), ("J",), ("B",), ("T0",), ("K",)])
def test_two_constants_are_told_apart_where_what_scales_with_them_is_held(
    held: tuple[str, ...],
) -> None:
    names = tuple(n for n in PARAMETERS if n not in held)
    assert probe(turning(1.0), names=names).tells(TERMS["ke-kt"]) is bool(
        {*held} & {"J", "B", "T0"}
    )
    assert probe(turning(1.0), names=names).tells(TERMS["quadratic-load"])


def test_two_constants_are_not_told_by_mechanics_alone() -> None:
    assert not probe(turning(1.0), names=("J", "B", "T0")).tells(TERMS["ke-kt"])
