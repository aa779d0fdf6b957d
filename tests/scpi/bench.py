"""A bench supply, a scope and a motor that answer SCPI: physics of their own, on any clock.

The motor is integrated by small steps; nothing here is shared with the fit or the simulator.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

MOTOR = {"R": 2.6, "L": 1.2e-3, "K": 0.0077, "B": 4.0e-7, "J": 1.2e-6, "T0": 5.0e-4}
STEP_S = 2e-5
SHUNT_V_A, TACHO_V_RAD_S, PROBE = 0.1, 2e-3, 1.0  # of the scope's inputs
FULL_V = 10.0  # of them: 16 bits over ± this


class Motor:
    """R, L, K, B, J and T0 behind a supply's terminals; plain numbers, for a step is a moment."""

    def __init__(self, ohm: float) -> None:
        self.ohm, self.decay = ohm, float(np.exp(-STEP_S * ohm / MOTOR["L"]))
        self.current = self.speed = self.volts = 0.0

    def step(self, volts: float | None, limit: float) -> None:
        """One STEP_S; ``volts`` None: an open output."""
        m = MOTOR
        emf = m["K"] * self.speed
        if volts is None:
            self.current, self.volts = 0.0, emf
        else:
            settled = (volts - emf) / self.ohm  # exact within a step: Euler's L would be 2 % low
            self.current = settled + (self.current - settled) * self.decay
            self.volts = volts
            if abs(self.current) > limit:
                self.current = math.copysign(limit, self.current)
                self.volts = self.ohm * self.current + emf
        torque = m["K"] * self.current - m["B"] * self.speed
        if self.speed == 0.0 and abs(torque) <= m["T0"]:
            return
        away = math.copysign(1.0, self.speed or torque)
        faster = self.speed + STEP_S * (torque - m["T0"] * away) / m["J"]
        self.speed = 0.0 if self.speed * faster < 0.0 else faster


class SettableClock:
    """Time that passes only where somebody waits."""

    def __init__(self) -> None:
        self.time = 0.0

    def now(self) -> float:
        return self.time

    def sleep(self, seconds: float) -> None:
        self.time += max(0.0, seconds)


@dataclass
class Bench:
    """One supply, one scope, one motor. ``reply_s``: what a message costs on a settable clock."""

    now: Callable[[], float]
    spend: Callable[[float], None] = lambda _: None
    reply_s: float = 2e-3
    slew_v_s: float = 1e5
    seed: int = 1
    settings: dict[str, float] = field(default_factory=dict)  # as a command set them
    silent_after: str = ""  # a command after which the supply answers nothing more
    ohm: float = MOTOR["R"]
    memory: int = 10**9  # points of the scope
    stuck_on: bool = False  # its output does not switch off
    heard: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.motor, self.errors = Motor(self.ohm), []
        self.done_s, self.level = self.now(), 0.0
        self.on = self.dead = self.limited = False
        self.settings |= {"VOLT": 0.0, "CURR": 0.1, "VOLT:PROT": 60.0, "CURR:PROT": 60.0}
        self.settings |= {"VOLT:PROT:STAT": 0.0, "CURR:PROT:STAT": 0.0}
        self.rows: list[tuple[float, float, float]] = []
        self.period_s, self.points, self.source = 1e-4, 0, "CHAN1"

    # ------------------------------------------------------------ physics

    def catch_up(self) -> None:
        """Integrates to now, and records where the scope runs."""
        limit = self.settings["CURR"]
        while self.done_s < self.now():
            wanted = self.settings["VOLT"] if self.on else 0.0
            most = self.slew_v_s * STEP_S
            self.level += min(max(wanted - self.level, -most), most)
            self.motor.step(self.level if self.on else None, limit)
            self.limited |= abs(self.motor.current) >= limit
            self.done_s += STEP_S
            if len(self.rows) < self.points and self.done_s >= self.next_s:
                self.rows.append((self.motor.current, self.motor.volts, self.motor.speed))
                self.next_s += self.period_s

    # ------------------------------------------------------------ messages

    def supply(self, text: str) -> str | None:
        """What the supply answers; None: nothing."""
        self.heard.append(text)
        self.spend(self.reply_s)
        self.catch_up()
        if self.dead or (self.silent_after and text.startswith(self.silent_after)):
            self.dead = True
            return None
        name, _, value = text.partition(" ")
        if text == "*IDN?":
            return "MOCK,SUPPLY,1,1.0"
        if text == "*CLS":
            self.errors.clear()
        elif text == "SYST:ERR?":
            return self.errors.pop(0) if self.errors else '+0,"No error"'
        elif name == "OUTP":
            self.on = value == "ON" or self.stuck_on
        elif text in ("OUTP?", "VOLT:PROT:TRIP?", "CURR:PROT:TRIP?"):
            return str(int(self.on if text == "OUTP?" else False))
        elif text == "STAT:QUES?":
            said, self.limited = str(int(self.limited)), False
            return said
        elif text in ("MEAS:CURR?", "MEAS:VOLT?"):
            return f"{self.motor.current if 'CURR' in text else self.motor.volts:+.6E}"
        elif name in self.settings and value:
            self.settings[name] = {"ON": 1.0, "OFF": 0.0}.get(value) or float(value)
        elif name.endswith("?") and name[:-1] in self.settings:
            found = self.settings[name[:-1]]
            return str(int(found)) if name.endswith("STAT?") else f"{found:.5E}"
        else:
            self.errors.append('-113,"Undefined header"')
        return None

    def scope(self, text: str) -> str | bytes | None:
        """What the scope answers: text, a block, or nothing."""
        self.spend(self.reply_s)
        self.catch_up()
        name, _, value = text.partition(" ")
        match name:
            case "*IDN?":
                return "MOCK,SCOPE,2,1.0"
            case ":SYST:ERR?":
                return '+0,"No error"'
            case ":ACQ:RATE":
                self.period_s = 1.0 / float(value)
            case ":ACQ:POIN":
                self.points = min(int(value), self.memory)
                self.rows, self.next_s = [], self.now()
            case ":OPER:COND?":
                return str(8 if len(self.rows) < self.points else 0)
            case ":STOP":
                self.points = len(self.rows)
            case ":WAV:SOUR":
                self.source = value
            case ":WAV:PRE?":
                step = 2 * FULL_V / 65536
                return f"1,2,{len(self.rows)},1,{self.period_s:.9E},0,0,{step:.9E},0.0,32768"
            case ":WAV:DATA?":
                return block(self.words())
        return None

    def words(self) -> np.ndarray[Any, Any]:
        """The chosen input as the scope's converter saw it."""
        rows = np.array(self.rows).reshape(-1, 3)
        place = {"CHAN1": 0, "CHAN2": 1, "CHAN3": 2}[self.source]
        volts = rows[:, place] * (SHUNT_V_A, PROBE, TACHO_V_RAD_S)[place]
        noise = np.random.default_rng(self.seed + place).normal(0.0, 1.5, len(volts))
        counts = np.rint(volts * 65536 / (2 * FULL_V) + 32768 + noise)
        return np.clip(counts, 0, 65535).astype("<u2")


def block(words: np.ndarray[Any, Any]) -> bytes:
    """A definite block of IEEE 488.2."""
    data = struct.pack(f"<{len(words)}H", *words.tolist())
    size = str(len(data))
    return f"#{len(size)}{size}".encode() + data
