"""What the residuals of a batch model say about its answer: noise, curvature, instruments."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture
from motorid.estimate.results.estimate import Floats
from motorid.estimate.solver.problem import Block, Linearised, Unknown
from motorid.estimate.solver.problem import Solution as Likely
from motorid.estimate.uncertainty.covariance import covariance_of
from motorid.motor.batch import Record
from motorid.search.problem import Problem, Solution

STEP = 1e-5  # relative, of central differences
SMALL = 1e-4  # relative change of a voltage by which its gain is tried
AT_WALL = 1e-3  # of the cube's side


def curvature(problem: Problem, found: Solution) -> Likely:
    """The answer as a solution of the likelihood's kind, every parameter by its logarithm."""
    lines = tuple(_linearise(problem, record, found) for record in problem.records)
    names = problem.box.names
    values = np.array([found.values[name] for name in names])
    information = sum((x.orthogonal.T @ x.orthogonal for x in lines), np.zeros((len(names),) * 2))
    u = problem.box.unit(np.clip(values, problem.box.low, problem.box.high))
    return Likely(
        unknowns=tuple(
            Unknown(n, float(v), lower=0.0, log=True) for n, v in zip(names, values, strict=True)
        ),
        values=values,
        own=tuple(np.zeros(line.own.shape[1]) for line in lines),
        own_covariance=tuple(covariance_of(line.own.T @ line.own) for line in lines),
        information=information,
        at_bound=(u < AT_WALL) | (u > 1.0 - AT_WALL),
        linearise=lambda: lines,
        objective=found.cost,
        evaluations=found.evaluations,
        converged=True,
    )


def outputs(problem: Problem, record: Record, named: Mapping[str, float]) -> Floats:
    """The model's response (channels, samples) at parameters of the motor alone."""
    values = np.array([named[name] for name in problem.model.parameters])
    values[problem.model.parameters.index("R")] += problem.series_ohm
    return np.asarray(problem.model.outputs(values[None], record)[0])


def _linearise(problem: Problem, record: Record, found: Solution) -> Linearised:
    kept = [np.flatnonzero(np.isfinite(y)) for y in record.measured.values()]
    edges = np.cumsum([0, *(len(k) for k in kept)])
    slices = tuple(slice(int(a), int(b)) for a, b in pairwise(edges))

    def joined(response: Floats) -> Floats:
        return np.concatenate([y[k] for y, k in zip(response, kept, strict=True)])

    measured = joined(np.array(list(record.measured.values())))
    residual = measured - joined(outputs(problem, record, found.values))
    columns = []
    for name in problem.box.names:
        ahead, behind = (
            joined(outputs(problem, record, {**found.values, name: found.values[name] * (1 + s)}))
            for s in (STEP, -STEP)
        )
        columns.append((ahead - behind) / (2 * STEP))
    own = np.zeros((len(residual), 0))
    for name, part in zip(record.channels, slices, strict=True):
        if name in (CURRENT, POSITION):
            column = np.zeros((len(residual), 1))
            column[part] = 1.0
            own = np.hstack([own, column])
    residual = residual - own @ np.linalg.lstsq(own, residual, rcond=None)[0]
    sigmas = np.array([max(float(np.sqrt(np.mean(residual[s] ** 2))), 1e-300) for s in slices])
    weights = np.concatenate(
        [np.full(s.stop - s.start, 1 / x) for s, x in zip(slices, sigmas, strict=True)]
    )
    shared, own = np.array(columns).T * weights[:, None], own * weights[:, None]
    blocks = tuple(
        Block(name, float(s), float(p.stop - p.start))
        for name, s, p in zip(record.channels, sigmas, slices, strict=True)
    )
    orthogonal = shared - own @ np.linalg.lstsq(own, shared, rcond=None)[0]
    precision = np.zeros(own.shape[1])
    return Linearised(
        residual * weights, shared, own, orthogonal, precision, blocks, slices, sigmas
    )


def instrument(
    problem: Problem,
    found: Solution,
    likely: Likely,
    captures: Sequence[Capture],
    series_ohm: float,
) -> Floats:
    """Standard uncertainty (p,), by logarithms, from gains and ``series_ohm`` before the motor."""
    inverse = covariance_of(likely.information)
    gains = {}
    for name in (VOLTAGE, CURRENT, POSITION, SPEED):
        known = [capture.get(name) for capture in captures]
        gains[name] = max((c.gain_uncertainty for c in known if c is not None), default=0.0)
    total = np.zeros(len(inverse))
    for cause, gain in gains.items():
        pull = np.zeros(len(inverse))
        for record, line in zip(problem.records, likely.records, strict=True):
            base = outputs(problem, record, found.values)
            if cause == VOLTAGE:
                louder = replace(record, input=record.input * (1 + SMALL))
                moved = -(outputs(problem, louder, found.values) - base) / SMALL
            else:
                chosen = np.array([name == cause for name in record.channels])
                moved = base * chosen[:, None]
            for k, (part, sigma) in enumerate(zip(line.slices, line.sigmas, strict=True)):
                keep = np.isfinite(list(record.measured.values())[k])
                pull += line.orthogonal[part].T @ (gain * moved[k][keep] / sigma)
        total += (inverse @ pull) ** 2
    if "R" in problem.box.names:
        total[problem.box.names.index("R")] += (series_ohm / found.values["R"]) ** 2
    return np.asarray(np.sqrt(total))
