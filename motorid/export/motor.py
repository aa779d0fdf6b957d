"""The motor that an export describes: the six constants at a shaft, and what is known of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from motorid.errors import UsageError
from motorid.estimate.results.estimate import PARAMETERS, UNITS
from motorid.estimate.results.status import Status

POWER = {"R": 0, "L": 0, "K": 1, "B": 2, "J": 2, "T0": 1}  # of the gear ratio, at its output
KNEE_RAD_S = 0.05  # of the motor: where a smooth Coulomb torque has 76 % of its size
GIVEN = "given"  # the standing of a value that was stated at the export


@dataclass(frozen=True)
class Value:
    """One constant, in SI units; None: unknown. ``u`` is the standard uncertainty."""

    value: float | None
    u: float | None = None
    interval_95: tuple[float, float] | None = None
    status: str = str(Status.ESTIMATED)
    note: str = ""

    def times(self, factor: float) -> Value:
        """The same multiplied by an exact number above zero."""
        return replace(
            self,
            value=None if self.value is None else factor * self.value,
            u=None if self.u is None else factor * self.u,
            interval_95=self.interval_95
            and (factor * self.interval_95[0], factor * self.interval_95[1]),
        )


@dataclass(frozen=True)
class Motor:
    """R, L, K, B, J and T0 at one shaft: v = R i + L di/dt + K w, J dw/dt = K i - B w - T0 sign w.

    ``correlation``: by pairs of names, of the estimated ones; ``beside``: facts as sentences.
    """

    values: Mapping[str, Value]
    correlation: Mapping[tuple[str, str], float]
    source: str = ""
    digest: str = ""
    serial: str = ""
    motorid: str = ""
    gear_ratio: float = 1.0
    beside: tuple[str, ...] = ()

    def number(self, name: str) -> float:
        """The value of a constant that the target was found to have."""
        found = self.values[name].value
        assert found is not None
        return found

    def text(self, name: str) -> str:
        """The same, in the fewest digits that lead back to it."""
        return repr(self.number(name))

    def u(self, name: str) -> float:
        """Its standard uncertainty; 0 where none is stated."""
        return self.values[name].u or 0.0

    @property
    def knee(self) -> float:
        """rad/s of this shaft at which a smooth Coulomb torque, T0 tanh(w / knee), is at 76 %."""
        return KNEE_RAD_S / self.gear_ratio

    def covariance(self) -> list[list[float]]:
        """Of R, L, K, B, J, T0, in that order and in SI units: (6, 6)."""
        return [
            [
                self.u(a) * self.u(b) * (1.0 if a == b else self.correlation.get((a, b), 0.0))
                for b in PARAMETERS
            ]
            for a in PARAMETERS
        ]

    def at_output(self, ratio: float) -> Motor:
        """The motor as the output of a gear without losses shows it; its equations stay.

        ``ratio``: motor turns for one turn of the output. Raises UsageError unless it is above 0.
        """
        if not 0.0 < ratio < 1e9:
            raise UsageError(f"--gear-ratio {ratio:g}: give motor turns for one turn of the output")
        values = {name: one.times(ratio ** POWER[name]) for name, one in self.values.items()}
        return replace(self, values=values, gear_ratio=self.gear_ratio * ratio)


def described(motor: Motor) -> list[str]:
    """What a file of any target says at its top, as lines without a comment's mark."""
    shaft = "at the motor's shaft"
    if motor.gear_ratio != 1.0:
        shaft = (
            f"at the output of a gear of {motor.gear_ratio:g} motor turns a turn, without losses"
        )
    serial = f", serial {motor.serial}" if motor.serial else ""
    lines = [
        f"A brushed DC motor{serial}, {shaft}. SI units.",
        f"Written by motorid {motor.motorid} from {motor.source}"
        + (f", content SHA-256 {motor.digest}" if motor.digest else ""),
    ]
    return [*lines, *(_line(name, one) for name, one in motor.values.items()), *motor.beside]


def _line(name: str, one: Value) -> str:
    note = f" ({one.note})" if one.note else ""
    if one.value is None:
        return f"{name}: {one.status}, no value{note}"
    parts = [f"{name} = {one.value:.6g} {UNITS[name]}"]
    if one.u is not None:
        parts.append(f"standard uncertainty {one.u:.2g}")
    if one.interval_95:
        parts.append("95 % from {:.6g} to {:.6g}".format(*one.interval_95))
    return ", ".join([*parts, one.status]) + note
