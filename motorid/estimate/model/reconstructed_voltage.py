"""What drives a capture's motor: judged by its readings first, then by the model's own current.

Sources of the parts, what dead time takes of them, what brushes and winding lose, where the PWM
begins late, and where a current stops: all of it bends with a current that only the model knows.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, Capture
from motorid.estimate.effects.brush_and_heating import Loss
from motorid.estimate.signals.excitation import Excitation, excitation
from motorid.estimate.signals.source.current_transient import Rise, moving, rises
from motorid.estimate.signals.source.dead_time import dead_time_loss, swinging, turning
from motorid.estimate.signals.source.discontinuous_current import confirmed
from motorid.estimate.signals.source.pwm_bridge import (
    DIODE_DROPS_SD_V,
    DIODE_DROPS_V,
    bridge_prior,
    clamp_voltage,
    switched_late,
)
from motorid.estimate.signals.source.ripple_average import Flow
from motorid.estimate.signals.source.supply_sag import Sag, sags, seen
from motorid.estimate.signals.source.thevenin_source import Source, source_resistance, sources
from motorid.estimate.signals.time_grid import Timeline
from motorid.estimate.signals.voltage_sensing import Sense
from motorid.estimate.signals.voltage_window import Window
from motorid.motor.reading import Output, Quantity

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Course:
    """How the model's motor runs as it is driven now, each (count,).

    ``current`` (A) over the windows of the voltage, ``mean`` over intervals, ``end`` at their ends;
    ``emf`` (V) over intervals.
    """

    current: Floats
    mean: Floats
    end: Floats
    emf: Floats
    resistance_ohm: float
    inductance_h: float


@dataclass(frozen=True)
class Driving:
    """The motor's excitation, as far as it is known.

    ``heard`` is ``sensed`` with what the dead time takes; ``switched_late``, of every part, the
    interval up to which its PWM begins late. ``decided``: what is a choice between two things
    (where PWM begins late, the forms of sources, a supply's lag) stays as it is.
    """

    capture: Capture
    timeline: Timeline
    sensed: Sense
    heard: Sense
    sources: tuple[Source | None, ...]
    switched_late: tuple[int, ...]
    loss: Loss | None
    sagging: Mapping[int, Sag] = field(default_factory=dict)
    decided: bool = False

    @classmethod
    def of(cls, capture: Capture, timeline: Timeline, sensed: Sense) -> Driving:
        """By the readings alone."""
        loss = Loss.of(capture, timeline, timeline.driven, sensed.volts, sensed.commanded)
        none, late = tuple(None for _ in timeline.parts), tuple(0 for _ in timeline.parts)
        first = cls(capture, timeline, sensed, sensed, none, late, loss)
        amperes = capture.get(CURRENT)
        if amperes is None:
            return first
        ohms = bridge_prior(capture)[0] if sensed.shows_emf else 0.0
        return first._with_sources(timeline.spread(amperes.values), ohms)

    @property
    def excitation(self) -> Excitation:
        """What the model is given, but for its losses."""
        clamp_v = clamp_voltage(self.capture, float(np.abs(self.sensed.volts).max()))
        return excitation(
            self.capture.wiring, self.capture.supply_v, clamp_v, self.heard,
            self.timeline.parts, self.sources, self.switched_late,
        )  # fmt: skip

    @property
    def window(self) -> Window:
        """Through which the voltage was seen."""
        return self.sensed.window or Window(self.timeline.period_s)

    @property
    def asked(self) -> list[Output]:
        """What the model's run is read by, for its ``course``."""
        period_s, current = self.timeline.period_s, Quantity.CURRENT
        mean, end = Output(current, period_s), Output(current)
        return [*self.window.outputs, Output(Quantity.SPEED, period_s), mean, end]

    def course(self, rows: Floats, emf_constant: float, ohms: float, henries: float) -> Course:
        """Of a motor's run: ``rows`` (outputs, count) are what was ``asked`` of it."""
        *seen, speed, mean, end = rows
        current = self.window.current(np.array(seen), mean, self.timeline)
        return Course(current, mean, end, emf_constant * speed, ohms, henries)

    def judged(self, course: Course, losing: Mapping[str, float]) -> Driving:
        """Anew by the model's course, which had ``losing``, the unknowns of what is lost."""
        L, R = course.inductance_h, course.resistance_ohm
        timeline = self.timeline if self.decided else confirmed(self.capture, self.timeline, L, R)
        now = replace(self, timeline=timeline)
        parts = timeline.parts
        course = now._at_rest(course)
        current, mean = course.current, course.mean
        risen = tuple(rises(self.capture, parts, mean, course.end, L, R))
        if not self.decided:
            late = tuple(switched_late(self.capture, part, current, L, R) for part in parts)
            now = replace(now, switched_late=late)
        now = now._losing(course, risen, losing)._hearing(course, risen)
        ohms = now._source_ohms(current)
        source_v = now.heard.volts + now.heard.lost_shown + ohms * current
        rail = self.capture.supply_v
        sagging = sags(
            self.window, parts, source_v, current, ~self._gone, mean, risen, rail,
            self.sagging if self.decided else None,
        )  # fmt: skip
        return replace(now, sagging=sagging)._with_sources(current, ohms, moving(mean, risen))

    @property
    def _gone(self) -> NDArray[np.bool_]:
        """Intervals (count,) without a reading of their own."""
        none = np.zeros(len(self.capture))
        return np.asarray(self.sensed.filled | np.isnan(self.timeline.spread(none)))

    def _at_rest(self, course: Course) -> Course:
        """The course where the dead time takes what it should of it.

        A source that follows its readings has that from them. Without unknowns of what brushes take
        the current near nothing is not known well enough to ask what it should lose.
        """
        shown = not self.sensed.commanded
        if shown and (self.loss is None or not np.any(self.heard.lost)):
            return course
        taken = np.broadcast_to(self.heard.lost, len(course.mean))
        off = np.zeros(len(course.mean))
        for part, source in zip(self.timeline.parts, self.sources, strict=True):
            if shown and (source is None or source.as_read):
                continue
            ohms = self.heard.series_ohm + (source.ohms if source is not None else 0.0)
            off[part.slice] = swinging(
                self.capture, part, course.mean, taken, course.inductance_h,
                course.resistance_ohm, ohms, shown,
            )  # fmt: skip
        return replace(
            course, current=course.current - off, mean=course.mean - off, end=course.end - off
        )

    def mixed(self, other: Driving, share: float) -> Driving:
        """This one, and of another its ``share`` of the difference to this one."""

        def mix(a: Floats, b: Floats) -> Floats:
            return np.asarray(a + share * (np.asarray(b) - a))

        sources = tuple(
            replace(
                a,
                volts=mix(a.volts, b.volts),
                ohms=max(a.ohms + share * (b.ohms - a.ohms), 0.0),
            )
            if a is not None and b is not None
            else a
            for a, b in zip(self.sources, other.sources, strict=True)
        )
        own, its = self.heard, other.heard
        heard = replace(
            own,
            volts=mix(own.volts, its.volts),
            lost=mix(np.asarray(own.lost), np.asarray(its.lost)),
            lost_shown=mix(np.asarray(own.lost_shown), np.asarray(its.lost_shown)),
        )
        loss = self.loss
        if loss is not None and other.loss is not None:
            loss = loss.mixed(other.loss, share)
        return replace(self, sources=sources, heard=heard, loss=loss)

    def _losing(
        self, course: Course, risen: Sequence[Rise], losing: Mapping[str, float]
    ) -> Driving:
        if self.loss is None:
            return self
        L, R, parts = course.inductance_h, course.resistance_ohm, self.timeline.parts
        flow = Flow.of(self.capture, parts, course.mean, L, R, risen, course.emf)
        unsure = turning(self.capture, parts, course.mean, L, R)
        followed = self.loss.follow(flow, R, losing, unsure, self._lost_to_diodes(course))
        return replace(self, loss=followed)

    def _lost_to_diodes(self, course: Course) -> Floats:
        """What the dead time takes for a volt that two diodes drop, (count,), by their scatter.

        Nothing where readings show what is lost.
        """
        if not self.sensed.commanded:
            return np.zeros(len(course.mean))
        less, more = (
            dead_time_loss(
                self.capture, self.timeline.parts, course.mean, course.inductance_h,
                course.resistance_ohm, drops_v=DIODE_DROPS_V + by,
            )[0]
            for by in (-DIODE_DROPS_SD_V, DIODE_DROPS_SD_V)
        )  # fmt: skip
        return (more - less) / (2.0 * DIODE_DROPS_SD_V)

    def _hearing(self, course: Course, risen: Sequence[Rise]) -> Driving:
        """With the dead time: of a command it is taken, readings show it and need only be told."""
        lost, shown = dead_time_loss(
            self.capture, self.timeline.parts, course.mean, course.inductance_h,
            course.resistance_ohm, risen, seen(self.window),
        )  # fmt: skip
        if self.sensed.commanded:
            volts = self.sensed.volts - lost
            return replace(
                self, heard=replace(self.sensed, volts=volts, lost=lost, lost_shown=lost)
            )
        return replace(self, heard=replace(self.sensed, lost=lost, lost_shown=shown))

    def _source_ohms(self, current: Floats) -> float:
        """A supply gives way by what it shows, and before a brake there is none."""
        if self.sensed.commanded:
            return 0.0
        prior = bridge_prior(self.capture) if self.sensed.shows_emf else (0.0, np.inf)
        return source_resistance(self.heard, current, self.timeline.parts, self._gone, prior)

    def _with_sources(
        self,
        current: Floats,
        ohms: float,
        mean: Floats | None = None,
    ) -> Driving:
        """By the current (count,) over windows, and its mean over intervals."""
        found = sources(
            self.heard, current, self.timeline.parts, self._gone, ohms, mean, self.sagging,
            self.sources if self.decided else None,
        )  # fmt: skip
        return replace(self, sources=found)
