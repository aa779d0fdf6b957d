"""A channel of a log that is ahead of the others, or less smooth: the others come later then.

No reading shows what comes after it, and no filter has a time constant below nothing. But only
differences between channels are seen: all of them may come later by the same after what drove the
motor, and, of a motor that is nearly linear, may all have passed one more low-pass.
"""

from __future__ import annotations

from collections.abc import Sequence

from motorid.estimate.effects import scales
from motorid.estimate.effects.action import Setup
from motorid.estimate.signals.measurements import Measured, filter_of


def let_be(setup: Setup, measured: Sequence[Measured]) -> None:
    """The same run with no channel ahead of its readings."""
    names = [m.block.name for m in measured]
    early_s = max(scales.least_delay_s(m) - setup.late_s.get(m.block.name, 0.0) for m in measured)
    if early_s > 0.0:
        setup.all_later(early_s, names)
    filters = [filter_of(m.channel, m.block.name) for m in measured]
    longer = [f + setup.filter_s.get(name, 0.0) for f, name in zip(filters, names, strict=True)]
    least_s = min(setup.log_filter_s, *longer)
    if least_s < 0.0:
        setup.all_smoother(-least_s, names)
