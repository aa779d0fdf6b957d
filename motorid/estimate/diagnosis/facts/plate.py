"""The nameplate's figures against the fit's, one by one, where no wrong scale explains them.

Such a figure is no fault of the measurement: the motor may carry a load, or the label be another's.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from motorid.capture.model import Capture
from motorid.estimate.diagnosis.facts.unit_mistakes import highest_v
from motorid.estimate.diagnosis.faults.scale_errors import (
    ALL_CAUSES,
    NO_LOAD,
    departures,
    read_nameplate,
)
from motorid.estimate.results.estimate import Diagnostic, Estimate

BEYOND = 1.5  # standard deviations of motors, runs and temperatures
HIGHER = {
    "R": "a warm winding, leads, or a voltage logged at a supply that sags, not at the terminals",
    "L": "few readings of the current's rise, or a filter of the current",
    "K": "a magnet or a winding of another type, or a wrong scale of voltage or speed",
    "J": "a load on the shaft, such as a disc, a coupling or a gear",
    NO_LOAD: "a load that rubs, dry bearings, or a wrong zero of the current",
}
LOWER = {
    "R": "a cold or shorted winding, or a wrong scale of voltage or current",
    "L": "saturation, or readings too slow for the current's rise",
    "K": "a magnet that has lost strength, or a wrong scale of voltage or speed",
    "J": "a wrong scale of the current, the speed or the time, or a current that is the supply's",
    NO_LOAD: "a motor run in, or a wrong zero of the current",
}
NAMES = {NO_LOAD: "the no-load current"}


def findings(captures: Sequence[Capture], estimate: Estimate) -> Iterator[Diagnostic]:
    """Each figure beyond its usual spread; none where a scale or the label is named."""
    codes = {c.code for c in ALL_CAUSES}
    if any(s.strength == "named" and s.code in codes for s in estimate.suspects):
        return
    if any(d.code == "not_the_minimum" for d in estimate.diagnostics):
        return  # the fit itself says that its figures are rough
    plate = read_nameplate(captures[0].stated.nameplate)
    top = max(highest_v(capture) for capture in captures)
    for name, (departure, deviation) in departures(estimate.parameters, plate, top).items():
        if name not in HIGHER or abs(departure) <= BEYOND * deviation:
            continue
        causes = HIGHER if departure > 0.0 else LOWER
        yield Diagnostic(
            "nameplate_differs", "info",
            f"{NAMES.get(name, name)} is {math.exp(departure):.3g} times the nameplate's: "
            f"{causes[name]}? Or is the label another motor's?",
        )  # fmt: skip
