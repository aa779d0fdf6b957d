"""What a quantity may be, and how to decide."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from motorid.quality.guard_band import Rule


@dataclass(frozen=True)
class Limit:
    """Limits of one quantity, in ``unit``.

    ``condition``: about the measurement rather than the motor, so that being outside makes a
    verdict INVALID instead of FAIL. ``low_means`` and ``high_means`` say what a value below or
    above usually is, for the operator.
    """

    quantity: str
    unit: str
    low: float = -math.inf
    high: float = math.inf
    rule: Rule = field(default_factory=Rule)
    condition: bool = False
    low_means: str = ""
    high_means: str = ""
