"""Strips as binary frames, and what a program says as text: the page's side of the wire.

A binary frame is little-endian: HEADER, then the samples as float64, channel by channel. Times are
seconds since the first sample that was watched. ``lost`` counts the frames that this viewer was too
slow for, before this one.
"""

from __future__ import annotations

import struct

import numpy as np

from motorid.acquire.strips import Strip

# lost frames, channels, samples, number of the run; start and period in s
HEADER = struct.Struct("<IIIIdd")


def encoded(strip: Strip) -> bytes:
    """The frame of one strip, with no loss before it."""
    channels, samples = strip.values.shape
    head = HEADER.pack(0, channels, samples, strip.run, strip.start_s, strip.period_s)
    return head + np.ascontiguousarray(strip.values, dtype="<f8").tobytes()


def after_loss(frame: bytes, lost: int) -> bytes:
    """The same frame, after so many that its viewer did not get."""
    return struct.pack("<I", lost) + frame[4:]
