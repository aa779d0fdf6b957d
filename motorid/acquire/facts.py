"""What a board says of itself, held against reason before anything turns."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

LEAST_SCALE, MOST_SCALE = 1e-15, 1e15  # of a count, in A or V
MOST_COUNTS = 1e9
MOST_CHANNELS = 64


def wrong_identity(identity: Mapping[str, Any]) -> str:
    """What no board can mean by its identity, or ""."""
    for name in ("clock_hz", "min_sample_period_ticks"):
        if not identity[name] > 0:
            return f"{name} = {identity[name]}"
    if identity["channel_count"] > MOST_CHANNELS:
        return f"channel_count = {identity['channel_count']}"
    fast, least = identity["burst_sample_period_ticks"], identity["min_sample_period_ticks"]
    if fast > least:
        return f"burst_sample_period_ticks = {fast}, above min_sample_period_ticks = {least}"
    return ""


def wrong_descriptor(fact: Mapping[str, Any]) -> str:
    """What no channel can have in its descriptor, or ""."""
    scale = fact["scale"]
    if not LEAST_SCALE < abs(scale) < MOST_SCALE:
        return f"scale = {scale}"
    if not abs(fact["offset"]) < MOST_COUNTS:
        return f"offset = {fact['offset']}"
    if fact["filter2_ns"] and not fact["filter_ns"]:
        return f"filter2_ns = {fact['filter2_ns']} and filter_ns = 0, which rings for ever"
    for name in ("gain_uncertainty", "offset_uncertainty", "noise", "step_uncertainty"):
        if not 0 <= fact.get(name, 0.0) < MOST_COUNTS:
            return f"{name} = {fact[name]}"
    return ""


def wrong_zero(zero: Mapping[str, Any]) -> str:
    """What no reading at rest can be, or ""."""
    for name, value in zero.items():
        noise = name.endswith("_noise")
        if not (math.isfinite(value) and abs(value) < MOST_COUNTS) or (noise and value < 0):
            return f"{name} = {value}"
    return ""
