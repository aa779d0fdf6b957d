"""A rig and what is asked of it -> the program to run, and the rig file that runs it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import parse_qs, urlsplit

from motorid.errors import RigError

if TYPE_CHECKING:
    from motorid.capture.model import Channel
    from motorid.estimate.diagnosis.identifiability import Excitation
    from motorid.estimate.results.estimate import Estimate
    from motorid.plan.motors import Spread
    from motorid.plan.propose import Plan
    from motorid.plan.skeleton import Bench
    from motorid.program import Decay, Program
    from motorid.quality.product import Product
    from motorid.rig import Rig

ROOM = 0.9  # of a rig's limit: what a plan uses at most
LINE_SHARE = 0.85  # of the link that samples may fill
ZERO_SAMPLES = 1000  # of the run's own offsets, at most rates
SAMPLES_OF_A_START = 3.0  # in a mechanical time constant: fewer show levels only
Fields = Mapping[str, Any]


@dataclass(frozen=True)
class Board:
    """What a board says of itself; nothing moved to learn it."""

    identity: Fields
    descriptors: Mapping[str, Fields]


def plan_run(
    rig: Rig,
    wants: Sequence[str],
    *,
    first: Path | None = None,
    product: Product | None = None,
) -> Plan:
    """The shortest program that reaches ``wants`` (R=1%), or a product's limits, on this rig.

    It holds for all motors that the nameplate, the product's limits, or a first run leave possible.
    Raises RigError, LinkError, DataError or UsageError.
    """
    from motorid.plan.motors import middle, motors
    from motorid.plan.propose import propose
    from motorid.plan.wants import USUAL, Demand, wanted
    from motorid.quality.tolerance import demand_of, spread_of

    spread, board, templates = _known(rig, first)
    if product is not None:
        spread = spread_of(product, spread)
        demand = demand_of(product)
        if wants:
            demand = replace(demand, wants=wanted(wants, middle(spread)))
    else:
        demand = Demand(wanted(wants or USUAL, middle(spread)))
    _refuse_hidden([want.name for want in demand.wants], templates)
    benches = benches_of(rig, board, templates)
    worst = _worst(rig, spread)
    return propose(
        benches,
        _top_volts(rig, spread, product),
        decay_of(board),
        motors(spread),
        demand,
        lambda program, period: allows(worst, program, board, period),
    )


def _known(rig: Rig, first: Path | None) -> tuple[Spread, Board, dict[str, Channel]]:
    """Ranges of the motor's parameters, the board, and its channels: from a first run, or asked."""
    from motorid.capture import store
    from motorid.estimate.results.estimate import SIX
    from motorid.identify import fit
    from motorid.plan.motors import of_estimate, of_nameplate

    if first is None:
        board = ask(rig)
        return of_nameplate(rig.nameplate), board, templates_of(rig, board)
    capture = store.load(first)
    told: Estimate = fit([capture], model=SIX)
    try:
        otherwise: Spread = of_nameplate(rig.nameplate)
    except RigError:
        otherwise = _of_values(told)
    identity = capture.provenance.get("identity")
    board = Board(identity, capture.provenance.get("descriptors", {})) if identity else ask(rig)
    return of_estimate(told, otherwise), board, dict(capture.channels)


def _of_values(told: Estimate) -> Spread:
    """Ranges where there is no nameplate: what the first run told must stand in for it."""
    from motorid.estimate.results.estimate import PARAMETERS

    lacking = [n for n in PARAMETERS if not told.parameters[n].value]
    if lacking:
        raise RigError(
            f"the first run does not tell {', '.join(lacking)}, and the rig's nameplate lacks "
            "figures to go by: complete [nameplate], roughly"
        )
    return {n: (float(told.parameters[n].value or 0),) * 2 for n in PARAMETERS}


def _refuse_hidden(names: Sequence[str], channels: Iterable[str]) -> None:
    """Raises RigError where these channels hide a parameter however the motor is driven."""
    from motorid.capture.model import SUPPLY
    from motorid.estimate.diagnosis.identifiability import Excitation, advice, assess

    run = Excitation(frozenset((*channels, SUPPLY)))  # a plan commands volts, so they are known
    hidden = [name for name in names if name in assess(run).missing]
    if hidden:
        raise RigError(
            f"no program tells {', '.join(hidden)} through {', '.join(sorted(channels))}. "
            f"{advice(run)}"
        )


def ask(rig: Rig) -> Board:
    """Identity and channels of the rig's board. Raises LinkError; nothing moves."""
    from motorid.acquire.board import Board as Client
    from motorid.acquire.port import open_port

    port = open_port(rig.port)
    try:
        client = Client(port)
        client.identify()
        return Board(client.identity, client.descriptors)
    finally:
        port.close()


def templates_of(rig: Rig, board: Board) -> dict[str, Channel]:
    """Channels without readings, by the board's descriptors and the rig's calibration."""
    import numpy as np

    from motorid.acquire import channels
    from motorid.acquire.plan import configuration
    from motorid.capture.model import POSITION
    from motorid.rig import Calibration

    configuration(rig, board.identity, board.descriptors)  # refuses what the board cannot do
    found = {}
    for name in rig.sampling.channels:
        fact = board.descriptors[name]
        if name == POSITION:
            found[name] = channels.position(np.zeros(1), fact, rig.wiring.counts_per_turn)
            continue
        known = rig.calibration.get(name, Calibration())
        key = channels.ZEROED.get(name)
        zero = {f"{key}_offset": fact["offset"], f"{key}_noise": fact["noise"]} if key else {}
        counts = channels.offset_of(name, fact, zero, ZERO_SAMPLES, known)
        found[name] = channels.analogue(name, np.zeros(1), fact, known, counts, rig.voltage_sense)
    return found


def benches_of(rig: Rig, board: Board, templates: Mapping[str, Channel]) -> list[Bench]:
    """One for the rig's own rate, as far as the link carries it, and one for the fastest."""
    from motorid.acquire.clock_check import of_identity
    from motorid.acquire.plan import sample_period
    from motorid.plan.skeleton import Bench

    identity = board.identity
    clock_hz, uncertainty, _ = of_identity(identity, rig.clock_rate, rig.clock_uncertainty)
    wiring = replace(
        rig.wiring,
        pwm_hz=float(identity["pwm_hz"]),
        dead_time_s=identity["dead_time_ns"] * 1e-9,
        supply_voltage_v=rig.supply_voltage_v or 0.0,
    )
    fastest = _shortest_period(rig, identity)
    periods = sorted({fastest, max(sample_period(rig, identity), fastest)}, reverse=True)
    return [Bench(templates, clock_hz, period, wiring, uncertainty) for period in periods]


def _shortest_period(rig: Rig, identity: Fields) -> int:
    """Ticks between samples: what the converter allows and the link carries."""
    from motorid.wire.render_docs import bytes_a_sample
    from motorid.wire.spec import load

    step, least = (
        int(identity["sample_period_step_ticks"]),
        int(identity["min_sample_period_ticks"]),
    )
    ticks = float(least)
    if rig.sampling.mode == "stream":
        options = parse_qs(urlsplit(rig.port).query)
        baud = float(options.get("baud", [str(load().baud)])[-1])
        bytes_s = LINE_SHARE * baud / 10.0
        if bytes_s:
            carried = bytes_s / bytes_a_sample(load(), len(rig.sampling.channels))
            ticks = max(ticks, identity["clock_hz"] / carried)
    return -int(-ticks // step) * step


def _worst(rig: Rig, spread: Spread) -> Rig:
    """The rig with the label of the motor that comes nearest to its limits, and those closer."""
    limits = rig.limits
    return replace(
        rig,
        nameplate=replace(
            rig.nameplate,
            resistance_ohm=spread["R"][0],
            torque_constant_nm_a=spread["K"][0],
            inertia_kg_m2=spread["J"][1],
        ),
        limits=replace(
            limits,
            current_a=ROOM * limits.current_a,
            speed_rad_s=ROOM * limits.speed_rad_s,
            run_time_s=ROOM * limits.run_time_s,
        ),
    )


def allows(rig: Rig, program: Program, board: Board, period: int) -> bool:
    """Whether ``motorid run`` would take it: by the same checks."""
    from motorid.acquire.plan import check_burst, wire_program
    from motorid.acquire.safety import check_program

    try:
        check_program(rig, program)
        check_burst(rig, wire_program(program, board.identity, period), board.identity, period)
    except RigError:
        return False
    return True


def _top_volts(rig: Rig, spread: Spread, product: Product | None) -> float:
    """The highest voltage from rest: of label or product, supply, current and speed limits.

    In whole millivolts, as levels are, and rounded down: a limit is a limit.
    """
    limits = rig.limits
    most = [
        ROOM * limits.current_a * spread["R"][0],
        ROOM * limits.speed_rad_s * spread["K"][0],
        ROOM * (rig.supply_voltage_v or limits.supply_min_v),
    ]
    label = product.voltage_v if product else rig.nameplate.voltage_v
    return math.floor(min([*most, label] if label else most) * 1e3) / 1e3


def decay_of(board: Board) -> Decay:
    """The first that the board has: synchronous is the one that hides nothing from a fit."""
    from motorid.program import Decay

    modes = int(board.identity["decay_modes"])
    return next((d for d in Decay if d and modes >> d & 1), Decay.SYNCHRONOUS_SLOW)


def excitation(rig: Rig, program: Program) -> Excitation:
    """What the rig's channels and a program show, before any run."""
    from motorid.estimate.diagnosis.identifiability import of_program
    from motorid.rig import settling_s

    tau_s = settling_s(rig.nameplate) / 8  # a guess where the nameplate does not know it
    fine = rig.sampling.rate_hz * tau_s > SAMPLES_OF_A_START
    return of_program(program, rig.sampling.channels, fine=fine)
