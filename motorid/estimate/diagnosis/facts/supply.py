"""The supply: as the rig states it, as the board read it, and as the motor's voltage shows it.

Its voltage gives the duty that a level takes, and so the ripple of the current, which moves L.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from motorid.capture.model import SUPPLY, SUPPLY_OFF, VOLTAGE, Capture
from motorid.estimate.results.estimate import Diagnostic, Parameter
from motorid.estimate.signals.time_grid import Part, lay
from motorid.program import Decay, StepKind

ABOVE = 1.05  # times the stated supply, that a motor's voltage cannot reach
BY_DUTY = 0.15  # by which a voltage over its duty may miss the supply: sag, dead time, switches
LEAST_DUTY = 0.2  # below it dead time and drops are a large share
SHIFT = 0.5  # of L, for a relative error of the supply: ripple is a part of its reading
FEWEST = 20  # readings of a step


def findings(
    capture: Capture, parameters: Mapping[str, Parameter], where: str = ""
) -> Iterator[Diagnostic]:
    """A stated supply that a measured figure contradicts. ``where``: " in run 2", or nothing."""
    stated = capture.wiring.supply_voltage_v
    if not stated > 0:
        return
    measured = _by_reading(capture, stated)
    shown_v, how = (None, "") if measured else _by_terminals(capture, stated)
    if not measured and shown_v is None:
        return
    ratio = (shown_v or capture.supply_measured_v or stated) / stated
    L = parameters["L"].value if "L" in parameters else None
    moves = {"L": L * SHIFT * abs(shown_v / stated - 1.0)} if L and shown_v else {}
    yield Diagnostic(
        "supply_contradicted", "warning",
        f"the rig states wiring.supply_voltage_v = {stated:g}, but {measured or how}{where}; "
        "correct the rig, or calibrate that channel: if the rig is right, "
        f"the scale of its voltage is off by {ratio - 1.0:+.1%}, and R, L, K, B, J and "
        "T0 with it",
        moves,
    )  # fmt: skip


def _by_reading(capture: Capture, stated: float) -> str:
    measured = capture.supply_measured_v
    if measured is None or abs(stated - measured) <= SUPPLY_OFF * measured:
        return ""
    during = capture.get(SUPPLY) is not None
    when = "the supply's channel shows" if during else "the board read its supply before the run as"
    return f"{when} {measured:.3g} V, by which the fit goes"


def _by_terminals(capture: Capture, stated: float) -> tuple[float | None, str]:
    """V that the motor's voltage shows of a supply that nobody measured, and in words; None."""
    channel = capture.get(VOLTAGE)
    if capture.supply_measured_v is not None or channel is None or capture.program is None:
        return None, ""
    volts = np.abs(channel.values)
    driven = [p for p in lay(capture).parts if p.level and p.stop - p.start >= FEWEST]
    steady = [(p, float(np.nanmedian(volts[_samples(capture, p)]))) for p in driven]
    highest = max((v for _, v in steady), default=0.0)
    if highest > ABOVE * stated:
        return highest, f"the terminal voltage reaches {highest:.3g} V, so that L may be off"
    shares = [
        v / abs(p.level)
        for p, v in steady
        if p.kind == StepKind.DRIVE_DUTY
        and p.decay == Decay.SYNCHRONOUS_SLOW
        and abs(p.level) >= LEAST_DUTY
    ]
    if shares and abs(np.median(shares) / stated - 1.0) > BY_DUTY:
        shown = float(np.median(shares))
        return shown, f"the terminal voltage over its duty is {shown:.3g} V, so that L may be off"
    return None, ""


def _samples(capture: Capture, part: Part) -> slice:
    """The later half of a part's readings, as samples of a capture without many gaps."""
    index = lay(capture).index
    first, last = np.searchsorted(index, ((part.start + part.stop) // 2, part.stop))
    return slice(int(first), int(last))
