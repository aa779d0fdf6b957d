"""A motion that comes after its drive by a few samples of a log, where nobody stated a delay.

A speed of counted edges is the mean since the row before, a voltage that is held goes straight here
from one row to the next, and the winding takes its L/R: each makes the motion later, and the
balance has none of them. At each jump of the drive that leaves a misfit, which is no load's and no
friction's. Where the motion taken earlier by some samples leaves no more than noise does, the lag
is the cause. By how much the answer changes with it is in the uncertainty.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from motorid.capture.model import POSITION, SPEED, Capture
from motorid.estimate.partial.block_bootstrap_regression import Regression
from motorid.estimate.partial.mechanical_remarks import lacks_fit
from motorid.estimate.partial.mechanical_signals import Motion, of_capture
from motorid.estimate.results.estimate import Diagnostic

TRIED = (0.5, 1.0, 1.5, 2.0, 3.0)  # samples

Regress = Callable[[Sequence[Motion]], Regression | None]


def allowed_for(
    captures: Sequence[Capture],
    drive: str,
    motions: Sequence[Motion],
    best: Regression,
    regress: Regress,
) -> tuple[Regression, Diagnostic] | None:
    """The answer, as uncertain as such a lag makes it, and what to say; None: it fits without, or
    with no such lag either, or the delays are stated.
    """
    if not lacks_fit(motions, best) or any(_stated(capture, drive) for capture in captures):
        return None
    found = []
    for samples in TRIED:
        earlier = [of_capture(_earlier(capture, samples), drive) for capture in captures]
        other = regress(earlier)
        if other is not None and not lacks_fit(earlier, other):
            found.append((float(np.mean(other.residual**2)), samples, other))
    if not found:
        return None
    _, samples, other = min(found, key=lambda one: one[0])
    shift = np.where(best.free, other.coefficients - best.coefficients, 0.0)
    wider = replace(best, covariance=best.covariance + np.outer(shift, shift))
    return wider, _said(drive, samples, samples * max(motion.period_s for motion in motions))


def _motion(capture: Capture) -> str:
    return SPEED if SPEED in capture.channels else POSITION


def _stated(capture: Capture, drive: str) -> bool:
    """Both delays are somebody's word, or the capture's own."""
    names = (_motion(capture), drive)
    return all(
        name in capture.channels and capture.channels[name].states("delay") for name in names
    )


def _earlier(capture: Capture, samples: float) -> Capture:
    """With its motion taken earlier."""
    name = _motion(capture)
    channel = capture.channels[name]
    late = replace(channel, delay_s=channel.delay_s + samples * capture.period_s)
    return replace(capture, channels={**capture.channels, name: late})


def _said(drive: str, samples: float, seconds: float) -> Diagnostic:
    return Diagnostic(
        "unstated_lag", "info",
        f"the motion comes about {1e3 * seconds:.2g} ms ({samples:g} samples) after the "
        f"{drive.replace('_', ' ')}, which explains what the model leaves at its jumps. Means "
        "since the row before, a drive that is held and the winding do so; the change that it "
        "makes is in the intervals. To narrow them state --aperture and --delay, or sample faster",
    )  # fmt: skip
