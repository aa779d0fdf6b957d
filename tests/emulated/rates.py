"""What the emulated board's clock, interrupts, processor and link do during a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from tests.conformance.boards import opened
from tests.conformance.client import BEAT_S, Client, Record

CLOCK_HZ = 16_000_000
MOTOR = "dunkermotoren-gr42"
THREE = 0b1011  # current, terminal voltage, position
PER_SAMPLE = 6  # bytes of those three
LINK_BYTES_S = 100_000  # 1 Mbaud, ten bits a byte
READ_LATENCY = 160  # cycles by which a slot may be late: firmware/ports/avr/timing.h
SETTLE_S = 0.02


@dataclass(frozen=True)
class Figures:
    """One run: ``times`` in cycles as the emulator's meter has them, ``facts`` after it."""

    board: str
    rate_hz: float
    edges_hz: float
    times: dict[str, Any]
    facts: dict[str, Any]
    record: Record

    @property
    def dropped(self) -> int:
        """Samples that found no room."""
        return int(self.record.one("done")["dropped"])

    @property
    def completed(self) -> bool:
        """Every sample came, and nothing tripped or reset the board."""
        return not self.record.all("fault") and not self.facts["resets"] and not self.dropped

    def share(self, what: str) -> float:
        """Of the processor's cycles: main, slot, sample, edge, receive, send or asleep."""
        return float(self.times["busy"][what] / self.times["cycles"])

    @property
    def link_bytes_s(self) -> float:
        """Bytes a second towards the host while it ran."""
        return float(self.times["bytes_out"] * CLOCK_HZ / self.times["cycles"])

    @property
    def bytes_a_sample(self) -> float:
        """On the wire, with headers, checks and stuffing."""
        return self.link_bytes_s / self.rate_hz


def follow(client: Client, record: Record, seconds: float) -> Record:
    """Hear a run to its end. Raises TimeoutError where a reset leaves it without."""
    beat_at, until = 0.0, client.port.now() + seconds
    while not record.all("done"):
        if (now := client.port.now()) >= beat_at:
            beat_at = now + BEAT_S
            client.send("heartbeat", sequence=0)
        client.wait(1e-3)
        record.told += client.told
        client.told.clear()
        if now > until:
            raise TimeoutError("the run did not end in its time")
    return record


def run(
    board: str, rate_hz: float, edges_hz: float, seconds: float = 0.5, defines: str = ""
) -> Figures:
    """A run with a turning encoder: coasts, and short drives so that the bridge acts.

    A rate of 0 is the board's highest. ``edges_hz`` come from the encoder alone, so the motor need
    not follow. ``defines`` go to the firmware's compiler. Raises TimeoutError where it has no end.
    """
    extra = {"defines": defines} if defines else {}
    with opened(board, motor=MOTOR, **extra) as emulated:
        port: Any = emulated.port
        client = Client(port)
        client.bring_up()
        shortest = client.identity["min_sample_period_ticks"]
        periods = round(CLOCK_HZ / rate_hz / shortest) if rate_hz else 1
        client.settings["sample_period_ticks"] = shortest * periods
        actual = CLOCK_HZ / client.settings["sample_period_ticks"]
        part = round(seconds * actual / 4)
        steps = [client.coast(part), client.drive(2, 0.1), client.coast(2)] * 4
        hashes = client.load(steps, channels=THREE)
        port.board.set("extra_edges", edges_hz)
        client.wait(SETTLE_S)
        port.board.times()
        client.told.clear()
        record = follow(client, Record(client.get("start", **hashes)["start_tick"]), 2 * seconds)
        times = port.board.times()
        return Figures(board, actual, edges_hz, times, port.board.facts(), record)


def scaled(slot_ticks: int) -> str:
    """Another length of the slots, and all else in proportion; the firmware is built for 250."""
    return f"-DSLOT_TICKS={slot_ticks} -DPWM_TICKS={slot_ticks * 16 // 5}"


def sustained(figures: Figures) -> bool:
    """Everything came, and no slot was read late."""
    return figures.completed and bool(figures.times["slot"]["most"] <= READ_LATENCY)
