"""A student's kit: whether R, K and J of many drawn rigs lie inside their stated intervals.

python bench/bench_kit.py --rigs 72 --out bench/results/kit.json
python bench/bench_kit.py --rigs 72 --emulated --out bench/results/kit_emulated.json

The rig file is the one that ``motorid init`` writes for an Uno, an L298N module, an ACS712 and an
encoder of 11 lines. The simulated board has that kit's errors, each drawn anew for every rig: the
sensor's gain (1.6 %), the 5 V reference of the dividers (2.9 %), offsets, 10 bits, a resonator's
clock, the bridge's drop and resistance. The winding stays at 25 °C, so that each rig has one R. The
six parameters alone are fitted: wider models stand beside an answer and do not change it.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
import tempfile
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np

import motorid
from motorid.acquire import record
from motorid.errors import MotoridError
from motorid.rig_front_end import load_front_end
from motorid.sim.options import parse_url
from motorid.workflow.kit import DRIVERS, Answers, kit

MOTORS = ("maxon-amax22-110147", "qube-servo", "dunkermotoren-gr42")
COUNTS = 44  # of 11 lines
DRIVER, SENSOR = "l298n", "acs712-05"
CODES, SUMMED = 1024, 4  # of the converter; conversions of one reading, as it sums them
NOISE_LSB, OFFSET_LSB = 1.3, 2.6  # of a conversion: the sensor's and the converter's
SUPPLY_OVER = 1.1  # of the motor's voltage
RANGE_V = 37.0  # of the dividers: coarser than theirs, for the simulator has it on both sides of 0
SHARED = (  # options of both benches
    "motor", "seed", "speed", "heating", "ambient", "supply", "copper", "magnet", "friction",
    "load_inertia", "bridge_drop", "bridge_resistance", "clock_uncertainty", "counts_per_turn",
)  # fmt: skip
JUDGED = ("R", "L", "K", "B", "J", "T0")
EXPECTED = {"R", "K", "J"}


def url_of(seed: int) -> tuple[str, dict[str, float]]:
    """A simulated bench with the kit's errors, and the supply and nominal motor."""
    rng = np.random.default_rng([seed, 22])
    motor = MOTORS[seed % len(MOTORS)]
    nominal = parse_url(f"sim://?motor={motor}").preset
    facts, driver = load_front_end(SENSOR).facts, DRIVERS[DRIVER]
    supply = SUPPLY_OVER * nominal.voltage_v
    lsb = facts["reference_v"] / CODES / SUMMED  # V, of a reading
    options: dict[str, Any] = {
        "motor": motor,
        "seed": seed + 1,
        "speed": "max",
        "heating": "no",
        "ambient": 25,
        "supply": round(supply, 3),
        "copper": round(rng.uniform(0.9, 1.1), 4),
        "magnet": round(rng.uniform(0.9, 1.1), 4),
        "friction": round(rng.uniform(0.7, 1.4), 4),
        "load_inertia": float(f"{rng.uniform(0.0, 2.0) * nominal.inertia_kg_m2:.4g}"),
        "bridge_drop": round(max(rng.normal(driver.drop_v, driver.drop_uncertainty_v), 0.1), 4),
        "bridge_resistance": round(max(rng.normal(driver.ohm, driver.ohm_uncertainty), 0.1), 4),
        "bits": 12,  # as four conversions of 10 make them
        "noise": NOISE_LSB * SUMMED**0.5,
        "offset_uncertainty": OFFSET_LSB * SUMMED,
        "current_range": round(2048 * lsb / facts["current_v_a"], 4),
        "voltage_range": RANGE_V,
        "gain_uncertainty": facts["current_gain_uncertainty"] * 1e-5,
        "voltage_gain_uncertainty": facts["voltage_gain_uncertainty"] * 1e-5,
        "aperture": 250e-6,
        "voltage_aperture": 250e-6,
        "current_filter": facts["current_filter"] * 1e-7,
        "voltage_filter": facts["voltage_filter"] * 1e-7,
        "clock_uncertainty": 5000,
        "counts_per_turn": COUNTS,
        "edge_ceiling": 40_000,
        "burst": 1,
    }
    url = "sim://?" + "&".join(f"{key}={value}" for key, value in options.items())
    return url, {
        "supply": supply,
        "volts": nominal.voltage_v,
        "ohm": nominal.resistance_ohm,
        "rpm": nominal.voltage_v / nominal.torque_constant_nm_a * 60 / math.tau,
    }


def emulated(url: str, seed: int) -> str:
    """The same bench with the real firmware on an emulated Uno, whose errors are drawn here.

    The sensor has the ACS712's slope and uncertainty, on the converter's usual reference.
    """
    rng = np.random.default_rng([seed, 23])
    facts = load_front_end(SENSOR).facts
    shares = [facts[f"{name}_gain_uncertainty"] * 1e-5 for name in ("current", "voltage")]
    kept = dict(pair.split("=") for pair in url.partition("?")[2].split("&"))
    options = {name: kept[name] for name in SHARED} | {
        "noise": NOISE_LSB,
        "gain_error": round(rng.normal(0.0, shares[0]), 5),
        "voltage_gain_error": round(rng.normal(0.0, shares[1]), 5),
        "driver": "bipolar",
        "divider": 8,
        "shunt": facts["current_v_a"] / 20.0,  # of the amplifier's gain
        "defines": "+".join(
            f"-D{name}_GAIN_UNCERTAINTY={share}f"
            for name, share in zip(("CURRENT", "VOLTAGE"), shares, strict=True)
        ),
    }
    return "emu://uno?" + "&".join(f"{key}={value}" for key, value in options.items())


def one(seed: int, folder: Path, emulate: bool = False) -> dict[str, Any]:
    """What came of one rig: each quantity's truth, value and interval."""
    url, known = url_of(seed)
    port = emulated(url, seed) if emulate else url
    said = Answers(
        "uno", port, DRIVER, SENSOR, COUNTS, known["supply"], "drawn", known["volts"],
        resistance_ohm=1.1 * known["ohm"], no_load_rpm=known["rpm"], ambient_c=25.0,
    )  # fmt: skip
    rig = kit(said, "kit", "").rig
    options = parse_url(url)
    motor = options.specimen
    truth = {
        "R": motor.resistance_ohm,
        "L": motor.inductance_h,
        "K": motor.torque_constant_nm_a,
        "B": motor.viscous_nm_s,
        "J": motor.inertia_kg_m2 + options.load_inertia,
        "T0": motor.coulomb_nm,
    }
    row: dict[str, Any] = {"seed": seed, "motor": options.motor, "found": {}}
    try:
        path = record.capture(rig, rig.program, folder / f"{seed}.h5")
        estimate = motorid.fit(motorid.load(path), model="six")
        path.unlink()
    except MotoridError as error:
        return row | {"error": str(error)}
    for name in JUDGED:
        found = estimate.parameters.get(name)
        if found is None or found.value is None:
            row["found"][name] = {"truth": truth[name], "status": str(found and found.status.value)}
            continue
        low, high = found.interval_95
        row["found"][name] = {
            "truth": truth[name],
            "value": found.value,
            "half": (high - low) / 2 / truth[name],
            "inside": bool(low <= truth[name] <= high),
            "status": found.status.value,
        }
    return row


def summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Of each quantity: rigs with a value, those whose interval holds the truth, median width."""
    table = {}
    for name in JUDGED:
        given = [r["found"][name] for r in rows if "inside" in r["found"].get(name, {})]
        table[name] = {
            "given": len(given),
            "inside": sum(one["inside"] for one in given),
            "share": round(sum(one["inside"] for one in given) / len(given), 4) if given else None,
            "median_half_width": round(float(np.median([one["half"] for one in given])), 4)
            if given
            else None,
        }
    return {"rigs": len(rows), "failed": sum("error" in row for row in rows), "table": table}


def main() -> int:
    """Runs the study, one rig after the other."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rigs", type=int, default=80)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--emulated", action="store_true", help="with the real firmware")
    chosen = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(chosen.first, chosen.first + chosen.rigs):
            rows.append(one(seed, Path(folder), chosen.emulated))
            print(json.dumps(rows[-1]), file=sys.stderr, flush=True)
    found = summary(rows)
    print(json.dumps(found, indent=1))
    if chosen.out:
        chosen.out.write_text(json.dumps({**found, "rows": rows}, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
