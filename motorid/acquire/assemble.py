"""Received bytes become a capture: the one way, live and in recovery."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from enum import IntEnum
from typing import Any

from numpy.typing import NDArray

from motorid.acquire import channels
from motorid.acquire.doubts import doubts
from motorid.acquire.journal import JournalReader, Kind, Record
from motorid.acquire.plan import is_fast
from motorid.acquire.timeline import Timeline
from motorid.capture.facts import of_provenance
from motorid.capture.model import NOTES, POSITION, Capture, Channel, Phase, Wiring
from motorid.errors import DataError, UsageError
from motorid.program import Program
from motorid.rig import Calibration
from motorid.wire.codec import BadPayload, Event, Reply, SampleBlock, decode
from motorid.wire.enums import Channel as WireChannel
from motorid.wire.enums import EndReason, Fault, ResetCause, Status
from motorid.wire.framing import BadFrame, Decoder

KEPT = (  # of the header, in a capture's provenance
    *("created", "motorid", "rig_name", "rig", "port", "board_serial", "calibration_text"),
    *("calibration_file", "serial", "note", "host"),
)


class NoSamplesError(DataError):
    """A journal of a run that sent nothing yet: there is nothing to keep."""


class Assembler:
    """Takes a journal's records in order; ``capture`` gives what they hold.

    Everything before the mark ``measure`` (identity, descriptors, offsets, the check pulse) is
    context; everything after it is the run.
    """

    def __init__(self, header: Mapping[str, Any]) -> None:
        self.header = header
        self.replies: dict[str, dict[str, Any]] = {}
        self.descriptors: dict[str, dict[str, Any]] = {}
        self.marks: dict[str, Any] = {}
        self.timeline: Timeline | None = None
        self.bad_frames = 0
        self.fault: str | None = None
        self.reset: str | None = None
        self.done: dict[str, Any] | None = None
        self._decoder = Decoder()

    def feed(self, record: Record) -> None:
        """Takes one record."""
        if record.kind is Kind.MARK:
            self.marks |= record.json
            if "measure" in record.json:
                self._begin()
        elif record.kind is Kind.RECEIVED:
            for frame in self._decoder.feed(record.data):
                self._frame(frame.payload if not isinstance(frame, BadFrame) else None)

    def _begin(self) -> None:
        period = self.replies.get("read_config", {}).get("sample_period_ticks", 0)
        if not period:
            raise DataError("the run began before a configuration was in force")
        self.timeline = Timeline(int(period), int(self.marks["samples"]))
        self.bad_frames = 0
        self.fault = self.reset = self.done = None

    def _frame(self, payload: bytes | None) -> None:
        try:
            message = decode(payload) if payload is not None else None
        except BadPayload:
            message = None
        match message:
            case None:
                self.bad_frames += 1
            case Reply(status=Status.OK):
                self._reply(message)
            case SampleBlock() if self.timeline is not None and not self.over:
                self.timeline.add(message)
            case Event() if self.timeline is not None and not self.over:
                self._event(message, self.timeline)

    @property
    def over(self) -> bool:
        """Whether what follows belongs to the run no more."""
        return self.done is not None or self.reset is not None

    def _reply(self, reply: Reply) -> None:
        if reply.name == "describe_channel":
            self.descriptors[name_of(WireChannel, reply.fields["channel"])] = reply.fields
        elif reply.name == "start" and self.timeline is not None:
            self.timeline.start(reply.fields["start_tick"])
        elif reply.name in ("identify", "configure", "read_config", "zero"):
            self.replies[reply.name] = reply.fields

    def _event(self, event: Event, timeline: Timeline) -> None:
        match event.name:
            case "phase":
                timeline.phase(event.fields["index"], event.fields["tick"])
            case "fault":
                self.fault = name_of(Fault, event.fields["fault"])
            case "hello":
                self.reset = name_of(ResetCause, event.fields["reset_cause"])
            case "done":
                self.done = event.fields

    def end_reason(self) -> str:
        """Why the run ended, as Capture.end_reason says it."""
        if self.reset is not None:
            return f"reset: {self.reset}"
        if "end" in self.marks:
            return str(self.marks["end"])
        if self.done is None:
            return f"fault: {self.fault}" if self.fault else "interrupted"
        reason = self.done["reason"]
        if reason == EndReason.FAULT:
            return f"fault: {self.fault or 'unknown'}"
        return name_of(EndReason, reason)

    def capture(self) -> Capture:
        """The run. Raises DataError when not one sample of it arrived."""
        if self.timeline is None or not self.timeline.blocks:
            raise NoSamplesError("not one sample of the run arrived: there is nothing to keep")
        dropped = int(self.done["dropped"]) if self.done is not None else 0
        arrays = self.timeline.arrays(self._taken(), dropped)
        identity = self.replies["identify"]
        wiring = Wiring(**self.header.get("wiring", {}))
        clock_hz, clock_uncertainty = clock_of(identity, **self.header.get("clock", {}))
        return Capture(
            ticks=arrays.ticks,
            clock_hz=clock_hz,
            clock_uncertainty=clock_uncertainty,
            channels={
                name: self._channel(name, raw, wiring) for name, raw in arrays.columns.items()
            },
            wiring=replace(
                wiring,
                pwm_hz=float(identity["pwm_hz"]),
                dead_time_s=identity["dead_time_ns"] * 1e-9,
            ),
            program=Program.from_dict(self.header["program"]),
            phases=self._phases(),
            gaps=arrays.gaps,
            end_reason=self.end_reason(),
            ambient_c=self.header.get("ambient_c"),
            ambient_uncertainty_c=float(self.header.get("ambient_uncertainty_c", 0.0)),
            stated=of_provenance(self.header),
            provenance=self._provenance(),
        )

    def _taken(self) -> int | None:
        """Samples that the board took, by its own word or by the program; None: unknown."""
        asked = int(self.marks["samples"])
        if self.done is not None:  # whose figures a damaged frame that passed may have spoilt
            return min(asked, int(self.done["samples"]) + int(self.done["dropped"]))
        return asked if self.end_reason() == "completed" else None

    def _phases(self) -> tuple[Phase, ...]:
        """Steps as the program counts them: one longer than the wire's u32 went as several."""
        steps = self.marks.get("wire_steps", [])
        found: dict[int, int] = {}
        for phase in self.timeline.phases if self.timeline else ():
            index = steps[phase.index] if phase.index < len(steps) else phase.index
            found.setdefault(index, phase.tick)
        return tuple(Phase(index, tick) for index, tick in found.items())

    def _provenance(self) -> dict[str, Any]:
        timeline = self.timeline
        return {key: self.header[key] for key in KEPT if key in self.header} | {
            "identity": self.replies["identify"],
            "configuration": self.replies["read_config"],
            "descriptors": self.descriptors,
            "zero": self.replies.get("zero", {}),
            "check": self.marks.get("check", {}),
            "link": {
                "bad_frames": self.bad_frames,
                "blocks": len(timeline.blocks) if timeline else 0,
                "repeated_blocks": timeline.repeated if timeline else 0,
                "impossible_blocks": timeline.impossible if timeline else 0,
                "done": self.done or {},
            },
        }

    def _channel(self, name: str, raw: NDArray[Any], wiring: Wiring) -> Channel:
        fact = self.descriptors.get(name)
        if fact is None:
            raise DataError(f"the board never described its channel {name}")
        if name == POSITION:
            return channels.position(raw, fact, wiring.counts_per_turn)
        known = Calibration(**self.header.get("calibration", {}).get(name, {}))
        zero, samples = self.replies.get("zero", {}), int(self.marks.get("zero_samples", 1))
        counts = channels.offset_of(name, fact, zero, samples, known)
        if is_fast(self.replies["read_config"]["sample_period_ticks"], self.replies["identify"]):
            counts = *counts[:2], max(counts[2], fact["noise"])  # zero was measured in a stream
        sense = self.header.get("voltage_sense", "terminals")
        return channels.analogue(name, raw, fact, known, counts, sense)


def assemble(journal: JournalReader) -> Capture:
    """The capture that a journal holds. Raises DataError when it holds no sample of a run."""
    assembler = Assembler(journal.header)
    try:
        for record in journal:
            assembler.feed(record)
        run = assembler.capture()
    except (KeyError, TypeError, ValueError, ArithmeticError, UsageError) as error:
        raise DataError(
            f"the journal does not hold a whole beginning of a run ({error!r})"
        ) from None
    notes = doubts(run)
    return replace(run, provenance={**run.provenance, NOTES: notes}) if notes else run


def clock_of(
    identity: Mapping[str, Any], rate: float = 1.0, uncertainty: float | None = None
) -> tuple[float, float]:
    """Ticks a second and their relative standard uncertainty: calibrated, or the board's own."""
    stated = identity["clock_uncertainty_ppm"] * 1e-6 / math.sqrt(3)
    return identity["clock_hz"] * rate, stated if uncertainty is None else uncertainty


def _low(value: IntEnum) -> str:
    return value.name.lower()


def name_of(enum: type[IntEnum], number: int) -> str:
    """An enumeration's name, or its number where a newer board says what we do not know."""
    try:
        return _low(enum(number))
    except ValueError:
        return str(number)
