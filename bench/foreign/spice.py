"""A motor, its bridge and its supply as an ngspice netlist, one analysis for each program step.

The bridge: four MOSFETs of level 1 with body diodes and an RC snubber, complementary gates with
dead time. The supply: a resistance, an inductance, a capacitor with its series resistance. The
winding: an inductor that may saturate by its flux, x (1 + p (x/I)²) = i with x = λ/L, and an eddy
branch L2 ‖ Rc. The mechanics are an analogue circuit: J is a capacitor and the speed its voltage.
Dry friction is T0 tanh(ω/ε).
"""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.foreign.chain import Trace
from bench.foreign.drawn import Rig
from bench.iron import Iron
from motorid.program import Step, StepKind

Floats = NDArray[np.float64]
PROGRAM = "ngspice"
CREEP = 1e-3  # ε of dry friction, of the no-load speed
EDGE_S = 2e-8  # rise of a gate
SNUBBER_S = 1e-6  # RC across the bridge's output, which carries what an opened diode leaves
POINTS = 25  # of a PWM period, at least
GATE_V, THRESHOLD_V = 10.0, 2.0
SAVED = (
    "v(a)",
    "v(p)",
    "v(b)",
    "v(bus)",
    "v(w)",
    "v(th)",
    "v(x)",
    "v(y)",
    "v(bc)",
    "i(vi)",
    "v(sl)",
)
SENSED = {"terminals": ("v(p)", "v(b)"), "bridge": ("v(a)", "v(b)"), "supply": ("v(bus)", "")}
STATES = {"w": 0.0, "th": 0.0, "x": 0.0, "y": 0.0, "sl": 0.0}


class SpiceError(RuntimeError):
    """ngspice gave up, or is not there."""


def available() -> bool:
    """True where ngspice is installed."""
    return shutil.which(PROGRAM) is not None


def run(rig: Rig, folder: Path) -> Trace:
    """The rig's program from rest. Raises SpiceError with the end of what ngspice said."""
    state = STATES | {"bc": rig.supply_v}
    begun, parts = 0.0, []
    for number, step in enumerate(rig.program.steps):
        length = step.duration_s / (1 + rig.clock_error)
        table = _analysis(netlist(rig, step, length, state), length, folder, number)
        keep = slice(0 if number == 0 else 1, None)
        high, low = SENSED[rig.sense]
        volts = table[high] - (table[low] if low else 0.0)
        columns = (table["time"] + begun, table["i(vi)"], volts, table["v(w)"])
        parts.append(np.column_stack(columns)[keep])
        state = {name: float(table[f"v({name})"][-1]) for name in state}
        begun += length
    return Trace(*np.concatenate(parts).T)


def netlist(rig: Rig, step: Step, length_s: float, state: dict[str, float]) -> str:
    """The circuit of one step, from that state (V) of its capacitors on."""
    period = 1.0 / rig.pwm_hz / (1 + rig.clock_error)
    longest = period / POINTS
    return "\n".join((
        f"* rig {rig.seed}",
        *_supply(rig, state),
        *_bridge(rig, step, period),
        *_winding(rig, state),
        *_mechanics(rig, state),
        ".options reltol=1e-4 abstol=1e-9 vntol=1e-6 chgtol=1e-16 method=trap",
        f".tran {longest:.9g} {length_s:.12g} 0 {longest:.9g} uic",
        f".save {' '.join(SAVED)}",
        ".end\n",
    ))  # fmt: skip


def _supply(rig: Rig, state: dict[str, float]) -> list[str]:
    """Its inductance is a current that follows the flux, and the flux a capacitor's voltage."""
    ohm, farad = rig.supply_ohm, rig.supply_f
    henry = ohm**2 * farad / 2
    return [
        f"Vs s0 0 {rig.supply_v:.9g}",
        f"Rs s0 s1 {ohm:.9g}",
        f"Bsl s1 bus I=v(sl)/{henry * 1e3:.9g}",
        "Bslv 0 sl I=v(s1,bus)",
        f"Csl sl 0 1e-3 IC={state['sl']:.12g}",
        f"Rc bus bc {ohm / 3:.9g}",
        f"Cc bc 0 {farad:.9g} IC={state['bc']:.12g}",
    ]


def _bridge(rig: Rig, step: Step, period: float) -> list[str]:
    kp = 1.0 / (rig.bridge_ohm / 2 * (GATE_V - THRESHOLD_V))
    gates = _gates(step, period, rig.dead_s)
    lines = [
        f".model nm nmos(level=1 vto={THRESHOLD_V} kp={kp:.9g} is=1e-20)",
        f".model db d(is={1e-9 * rig.stall_a:.4g} n=1.3 rs={rig.bridge_ohm / 4:.6g} "
        f"cjo={1e-11 * rig.stall_a:.3g})",
    ]
    for leg in ("a", "b"):
        lines += [
            f"Mh{leg} bus gh{leg} {leg} {leg} nm", f"Ml{leg} {leg} gl{leg} 0 0 nm",
            f"Dh{leg} {leg} bus db", f"Dl{leg} 0 {leg} db",
            f"Vgh{leg} gh{leg} {leg} {gates['h' + leg]}", f"Vgl{leg} gl{leg} 0 {gates['l' + leg]}",
        ]  # fmt: skip
    damper = rig.truth["L"] / SNUBBER_S
    return [*lines, f"Rd a d1 {damper:.6g}", f"Cd d1 b {SNUBBER_S / damper:.6g} IC=0"]


def _gates(step: Step, period: float, dead: float) -> dict[str, str]:
    """Sources of the four gates. A drive switches one leg and holds the other leg's low switch."""
    off, on = "0", f"{GATE_V}"
    if step.kind == StepKind.COAST:
        return {"ha": off, "la": off, "hb": off, "lb": off}
    if step.kind == StepKind.BRAKE:
        return {"ha": off, "la": on, "hb": off, "lb": on}
    driven, other = ("a", "b") if step.level > 0 else ("b", "a")
    duty = abs(step.level)
    high, low = on, off
    if duty < 1.0:
        width = duty * period
        high = _pulse(dead, width - dead - EDGE_S, period)
        low = _pulse(width + dead, period - width - dead - EDGE_S, period)
    return {f"h{driven}": high, f"l{driven}": low, f"h{other}": off, f"l{other}": on}


def _pulse(delay: float, width: float, period: float) -> str:
    return f"PULSE(0 {GATE_V} {delay:.12g} {EDGE_S} {EDGE_S} {width:.12g} {period:.15g})"


def _winding(rig: Rig, state: dict[str, float]) -> list[str]:
    """x and y are λ/L (A) of the two parts of the inductance; y is eddy's."""
    iron, motor = rig.iron, rig.truth
    first, second = motor["L"] * (1 - iron.eddy), motor["L"] * iron.eddy
    lines = [
        "Vi a a1 0",
        f"Rl a1 p {rig.lead_ohm:.9g}",
        f"Rw p n1 {motor['R']:.12g}",
        f"Bx n1 n2 I=v(x)*(1+{_stiffening(rig):.9g}*v(x)*v(x))",
        "Bxv 0 x I=v(n1,n2)",
        f"Cx x 0 {first:.12g} IC={state['x']:.12g}",
    ]
    if second:
        lines += [
            f"Re n2 n3 {second / iron.eddy_s:.9g}",
            "By n2 n3 I=v(y)",
            "Byv 0 y I=v(n2,n3)",
            f"Cy y 0 {second:.12g} IC={state['y']:.12g}",
        ]
    else:
        lines += ["Vn n2 n3 0", "Ry y 0 1", "Iy y 0 0"]
    return [*lines, "Be n3 b V=v(kt)*v(w)"]


def _stiffening(rig: Rig) -> float:
    """p/I² (1/A²) such that dλ/di at the stall current has lost its share."""
    lost = rig.iron.saturation
    if not lost:
        return 0.0
    # i = x + q x³, dλ/di over L = 1/(1 + 3 q x²) = 1 - lost
    bent = lost / (1 - lost) / 3  # q x²
    return bent * (1 + bent) ** 2 / rig.stall_a**2


def _mechanics(rig: Rig, state: dict[str, float]) -> list[str]:
    iron, motor = rig.iron, rig.truth
    creep = CREEP * rig.idle_rad_s
    square = iron.windage * motor["B"] / rig.idle_rad_s
    return [
        f"Bk kt 0 V={_constant(rig.iron, motor['K'], rig.stall_a)}",
        "Bt 0 w I=v(kt)*i(Vi)",
        f"Bf w 0 I={motor['B']:.12g}*v(w)+{square:.9g}*abs(v(w))*v(w)"
        f"+({motor['T0']:.12g}+{iron.load_friction:.9g}*abs(v(kt)*i(Vi)))*tanh(v(w)/{creep:.9g})",
        f"Cw w 0 {motor['J']:.12g} IC={state['w']:.12g}",
        "Bth 0 th I=v(w)",
        f"Cth th 0 1 IC={state['th']:.12g}",
    ]


def _constant(iron: Iron, K: float, stall: float) -> str:
    bend = iron.bend * stall
    whole = np.hypot(stall, bend) - bend
    return (
        f"{K:.12g}*(1-{iron.reaction / whole:.9g}*(sqrt(i(Vi)*i(Vi)+{bend**2:.9g})-{bend:.9g}))"
        f"*(1+{iron.ripple:.6g}*cos({iron.ripple_per_turn}*v(th)))"
    )


def _analysis(text: str, length_s: float, folder: Path, number: int) -> dict[str, Floats]:
    circuit, raw = folder / f"step{number}.cir", folder / f"step{number}.raw"
    circuit.write_text(text, encoding="ascii")
    raw.unlink(missing_ok=True)
    done = subprocess.run(
        (PROGRAM, "-b", "-r", str(raw), str(circuit)), capture_output=True, text=True, check=False
    )
    table = _table(raw.read_bytes()) if raw.exists() else {}
    raw.unlink(missing_ok=True)
    if not len(table.get("time", ())) or table["time"][-1] < (1 - 1e-6) * length_s:
        said = (done.stdout + done.stderr).splitlines()
        raise SpiceError(
            f"step {number}: " + "; ".join(line for line in said if line.strip())[-600:]
        )
    return table


def _table(raw: bytes) -> dict[str, Floats]:
    """The vectors of a binary raw file, by name."""
    head, _, body = raw.partition(b"Binary:\n")
    names, count = [], 0
    for line in head.decode("ascii").splitlines():
        if line.startswith("No. Points:"):
            count = int(line.split(":")[1])
        elif line.startswith("\t") and len(line.split()) >= 3:
            names.append(line.split()[1].lower())
    values = np.frombuffer(body, np.float64, count * len(names)).reshape(count, len(names))
    return dict(zip(names, values.T, strict=True))
