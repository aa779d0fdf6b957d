"""A DAQ with one converter behind a multiplexer: a scan reads its inputs one after another."""

from __future__ import annotations

import math

from tests.scpi.bench import SHUNT_V_A, TACHO_V_RAD_S, Bench

PACE_S = 4e-3  # from one input to the next: 250 readings a second, a 34970A's
FINE_S = 1e-4  # between the bench's rows, of which a reading is one
STAMP_S = 1e-3  # that its clock shows
FULL_V, DIGITS = 10.0, 1e-5
INPUTS = {"101": (0, SHUNT_V_A), "102": (1, 1.0), "103": (2, TACHO_V_RAD_S)}
BUSY = 16


class Daq:
    """Reads the bench's motor through shunt, terminals and tacho.

    ``lost``: a reading, counted from the first, that its answer lacks.
    """

    def __init__(self, bench: Bench, lost: int = -1) -> None:
        self.bench, self.lost = bench, lost
        self.heard: list[str] = []
        self.order: list[str] = []
        self.period_s, self.scans = 1.0, 0

    def answer(self, text: str) -> str | None:
        self.heard.append(text)
        self.bench.spend(self.bench.reply_s)
        self.bench.catch_up()
        name, _, value = text.partition(" ")
        if name == "ROUT:SCAN":
            self.order = sorted(value.strip("(@)").split(","))  # whatever the order it was told
        elif name == "TRIG:TIM":
            self.period_s = max(float(value), len(self.order) * PACE_S)
        elif name == "TRIG:COUN":
            self.scans = int(value)
        elif name == "INIT":
            self.bench.period_s, self.bench.rows = FINE_S, []
            self.bench.points = math.ceil(self.scans * self.period_s / FINE_S)
            self.bench.next_s = self.bench.now()
        elif name == "ABOR":
            self.bench.points = len(self.bench.rows)
        elif text == "STAT:OPER:COND?":
            return str(BUSY if len(self.bench.rows) < self.bench.points else 0)
        elif text == "FETC?":
            return ",".join(self.readings())
        return {"*IDN?": "MOCK,DAQ,4,1.0", "SYST:ERR?": '+0,"No error"'}.get(text)

    def readings(self) -> list[str]:
        """Value, time and channel of each."""
        found: list[str] = []
        for number in range(self.scans * len(self.order)):
            scan, place = divmod(number, len(self.order))
            at_s = scan * self.period_s + place * PACE_S
            row = round(at_s / FINE_S)
            if row >= len(self.bench.rows):
                break
            quantity, scale = INPUTS[self.order[place]]
            volts = min(FULL_V, self.bench.rows[row][quantity] * scale)
            shown = round(volts / DIGITS) * DIGITS
            stamp = math.floor(at_s / STAMP_S + 0.5) * STAMP_S
            if number != self.lost:
                found.append(f"{shown:+.8E},{stamp:.3f},{self.order[place]}")
        return found
