"""A PRBS for a held rotor that tells what the iron makes of L, and its promise by the fit itself.

Two levels of signal follow one another: a small one, whose currents separate R from the brushes,
and a large one, whose currents saturate. The promise is that of the fit's linearisation, for the
motor of the nameplate with three usual sorts of iron; the worst counts.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from motorid.capture.model import CURRENT, Capture, Stated
from motorid.errors import RigError
from motorid.estimate.fit.parameter_bounds import merged, unknowns_of
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.partial import locked_rotor
from motorid.estimate.selection.extended_fit import Begun, begin
from motorid.estimate.selection.extended_results import findings, parameters
from motorid.estimate.selection.held_rotor import IRON, stilled
from motorid.estimate.solver.levenberg_marquardt import maximise
from motorid.excitation import Levels, prbs
from motorid.motor.parameters import Motor
from motorid.plan.predict import ROUGH
from motorid.plan.propose import Promise
from motorid.plan.skeleton import Bench, skeleton
from motorid.plan.wants import Want
from motorid.program import Decay, Program, Rotor, Step, StepKind

WANTED = ("R", "L", "L_1kHz", "L_rated", "L_pwm")
REST_S = 0.005
SMALL = 0.25  # of the large amplitude
SECONDS = (0.05, 0.1)  # of both signals together
LINE = 30  # samples of a chip: fewer leave the fit no line of the source
BITS = (7, 6, 5, 4, 3, 2)
HOLDS = 100.0  # N·m: more than any current makes
# shares of L that eddies shield and that the stall current takes, and the eddies' time (s)
SORTS = ((0.2, 0.2, 2e-4), (0.5, 0.5, 1e-4), (0.5, 0.5, 5.3e-4))


@dataclass(frozen=True)
class Signal:
    """One PRBS, in duty about 0."""

    amplitude: float
    bits: int
    seconds: float
    decay: Decay

    @property
    def steps(self) -> tuple[Step, ...]:
        """As the board takes it."""
        return prbs(Levels(StepKind.DRIVE_DUTY, 0.0, self.amplitude, self.decay), self.bits,
                    self.seconds)  # fmt: skip


@dataclass(frozen=True)
class IronPlan:
    """Signals after a rest, the heat (J) that they give at most, and what they promise."""

    signals: tuple[Signal, ...]
    bench: Bench
    motor: Motor
    heat_j: float
    promises: tuple[Promise, ...]
    tried: int

    @property
    def program(self) -> Program:
        """For a rotor that a person says is held."""
        return _program(self.signals, self.heat_j)


Allowed = Callable[[Program], bool]


def propose_iron(
    bench: Bench,
    motor: Motor,
    top_duty: float,
    least_ohm: float,
    energy_j: float,
    decay: Decay,
    wants: Sequence[Want],
    allowed: Allowed,
    rated_a: float | None = None,
) -> IronPlan:
    """The shortest signals that meet the wants, or else those that come nearest.

    ``top_duty``: the largest amplitude that current and supply allow; ``rated_a``: at which L_rated
    is stated. Raises RigError where the board holds none of them.
    """
    best: tuple[float, IronPlan] | None = None
    tried = 0
    for seconds in SECONDS:
        signals = _signals(bench, seconds, top_duty, least_ohm, energy_j, decay, allowed)
        if signals is None:
            continue
        tried += 1
        heat = _heat(bench, signals, least_ohm)
        promises = _promises(bench, _program(signals, heat), motor, wants, rated_a)
        lacking = max(p.reach / p.want.reach for p in promises)
        if best is None or lacking < best[0]:
            best = lacking, IronPlan(signals, bench, motor, heat, promises, tried)
        if lacking <= 1.0:
            break
    if best is None:
        raise RigError(
            "no PRBS for a held rotor fits this board and rig: raise limits.run_time_s or "
            "--energy, or sample faster"
        )
    return replace(best[1], tried=tried)


def _signals(
    bench: Bench,
    seconds: float,
    top_duty: float,
    least_ohm: float,
    energy_j: float,
    decay: Decay,
    allowed: Allowed,
) -> tuple[Signal, ...] | None:
    """The most bits that the board holds and whose chips are long enough; None: it holds none."""
    each = seconds / 2
    for bits in BITS:
        if bits > min(BITS) and each / (2**bits - 1) < LINE * bench.period_s:
            continue
        shape = tuple(Signal(a, bits, each, decay) for a in (SMALL * top_duty, top_duty))
        less = min(1.0, (energy_j / _heat(bench, shape, least_ohm)) ** 0.5)
        signals = tuple(replace(s, amplitude=_rounded(less * s.amplitude)) for s in shape)
        program = _program(signals, _heat(bench, signals, least_ohm))
        if allowed(replace(program, rotor=Rotor.CLAMPED)):
            return signals
    return None


def _rounded(duty: float) -> float:
    """Down, to what the wire carries exactly."""
    return float(np.floor(duty * 1e4) / 1e4)


def _heat(bench: Bench, signals: Sequence[Signal], ohms: float) -> float:
    rail = bench.wiring.supply_voltage_v
    return sum((s.amplitude * rail) ** 2 * s.seconds for s in signals) / ohms


def _program(signals: Sequence[Signal], heat_j: float) -> Program:
    steps = (Step(StepKind.COAST, REST_S), *(step for s in signals for step in s.steps))
    return Program(steps, Rotor.ASK, float(f"{1.02 * heat_j:.3g}"))


def _promises(
    bench: Bench, program: Program, motor: Motor, wants: Sequence[Want], rated_a: float | None
) -> tuple[Promise, ...]:
    """Half widths of 95 % intervals over the sorts of iron, relative."""
    reached = [_reached(bench, program, motor, sort, rated_a) for sort in SORTS]
    out = []
    for want in wants:
        each = [one[want.name] for one in reached]
        worst = max(each)
        out.append(Promise(want, worst[0], each[0][0], worst[1], ""))
    return tuple(out)


def _reached(
    bench: Bench,
    program: Program,
    motor: Motor,
    sort: tuple[float, float, float],
    rated_a: float | None,
) -> dict[str, tuple[float, float]]:
    """By measurand: half the relative 95 % interval, and the instruments' part of it."""
    still = dict(zip(("K", "B", "J", "T0"), (1.0, 0.0, 1.0, HOLDS), strict=True))
    stands = replace(motor, K=1.0, B=0.0, J=1.0, T0=HOLDS)
    run = skeleton(bench, program, stands)
    capture = stilled(replace(run, stated=Stated({"rated_current_a": rated_a} if rated_a else {})))
    start = {"R": motor.R, "L": motor.L, **still, **_iron(bench, motor, sort)}
    blank = _begun(capture, start, still)
    capture = _as_read(capture, blank)
    begun = _begun(capture, start, still)
    fitted = begun.roughly(ROUGH)
    found = findings(fitted, still, ())
    told = parameters(found, fitted)
    out = {}
    for name in WANTED:
        p = told[name]
        if p.value is None or p.interval_95 is None or p.instrument is None:
            out[name] = (float("inf"), 0.0)
            continue
        half = (p.interval_95[1] - p.interval_95[0]) / 2
        out[name] = (half / p.value, 1.96 * p.instrument / p.value)
    return out


def _iron(bench: Bench, motor: Motor, sort: tuple[float, float, float]) -> dict[str, float]:
    """A motor's iron that loses a share of L at the stall current of the rail."""
    shielded, lost, time_s = sort
    stall = bench.wiring.supply_voltage_v / motor.R
    return {"d_L": 1.25 * lost, "i_L": stall / 2, "L2_share": shielded, "t_e": time_s}


def _begun(capture: Capture, start: Mapping[str, float], still: Mapping[str, float]) -> Begun:
    free = locked_rotor.ELECTRICAL
    records = [MotorRecord(capture, free, still)]
    plain = maximise(unknowns_of(records, free, start), records, enough=ROUGH)
    return begin(records, plain, IRON, fixed=still, start={**merged(still, plain), **start})


def _as_read(capture: Capture, begun: Begun) -> Capture:
    """With the current that the motor with iron would show, its noise as it was."""
    record = begun.records[0]
    plain = MotorRecord(capture, locked_rotor.ELECTRICAL, begun.start)
    shared = np.array([begun.start[n] for n in begun.free])
    own = np.array([u.start for u in record.unknowns])
    six = plain.fitted(shared[:2], np.array([u.start for u in plain.unknowns]))
    raw = np.array(capture.channels[CURRENT].raw, dtype=np.float64)
    for m, wide, narrow in zip(record.measured, record.fitted(shared, own), six, strict=True):
        if m.block.name == CURRENT:
            raw[m.keep] += np.rint((wide - narrow) / capture.channels[CURRENT].scale)
    channel = replace(capture.channels[CURRENT], raw=raw)
    return replace(capture, channels={**capture.channels, CURRENT: channel})
