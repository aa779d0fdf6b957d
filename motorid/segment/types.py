"""What a stretch of a capture can be."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class SegmentKind(StrEnum):
    """What the motor is doing."""

    ACCELERATION = "acceleration"
    STEADY = "steady"
    COAST = "coast"  # deceleration with the bridge open: no current
    BRAKE = "brake"  # deceleration with current flowing, or with none measured
    REST = "rest"
    REJECTED = "rejected"


@dataclass(frozen=True)
class Segment:
    """Samples ``start`` to ``stop`` (exclusive) of a capture, and why they are what they are."""

    kind: SegmentKind
    start: int
    stop: int
    reason: str = ""

    @property
    def slice(self) -> slice:
        """The segment's samples."""
        return slice(self.start, self.stop)
