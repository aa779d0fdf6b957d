"""One record of a rig: what is true, what the fits said, what could be known, what was drawn."""

from __future__ import annotations

import math
import time
import traceback
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench.coverage.bound import BRUSH, NAMES, Brush, linearised
from bench.coverage.cost import counted
from bench.coverage.moved import moves
from bench.coverage.naive import forget_chain
from bench.coverage.rigs import Bench, draw_bench
from bench.coverage.runs import Runs, kept, record, save
from bench.coverage.tables import COLD
from bench.iron import present
from motorid.capture.model import Capture
from motorid.errors import MotoridError
from motorid.estimate.assembly.doubt import grown
from motorid.estimate.results.estimate import AUTO, SIX, Alternative, Estimate, Parameter
from motorid.identify import fit

Row = dict[str, Any]


@dataclass(frozen=True)
class How:
    """How rigs are scored: in which ``folder`` captures go and stay, and without which effects.

    ``parts`` of a record that are made: "bound", "fit", "naive", and "auto": "headline", the six
    parameters as a report states them, and "better", what it recommends, the better model's answer
    where one is offered. ``effects``: motors have some of those of ``bench.iron``.
    """

    folder: Path
    parts: tuple[str, ...] = ("bound", "fit", "naive")
    without: tuple[str, ...] = ()
    effects: bool = False
    keep: bool = False


def score(seed: int, how: How) -> Row:
    """The record of the rig of that seed. Never raises: what went wrong is in it."""
    row: Row = {"seed": seed}
    try:
        bench = draw_bench(seed, how.without, how.effects)
        row |= _drawn(bench)
        runs = _runs(bench, how)
        row |= {"truth": dict(runs.truth), "winding_c": runs.winding_c}
        row["samples"] = sum(len(capture) for capture in runs.captures)
        if "bound" in how.parts:
            late = bench.options.delay_uncertainty
            brush = Brush(bench.options.brush_drop, bench.drawn.brush_current_a)
            at = linearised(runs.captures, runs.truth, late, brush, bench.added)
            row["bound"], row["wide_bound"] = at.bound(without=BRUSH), at.bound()
            if bench.added:
                row["moves"] = moves(runs.captures, at, bench.added)
        if "fit" in how.parts:
            row["fit"] = _fitted(runs.captures, runs)
        if "auto" in how.parts:
            row |= _by_both(runs.captures, runs)
        if "naive" in how.parts:
            row["naive"] = _fitted([forget_chain(c) for c in runs.captures], runs)
    except MotoridError as error:
        row["refused"] = f"{type(error).__name__}: {error}"
    except Exception as error:  # a study goes on; the record says what broke
        row["crashed"] = "".join(traceback.format_exception(error))[-2000:]
    return row


def _runs(bench: Bench, how: How) -> Runs:
    """The rig's captures: those that were kept, or new ones."""
    if not how.keep:
        return record(bench, how.folder)
    runs = kept(how.folder, bench.seed)
    if runs is None:
        runs = record(bench, how.folder)
        save(runs, how.folder, bench.seed)
    return runs


def _fitted(captures: Sequence[Capture], runs: Runs) -> Row:
    """What the six parameters alone say."""
    estimate, cost = _estimate(captures, SIX)
    return _said(estimate, runs) | cost if isinstance(estimate, Estimate) else estimate


def _by_both(captures: Sequence[Capture], runs: Runs) -> Row:
    """The headline, and what the report recommends."""
    estimate, cost = _estimate(captures, AUTO)
    if not isinstance(estimate, Estimate):
        return {"headline": estimate, "better": estimate}
    better, headline = estimate.alternative, _said(estimate, runs) | cost
    if better is None:
        return {"headline": headline, "better": headline}
    by_ripple = _by_ripple(estimate) and "eddy" not in better.terms
    values = _parameters({**better.parameters, **better.at_25}, runs, by_ripple)
    said = {"terms": list(better.terms), "parameters": values, "sizes": _sizes(better)}
    return {"headline": headline, "better": said}


def _sizes(better: Alternative) -> Row:
    """Every added parameter in its total standard uncertainties."""
    added = {name: p for name, p in better.parameters.items() if name not in NAMES}
    return {name: p.value / p.total for name, p in added.items() if p.value and p.total}


def _estimate(captures: Sequence[Capture], model: str) -> tuple[Estimate | Row, Row]:
    """The estimate or what went wrong, and what it cost: processor time and responses."""
    began, found = time.process_time(), {}
    try:
        with counted() as count:
            estimate = fit(captures, model=model)
        seconds = round(time.process_time() - began, 3)
        return estimate, {"seconds": seconds, "responses": count.responses}
    except MotoridError as error:
        found["refused"] = f"{type(error).__name__}: {error}"
    except Exception as error:
        found["crashed"] = "".join(traceback.format_exception(error))[-2000:]
    return found, {}


def _said(estimate: Estimate, runs: Runs) -> Row:
    """Values, remarks and budgets. ``half``: of each interval before findings widened it."""
    values = _parameters({**estimate.parameters, **estimate.at_25}, runs, _by_ripple(estimate))
    told = [name for name in NAMES if values.get(name, {}).get("off") is not None]
    half = {name: _bare_half(estimate, name, values[name]) for name in told}
    return {
        "parameters": values,
        "half": half,
        "diagnostics": [d.code for d in estimate.diagnostics],
        "budget": {name: dict(shares) for name, shares in estimate.budget.items()},
    }


def _bare_half(estimate: Estimate, name: str, value: Row) -> float:
    """Half of the interval before findings widened it, relative to the truth."""
    p, (low, high) = estimate.parameters[name], value["interval"]
    assert p.interval_95 is not None
    half = (p.interval_95[1] - p.interval_95[0]) / 2.0
    share = grown(p, estimate.budget.get(name, {})) / half if half else 0.0
    return float((high - low) / 2.0 * (1.0 - share))


def _by_ripple(estimate: Estimate) -> bool:
    """It says that its inductance is the one at the PWM frequency."""
    return any(d.code == "inductance_by_ripple" for d in estimate.diagnostics)


def _parameters(found: Mapping[str, Parameter], runs: Runs, by_ripple: bool) -> Row:
    """Each against the truth of what it is said to be."""
    truth = dict(runs.truth) | ({"L": runs.truth["L_pwm"]} if by_ripple else {})
    return {name: _one(found[name], truth[name]) for name in (*NAMES, COLD) if name in found}


def _one(p: Parameter, truth: float) -> Row:
    """Relative error and interval, and whether it holds the truth; nothing where not given."""
    if p.interval_95 is None:
        return {"status": p.status}
    low, high = p.interval_95
    return {
        "status": p.status,
        "off": None if p.value is None else p.value / truth - 1.0,
        "statistical": _share(p.statistical, truth),
        "instrument": _share(p.instrument, truth),
        "total": _share(p.total, truth),
        "interval": [low / truth - 1.0, high / truth - 1.0],
        "holds": low <= truth <= high,
    }


def _share(value: float | None, truth: float) -> float | None:
    return None if value is None else value / truth


def _drawn(bench: Bench) -> Row:
    """What was drawn, as figures without a unit that a miss may be held against."""
    motor, options, said, board = bench.drawn.motor, bench.options, bench.stated, bench.rigs[0]
    R = motor.resistance_ohm
    rate = board.sampling.rate_hz
    return {
        "power_w": bench.drawn.power_w,
        "sense": said.sense,
        "decay": said.decay,
        "by_duty": any(step.kind.name == "DRIVE_DUTY" for step in board.program.steps),
        "window": "instant" if options.phase is not None else "mean",
        "effects": list(present(bench.iron)),
        "feature": {
            "log power": math.log10(bench.drawn.power_w),
            "brush drop / V": options.brush_drop / motor.voltage_v,
            "cogging / T0": options.cogging / motor.coulomb_nm,
            "ripple": options.ripple,
            "stiction - 1": options.stiction - 1,
            "stribeck / no-load speed": options.stribeck
            / (motor.voltage_v / motor.torque_constant_nm_a),
            "bridge error / u": ((options.bridge_resistance or 0.0) - said.bridge_ohm)
            / said.bridge_u,
            "lead error / u": (options.lead_resistance - said.lead_ohm) / said.lead_u,
            "bridge / R": said.bridge_ohm / R,
            "dead time * pwm": options.dead_time * options.pwm,
            "diode drop": options.diode_drop,
            "supply sag": (options.supply_resistance or 0.0) / R,
            "supply tau / tau": (options.supply_resistance or 0.0)
            * (options.supply_capacitance or 0.0) / (R * motor.inertia_kg_m2)
            * motor.torque_constant_nm_a**2,
            "L/R in samples": motor.inductance_h / R * rate,
            "tau in samples": R * (motor.inertia_kg_m2 + options.load_inertia)
            / motor.torque_constant_nm_a**2 * rate,
            "log counts": math.log10(options.counts_per_turn),
            "bits": options.bits,
            "noise": options.noise,
            "aperture / period": options.aperture * rate,
            "pwm / rate": options.pwm / rate,
            "friction / stall": motor.coulomb_nm / motor.torque_constant_nm_a
            / motor.stall_current_a,
            "heating at stall": motor.voltage_v**2 / R * motor.winding_k_w / motor.winding_s,
            "clock ppm": options.clock_uncertainty,
            "current gain u": options.gain_uncertainty,
            "voltage gain u": options.voltage_gain_uncertainty,
            "delay u": options.delay_uncertainty,
        },
    }  # fmt: skip
