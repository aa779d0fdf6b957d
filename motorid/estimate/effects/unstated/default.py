"""The stated defaults: what a channel of a log may be off by where nobody says anything of it.

Captures of a board declare all of it. A log is one whose voltage came at stamps, with no program.
"""

from __future__ import annotations

from collections.abc import Callable

from motorid.capture.model import VOLTAGE, Channel, Fact
from motorid.estimate.effects.influence_quantity import Prior, Subject

SAMPLES = 0.3  # by which a channel is late, or smoothed: standard
FARTHEST = 500.0  # samples


def period_s(subject: Subject) -> float:
    """s between the samples of a log; 0: it is none."""
    waveform = subject.sensed.waveform
    return waveform.period_s if waveform is not None else 0.0


def unstated(subject: Subject, channel: Channel | None, fact: Fact) -> bool:
    """Nobody says anything of this fact of a log's channel."""
    return channel is not None and period_s(subject) > 0.0 and not channel.states(fact)


def of(name: str, fact: Fact) -> Callable[[Subject, int], Prior | None]:
    """The prior of a lag or of a low-pass of a channel."""

    def prior(subject: Subject, _: int) -> Prior | None:
        if name == VOLTAGE:
            channel = subject.sensed.channel
        else:
            measured = subject.block(name)
            channel = measured.channel if measured is not None else None
        return Prior(SAMPLES * period_s(subject)) if unstated(subject, channel, fact) else None

    return prior


def whole(subject: Subject, size_s: float) -> float:
    """s, of so many whole samples of a log."""
    period = period_s(subject)
    return period * round(size_s / period) if period else size_s


def either_way(subject: Subject) -> tuple[float, float]:
    """Bounds of a lag, s."""
    reach = FARTHEST * period_s(subject)
    return -reach, reach


def smoothing(subject: Subject) -> tuple[float, float]:
    """Bounds of a time constant, s; a little below none: the other channels are smoother."""
    return either_way(subject)


def none_or_more(subject: Subject) -> tuple[float, float]:
    """Bounds of a size that has no sign, s."""
    return 0.0, FARTHEST * period_s(subject)
