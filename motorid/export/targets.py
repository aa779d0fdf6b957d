"""Every target of an export, in one table: what it holds, and what it cannot."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from motorid.errors import UsageError, nearest
from motorid.estimate.results.estimate import PARAMETERS
from motorid.export import (
    control,
    data,
    fmu,
    modelica,
    mujoco,
    octave,
    readings,
    simscape,
    simulink,
    spice,
    urdf,
)
from motorid.export.motor import Motor
from motorid.export.read import insist, read_motor, with_given

NOT_RUN = "written, not run here: compare it with a capture before you rely on it"
SMOOTH = "T0 is a tanh of the speed: at rest the motor creeps, where a real one sticks"
LINEAR = "T0 is in the nonlinear form alone: a linear system cannot hold it"


@dataclass(frozen=True)
class Target:
    """One form. ``holds``: the constants that it needs; ``divides``: those that may not be 0.

    ``cannot``: sentences on what it cannot hold. ``run``: whether it was tried with its program.
    """

    name: str
    suffix: str
    write: Callable[[Motor], str | bytes]
    holds: tuple[str, ...] = PARAMETERS
    divides: tuple[str, ...] = ("L",)
    cannot: tuple[str, ...] = ()
    run: bool = True


TABLE = (
    Target(
        "mujoco",
        ".xml",
        mujoco.write,
        divides=(),
        cannot=("MuJoCo holds no uncertainty: it is in the comment",),
    ),
    Target("spice", ".lib", spice.write, cannot=(SMOOTH,)),
    Target("control", ".py", control.write, cannot=(LINEAR, SMOOTH)),
    Target(
        "fmu", ".fmu", fmu.write, cannot=("FMI 2.0 holds no uncertainty: it is in descriptions",)
    ),
    Target("octave", ".m", octave.write, cannot=(LINEAR, SMOOTH)),
    Target(
        "urdf",
        ".urdf",
        urdf.write,
        holds=("B", "J", "T0"),
        divides=(),
        cannot=(
            "URDF has no electrical side: R, L and K are in the comment alone",
            "URDF holds no uncertainty: it is in the comment",
        ),
    ),
    Target("json", ".json", data.write_json, divides=()),
    Target("toml", ".toml", data.write_toml, divides=()),
    Target("simulink", ".m", simulink.write, cannot=(SMOOTH,), run=False),
    Target("simscape", ".ssc", simscape.write, cannot=(SMOOTH,), run=False),
    Target("modelica", ".mo", modelica.write, cannot=(SMOOTH,), run=False),
)
NAMES = tuple(target.name for target in TABLE)
BINARY = ("fmu", "parquet", "mat")  # no text for a terminal


@dataclass(frozen=True)
class Made:
    """What an export wrote, and what a person should know of it, a sentence each."""

    content: bytes
    said: tuple[str, ...] = field(default=())


def insist_known(name: str) -> None:
    """Raises UsageError for a name that is no target's."""
    known = (*NAMES, *readings.FORMS)
    if name not in known:
        raise UsageError(
            f"--to {name}: no such target{nearest(name, known)}; of an estimate: "
            f"{', '.join(NAMES)}; of a capture: {', '.join(readings.FORMS)}"
        )


def export(
    source: Path,
    to: str,
    *,
    gear_ratio: float = 1.0,
    given: Mapping[str, float] | None = None,
    allow_doubtful: bool = False,
) -> Made:
    """The motor of an estimate.json, or the readings of a capture, in the form of ``to``.

    ``gear_ratio``: motor turns for one of the shaft that the export describes. ``given``: constants
    in SI units that take the place of the estimate's. Raises DataError where a constant has no
    value, or one that is not sure unless ``allow_doubtful``; UsageError on a bad option.
    """
    insist_known(to)
    if to in readings.FORMS:
        if given or allow_doubtful or gear_ratio != 1.0:
            raise UsageError(f"--to {to} writes a capture: it takes no option of a motor")
        return Made(*readings.export_readings(source, to))
    (target,) = (one for one in TABLE if one.name == to)
    motor = with_given(read_motor(source), given or {})
    insist(motor, target.holds, allow_doubtful=allow_doubtful, above_zero=target.divides)
    content = target.write(motor.at_output(gear_ratio))
    return Made(
        content if isinstance(content, bytes) else content.encode("utf-8"),
        tuple(_said(target, motor)),
    )


def _said(target: Target, motor: Motor) -> list[str]:
    said = [f"{target.name}: {NOT_RUN}"] if not target.run else []
    said += target.cannot
    if target.name == "fmu" and fmu.compiler() is None:
        said.append(
            "this machine has no C compiler, so the FMU holds its sources alone: compile it "
            "(python -m fmpy compile FILE), or export where cc is"
        )
    for name, one in motor.values.items():
        if name in target.holds and one.status != "estimated":
            note = f" ({one.note})" if one.note else ""
            said.append(f"{name} is {one.status}{note}")
    return said + list(motor.beside)
