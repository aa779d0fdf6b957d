"""Excitation: a frozen list of steps, in SI units. Pure; knows no board."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import IntEnum, StrEnum
from typing import Any

from motorid.errors import UsageError

VERSION = 1


class StepKind(IntEnum):
    """What the bridge does during a step; numbers are the wire protocol's."""

    COAST = 0
    DRIVE_DUTY = 1
    DRIVE_VOLTS = 2
    BRAKE = 3


class Decay(IntEnum):
    """What the bridge does in the off part of a PWM period; numbers are the wire protocol's."""

    NONE = 0
    SYNCHRONOUS_SLOW = 1
    DIODE = 2
    FAST = 3


class Rotor(StrEnum):
    """Whether a program wants the rotor held, and who says that it is."""

    FREE = "free"
    ASK = "ask"  # held; a person confirms it before each run
    CLAMPED = "clamped"  # by a fixture, as the rig file or a person says
    BRAKED = "braked"  # by a brake on the shaft, said likewise


@dataclass(frozen=True)
class Step:
    """One stretch of a program.

    ``level`` is a signed duty (-1 to 1) for DRIVE_DUTY, signed volts for DRIVE_VOLTS, else 0.
    """

    kind: StepKind
    duration_s: float
    level: float = 0.0
    decay: Decay = Decay.NONE

    def __post_init__(self) -> None:
        drives = self.kind in (StepKind.DRIVE_DUTY, StepKind.DRIVE_VOLTS)
        if not self.duration_s > 0:
            raise UsageError(f"a step's duration must be above 0 s, not {self.duration_s}")
        if not drives and self.level:
            raise UsageError(f"a {self.kind.name.lower()} step takes no level")
        if self.kind == StepKind.DRIVE_DUTY and not abs(self.level) <= 1:
            raise UsageError(f"a duty must lie between -1 and 1, not {self.level}")
        if drives == (self.decay == Decay.NONE):
            raise UsageError("a drive step names a decay mode, and no other step does")


@dataclass(frozen=True)
class Program:
    """What a run does from its first sample to its last.

    ``rotor``: whether it may turn. ``energy_j``: the most I²R heat that a run may give the winding
    while the rotor is held; None: no bound, as for a free one.
    """

    steps: tuple[Step, ...]
    rotor: Rotor = Rotor.FREE
    energy_j: float | None = None

    @property
    def duration_s(self) -> float:
        """Length of the whole run in seconds."""
        return sum(step.duration_s for step in self.steps)

    @property
    def held(self) -> bool:
        """The rotor is not to turn."""
        return self.rotor is not Rotor.FREE

    def braked(self) -> Program:
        """The same with a brake for each coast: for a bridge that nothing opens."""
        coasts = {StepKind.COAST: StepKind.BRAKE}
        steps = tuple(replace(s, kind=coasts.get(s.kind, s.kind)) for s in self.steps)
        return replace(self, steps=steps)

    def to_dict(self) -> dict[str, Any]:
        """Plain data for files and reports; ``from_dict`` reads it back."""
        held = {"rotor": self.rotor.value, "energy_j": self.energy_j} if self.held else {}
        return {
            "version": VERSION,
            **held,
            "steps": [
                {
                    "kind": step.kind.name.lower(),
                    "duration_s": step.duration_s,
                    "level": step.level,
                    "decay": step.decay.name.lower(),
                }
                for step in self.steps
            ],
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Program:
        """The program that ``to_dict`` wrote. Raises UsageError on another version."""
        if data.get("version") != VERSION:
            raise UsageError(f"program version {data.get('version')} is not {VERSION}")
        return cls(
            tuple(
                Step(
                    StepKind[s["kind"].upper()],
                    float(s["duration_s"]),
                    float(s["level"]),
                    Decay[s["decay"].upper()],
                )
                for s in data["steps"]
            ),
            Rotor(data.get("rotor", Rotor.FREE)),
            data.get("energy_j"),
        )


def whole_ticks(duration_s: float, clock_hz: float, unit: int) -> int:
    """Ticks that a board gives to a step: the nearest multiple of ``unit`` ticks, at least one."""
    return max(1, round(duration_s * clock_hz / unit)) * unit


def climbs(
    levels: Sequence[Sequence[float]],
    *,
    kind: StepKind,
    drive_s: float,
    coast_s: Sequence[float],
    rest_s: float = 0.05,
    decay: Decay = Decay.SYNCHRONOUS_SLOW,
) -> Program:
    """Rest, then for each climb: its levels in turn, ``drive_s`` each, and a coast to rest.

    ``levels[i]`` are volts or duties (by ``kind``); ``coast_s[i]`` seconds end climb i. The rest at
    the start, with the bridge open, is where the offsets of the sensors show.
    """
    steps = [Step(StepKind.COAST, rest_s)]
    for climb, coast in zip(levels, coast_s, strict=True):
        steps += [Step(kind, drive_s, float(level), decay) for level in climb]
        steps.append(Step(StepKind.COAST, coast))
    return Program(tuple(steps))
