"""From a rig without a board to a capture file: protect, switch on, record, switch off, keep."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from motorid.acquire.held_program import refuse_held
from motorid.acquire.interrupt import Stop, interruptible
from motorid.acquire.live import Live
from motorid.acquire.outputs import check_outputs
from motorid.acquire.safety import check_program
from motorid.acquire.scpi.bench_file import BenchFile, Place, of_rig
from motorid.acquire.scpi.build import capture_of
from motorid.acquire.scpi.link import Instrument, Link, open_visa
from motorid.acquire.scpi.notes import Told
from motorid.acquire.scpi.poll import Poller
from motorid.acquire.scpi.recorder import SLICE_S, Clock, Recorder, Recording
from motorid.acquire.scpi.supply import Supply
from motorid.capture import store
from motorid.capture.model import POSITION
from motorid.errors import DataError, LinkError, MotoridError, RigError
from motorid.program import Program, Step, StepKind
from motorid.rig import Rig

OpenLink = Callable[[str, str, float, str], Link]  # backend, resource, time-out, name
Progress = Callable[[Live], None]
Say = Callable[[str], None]
QUESTIONS = 8  # that the change of a level may cost, in round trips
SPARE_S = 0.2  # of a recording, beyond its program
PATIENCE_S = 10.0  # for a recorder that is done late
REDRAW_S = 0.1
COMPLETED = "completed"
PRESSES = 5  # of Ctrl-C that switching off outlives


def capture_all(
    rig: Rig,
    program: Program,
    paths: Sequence[Path],
    *,
    force: bool = False,
    progress: Progress | None = None,
    serial: str = "",
    note: str = "",
    say: Say | None = None,
    open_link: OpenLink = open_visa,
    clock: Clock | None = None,
) -> list[Path]:
    """Drives ``rig`` through ``program`` with its instruments, one run for each path.

    The output is off before and after each run, and was seen to be. Raises as
    ``acquire.record.capture``; what was measured before an error is kept.
    """
    bench = of_rig(rig)
    refuse(rig, bench, program)
    refuse_held(program, "a bench of instruments")
    check_program(rig, program)
    check_outputs(paths, rig, program, force=force)
    if say is not None:
        say(
            "no board guards this run: if this computer dies, the supply's output stays on as it "
            "was last told; only its own protections and your hand end that"
        )
    with interruptible() as stop, _Bench(rig, bench, open_link, clock or Clock()) as session:
        for path in paths:
            _Run(session, program, stop, progress).record(path, force, serial, note)
    return list(paths)


def refuse(rig: Rig, bench: BenchFile, program: Program) -> None:
    """Raises RigError for a program that these instruments cannot run."""
    if rig.calibration:
        raise RigError("[calibration] is of a board: state scale and zero in the instruments' file")
    if not math.isfinite(rig.sampling.rate_hz):
        raise RigError("a burst is of a board's memory: state sampling.rate_hz of the recorder")
    if not rig.wiring.counts_per_turn and any(one.name == POSITION for one in bench.channels):
        raise RigError("wiring.counts_per_turn is missing: an encoder's edges need it")
    for number, step in enumerate(program.steps):
        said = f"step {number} of the program"
        if step.kind is StepKind.DRIVE_DUTY:
            raise RigError(f"{said} asks for a duty, and a supply has volts: write drive_volts")
        if step.kind is StepKind.BRAKE and bench.quadrants < 2:
            raise RigError(
                f"{said} brakes, and an output that only sources cannot: leave it out, or write "
                "supply.quadrants = 2 where the output sinks current"
            )
        if step.level < 0 and bench.quadrants < 4:
            raise RigError(
                f"{said} asks for {step.level:g} V, and the supply gives one sign alone: leave it "
                "out, or write supply.quadrants = 4"
            )


class _Bench:
    """The instruments of a rig, open; leaving it has the output off."""

    def __init__(self, rig: Rig, file: BenchFile, open_link: OpenLink, clock: Clock) -> None:
        self.rig, self.file, self.clock, self._open_link = rig, file, clock, open_link
        self._held = contextlib.ExitStack()

    def __enter__(self) -> _Bench:
        with contextlib.ExitStack() as held:
            file = self.file
            first = self._opened("supply", file.supply, held, file.supply_dialect.error)
            self.supply = Supply(first, file.supply_dialect, file.channel, self._supply_again)
            held.callback(self.supply.close)
            self.meters = {n: self._opened(n, place, held) for n, place in file.meters.items()}
            self.recorder = self._recorder(held)
            self.supply.prepare()
            limits = self.rig.limits
            self.supply.protect(limits.voltage_v or limits.supply_max_v, limits.current_a)
            self._held = held.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self._held.close()

    def _opened(
        self, name: str, place: Place, held: contextlib.ExitStack, error: str | None = None
    ) -> Instrument:
        link = self._open_link(self.file.visa, place.resource, place.timeout_s, name)
        found = Instrument(name, link, place.error if error is None else error)
        if name != "supply":
            held.callback(found.close)
        found.identify()
        return found

    def _supply_again(self) -> Instrument:
        with contextlib.suppress(MotoridError):
            self.supply.close()
        link = self._open_link(
            self.file.visa, self.file.supply.resource, self.file.supply.timeout_s, "supply"
        )
        return Instrument("supply", link, self.file.supply_dialect.error)

    def _recorder(self, held: contextlib.ExitStack) -> Recorder | None:
        place, dialect = self.file.recorder, self.file.recorder_dialect
        if place is None or dialect is None:
            return None
        instrument = self._opened("recorder", place, held, dialect.error)
        return Recorder(instrument, dialect, self.file.channels, self.file.clock_uncertainty)

    def round_trip_s(self) -> float:
        """What one question to the supply costs."""
        began = self.clock.now()
        self.supply.is_on()
        return self.clock.now() - began

    def identities(self) -> dict[str, str]:
        """What each instrument says it is."""
        found = {"supply": self.supply.instrument.identity}
        found |= {name: meter.identity for name, meter in self.meters.items()}
        return found | ({"recorder": self.recorder.instrument.identity} if self.recorder else {})


@dataclass
class _Run:
    """One run into one file."""

    bench: _Bench
    program: Program
    stop: Stop
    progress: Progress | None
    commanded: list[dict[str, Any]] = field(default_factory=list)
    limited: list[int] = field(default_factory=list)
    live: bool = False  # whether the output is on, as far as this run knows
    drawn: float = -math.inf

    def record(self, path: Path, force: bool, serial: str, note: str) -> None:
        """Measures and saves; raises afterwards what ended the run early."""
        created = datetime.now(UTC).isoformat(timespec="seconds")
        identities = self.bench.identities()
        poller = self._poller()
        failure: MotoridError | None = None
        reason = "interrupted"
        try:
            with self._switched_off_at_last():
                reason = self._measure(poller)
        except MotoridError as error:
            failure = error
            reason = "link lost" if isinstance(error, LinkError) else "stopped"
        supply = self.bench.supply
        told = Told(
            reason, created, serial, note, identities, dict(supply.settings),
            self.commanded, self.limited, self.program.duration_s, self.bench.file.text,
        )  # fmt: skip
        kept = ""
        try:
            run = capture_of(self.bench.rig, self._recording(poller, reason), told)
            store.save(run, path, force)
            kept = f"; {len(run)} samples are kept in {path}"
        except (DataError, LinkError) as error:
            if failure is None:
                raise
            kept = f"; {error}"
        if failure is not None:
            raise type(failure)(f"{failure}{kept}")
        if reason.startswith("fault"):
            raise RigError(f"the supply ended the run ({reason}){kept}")
        if self.stop.requested:
            raise KeyboardInterrupt(f"interrupted{kept}")

    @contextlib.contextmanager
    def _switched_off_at_last(self) -> Iterator[None]:
        """However the run ends, the output is off and was seen to be; else that is what is said."""
        try:
            yield
        except BaseException as error:
            try:
                self._off()
            except MotoridError as worse:
                if isinstance(error, MotoridError):
                    raise LinkError(f"{error}. {worse}") from None
                raise worse from error
            raise
        self._off()

    def _off(self) -> None:
        """Off, whoever presses Ctrl-C meanwhile."""
        pressed: KeyboardInterrupt | None = None
        for _ in range(PRESSES):
            try:
                self.bench.supply.off()
            except KeyboardInterrupt as error:
                pressed = error
            else:
                break
        if pressed is not None:
            raise pressed

    def _poller(self) -> Poller | None:
        bench = self.bench
        if bench.recorder is not None:
            return None
        return Poller(bench.supply, bench.meters, bench.file.channels, bench.clock)

    def _measure(self, poller: Poller | None) -> str:
        """The whole program; returns why it ended."""
        bench, recorder = self.bench, self.bench.recorder
        total_s = self.program.duration_s
        if recorder is not None:
            spent_s = QUESTIONS * bench.round_trip_s() * len(self.program.steps)
            length_s = total_s + spent_s + bench.file.lead_s + SPARE_S
            recorder.start(bench.rig.sampling.rate_hz, length_s)
            bench.clock.sleep(bench.file.lead_s)
        began = bench.clock.now()
        for index, step in enumerate(self.program.steps):
            self._apply(index, step, bench.clock.now() - began)
            if reason := self._hold(index, step, began, poller):
                return reason
        if recorder is not None:
            bench.supply.off()  # no motor turns while a recorder takes its time
            recorder.wait(bench.clock, length_s + PATIENCE_S)
        return COMPLETED

    def _apply(self, index: int, step: Step, at_s: float) -> None:
        """Brings the output to where a step wants it."""
        supply = self.bench.supply
        driven = step.kind is not StepKind.COAST
        if not driven:
            if self.live:
                supply.off()
            self.live = False
        else:
            supply.set(step.level)
            if not self.live:
                supply.on()
            self.live = True
            if supply.limited():
                self.limited.append(index)
        self.commanded.append(
            {
                "step": index,
                "kind": step.kind.name.lower(),
                "volts": step.level if driven else None,
                "host_s": round(at_s, 6),
            }
        )

    def _hold(self, index: int, step: Step, began: float, poller: Poller | None) -> str:
        """Until a step is over; returns why the run ends in it, or nothing."""
        clock, limits = self.bench.clock, self.bench.rig.limits
        period_s = 1.0 / self.bench.rig.sampling.rate_hz
        until = clock.now() + step.duration_s
        while (left := until - (now := clock.now())) > 0.0:
            if self.stop.requested:
                return "interrupted"
            if now - began > limits.run_time_s:
                return "fault: run_time"
            if poller is None:
                clock.sleep(min(left, SLICE_S))
            else:
                poller.row()
                clock.sleep(min(until - clock.now(), now + period_s - clock.now()))
            self._show(clock.now() - began, poller)
        return self._ended(index)

    def _ended(self, index: int) -> str:
        """What the supply says after a step."""
        if not self.live:
            return ""
        supply = self.bench.supply
        if supply.limited() and index not in self.limited:
            self.limited.append(index)
        if found := supply.tripped():
            return f"fault: {found}"
        return "" if supply.is_on() else "fault: output off"

    def _show(self, done_s: float, poller: Poller | None) -> None:
        total_s = self.program.duration_s
        if self.progress is None or done_s - self.drawn < REDRAW_S:
            return
        self.drawn = done_s
        current, speed = poller.latest() if poller is not None else (None, None)
        self.progress(Live(min(done_s, total_s), total_s, current, speed))

    def _recording(self, poller: Poller | None, reason: str) -> Recording:
        """What there is, also of a run that was cut short."""
        if poller is not None:
            return poller.recording()
        recorder = self.bench.recorder
        assert recorder is not None
        if reason != COMPLETED:
            recorder.stop()
        return recorder.recording()
