"""Simulated benches whose captures the suspects are tried on."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from motorid.acquire.record import capture as record
from motorid.capture import store
from motorid.capture.model import CURRENT, POSITION, VOLTAGE, Capture, Stated, Wiring
from motorid.program import Decay, Program, Step, StepKind
from motorid.rig import Limits, Nameplate, Rig, Sampling, coasting_s, settling_s
from motorid.sim.motor import Motor
from motorid.sim.options import parse_url

FINE_HZ, RATE_HZ = 20_000.0, 10_000.0  # faults in time are put in at the finer rate
LONGEST_DRIVE, LONGEST_COAST = 0.1, 0.25
DIRECTIONS, DUTIES = "directions", "duties"
CHANNELS = (CURRENT, VOLTAGE, POSITION)


@dataclass(frozen=True)
class Bench:
    """One simulated motor with its seed and its program. ``folder`` takes the captures."""

    motor: str
    seed: int
    program: str
    folder: Path

    @property
    def preset(self) -> Motor:
        """The motor's figures."""
        return parse_url(f"sim://?motor={self.motor}").preset

    @property
    def nameplate(self) -> Nameplate:
        """What the maker prints."""
        m = self.preset
        top = m.voltage_v / m.torque_constant_nm_a
        idle = (m.coulomb_nm + m.viscous_nm_s * top) / m.torque_constant_nm_a
        return Nameplate(
            m.resistance_ohm, m.inductance_h, m.torque_constant_nm_a, m.inertia_kg_m2, idle,
            m.voltage_v,
        )  # fmt: skip

    def capture(
        self,
        options: str = "",
        channels: tuple[str, ...] = CHANNELS,
        rate_hz: float = RATE_HZ,
        decay: Decay = Decay.SYNCHRONOUS_SLOW,
    ) -> Capture:
        """A run of the rig; ``options`` are added to its URL."""
        rig = self._rig(options, channels, rate_hz, decay)
        path = record(rig, rig.program, self.folder / "run.h5", force=True)
        return store.load(path)

    def _rig(self, options: str, channels: tuple[str, ...], rate_hz: float, decay: Decay) -> Rig:
        m, plate = self.preset, self.nameplate
        bridge = 2 * m.switch_resistance_ohm
        return Rig(
            name=self.motor,
            port=f"sim://?motor={self.motor}&seed={self.seed}&speed=max&baud=0{options}",
            wiring=Wiring(bridge, 0.1 * bridge, counts_per_turn=2048),
            limits=Limits(
                1.45 * m.stall_current_a, 1.4 * m.voltage_v / m.torque_constant_nm_a,
                0.1 * m.supply_v, 1.5 * m.supply_v,
            ),
            nameplate=plate,
            sampling=Sampling(rate_hz, channels),
            program=_program(self.program, plate, decay),
            voltage_sense="bridge" if "sense=bridge" in options else "terminals",
            supply_voltage_v=m.supply_v,
            ambient_c=23.0,
            text=_text(plate),
        )  # fmt: skip


def _program(name: str, plate: Nameplate, decay: Decay) -> Program:
    """Volts in both directions, or duties in one; a coast after each."""
    volts = plate.voltage_v or 1.0
    drive_s = min(settling_s(plate), LONGEST_DRIVE)
    coast = Step(StepKind.COAST, min(coasting_s(plate), LONGEST_COAST))

    def step(kind: StepKind, level: float) -> Step:
        return Step(kind, drive_s, round(level, 3), decay)

    rest = Step(StepKind.COAST, 0.05)
    if name == DUTIES:
        return Program((rest, *(step(StepKind.DRIVE_DUTY, u) for u in (0.35, 0.8)), coast))
    forth = [step(StepKind.DRIVE_VOLTS, u * volts) for u in (0.4, 0.7)]
    back = [step(StepKind.DRIVE_VOLTS, u * volts) for u in (-0.7, -0.3)]
    return Program((rest, *forth, coast, *back, coast))


def _text(plate: Nameplate) -> str:
    """The rig's file as far as the nameplate goes."""
    keys = [f"{key} = {value!r}" for key, value in vars(plate).items() if value is not None]
    return "\n".join(["[nameplate]", *keys, ""])


def without_nameplate(capture: Capture) -> Capture:
    """The capture of a rig whose file says nothing of the motor."""
    return replace(capture, stated=Stated())
