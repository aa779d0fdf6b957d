"""What a study of detection power found: each defect, and the motors without one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from motorid.quality.detection import Trials


@dataclass(frozen=True)
class Power:
    """What became of one defect; severities are in ``unit``, "1" for a share.

    ``option``: of the simulator, which stands for the defect. ``named``: the quantities that most
    often did not pass. ``invalid``: of the motors that did not pass, how many were INVALID.
    """

    name: str
    title: str
    unit: str
    option: str
    trials: Trials
    named: tuple[str, ...]
    invalid: int


@dataclass(frozen=True)
class Study:
    """The powers, and the ``good`` motors without a defect; ``rejected`` of them did not pass."""

    product: str
    rig: str
    good: int
    rejected: int
    invalid: int
    named: tuple[str, ...]
    powers: tuple[Power, ...]
    spread: Mapping[str, float]
