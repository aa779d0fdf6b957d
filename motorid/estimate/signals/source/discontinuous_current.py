"""Where the current stops within every PWM period, by the voltage at the terminals.

With diode decay the current cannot turn round. While it flows on, the mean voltage is that of the
two parts of the PWM period, d S - (1 - d)(S + 1.4 V). Once it stops before the period ends, the
terminals show the back-EMF for the rest, and the mean is larger. Every period then begins without
a current, so that the mean current follows the mean voltage without delay and L takes no part in
it; and a reading over part of a period no longer tells the mean.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, Capture, Channel
from motorid.errors import DataError
from motorid.estimate.signals.source.pwm_bridge import DIODE_DROPS_V, ripple, signed_duty
from motorid.estimate.signals.source.smoothing import smoothed
from motorid.estimate.signals.time_grid import Part, Timeline
from motorid.estimate.signals.voltage_sensing import Sense
from motorid.program import Decay

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

NEAR = 0.05  # of the supply, by which drops and sags may move the voltage of a current that flows
CLEAR = 0.01  # of the supply, by which it has risen for certain
MOST = 3.0  # times the mean at which a pulse just fills its period: a current that flows on
HALF = 4  # samples on either side, of a mean
WHOLE = 1e-3  # of a PWM period, by which an aperture may miss a whole number of them


def stops_from(part: Part, volts: Floats, rail: float) -> int:
    """Interval of a part from which on the current stops within the PWM period; its end: never.

    ``volts`` (count,) are those of the source. As a motor speeds up its current falls, so that
    there is one such interval.
    """
    duty = signed_duty(part, rail)
    if part.decay != Decay.DIODE or not 0.0 < abs(duty) < 1.0:
        return part.stop
    flowing = (2.0 * abs(duty) - 1.0) * rail - (1.0 - abs(duty)) * DIODE_DROPS_V
    here = smoothed(math.copysign(1.0, duty) * volts[part.slice], HALF)
    lowest = float(here.min())
    if lowest > flowing + NEAR * rail:
        return part.start
    clear = _rises(here, lowest + CLEAR * rail)
    halfway = _rises(here, lowest + CLEAR / 2 * rail)
    return part.start + (max(2 * halfway - clear, 0) if clear < len(here) else clear)


def _rises(values: Floats, above: float) -> int:
    """Place from which on values lie above a level, but for a few on either side."""
    votes = np.cumsum(np.where(values < above, 1, -1))
    return int(np.argmax(np.append(0, votes)))


def divided(capture: Capture, timeline: Timeline, sensed: Sense) -> Timeline:
    """With every part divided where the current begins to stop within the PWM period.

    The highest voltage stands in for a supply that nothing tells. Raises DataError where only duty
    and supply tell of the voltage, and that is not enough.
    """
    if all(part.decay != Decay.DIODE for part in timeline.parts):
        return timeline
    volts = sensed.volts
    rail = capture.supply_v or float(np.abs(volts).max())
    if not sensed.shows_emf:
        _refuse_unsensed(timeline, rail)
    ohms = capture.wiring.bridge_resistance_ohm + capture.wiring.lead_resistance_ohm
    current = capture.get(CURRENT)
    if current is not None and not current.unsigned:
        volts = volts + ohms * np.nan_to_num(timeline.spread(current.values))
    parts: list[Part] = []
    for part in timeline.parts:
        edge = stops_from(part, volts, rail)
        if edge > part.start:
            parts.append(replace(part, stop=edge))
        if edge < part.stop:
            parts.append(replace(part, start=edge, discontinuous=True))
    return replace(timeline, parts=tuple(parts))


def confirmed(
    capture: Capture, timeline: Timeline, inductance_h: float, resistance_ohm: float
) -> Timeline:
    """With those parts taken back whose current is more than pulses could be, by this inductance.

    A drop that nobody knows may look like the rise of the voltage.
    """
    channel = capture.get(CURRENT)
    if channel is None or not timeline.stopped.any():
        return timeline
    size = np.abs(timeline.spread(channel.values))

    def stops(part: Part) -> bool:
        here = size[part.slice]
        most = MOST * ripple(capture, part, inductance_h, resistance_ohm)[0]
        known = here[np.isfinite(here)]
        return not (most and len(known)) or float(np.median(known)) < most

    parts = (
        replace(p, discontinuous=False) if p.discontinuous and not stops(p) else p
        for p in timeline.parts
    )
    return replace(timeline, parts=tuple(parts))


def unclear(channel: Channel, timeline: Timeline, pwm_hz: float) -> Bools:
    """Ticks (count,) whose reading is of part of a PWM period in which the current stops, and
    nobody knows of which.
    """
    stopped = timeline.stopped
    if (
        not stopped.any()
        or _placed(channel, timeline.period_s, pwm_hz)
        or _whole(channel.window_s * pwm_hz)
    ):
        return np.zeros(timeline.count, dtype=bool)
    first = math.floor(channel.delay_s / timeline.period_s + WHOLE)
    last = math.ceil((channel.delay_s + channel.window_s) / timeline.period_s + WHOLE)
    hidden = np.zeros(timeline.count, dtype=bool)
    for back in range(first, max(last, first + 1)):
        hidden[back:] |= stopped[: timeline.count - back]
    return hidden


def shows_ripple(channel: Channel, period_s: float, pwm_hz: float) -> bool:
    """Its readings are of part of a PWM period, and it is known of which."""
    return (
        pwm_hz > 0 and _placed(channel, period_s, pwm_hz) and not _whole(channel.window_s * pwm_hz)
    )


def _placed(channel: Channel, period_s: float, pwm_hz: float) -> bool:
    """Every reading lies at a known place of the PWM period."""
    declared = channel.pwm_phase is not None and not channel.window_s
    return declared or _whole(period_s * pwm_hz)


def _whole(periods: float) -> bool:
    return round(periods) > 0 and abs(periods - round(periods)) < WHOLE


def _refuse_unsensed(timeline: Timeline, rail: float) -> None:
    """With diode decay the terminals show the reversed supply while the current falls, and the
    back-EMF once it has stopped: duty times supply is not their mean.
    """
    for part in timeline.parts:
        if part.decay == Decay.DIODE and abs(signed_duty(part, rail)) < 1.0:
            raise DataError(
                "duty times supply is not the motor's voltage with diode decay (level "
                f"{part.level:g}): measure the voltage at the terminals, or drive with synchronous "
                "decay"
            )
