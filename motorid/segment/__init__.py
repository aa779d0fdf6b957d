"""Splits a capture into acceleration, steady state, deceleration and rest.

From the signals alone: speed or position, and the current where there is one. The program that
drove the motor is not asked, so a capture from elsewhere is treated the same.

Steady state begins where a hundredth of the change remains or the noise hides the rest. Coast is
motion without current; deceleration with current, or with no current measured, is brake.
"""

from __future__ import annotations

from motorid.segment.split import segment
from motorid.segment.types import Segment, SegmentKind

__all__ = ["Segment", "SegmentKind", "segment"]
