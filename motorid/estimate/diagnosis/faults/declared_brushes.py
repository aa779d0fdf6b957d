"""Brushes that drop another voltage than the rig declares: a fact that the readings contradict."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import Capture
from motorid.estimate.diagnosis.fault import Hypothesis, Words
from motorid.estimate.diagnosis.faults.model_alternatives import brush_drop
from motorid.estimate.model.capture_model import MotorRecord

Floats = NDArray[np.float64]

SOME, MOST = 0.02, 0.2  # of the highest voltage


def _undeclared(capture: Capture, _: float) -> list[Capture]:
    """The capture whose rig says nothing of its brushes."""
    wiring = replace(capture.wiring, brush_drop_v=None, brush_drop_uncertainty_v=0.0)
    return [replace(capture, wiring=wiring)]


def hypotheses(records: Sequence[MotorRecord]) -> list[Hypothesis]:
    """One, where every rig declares what its brushes drop; else the fit looks for it by itself."""
    declared = [r.capture.wiring.brush_drop_v for r in records]
    known = [v for v in declared if v is not None]
    if len(known) < len(records):
        return []
    stated, volts = float(np.mean(known)), max(float(np.abs(r.volts).max()) for r in records)

    def words(size: Floats) -> Words:
        found = stated + float(size[0])
        return Words(
            "brushes",
            f"the brushes drop about {found:.2g} V where the rig declares {stated:.2g} V",
            "take brush_drop_v out of the rig, so that the fit finds it, or measure it",
        )

    return [
        Hypothesis(
            "brush_drop_contradicted", brush_drop, ((SOME * volts,),), (SOME * volts,),
            (-MOST * volts,), (MOST * volts,), words, remedy=_undeclared,
        )
    ]  # fmt: skip
