"""A plan for the iron as text: signals, heat, promise, and the clamp that it needs."""

from __future__ import annotations

from motorid.plan.iron import REST_S, IronPlan
from motorid.report.numbers import percent
from motorid.report.plan import table, wrapped


def render(plan: IronPlan) -> str:
    """Signals, promise and remarks."""
    program = plan.program
    rate = plan.bench.clock_hz / plan.bench.period_ticks
    head = f"1 run of {program.duration_s:.4g} s at {rate:g} Hz, the rotor held:"
    lines = [head, f"  coast for {REST_S * 1e3:g} ms, then"]
    for signal in plan.signals:
        chip_ms = 1e3 * signal.seconds / (2**signal.bits - 1)
        lines.append(
            f"  PRBS of {signal.bits} bits, ± {percent(signal.amplitude)} duty, "
            f"{signal.seconds * 1e3:g} ms: chips of {chip_ms:.3g} ms"
        )
    heat = (
        f"It gives the winding {plan.heat_j:.3g} J at most, by the least resistance that the "
        f"nameplate allows; the program's bound is {program.energy_j:g} J."
    )
    clamp = (
        "Clamp the rotor. `motorid capture` asks for it, or takes --clamped; the board stops a "
        "rotor that moves."
    )
    parts = ["\n".join(lines), wrapped(heat), table(plan.promises), *_remarks(plan), wrapped(clamp)]
    return "\n\n".join(parts) + "\n"


def _remarks(plan: IronPlan) -> list[str]:
    lacking = [p.want.name for p in plan.promises if not p.met]
    if not lacking:
        return []
    return [wrapped(
        f"{', '.join(lacking)}: not met for every sort of iron. Allow more heat (--energy) or "
        "current, sample faster, or repeat the run and fit all of them together."
    )]  # fmt: skip
