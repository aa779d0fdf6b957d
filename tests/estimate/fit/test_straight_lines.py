"""Sizes of more unknowns along straight lines about a solution."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from motorid.capture.model import CURRENT
from motorid.estimate.diagnosis.repeating_remarks import allowed_for
from motorid.estimate.effects.rotor.k_ripple import K_RIPPLE
from motorid.estimate.effects.rotor.repeating import of_order
from motorid.estimate.fit.joint_fit import solved
from motorid.estimate.fit.straight_lines import StraightLines, fall
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.covariance import covariance_of
from tests.exact_capture import FAULHABER, Plan, clean_capture

COSINE, SINE = of_order(K_RIPPLE, 7)


@cache
def fitted() -> tuple[MotorRecord, Solution]:
    records, solution = solved([clean_capture(FAULHABER, Plan(volts=(6.0,), count=800))], {}, ())
    return records[0], solution


def waves(record: MotorRecord, periods: float) -> np.ndarray:
    m = record.block(CURRENT)
    assert m is not None
    return np.cos(2 * np.pi * periods * np.arange(len(m.values)) / len(m.values))


def about(size: float) -> tuple[StraightLines, dict]:
    """A record whose residual is noise and so much of a course."""
    record, solution = fitted()
    line, inverse = solution.records[0], covariance_of(solution.information)
    slopes = {COSINE: {CURRENT: waves(record, 40.0)}}
    bare = StraightLines(record, line, inverse)
    noise = np.random.default_rng(1).normal(size=len(line.residual))
    weights = np.repeat(1.0 / line.sigmas, [part.stop - part.start for part in line.slices])
    left = size * (bare.rows(slopes) * weights)[0] + noise
    return StraightLines(record, replace(line, residual=left), inverse), slopes


def test_the_size_of_what_is_there_is_found() -> None:
    lines, slopes = about(0.01)
    sizes, left = lines.fitted(slopes)
    assert sizes[0] == pytest.approx(0.01, rel=0.05)
    assert np.square(left).sum() < np.square(lines.line.residual).sum()


def test_what_is_not_there_earns_nothing() -> None:
    lines, slopes = about(0.0)
    _, left = lines.fitted(slopes)
    whole = [lambda residual: residual for _ in lines.line.slices]
    fallen, readings = fall(lines.line, lines.line.residual, left, whole)
    assert abs(fallen) < 12.0  # chi-square of one unknown
    assert 0.0 < readings <= sum(block.count for block in lines.line.blocks)


def test_where_nothing_is_looked_at_nothing_falls() -> None:
    lines, slopes = about(0.01)
    _, left = lines.fitted(slopes)
    nothing = [lambda residual: residual[:0] for _ in lines.line.slices]
    assert fall(lines.line, lines.line.residual, left, nothing) == (0.0, 0.0)


def test_a_change_that_parameters_explain_has_no_length() -> None:
    lines, _ = about(0.0)
    record = fitted()[0]
    m = record.block(CURRENT)
    assert m is not None
    constant = {CURRENT: np.ones(len(m.values))}
    seen = {CURRENT: waves(record, 40.0)}
    assert lines.length(constant) < lines.length(seen)
    assert lines.shift(seen) < lines.length(seen)


def test_nothing_is_said_where_nothing_repeats() -> None:
    record, solution = fitted()
    assert allowed_for([record], solution) == []
