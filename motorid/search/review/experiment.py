"""An experiment of the review: what drives which motor, what is measured, who searches."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.results.estimate import Floats
from motorid.motor.batch import Model, Record, blank
from motorid.search.bounds import Box
from motorid.search.objective import peaks
from motorid.search.problem import Problem
from motorid.search.relations import Rule


@dataclass(frozen=True)
class Row:
    """One row: a method with its budget, and the figures that the review prints for it.

    ``printed`` holds parameter values in SI, or percent errors if ``percent``.
    """

    label: str
    method: str
    budget: int
    n: int | None = None
    rule: Rule = "exact"
    printed: Mapping[str, float] = field(default_factory=dict)
    percent: bool = False


@dataclass(frozen=True)
class Experiment:
    """``key`` names it, such as "9-w100". ``truth`` in the model's order, SI.

    ``noise``: white, relative to a channel's peak, times ``noise_share`` of the channel.
    ``truth_model`` makes the data where it is finer than the searched model, in ``refine`` steps
    a sample.
    ``guess_spread``: a start is the truth times a random factor up to this (0: no start).
    ``quantities``: further figures that follow from parameters, judged like them.
    ``derivative``: dω/dt comes from the equations, as the review's own figures need.
    """

    key: str
    table: int
    title: str
    truth: Mapping[str, float]
    model: Model
    channels: tuple[str, ...]
    period_s: float
    input: Floats
    box: Box
    rows: tuple[Row, ...]
    noise: tuple[float, ...] = (0.0, 0.01)
    noise_share: Mapping[str, float] = field(default_factory=dict)
    truth_model: Model | None = None
    refine: int = 1
    open: NDArray[np.bool_] | None = None
    scale: Mapping[str, float] | None = None
    cost: Literal["rms", "sum"] = "rms"
    guess_spread: float = 0.0
    derivative: bool = False
    note: str = ""
    quantities: Callable[[Mapping[str, float]], Mapping[str, float]] | None = None

    def figures(self, values: Mapping[str, float]) -> dict[str, float]:
        """The parameters, and the quantities where the experiment has some."""
        return {**values, **(self.quantities(values) if self.quantities else {})}

    def clean(self) -> Record:
        """The record without noise."""
        fine_input = np.repeat(self.input, self.refine)
        fine_open = None if self.open is None else np.repeat(self.open, self.refine)
        nothing = blank(fine_input, self.channels)
        silent = Record(self.period_s / self.refine, fine_input, nothing, fine_open)
        values = np.array([list(self.truth.values())])
        outputs = (self.truth_model or self.model).outputs(values, silent)[0, :, :: self.refine]
        measured = dict(zip(self.channels, outputs, strict=True))
        return Record(self.period_s, self.input, measured, self.open)

    def problem(self, noise: float, seed: int) -> Problem:
        """The record of one seed with the bounds and weights of this experiment."""
        rng = np.random.default_rng([self.table, round(1e6 * noise), seed])
        clean = self.clean()
        peak = peaks([clean])
        measured = {
            name: y
            + noise * self.noise_share.get(name, 1.0) * peak[name] * rng.standard_normal(len(y))
            for name, y in clean.measured.items()
        }
        record = Record(self.period_s, self.input, measured, self.open)
        return Problem(
            self.model,
            (record,),
            self.box,
            self.scale or peak,
            self.cost == "rms",
            self._acceleration(clean) if self.derivative and noise == 0.0 else None,
            self._start(rng),
        )

    def _acceleration(self, clean: Record) -> Floats:
        torque = self.truth["K"] * clean.measured["current"]
        return np.asarray((torque - self.truth["B"] * clean.measured["speed"]) / self.truth["J"])

    def _start(self, rng: np.random.Generator) -> Floats | None:
        if not self.guess_spread:
            return None
        values = np.array(list(self.truth.values()))
        return np.asarray(values * self.guess_spread ** rng.uniform(-1.0, 1.0, len(values)))
