"""Noise of a log's voltage, whose readings drive the model: an error in the variables.

The model turns such noise into a current that the motor never had. Each draw of it moves the
answer by chance; and since an answer that passes less of it fits better, all draws together move it
one way: an inductance is taken for larger, and a lag for longer. Both are tried: noise as large as
that of the readings is added to them once more, and the answer's step is what it does (simulation
and extrapolation: Cook and Stefanski, 1994, its first step).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import VOLTAGE, Channel
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.intersample_voltage import MEANS, Waveform, of_log
from motorid.estimate.signals.voltage_jumps import scatter
from motorid.estimate.solver.dense_products import gram, project
from motorid.estimate.solver.levenberg_marquardt import maximise
from motorid.estimate.solver.problem import Linearised, Solution
from motorid.estimate.uncertainty.covariance import covariance_of

Floats = NDArray[np.float64]

DRAWS = 8  # of a log's noise
LEAST_LEFT = 0.1  # share of an information that is the motor's own, at least


@dataclass(frozen=True)
class Step:
    """Of the answer, by one draw: ``shared`` (p,) in search coordinates, ``own`` (m,). ``change``
    (n,): of the model's readings, weighed, if the answer stayed.
    """

    shared: Floats
    own: Floats
    change: Floats


def steps(k: int, record: MotorRecord, solution: Solution) -> Iterator[Step]:
    """By every draw, each a standard deviation over the root of their number; none: no log, or its
    voltage has no noise.
    """
    others = list(_noisier(record))
    if not others:
        return
    usual = _at(k, record.twin(), solution)
    lines = [_at(k, other, solution) for other in others]
    inverse = _without_what_noise_tells(solution.information, usual, lines)
    follows = covariance_of(usual.own_information)
    share = 1.0 / np.sqrt(len(others))
    for line in lines:
        pull = project(line.orthogonal.T, line.residual)
        shared = inverse @ (pull - project(usual.orthogonal.T, usual.residual))
        own = project(line.own.T, line.residual) - project(usual.own.T, usual.residual)
        own = follows @ (own - usual.own.T @ project(usual.shared, shared))
        yield Step(share * shared, share * own, share * (usual.residual - line.residual))


def _without_what_noise_tells(
    information: Floats, usual: Linearised, lines: Sequence[Linearised]
) -> Floats:
    """The inverse (p, p) of the information that is left without that of the noise itself.

    Noise moves the model's readings as a voltage does, so that their derivatives seem to tell the
    parameters. More noise tells as much again.
    """
    moved = [_in_units_of(usual, line) - usual.orthogonal for line in lines]
    told = np.mean([gram(one.T, one.T) for one in moved], axis=0)
    root = _root(covariance_of(information))
    shares, ways = np.linalg.eigh(root.T @ told @ root)
    left = np.maximum(1.0 - shares, LEAST_LEFT)
    return np.asarray(root @ (ways / left) @ ways.T @ root.T)


def _in_units_of(usual: Linearised, line: Linearised) -> Floats:
    """The derivatives (n, p) of one record in the standard deviations of another."""
    lengths = [part.stop - part.start for part in line.slices]
    return line.orthogonal * np.repeat(line.sigmas / usual.sigmas, lengths)[:, None]


def _root(covariance: Floats) -> Floats:
    """(p, p), by whose product with its transpose a covariance is."""
    sizes, ways = np.linalg.eigh(covariance)
    return np.asarray(ways * np.sqrt(np.maximum(sizes, 0.0)))


def _at(k: int, record: MotorRecord, solution: Solution) -> Linearised:
    """A record that stands for the one of that number, at the solution from here on."""
    shared = [
        replace(unknown, start=float(value))
        for unknown, value in zip(solution.unknowns, solution.values, strict=True)
    ]
    record.unknowns = tuple(
        replace(unknown, start=float(size))
        for unknown, size in zip(record.unknowns, solution.own[k], strict=True)
    )
    return maximise(shared, [record], max_iterations=0).records[0]


def _noisier(record: MotorRecord) -> Iterator[MotorRecord]:
    """The record, if its voltage had as much noise once more."""
    waveform, channel = record.sensed.waveform, record.capture.get(VOLTAGE)
    if waveform is None or channel is None:
        return
    known = channel.values[np.isfinite(channel.values)]
    deviation = scatter(known)
    if not deviation:
        return
    rng = np.random.default_rng(len(known))
    as_heard = np.concatenate([
        np.full(part.stop - part.start, source is None)
        for part, source in zip(record.timeline.parts, record.sources, strict=True)
    ])  # fmt: skip
    for _ in range(DRAWS):
        noise = deviation * rng.standard_normal(len(channel.values))
        moved = _shaken(record, waveform, channel, noise)
        if moved is not None:
            yield _driven_by(record, moved, as_heard)


def _shaken(
    record: MotorRecord, waveform: Waveform, channel: Channel, noise: Floats
) -> Waveform | None:
    """The waveform of readings with ``noise`` (n,) in V, which jumps where it did."""
    raw = np.asarray(channel.raw, dtype=np.float64) + noise / channel.scale
    moved = of_log(record.capture, replace(channel, raw=raw), record.shape)
    if moved is not None and moved.shape != MEANS:
        vars(moved).update(steps_off=waveform.steps_off, wanders=waveform.wanders)
    return moved


def _driven_by(record: MotorRecord, waveform: Waveform, as_heard: NDArray[np.bool_]) -> MotorRecord:
    """The record under another waveform, where no source was fitted to its readings."""
    twin = record.twin()
    volts = waveform.means(record.timeline)
    twin.volts = record.volts + np.where(as_heard, volts - record.sensed.volts, 0.0)
    twin.sensed = replace(record.sensed, waveform=waveform, volts=volts)
    twin.standing.excite(twin.volts, twin.stretches, twin.first)
    return twin
