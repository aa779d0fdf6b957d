"""Friction that varies with the rotor's angle: a rubbing disc, a bent shaft, a belt.

The shaft's friction has F cos(N angle + phase) more, against the motion whichever way it goes. One
way it cannot be told from cogging.
"""

from __future__ import annotations

from dataclasses import replace

from motorid.estimate.effects.rotor.cogging import COGGING

FRICTION_RIPPLE = replace(
    COGGING, name="friction ripple", remedy="record more turns at each level, both ways"
)
