"""Received bytes become a capture: the one way, live and in recovery."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import Any

from numpy.typing import NDArray

from motorid.acquire import channels, clock_check
from motorid.acquire.clock import Clock, Pair
from motorid.acquire.doubts import doubts
from motorid.acquire.facts import wrong_descriptor, wrong_zero
from motorid.acquire.header import check_kinds
from motorid.acquire.journal import JournalReader, Kind, Record
from motorid.acquire.plan import is_fast
from motorid.acquire.timeline import Timeline
from motorid.capture.facts import of_provenance
from motorid.capture.model import (
    CURRENT,
    NOTES,
    POSITION,
    SUPPLY_BEFORE,
    Capture,
    Channel,
    Phase,
    Wiring,
)
from motorid.errors import DataError, UsageError
from motorid.program import Program
from motorid.rig import Calibration
from motorid.wire.codec import (
    SAMPLE_BLOCK,
    BadPayload,
    Command,
    Event,
    Reply,
    SampleBlock,
    decode,
    mask_channels,
    name_of,
)
from motorid.wire.enums import Channel as WireChannel
from motorid.wire.enums import EndReason, Fault, ResetCause, Status
from motorid.wire.framing import BadFrame, Decoder, Frame
from motorid.wire.spec import load

KEPT = (  # of the header, in a capture's provenance
    *("created", "motorid", "rig_name", "rig", "port", "board_serial", "calibration_text"),
    *("calibration_file", "serial", "note", "settings", "host"),
)


UNUSABLE = (LookupError, TypeError, ValueError, ArithmeticError, AttributeError, UsageError)
CONTEXT = ("identify", "describe_channel", "configure", "read_config", "zero", "read_front_end")
AFTER_RESET = "samples after a reset of the board"
UNREAD = "blocks that this version cannot read"
DAMAGED = "damaged frames"
BLOCK = load().events[SAMPLE_BLOCK].code


class NoSamplesError(DataError):
    """A journal of a run that sent nothing yet: there is nothing to keep."""


class NoPlaceError(DataError):
    """A journal whose samples, or what may have been some, have no place in a run."""


class Assembler:
    """Takes a journal's records in order; ``capture`` gives what they hold.

    Everything before the mark ``measure`` (identity, descriptors, offsets, the check pulse) is
    context; everything after it is the run. A reply counts where it was asked for, and once: the
    client of the board takes it likewise.
    """

    def __init__(self, header: Mapping[str, Any]) -> None:
        check_kinds(header, "the journal's header")
        self.header = header
        self.replies: dict[str, dict[str, Any]] = {}
        self.descriptors: dict[str, dict[str, Any]] = {}
        self.marks: dict[str, Any] = {}
        self.timeline: Timeline | None = None
        self.bad_frames = 0
        self.fault: str | None = None
        self.reset: str | None = None
        self.done: dict[str, Any] | None = None
        self._decoder, self._sent = Decoder(), Decoder()
        # command -> request of the one that waits for its reply, and when it first was sent
        self._asked: dict[str, tuple[int, float]] = {}
        self._ticks: tuple[list[Pair], list[Pair]] = [], []  # before the run, and from then on
        self._now_s = 0.0
        self._stray: Counter[str] = Counter()  # samples, or frames, that no timeline has seen

    def feed(self, record: Record) -> None:
        """Takes one record. Raises DataError where a mark is damaged."""
        self._now_s = record.time_s
        match record.kind:
            case Kind.MARK:
                mark = record.json
                check_kinds(mark, "a mark of the journal")
                self.marks |= mark
                if "measure" in mark and self.timeline is None:
                    self._begin()
            case Kind.SENT:
                for frame in self._sent.feed(record.data):
                    self._note_sent(frame)
            case Kind.RECEIVED:
                for frame in self._decoder.feed(record.data):
                    self._frame(frame.payload if not isinstance(frame, BadFrame) else None)

    def _note_sent(self, frame: Frame | BadFrame) -> None:
        try:
            message = decode(frame.payload) if isinstance(frame, Frame) else None
        except BadPayload:
            return
        if isinstance(message, Command):
            known, first_s = self._asked.get(message.name, (None, 0.0))
            again = known == message.request
            self._asked[message.name] = message.request, first_s if again else self._now_s

    def _begin(self) -> None:
        config = self.replies.get("read_config", {})
        period = config.get("sample_period_ticks", 0)
        if not period:
            raise DataError("the run began before a configuration was in force")
        asked = mask_channels(config.get("channels", 0))
        self.timeline = Timeline(int(period), int(self.marks["samples"]), asked)
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
                if self.timeline is not None and (payload is None or payload[0] == BLOCK):
                    self._stray[UNREAD if payload else DAMAGED] += 1
            case Reply(status=Status.OK):
                self._reply(message)
            case SampleBlock() if self.timeline is not None:
                if self.reset is None:
                    self.timeline.add(message)
                else:
                    self._stray[AFTER_RESET] += len(message.samples)
            case Event() if self.timeline is not None and not self.over:
                self._event(message, self.timeline)

    @property
    def over(self) -> bool:
        """Whether the run has ended, by the board's word."""
        return self.done is not None or self.reset is not None

    def _reply(self, reply: Reply) -> None:
        request, sent_s = self._asked.get(reply.name, (None, 0.0))
        if request != reply.request:
            return
        del self._asked[reply.name]
        if reply.name == "read_status" and self.reset is None:
            pair = Pair(reply.fields["tick"], sent_s, self._now_s)
            self._ticks[self.timeline is not None].append(pair)
        if reply.name == "start" and self.timeline is not None:
            self.timeline.start(reply.fields["start_tick"])
        elif self.timeline is not None or reply.name not in CONTEXT:
            return  # what the run rests on was checked before it began
        elif reply.name == "describe_channel":
            self.descriptors[name_of(WireChannel, reply.fields["channel"])] = reply.fields
        else:
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

    def unplaced(self) -> dict[str, int]:
        """Samples that arrived and have no place in the run, by the reason."""
        timeline = self.timeline
        found = Counter(timeline.unplaced if timeline is not None else {})
        found[AFTER_RESET] += self._stray[AFTER_RESET]
        found[UNREAD] += self._stray[UNREAD]
        return {reason: count for reason, count in found.items() if count}

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
        """The run. Raises NoSamplesError when not one sample of it arrived, else DataError."""
        if self.timeline is not None:
            self.timeline.settle()
        if self.timeline is None or not self.timeline.blocks:
            raise self._nothing()
        dropped = int(self.done["dropped"]) if self.done is not None else 0
        arrays = self.timeline.arrays(self._taken(), dropped)
        identity = self.replies["identify"]
        wiring = Wiring(**self.header.get("wiring", {}))
        clock_hz, clock_uncertainty, _ = self._clock_in_force()
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

    def _nothing(self) -> DataError:
        """Why there is no run: nothing came, or nothing of what came has a place in one."""
        unplaced = self.unplaced()
        if unplaced:
            return NoPlaceError(f"not one sample has a place in the run: {listed(unplaced)} came")
        if damaged := self._stray[DAMAGED]:
            return NoPlaceError(
                f"not one sample of the run arrived whole: {damaged} damaged frames came"
            )
        return NoSamplesError("not one sample of the run arrived: there is nothing to keep")

    def _taken(self) -> int | None:
        """Samples that the board took, by its own word or by the program; None: unknown."""
        asked = int(self.marks["samples"])
        if self.done is not None and self.done["reason"] == EndReason.COMPLETED:
            return asked  # whatever it counted
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

    def remarks(self) -> list[str]:
        """What a person should know of how the board told of this run, in sentences."""
        found = []
        if self.timeline is not None and self.timeline.wrong_start is not None:
            found.append(
                f"the board named tick {self.timeline.wrong_start} as the run's first, which fits "
                "none of its samples: their own ticks are used; its firmware is at fault"
            )
        if unplaced := self.unplaced():
            found.append(
                f"what has no place in the run is in the journal alone, which stays as .raw: "
                f"{listed(unplaced)}"
            )
        *_, said = self._clock_in_force()
        if said:
            found.append(said)
        if self._zero() is None and self.replies.get("zero"):
            found.append(
                "the board's reply to zero holds no readings: the nominal offsets are used"
            )
        return found

    def _zero(self) -> Mapping[str, Any] | None:
        """Offsets at rest; None where there are none, or none that can be."""
        zero = self.replies.get("zero")
        return zero if zero and not wrong_zero(zero) else None

    def _clock(self) -> Clock | None:
        """What this computer's clock showed of the board's; None where it tells nothing."""
        step_s = float(self.header.get("host", {}).get("clock_resolution_s", 0.0))
        return clock_check.measured(*self._ticks, self.replies["identify"]["clock_hz"], step_s)

    def _clock_in_force(self) -> tuple[float, float, str]:
        """As ``clock_check.of_identity`` says it."""
        stated = self.header.get("clock", {})
        return clock_check.of_identity(self.replies["identify"], **stated, found=self._clock())

    def _front_end(self) -> dict[str, Any]:
        """The facts that the board had stored; none where its firmware's own held."""
        facts = self.replies.get("read_front_end")
        return {"front_end": facts} if facts and facts["front_end_hash"] else {}

    def _provenance(self) -> dict[str, Any]:
        timeline = self.timeline
        unplaced = {"unplaced_samples": found} if (found := self.unplaced()) else {}
        return {key: self.header[key] for key in KEPT if key in self.header} | {
            "identity": self.replies["identify"],
            "configuration": self.replies["read_config"],
            "descriptors": self.descriptors,
            **self._front_end(),
            "zero": self._zero() or {},
            "check": self.marks.get("check", {}),
            **{key: self.marks[key] for key in (SUPPLY_BEFORE,) if key in self.marks},
            **({"clock": asdict(clock)} if (clock := self._clock()) else {}),
            "link": {
                "bad_frames": self.bad_frames,
                "blocks": len(timeline.blocks) if timeline else 0,
                "repeated_blocks": timeline.repeated if timeline else 0,
                "impossible_blocks": timeline.impossible if timeline else 0,
                "done": self.done or {},
                **unplaced,
            },
        }

    def _channel(self, name: str, raw: NDArray[Any], wiring: Wiring) -> Channel:
        fact = self.descriptors.get(name)
        if fact is None:
            raise DataError(f"the board never described its channel {name}")
        if wrong := wrong_descriptor(fact):
            raise DataError(f"the board describes its channel {name} with {wrong}")
        if name == POSITION:
            return channels.position(raw, fact, wiring.counts_per_turn)
        known = Calibration(**self.header.get("calibration", {}).get(name, {}))
        zero, samples = self._zero() or {}, int(self.marks.get("zero_samples", 1))
        counts = channels.offset_of(name, fact, zero, samples, known)
        if is_fast(self.replies["read_config"]["sample_period_ticks"], self.replies["identify"]):
            counts = *counts[:2], max(counts[2], fact["noise"])  # zero was measured in a stream
        sense = self.header.get("voltage_sense", "terminals")
        found = channels.analogue(name, raw, fact, known, counts, sense)
        follows = bool(self._front_end().get("front_end", {}).get("ratiometric", 0))
        return replace(found, ratiometric=follows and name == CURRENT)


def assemble(journal: JournalReader) -> Capture:
    """The capture that a journal holds.

    Raises NoSamplesError when it holds no sample of a run, NoPlaceError when none has a place in
    it, DataError where the beginning of the run is not in it.
    """
    assembler = Assembler(journal.header)
    try:
        for record in journal:
            assembler.feed(record)
        run = assembler.capture()
        notes = [*assembler.remarks(), *doubts(run)]
    except UNUSABLE as error:
        raise DataError(
            f"the journal does not hold a whole beginning of a run ({error!r})"
        ) from None
    return replace(run, provenance={**run.provenance, NOTES: notes}) if notes else run


def listed(unplaced: Mapping[str, int]) -> str:
    """Samples without a place, in words."""
    return ", ".join(f"{count} {reason}" for reason, count in unplaced.items())
