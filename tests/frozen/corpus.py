"""Makes the corpus' files anew: ``python -m tests.frozen.corpus [NAME ..]``.

What is stored stays as it is, so that a change of the simulator is none of the frozen results. The
drawings here say where each file came from, and how to add one. Where no board can be emulated,
its capture is left as it is.
"""

from __future__ import annotations

import lzma
import sys
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from bench.coverage import rigs as drawn_rigs
from bench.coverage import runs as drawn_runs
from bench.foreign import cases as foreign
from bench.foreign.plant import Drive, Motor, Trace, turn
from motorid.acquire.record import capture_all
from motorid.capture import store
from motorid.capture.model import Capture
from motorid.program import Decay, Program, Step, StepKind
from motorid.rig import Rig, Sampling, coasting_s, default_program, load_rig, settling_s
from motorid.rig_file import parse
from tests.frozen.cases import CAPTURES, LOGS, PACKED

CREATED = "2026-01-01T00:00:00+00:00"
REST_S = 0.03
SIM, SIM_PITTMAN = (load_rig(name).text for name in ("sim", "sim-pittman"))


def keep(name: str, captures: list[Capture]) -> None:
    """Stores runs as NAME-0, NAME-1 .., with a date and a host that say nothing."""
    for k, capture in enumerate(captures):
        known = {**capture.provenance, "created": CREATED, "host": {}}
        data = store.to_bytes(replace(capture, provenance=known))
        path = CAPTURES / f"{name}-{k}{PACKED}"
        path.write_bytes(lzma.compress(data, preset=9 | lzma.PRESET_EXTREME))


def recorded(rig: Rig, runs: int = 1) -> list[Capture]:
    """Captures of a rig over its port."""
    with tempfile.TemporaryDirectory() as folder:
        paths = [Path(folder) / f"{k}.h5" for k in range(runs)]
        return [store.load(path) for path in capture_all(rig, rig.program, paths)]


def shortened(rig: Rig, decay: Decay = Decay.SYNCHRONOUS_SLOW) -> Program:
    """Three levels ahead, a coast, one level backwards, a coast: four time constants each."""
    plate = rig.nameplate
    drive_s, coast_s = round(settling_s(plate) / 2, 3), round(min(coasting_s(plate) / 3, 0.2), 3)
    top = plate.voltage_v or 0.0
    ahead, back = (
        [Step(StepKind.DRIVE_VOLTS, drive_s, share * top, decay) for share in shares]
        for shares in ((0.35, 0.65, 0.9), (-0.25,))
    )
    coast = Step(StepKind.COAST, coast_s)
    return Program((Step(StepKind.COAST, REST_S), *ahead, coast, *back, coast))


def sim(preset: str, more: str = "", text: str = "", **changes: Any) -> Rig:
    """A simulated preset with a short program, options added to its URL; ``text`` in its place."""
    rig = parse(text) if text else load_rig(preset)
    join = "&" if "?" in rig.port else "?"
    url = f"{rig.port}{join}speed=max&seed=3{more}"
    return replace(rig, port=url, **{"program": shortened(rig), **changes})


def by_duty() -> Rig:
    """Driven in duty, with no voltage sensed but the supply's."""
    rig = load_rig("sim-re35")
    program = shortened(rig)
    steps = tuple(
        replace(s, kind=StepKind.DRIVE_DUTY, level=s.level / 36.0)
        if s.kind == StepKind.DRIVE_VOLTS
        else s
        for s in program.steps
    )
    sampling = replace(rig.sampling, channels=("current", "supply_voltage", "position"))
    return sim("sim-re35", program=Program(steps), voltage_sense="supply", sampling=sampling)


def without_plate_resistance() -> Rig:
    """Without R the program is long: a fit 20 times as dear, as its residuals are coloured."""
    (line,) = (one for one in SIM_PITTMAN.splitlines() if one.startswith("resistance_ohm"))
    text = SIM_PITTMAN.replace(line, "")
    return sim("", text=text, program=default_program(parse(text).nameplate), sampling=plain(5000))


def decaying(decay: Decay) -> Rig:
    """The current decays through the bridge's diodes, and stops within the PWM period."""
    return sim("sim-pittman", program=shortened(load_rig("sim-pittman"), decay))


def with_thermal_figures() -> Rig:
    """A small motor that warms as it runs, and what its data sheet says of that."""
    lines = "winding_k_w = 28.0\nwinding_s = 8.0\nmagnet_per_k = -0.002\n"
    return sim("", "&load_inertia=1e-6", text=f"{SIM}\n[thermal]\n{lines}", sampling=plain(5000))


def plain(rate_hz: float) -> Sampling:
    return Sampling(rate_hz, ("current", "terminal_voltage", "position"))


WORN = "&heating=0&brush_drop=0.15&cogging=6e-4&cogging_per_turn=4&stiction=1"
RIGS: Mapping[str, Callable[[], Rig]] = {
    **{name: lambda name=name: sim(name) for name in
       ("sim", "sim-re35", "sim-qube", "sim-pittman", "sim-line")},
    "diode-decay": lambda: decaying(Decay.DIODE),
    "fast-decay": lambda: decaying(Decay.FAST),
    "supply-sense-by-duty": by_duty,
    "no-resistance-on-the-plate": without_plate_resistance,
    "brushes-and-cogging": lambda: sim("sim", WORN, sampling=plain(5000.0)),
    "emulated-uno": lambda: sim("emulated-uno"),
    "thermal-figures": with_thermal_figures,
    "wrong-counts": lambda: sim("sim-re35", "&counts_per_turn=1024"),
}  # fmt: skip


def drawn(seed: int, runs: int) -> list[Capture]:
    """The first runs of a rig of the coverage study."""
    with tempfile.TemporaryDirectory() as folder:
        return list(drawn_runs.record(drawn_rigs.draw_bench(seed), Path(folder)).captures[:runs])


def swinging() -> Drive:
    """Levels both ways that change every 70 ms, and a stop."""
    levels = (0.0, 6.0, 3.0, -4.0, -2.0, 4.5, 0.0)
    return lambda t, w: levels[min(int(t / 0.07), 6)]


@dataclass(frozen=True)
class Log:
    """What somebody's logger wrote of a drive: ``rows`` at most, some columns, some at means."""

    columns: str
    drive: Callable[[], Drive] = swinging
    stamps: Callable[[np.random.Generator], foreign.Floats] = lambda rng: foreign.regular(PERIOD_S)
    rows: int = 600
    begins: float = 0.0  # rad/s
    motor: Motor = foreign.MOTOR
    mean: bool = False

    def text(self) -> str:
        """The file."""
        rng = np.random.default_rng(5)
        stamps = self.stamps(rng)[: self.rows]
        true = turn(self.motor, self.drive(), float(stamps[-1]) + PERIOD_S, self.begins)
        truths = {"v": true.volts, "i": true.current, "w": true.speed, "p": true.angle}
        table = {"t": stamps}
        for name in self.columns:
            clean = truths[name]
            read = self._means(true, clean, stamps) if self.mean else true.at(clean, stamps)
            table[name] = read + NOISE[name] * rng.standard_normal(len(stamps))
        rows = np.column_stack(list(table.values()))
        lines = [",".join(table), *(",".join(f"{x:.6g}" for x in row) for row in rows)]
        return "\n".join(lines) + "\n"

    def _means(self, true: Trace, clean: foreign.Floats, stamps: foreign.Floats) -> foreign.Floats:
        """Over the period before each stamp."""
        whole = np.concatenate([[0.0], np.cumsum(clean)]) * (true.time_s[1] - true.time_s[0])
        ends = np.append(true.time_s, 2 * true.time_s[-1] - true.time_s[-2])
        area = np.interp(stamps, ends, whole) - np.interp(stamps - PERIOD_S, ends, whole)
        return area / PERIOD_S


PERIOD_S = foreign.PERIOD_S
NOISE = {**foreign.NOISE, "p": 1e-3}
LOCKED = replace(foreign.MOTOR, T0=10.0)
LOGS_MADE = {
    "steps": Log("viw"),
    "position": Log("vip"),
    "means": Log("viw", mean=True),
    "random-stamps": Log("viw", stamps=foreign.at_random),
    "drop-outs": Log("viw", foreign.prbs, stamps=foreign.drop_outs),
    "motionless": Log("vi", foreign.closed_loop, rows=1200),
    "motionless-random-stamps": Log("vi", stamps=foreign.at_random, rows=400),
    "locked-rotor": Log("viw", motor=LOCKED),
    "mechanical": Log("iw", foreign.closed_loop, rows=1200),
    "no-current": Log("vw"),
    "coast-down": Log("w", foreign.then_open, begins=120.0),
    "tachometer": Log("v", foreign.then_open, begins=120.0),
}
DRAWN = {12: 1, 526: 3, 903: 3, 930: 1, 1123: 1, 1449: 1}


def makers() -> dict[str, Callable[[], None]]:
    """For each file or group of files, what writes it."""
    made: dict[str, Callable[[], None]] = {}
    for name, rig in RIGS.items():
        made[name] = partial(_rig, name, rig)
    made["three-runs"] = lambda: keep("three-runs", recorded(sim("sim-qube"), 3))
    for seed, runs in DRAWN.items():
        made[f"drawn-{seed}"] = partial(_drawn, seed, runs)
    for name, log in LOGS_MADE.items():
        made[name] = partial(_log, name, log)
    return made


def _rig(name: str, rig: Callable[[], Rig]) -> None:
    keep(name, recorded(rig()))


def _drawn(seed: int, runs: int) -> None:
    keep(f"drawn-{seed}", drawn(seed, runs))


def _log(name: str, log: Log) -> None:
    (LOGS / f"{name}.csv").write_text(log.text(), encoding="utf-8")


def main() -> None:
    """Writes the files named, or all."""
    made = makers()
    CAPTURES.mkdir(exist_ok=True)
    LOGS.mkdir(exist_ok=True)
    for name in sys.argv[1:] or made:
        if name not in made:
            sys.exit(f"there is no file {name!r}: choose of {', '.join(made)}")
        made[name]()
        print(name, flush=True)


if __name__ == "__main__":
    main()
