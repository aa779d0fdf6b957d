"""Each effect alone in the simulator: is it named, is its size right, are the six put right?

python bench/bench_wider.py [--seeds N] [--clean N] [ROW ..]

A row an effect: how often the six-parameter answer is off by more than its interval or 2 % (the
effect matters), how often the better model is offered and names it, how often the added size and
the corrected six lie in their 95 % intervals, and the time beside the six-parameter fit's. The
last rows: captures without any effect, and the cost of the widest model.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from motorid.acquire.record import capture as record
from motorid.capture import store
from motorid.capture.model import Capture
from motorid.estimate.model.extended_terms import TERMS
from motorid.estimate.results.estimate import PARAMETERS, Estimate, Parameter
from motorid.program import Decay, Program, Step, StepKind
from motorid.rig import Sampling, load_rig
from motorid.sim import truth
from tests.six_parameters import fit

MATTERS = 0.02
RATE_HZ = 5_000.0
BARE = "heating=0&stiction=1&current_range=6"
LIMIT_A = 5.5  # of a reversal at full speed
T0_NM = 4.3e-4  # of the preset
R_OHM = 2.6
STALL_A = 6.0 / R_OHM
TOP = 6.0 / 7.68e-3  # rad/s, without friction


def levels(seconds: float, *volts: float, coast_s: float = 0.8) -> Program:
    """Rest, then each level for so long, a coast, the last level backwards, a coast."""
    slow = Decay.SYNCHRONOUS_SLOW
    ahead = [Step(StepKind.DRIVE_VOLTS, seconds, v, slow) for v in volts]
    back = Step(StepKind.DRIVE_VOLTS, seconds, -0.8 * volts[-1], slow)
    coast = Step(StepKind.COAST, coast_s)
    return Program((Step(StepKind.COAST, 0.03), *ahead, coast, back, coast))


SHORT = levels(0.12, 1.8, 3.5, 6.0)


@dataclass(frozen=True)
class Effect:
    """What to switch on, and what the better model must then say."""

    term: str
    options: str
    true: Mapping[str, float] = field(default_factory=dict)
    program: Program = SHORT
    rate_hz: float = RATE_HZ


EFFECTS = {
    "brush drop 0.15 V": Effect(
        "brush-drop", "brush_drop=0.15", {"V_b": 0.15, "i_b": 0.05 * STALL_A}
    ),
    "quadratic load": Effect("quadratic-load", "quadratic=2e-10", {"T_lc": 2e-10}),
    "direction, 10 %": Effect("direction", "asymmetry=0.1", {"d_T0": 0.1}),
    "Stribeck": Effect("stribeck", "stiction=2&stribeck=60", {"T_s": T0_NM, "w_s": 60.0}),
    "cogging": Effect("cogging", "cogging=6e-4&cogging_per_turn=4", {"T_c": 6e-4, "N_c": 4.0}),
    "ripple, 6 %": Effect("ripple", "ripple=0.06", {"k_K": 0.06, "k_R": 0.06, "N_r": 10.0}),
    "heating": Effect(
        "heating", "heating=1&load_inertia=2e-5", {"C_w": 8.0 / 6.0},
        levels(0.8, 6.0, -6.0, 6.0), 4_000.0,
    ),
    "commutation, 6 %": Effect(
        "commutation-resistance", "commutation=0.06", {"c_R": 0.06 * R_OHM / TOP}
    ),
    "lifting brushes": Effect(
        "commutation-resistance", f"commutation=0.06&commutation_speed={0.6 * TOP:g}",
        {"c_R": 0.06 * R_OHM / (0.4 * TOP), "w_R": 0.6 * TOP},
    ),
    "friction falls by a third": Effect(
        "friction-drift", "fresh_friction=0.5&fresh_time=0.8", {}, levels(0.4, 3.0, 6.0, -3.0, 3.0)
    ),
    "two masses": Effect(
        "two-masses", "load_inertia=4e-7&shaft_stiffness=0.05&shaft_damping=2e-6",
        {"J2": 4e-7, "Ks": 0.05, "b": 2e-6},
    ),
}  # fmt: skip
NONE, EVERY = "none", "every effect at once"
ROWS = (*EFFECTS, NONE, EVERY)


def captured(folder: Path, effect: Effect, seed: int) -> tuple[Capture, dict[str, float]]:
    """A capture of the simulated bench, and what is true of it."""
    given = dict(pair.split("=") for pair in f"{BARE}&{effect.options}".split("&") if pair)
    options = "&".join(f"{name}={value}" for name, value in given.items())
    rig = load_rig("sim")
    url = f"{rig.port}&speed=max&seed={seed}&{options}"
    channels = ("current", "terminal_voltage", "position")
    rig = replace(
        rig, port=url, program=effect.program, sampling=Sampling(effect.rate_hz, channels),
        limits=replace(rig.limits, current_a=LIMIT_A),
    )  # fmt: skip
    return store.load(record(rig, rig.program, folder / "run.h5", force=True)), truth(url)


def covers(p: Parameter, true: float) -> bool:
    """The interval holds the truth; what is not identifiable claims nothing."""
    return p.interval_95 is None or p.interval_95[0] <= true <= p.interval_95[1]


def biased(estimate: Estimate, true: Mapping[str, float]) -> bool:
    """A six-parameter value misses by more than its interval or 2 %."""
    return any(
        p.value is not None and (not covers(p, true[n]) or abs(p.value / true[n] - 1) > MATTERS)
        for n, p in estimate.parameters.items()
    )


@dataclass
class Tally:
    """Counts over seeds."""

    runs: int = 0
    matters: int = 0
    offered: int = 0
    named: int = 0
    sizes: list[bool] = field(default_factory=list)
    six: list[bool] = field(default_factory=list)
    cost: list[float] = field(default_factory=list)
    extra: list[str] = field(default_factory=list)

    def add(self, effect: Effect, capture: Capture, true: Mapping[str, float]) -> None:
        """One more capture."""
        narrow, alone = timed(lambda: fit([capture]))
        estimate, whole = timed(lambda: fit([capture], model="auto"))
        self.runs += 1
        self.cost.append(whole / alone)
        self.matters += biased(narrow, true)
        better = estimate.alternative
        if better is None:
            return
        self.offered += 1
        self.extra += [name for name in better.terms if name != effect.term]
        if effect.term not in better.terms:
            return
        self.named += 1
        self.sizes += [covers(better.parameters[n], v) for n, v in effect.true.items()]
        self.six += [covers(better.parameters[n], true[n]) for n in PARAMETERS]


def timed(work: Callable[[], Estimate]) -> tuple[Estimate, float]:
    """A fit and its processor time, s."""
    began = time.process_time()
    return work(), time.process_time() - began


def share(hits: list[bool]) -> str:
    """``57/60``."""
    return f"{sum(hits)}/{len(hits)}"


def row(name: str, tally: Tally) -> None:
    """Print one row."""
    cost = sorted(tally.cost)[len(tally.cost) // 2] if tally.cost else float("nan")
    print(
        f"{name:<20}{tally.runs:>5}{tally.matters:>9}{tally.offered:>9}{tally.named:>7}"
        f"{share(tally.sizes):>9}{share(tally.six):>9}{cost:>8.1f} x  {' '.join(tally.extra)}",
        flush=True,
    )


def widest(folder: Path) -> None:
    """Every effect at once but a flexible shaft: all terms named, and the search by itself."""
    options = (
        "brush_drop=0.15&quadratic=2e-10&asymmetry=0.1&stiction=2&stribeck=60&ripple=0.02"
        "&heating=1&cogging=6e-4&cogging_per_turn=4"
    )
    capture, _ = captured(folder, Effect("", options), 1)
    names = "+".join(name for name in TERMS if name not in ("ke-kt", "two-masses"))
    _, alone = timed(lambda: fit([capture], model="six"))
    for model in (names, "auto"):
        estimate, whole = timed(lambda model=model: fit([capture], model=model))  # type: ignore[misc]
        found = estimate.alternative.name if estimate.alternative else "six"
        print(
            f"{EVERY}, {model}: {found}, {whole:.2f} s processor time; "
            f"six: {alone:.2f} s; {whole / alone:.1f} x (target 10)"
        )


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser()
    names = ", ".join(ROWS).replace("%", "%%")
    parser.add_argument("rows", nargs="*", help=f"beginnings of: {names}")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--clean", type=int, default=20)
    options = parser.parse_args()
    print(
        f"{'effect':<20}{'runs':>5}{'matters':>9}{'offered':>9}{'named':>7}{'sizes':>9}{'six':>9}"
        f"{'time':>10}  other terms"
    )
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        for name in ROWS:
            if options.rows and not name.startswith(tuple(options.rows)):
                continue
            if name == EVERY:
                widest(folder)
                continue
            effect, tally = EFFECTS.get(name, Effect("", "")), Tally()
            for seed in range(1, (options.clean if name == NONE else options.seeds) + 1):
                tally.add(effect, *captured(folder, effect, seed))
            row(name, tally)


if __name__ == "__main__":
    main()
