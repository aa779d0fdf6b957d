"""A rig file or a product file with another program in it, everything else as it was."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import TYPE_CHECKING

from motorid.errors import MotoridError, UsageError

if TYPE_CHECKING:
    from motorid.plan.propose import Plan
    from motorid.plan.skeleton import Bench
    from motorid.program import Program, Step
    from motorid.quality.product import Product
    from motorid.rig import Rig

HEADER = re.compile(r"\s*\[")
PROGRAM = re.compile(r"\s*\[\[?\s*program\s*(\.\s*steps\s*)?\]\]?")
RATE = re.compile(r"^(\s*rate_hz\s*=\s*)[^#\n]*?(\s*(?:#.*)?)$", re.MULTILINE)
TABLE = re.compile(r"^\s*\[calibration\]\s*$", re.MULTILINE)


def rig_text(rig: Rig, source: Path, plan: Plan, target: Path) -> str:
    """The rig's file for ``target``: the planned program and rate, the same calibration.

    Raises UsageError where the file is written in a way that this cannot edit.
    """
    text = with_program(rig.text, plan.program, f"`motorid plan --rig {source.name}`")
    return checked(text, rig, source, target, plan.program, plan.bench)


def checked(text: str, rig: Rig, source: Path, target: Path, program: Program, bench: Bench) -> str:
    """``text`` with the bench's rate and the rig's calibration, once it reads as ``program``.

    Raises UsageError where it does not.
    """
    from motorid.rig_file import parse

    rate_hz = bench.clock_hz / bench.period_ticks
    if abs(rate_hz - rig.sampling.rate_hz) > 1e-3 * rate_hz:
        text = RATE.sub(rf"\g<1>{rate_hz:.9g}\g<2>", text, count=1)
    text = _calibrated(text, rig, source, target)
    try:
        read = parse(text, str(target))
    except MotoridError as error:
        raise UsageError(f"the program could not be put into {source}: {error}") from None
    if read.program != program:
        raise UsageError(f"the program could not be put into {source}: it names one twice")
    return text


def product_text(product: Product, plan: Plan, target: Path) -> str:
    """The product's file with the planned program. Raises UsageError."""
    from motorid.quality.product import parse

    text = with_program(product.text, plan.program, f"`motorid plan --product {product.name}`")
    parse(text, str(target))
    return text


def with_program(text: str, program: Program, by: str) -> str:
    """TOML ``text`` with ``program`` in place of its own, or at its end."""
    return with_block(text, [f"# by {by}", *(li for step in program.steps for li in _step(step))])


def with_block(text: str, lines: list[str]) -> str:
    """TOML ``text`` with these lines in place of its program, or at its end."""
    kept: list[str] = []
    place = None
    inside = False
    for line in text.splitlines():
        if HEADER.match(line):
            inside = bool(PROGRAM.match(line))
            place = len(kept) if inside and place is None else place
        if not inside:
            kept.append(line)
    block = [*lines, ""]
    if place is None:
        kept += ["", *block[:-1]]
    else:
        kept[place:place] = block
    return "\n".join(kept) + "\n"


def _step(step: Step) -> list[str]:
    from motorid.program import Decay, StepKind

    lines = ["[[program.steps]]", f'kind = "{step.kind.name.lower()}"']
    if step.kind is StepKind.DRIVE_VOLTS:
        lines.append(f"volts = {step.level!r}")
    if step.kind is StepKind.DRIVE_DUTY:
        lines.append(f"duty = {step.level!r}")
    if step.decay not in (Decay.NONE, Decay.SYNCHRONOUS_SLOW):
        lines.append(f'decay = "{step.decay.name.lower()}"')
    return [*lines, f"duration_s = {step.duration_s!r}"]


def _calibrated(text: str, rig: Rig, source: Path, target: Path) -> str:
    """Naming the calibration file that applies now, as seen from where the text will lie."""
    from motorid.rig_calibration import path_beside

    if rig.calibrated is None:
        return text
    named = rig.calibration_file
    file = source.parent / named if named else path_beside(source)
    seen = Path(os.path.relpath(file.resolve(), target.resolve().parent)).as_posix()
    if named:
        return text.replace(f'"{named}"', f'"{seen}"', 1)
    if target.resolve() == source.resolve():
        return text
    line = f'file = "{seen}"'
    if TABLE.search(text):
        return TABLE.sub(lambda m: f"{m[0]}\n{line}", text, count=1)
    return f"{text}\n[calibration]\n{line}\n"
