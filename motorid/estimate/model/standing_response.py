"""The response of a record that stands, and is changed from run to run by its own unknowns."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.effects.action import Setup
from motorid.estimate.model.low_passes import first_orders
from motorid.estimate.model.responses_at_hand import AtHand, Key
from motorid.estimate.signals.measurements import Measured
from motorid.motor.reading import Output, Stretch
from motorid.motor.response import Response
from motorid.motor.wide import WideResponse

Floats = NDArray[np.float64]
First = Mapping[int, int] | Sequence[int]  # the stretch in which a part of the program begins


@dataclass(frozen=True)
class Run:
    """One run: what its own unknowns move, the motor by its response's names, and volts (count,)
    by which a log's stamps change what drives it.
    """

    setup: Setup
    motor: Floats
    stamped: Floats | float


class StandingResponse:
    """``response`` at these readings; ``at_hand``: what needs no new computation while what
    drives it stays.
    """

    def __init__(
        self,
        response: Response,
        measured: Sequence[Measured],
        outputs: Sequence[Output],
        first: First = (),
    ) -> None:
        self.response, self._first = response, first
        self.at_hand = AtHand()
        self._measured, self._outputs = measured, outputs
        self._kicked: Mapping[int, float] = {}
        self._late_s: Mapping[str, float] = {}
        self._filter_s: Mapping[str, float] = {}

    def excite(self, volts: Floats, stretches: Sequence[Stretch], first: First) -> None:
        """Be driven like that from here on."""
        self.at_hand.clear()
        self._kicked, self._first = {}, first
        self.response.excite(volts, stretches)

    @contextmanager
    def driven_by(
        self, volts: Floats, usual: Floats, stretches: Sequence[Stretch]
    ) -> Iterator[None]:
        """In between, ``volts`` (count,) in place of the usual ones."""
        at_hand, self.at_hand = self.at_hand, AtHand()
        self.excite(volts, stretches, self._first)
        try:
            yield
        finally:
            self.excite(usual, stretches, self._first)
            self.at_hand = at_hand

    def of(self, setup: Setup, stamped: Floats | float) -> Response:
        """The response, changed into this run."""
        self.response.shift(setup.volts + stamped)
        for part in self._kicked.keys() | setup.kicks.keys():
            self.response.kick(self._first[part], setup.kicks.get(part, 0.0))
        filters = first_orders(self._measured, self._outputs, setup)
        for m in self._measured:
            late = setup.late_s.get(m.block.name, 0.0)
            if late != self._late_s.get(m.block.name, 0.0):
                self.response.delay(m.row, late)
            if (more := filters[m.block.name]) != self._filter_s.get(m.block.name, 0.0):
                self.response.filter(m.row, self._outputs[m.row].filter_s + more)
        self._kicked, self._late_s, self._filter_s = setup.kicks, setup.late_s, filters
        return self.response

    @property
    def takes_several(self) -> bool:
        """Whether several runs at once are quicker than one by one."""
        return isinstance(self.response, WideResponse)

    def several(
        self, runs: Mapping[Key, Run], finished: Callable[[Floats, Setup], Floats]
    ) -> dict[Key, tuple[Floats, int]]:
        """Readings of runs and what each is worth, side by side; those that are quicker alone, or
        need a response of their own, are left out. ``finished``: what comes behind a response.
        """
        assert isinstance(self.response, WideResponse)
        fitting = {key: run for key, run in runs.items() if not run.setup.rebuilt}
        posed = []
        for run in fitting.values():
            self.of(run.setup, run.stamped)
            posed.append(self.response.pose(run.motor, run.setup.initial))
        answers = zip(fitting.items(), self.response.several(posed), strict=True)
        return {
            key: (finished(answer[0], run.setup), answer[1])
            for (key, run), answer in answers
            if answer is not None
        }
