"""What a person should know of a rig before it drives a motor, in sentences."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from motorid.rig import Rig

KEYS = {
    "R": "resistance_ohm",
    "L": "inductance_h",
    "K": "torque_constant_nm_a",
    "J": "inertia_kg_m2",
    "V": "voltage_v",
}
# what people copy from data sheets without their unit, over the SI unit
COPIED = {
    "R": {1e-3: "mohm", 1e3: "kohm"},
    "L": {1e-3: "mH", 1e-6: "µH"},
    "K": {1e-3: "mN·m/A", 9.5493e-3: "V/krpm", 7.0616e-3: "oz·in/A", 1e-2: "N·cm/A"},
    "J": {1e-7: "g·cm²", 1e-4: "kg·cm²", 7.0616e-3: "oz·in·s²"},
    "V": {1e-3: "mV"},
}
UNUSUAL, USUAL = 15.0, 8.0  # distance from the catalogue, and from all motors: looked at; explained
AS_WELL = 1.0  # another unit, within so much of the best, is asked for too


def doubts(rig: Rig) -> Iterator[str]:
    """An old calibration, and a nameplate that no motor can have."""
    from motorid.workflow.record import old_calibration

    if sentence := old_calibration(rig):
        yield sentence
    if sentence := nameplate_doubt(rig):
        yield sentence


def nameplate_doubt(rig: Rig) -> str:
    """A sentence where the nameplate's figures go together in no motor; "" where they may."""
    from motorid.acquire.safety import program_volts
    from motorid.estimate.diagnosis.facts.catalogue import Figures, distance

    plate = rig.nameplate
    known = {name: getattr(plate, key) for name, key in KEYS.items()}
    volts = known["V"] or max(program_volts(rig, rig.program), default=0.0)
    if None in (known["R"], known["K"], known["J"]) or not volts > 0:
        return ""

    def far(of: dict[str, float | None], wide: bool = False) -> float:
        return distance(Figures(of["V"] or volts, of["R"] or 0.0, of["K"] or 0.0, of["J"] or 0.0,
                                of["L"]), wide)  # fmt: skip

    if min(far(known), far(known, wide=True)) <= UNUSUAL:
        return ""
    tried = [
        (far({**known, name: value * size}), name, unit)
        for name, value in known.items()
        if value is not None
        for size, unit in COPIED[name].items()
    ]
    tried.sort()
    near = [(name, unit) for off, name, unit in tried if off - tried[0][0] < AS_WELL]
    guess = " or ".join(f"{KEYS[name]} in {unit}" for name, unit in near)
    shown = ", ".join(f"{KEYS[n]} = {v:g}" for n, v in known.items() if v is not None)
    why = f": is {guess}?" if tried[0][0] < USUAL else ": check their units"
    return f"the figures of [nameplate] go together in no motor ({shown}){why}"
