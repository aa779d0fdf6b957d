"""A plan as text: the program, its promise, what cannot be had and why."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from motorid.capture.model import CURRENT
from motorid.estimate.diagnosis.identifiability import Excitation, advice, assess
from motorid.estimate.results.estimate import PARAMETERS, UNITS
from motorid.estimate.uncertainty.budget import remedy
from motorid.estimate.uncertainty.intervals import POSITIVE
from motorid.plan.propose import Plan, Promise
from motorid.program import Step, StepKind
from motorid.report.numbers import percent, scaled_unit

WIDTH = 96


def render(plan: Plan, channels: Sequence[str], spread: int) -> str:
    """Program, promise and remarks; ``spread`` motors were planned for."""
    rate = plan.bench.clock_hz / plan.bench.period_ticks
    times = "1 run" if plan.repeats == 1 else f"{plan.repeats} runs"
    head = f"{times} of {plan.program.duration_s:.4g} s at {rate:g} Hz: {', '.join(channels)}"
    parts = [
        f"{head}\n{_steps(plan.program.steps)}",
        f"Planned for {spread} motors about {_motor(plan)}; {plan.tried} programs weighed.",
        table(plan.promises),
        "\n".join(wrapped(line) for line in _remarks(plan)),
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def explain(run: Excitation) -> str:
    """What these channels and this excitation can tell at best, before any run."""
    known = assess(run)
    told = ", ".join((*known.parameters, *known.combinations)) or "nothing"
    lines = [
        f"Channels {', '.join(sorted(run.channels))}; {_shows(run)}.",
        f"These can determine at best: {told}.",
    ]
    if known.missing:
        lines.append(f"They cannot determine {', '.join(known.missing)}. {advice(run)}")
    without = assess(run, {**_typical(), "T0": 0.0})
    lost = [n for n in known.parameters if n not in without.parameters and n != "T0"]
    if lost:
        lines.append(
            f"If the motor had no dry friction (T0 = 0), {', '.join(lost)} would be lost too."
        )
    return "\n".join(wrapped(line) for line in lines) + "\n"


def _typical() -> dict[str, float]:
    from motorid.estimate.diagnosis.identifiability import TYPICAL

    return dict(TYPICAL)


def _shows(run: Excitation) -> str:
    if not run.levels:
        return "never driven" + (", a coast-down" if run.coast else "")
    levels = "one level" if run.levels == 1 else f"{run.levels} levels"
    parts = [f"drive at {levels}"]
    parts += ["starts and steps seen"] if run.transient else []
    parts += ["a coast-down"] if run.coast else []
    return ", ".join(parts)


def _steps(steps: Sequence[Step]) -> str:
    return "\n".join(f"  {k:>2}  {_what(step):<16} {_time(step.duration_s):>10}"
                     for k, step in enumerate(steps))  # fmt: skip


def _what(step: Step) -> str:
    if step.kind is StepKind.DRIVE_VOLTS:
        return f"drive {step.level:+.3g} V"
    if step.kind is StepKind.DRIVE_DUTY:
        return f"drive {step.level:+.1%}"
    return step.kind.name.lower()


def _time(seconds: float) -> str:
    return f"{seconds * 1e3:.4g} ms" if seconds < 1 else f"{seconds:.4g} s"


def _motor(plan: Plan) -> str:
    return ", ".join(f"{n} = {_si(getattr(plan.motor, n), UNITS[n])}" for n in PARAMETERS)


def _si(value: float, unit: str) -> str:
    name, factor = scaled_unit(unit, value)
    return f"{value * factor:.3g} {name}".strip()


def table(promises: Sequence[Promise]) -> str:
    """Half widths of 95 % intervals: asked, promised for the worst motor, for the middle one."""
    rows: list[tuple[str, ...]] = [("", "asked", "worst motor", "this motor", "instrument", "")]
    rows += [
        (
            p.want.name,
            *(_reach(p.want.name, r) for r in (p.want.reach, p.reach, p.expected, p.instrument)),
            "met" if p.met else "not met",
        )
        for p in promises
    ]
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    head = "Half widths of the 95 % intervals:"
    lines = ["  ".join(f"{cell:>{w}}" for cell, w in zip(row, widths, strict=True)).rstrip()
             for row in rows]  # fmt: skip
    return "\n".join((head, *("  " + line for line in lines)))


def _reach(name: str, reach: float) -> str:
    return percent(reach) if name in POSITIVE or name not in UNITS else _si(reach, UNITS[name])


def _remarks(plan: Plan) -> list[str]:
    out = []
    for p in plan.promises:
        if p.met:
            continue
        asked, held = _reach(p.want.name, p.want.reach), _reach(p.want.name, p.instrument)
        if p.instrument_limited:
            cause = remedy(p.cause)
            out.append(
                f"{p.want.name} to {asked} cannot be met however long the run: instruments alone "
                f"take {held}, most of it the {p.cause}. To improve it, {cause}."
            )
        else:
            out.append(
                f"{p.want.name} to {asked} is not met by every motor: the rig's limits on run "
                "time or steps end the program before."
            )
    if plan.repeats == 1:
        out.append("Three repeats or more would also show the spread between runs.")
    if CURRENT not in plan.bench.channels:
        out.append("Without a current channel less can be known: see --explain.")
    return out


def wrapped(text: str) -> str:
    return textwrap.fill(text, WIDTH, subsequent_indent="  ")
