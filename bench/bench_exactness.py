"""How exact the fit is: against the Cramér-Rao bound, and on the simulated rig.

python bench/bench_exactness.py            all parts, full size
python bench/bench_exactness.py --part 1   noisy captures from the exact model
python bench/bench_exactness.py --part 2   every preset of the simulated rig
python bench/bench_exactness.py --part 3   the cost of one response
(--captures, --count, --seeds and --motor, a beginning of its name, make them smaller)

Prints one row for each quantity and ends with 1 when a goal is missed.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import timeit
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from motorid.acquire.record import capture as record
from motorid.capture import store
from motorid.capture.model import CURRENT, POSITION, VOLTAGE, Capture, Wiring
from motorid.estimate.effects.brush_and_heating import lossless
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS, Estimate
from motorid.motor.reading import Output, Quantity
from motorid.motor.response import Response
from motorid.motor.wide import AT_REST, LANES, NAMES, WideResponse
from motorid.rig import Limits, Nameplate, Rig, Sampling, default_program
from motorid.sim import truth
from motorid.sim.motor import motors
from motorid.sim.options import parse_url
from tests.exact_capture import FAULHABER, Plan, clean_capture, noisy
from tests.six_parameters import fit

MOTORS = (
    FAULHABER,
    {"R": 8.4, "L": 1.16e-3, "K": 0.042, "B": 5e-6, "J": 4e-6, "T0": 2e-3},
    {"R": 1.2, "L": 340e-6, "K": 38.9e-3, "B": 8e-6, "J": 6.81e-6, "T0": 3e-3},
)
VOLTS = ((6.0, 3.0), (15.0, 6.0), (12.0, 4.0))
RMS_GOAL, COVERAGE_GOAL = 1.07, (0.93, 0.97)
SCALE_GOAL = {"R": 1.0, "K": 1.0, "J": 1.0, "L": 3.0, "B": 3.0, "T0": 3.0}  # percent


def bound(capture: Capture, truth: dict[str, float], sigmas: dict[str, float]) -> np.ndarray:
    """Cramér-Rao relative standard deviations of the six, nuisances unknown, by central steps."""
    record = MotorRecord(capture, PARAMETERS, {})
    values = np.array([truth[name] for name in PARAMETERS])
    own = np.array([0.0] * len(record.unknowns))
    weights = [1.0 / sigmas[m.block.name] for m in record.measured]

    def model(v: np.ndarray, o: np.ndarray) -> np.ndarray:
        return np.concatenate(
            [y * w for y, w in zip(record.fitted(v, o), weights, strict=True)]
        ).copy()

    columns = []
    for k in range(len(values)):
        step = np.zeros(len(values))
        step[k] = 1e-5 * values[k]
        columns.append((model(values + step, own) - model(values - step, own)) / 2e-5)
    for k, unknown in enumerate(record.unknowns):
        step = np.zeros(len(own))
        step[k] = 1e-6 * unknown.scale
        columns.append((model(values, own + step) - model(values, own - step)) / 2.0)
    J = np.array(columns)
    scale = np.sqrt((J**2).sum(axis=1))
    J = J / scale[:, None]
    covariance = np.linalg.inv(J @ J.T) / np.outer(scale, scale)
    return np.sqrt(np.diag(covariance))[: len(values)]


def errors(estimate: Estimate, truth: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
    """Relative errors of the six (NaN: not given), and whether the intervals hold the truth."""
    off, held = [], []
    for name in PARAMETERS:
        p = estimate.parameters[name]
        off.append(np.nan if p.value is None else p.value / truth[name] - 1.0)
        low, high = p.interval_95 or (-np.inf, np.inf)
        held.append(low <= truth[name] <= high)
    return np.array(off), np.array(held)


def exact_model(captures: int, count: int) -> bool:
    """RMS error over the bound, and coverage, on captures that obey the model."""
    ratios, covered = [], []
    each = -(-captures // len(MOTORS))
    for k, (motor, volts) in enumerate(zip(MOTORS, VOLTS, strict=True)):
        clean = lossless(clean_capture(motor, Plan(volts=volts, count=count)))
        stall = volts[0] / motor["R"]
        sd = {CURRENT: 2e-3 * stall, POSITION: 3e-3, VOLTAGE: 1e-3 * volts[0]}
        sigmas = {CURRENT: sd[CURRENT], POSITION: sd[POSITION], "back_emf": sd[VOLTAGE]}
        least = bound(clean, motor, sigmas)
        for seed in range(k * each, (k + 1) * each):
            noisy_one = noisy(clean, seed, sd[CURRENT], sd[POSITION], sd[VOLTAGE])
            off, held = errors(fit([noisy_one]), motor)
            ratios.append(off / least)
            covered.append(held)
    rms = np.sqrt(np.mean(np.square(ratios), axis=0))
    coverage = np.mean(covered, axis=0)
    print(f"{len(ratios)} captures of {count} samples from the exact model, {len(MOTORS)} motors")
    good = True
    for name, ratio, share in zip(PARAMETERS, rms, coverage, strict=True):
        ok = bool(ratio <= RMS_GOAL and COVERAGE_GOAL[0] <= share <= COVERAGE_GOAL[1])
        good &= ok
        print(
            f"  {name:<3} RMS error {ratio:.3f} x bound (at most {RMS_GOAL})"
            f"   95 % intervals hold {share:.1%} (93 to 97 %)   {'ok' if ok else 'MISSED'}"
        )
    return good


def rig_of(preset: str, seed: int) -> Rig:
    """A bench around a simulated motor: 12 bits over 1.5 x stall current, 2048 counts, 10 kHz."""
    url = f"sim://?motor={preset}&seed={seed}&speed=max"
    motor = parse_url(url).preset
    top = motor.voltage_v / motor.torque_constant_nm_a
    idle = (motor.coulomb_nm + motor.viscous_nm_s * top) / motor.torque_constant_nm_a
    plate = Nameplate(
        motor.resistance_ohm,
        motor.inductance_h,
        motor.torque_constant_nm_a,
        motor.inertia_kg_m2,
        idle,
        motor.voltage_v,
    )
    bridge = 2 * motor.switch_resistance_ohm
    return Rig(
        name=preset,
        port=url,
        wiring=Wiring(bridge, 0.1 * bridge, counts_per_turn=2048),
        limits=Limits(
            1.45 * motor.stall_current_a, 1.4 * top, 0.5 * motor.supply_v, 1.5 * motor.supply_v
        ),
        nameplate=plate,
        sampling=Sampling(10_000.0, ("current", "terminal_voltage", "position")),
        program=default_program(plate),
        supply_voltage_v=motor.supply_v,
        ambient_c=23.0,
    )


def simulated(seeds: int, begins: str = "") -> bool:
    """Median error over ``seeds`` of every preset whose name ``begins`` so; and the coverage."""
    print(f"simulated rig, everything on but cogging, brush drop and ripple; {seeds} seeds a motor")
    good, covered = True, []
    with tempfile.TemporaryDirectory() as folder:
        for preset in (name for name in motors() if name.startswith(begins)):
            off = []
            for seed in range(seeds):
                rig = rig_of(preset, seed)
                path = record(rig, rig.program, Path(folder) / "run.h5", force=True)
                error, held = errors(fit([store.load(path)]), truth(rig.port))
                off.append(error)
                covered.append(held)
            median = 100 * np.median(np.abs(off), axis=0)
            goals = np.array([SCALE_GOAL[name] for name in PARAMETERS])
            good &= (ok := bool((median <= goals).all()))
            figures = "  ".join(
                f"{name} {m:.2f}" for name, m in zip(PARAMETERS, median, strict=True)
            )
            print(f"  {preset:<22} median error %: {figures}   {'ok' if ok else 'MISSED'}")
    shares = "  ".join(
        f"{name} {share:.0%}"
        for name, share in zip(PARAMETERS, np.mean(covered, axis=0), strict=True)
    )
    print(f"  95 % intervals hold: {shares}")
    return good


def response_cost() -> bool:
    """One response of 10,000 samples against one pass of a second-order filter of that length."""
    capture = lossless(clean_capture(FAULHABER, Plan(count=10_000)))
    start = MotorRecord(capture, PARAMETERS, {})
    volts = start.volts.copy()
    outputs = [Output(Quantity.CURRENT, 5e-5, 2e-6), Output(Quantity.POSITION)]
    response = Response(1e-4, volts, outputs, start.stretches)
    motor = tuple(FAULHABER.values())

    def fastest(call: Callable[[], object], times: int = 300) -> float:
        return min(timeit.repeat(call, number=1, repeat=times))

    one_pass = fastest(lambda: lfilter([0.1, 0.2, 0.1], [1.0, -0.5, 0.1], volts))
    ours = fastest(lambda: response(motor))
    fit_s = fastest(lambda: fit([noisy(capture, 1, 5e-3, 3e-3, 6e-3)]), 10)
    print(
        f"one response of 10,000 samples: {1e6 * ours:.0f} µs, "
        f"{ours / one_pass:.2f} x an lfilter pass (at most 3)"
    )
    print(f"six parameters of that capture fitted, with report: {1e3 * fit_s:.0f} ms")
    return ours <= 3 * one_pass


def side_by_side() -> None:
    """Responses of a motor with iron, as many as there are lanes, against one after the other."""
    capture = lossless(clean_capture(FAULHABER, Plan(count=10_000)))
    start = MotorRecord(capture, PARAMETERS, {})
    iron = {"reaction": 0.05, "reaction_bend": 0.1, "eddy": 0.3, "eddy_time": 1e-4}
    motor = np.array([{**FAULHABER, **iron}.get(name, 0.0) for name in NAMES])
    outputs = [Output(Quantity.CURRENT, 5e-5, 2e-6), Output(Quantity.POSITION)]
    response = WideResponse(1e-4, start.volts.copy(), outputs, start.stretches)
    response.plan(motor)
    runs = [response.pose(motor * (1.0 + 1e-4 * k), AT_REST) for k in range(max(LANES, 2))]
    together = min(timeit.repeat(lambda: response.several(runs), number=1, repeat=30))
    alone = min(
        timeit.repeat(lambda: [response(r.motor, r.initial) for r in runs], number=1, repeat=30)
    )
    print(
        f"{len(runs)} responses with iron side by side: {alone / together:.2f} x as fast as in turn"
    )


def main() -> int:
    """Runs the parts asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--part", type=int, choices=(1, 2, 3), action="append")
    parser.add_argument("--captures", type=int, default=1000)
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--motor", default="", help="of part 2: only names that begin so")
    args = parser.parse_args()
    parts = args.part or [1, 2, 3]
    good = True
    if 1 in parts:
        good &= exact_model(args.captures, args.count)
    if 3 in parts:
        good &= response_cost()
        side_by_side()
    if 2 in parts:
        good &= simulated(args.seeds, args.motor)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
