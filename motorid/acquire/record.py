"""From a rig to a capture file: the only writer of captures from a board."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NoReturn

from motorid.acquire import clock_check
from motorid.acquire.assemble import NoPlaceError, NoSamplesError
from motorid.acquire.bench_facts import contradictions
from motorid.acquire.board import Board, Fields
from motorid.acquire.check import check_signs, check_supply, check_zero
from motorid.acquire.contacts import check_inputs
from motorid.acquire.drive import drive, load, tripped
from motorid.acquire.encoder_scale import why_too_fast
from motorid.acquire.front_end import check, drivable, refuse_coasts
from motorid.acquire.guards import signs
from motorid.acquire.header import check_kinds
from motorid.acquire.held_rotor import MOVED, TravelWatch, board_limit, check_held
from motorid.acquire.interrupt import Stop, interruptible
from motorid.acquire.journal import journal_path
from motorid.acquire.journal_writer import JournaledPort, JournalWriter
from motorid.acquire.keep import RAW, keep
from motorid.acquire.keep import missing as missing
from motorid.acquire.keep import recover as recover
from motorid.acquire.keep import remarks as remarks
from motorid.acquire.leftover import make_way, set_aside
from motorid.acquire.link import Port
from motorid.acquire.live import Live, LiveView
from motorid.acquire.outputs import check_outputs
from motorid.acquire.plan import (
    WireProgram,
    check_burst,
    configuration,
    differing,
    is_fast,
    sample_period,
    step_ticks,
    wire_program,
)
from motorid.acquire.port import INSTRUMENTS, open_port
from motorid.acquire.ports import serial_of
from motorid.acquire.resets import BoardResetError
from motorid.acquire.run_header import run_header
from motorid.acquire.safety import check_program
from motorid.acquire.signs import Sign, seen
from motorid.acquire.tap import Consume, Watch, both, run_facts
from motorid.capture import store
from motorid.capture.model import SUPPLY, SUPPLY_BEFORE
from motorid.errors import DataError, LinkError, MotoridError, RigError
from motorid.program import Program
from motorid.rig import Rig
from motorid.rig_calibration import refuse_other_board
from motorid.wire.codec import SampleBlock, name_of
from motorid.wire.enums import Fault, Mode

Progress = Callable[[Live], None]
Say = Callable[[str], None]
ZERO_S = 0.2
SIGNS = {
    name_of(Fault, Fault.OVER_CURRENT): Sign.OVER_CURRENT,
    name_of(Fault, Fault.OVER_SPEED): Sign.OVER_SPEED,
}


def capture(
    rig: Rig,
    program: Program,
    path: Path,
    *,
    force: bool = False,
    progress: Progress | None = None,
    serial: str = "",
    note: str = "",
) -> Path:
    """Drives ``rig`` through ``program`` and writes the capture to ``path``; returns it.

    Raises UsageError when ``path`` exists and ``force`` is not given, RigError when the rig is
    unsafe, wired wrong or trips, LinkError when the board is lost, KeyboardInterrupt after Ctrl-C.
    What was measured before a trip, a lost link or Ctrl-C is in ``path`` all the same.
    """
    return capture_all(
        rig, program, [path], force=force, progress=progress, serial=serial, note=note
    )[0]


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
    watch: Watch | None = None,
) -> list[Path]:
    """As ``capture``, one run for each path, over one opening of the port.

    ``say`` is told what rig and board contradict one another in, before the first program runs.
    ``watch`` is given the samples of each run as they come.
    """
    if rig.port.startswith(INSTRUMENTS):
        from motorid.acquire.scpi.run import capture_all as over_scpi

        return over_scpi(
            rig, program, paths, force=force, progress=progress, serial=serial, note=note, say=say
        )
    program = drivable(rig, program)
    check_program(rig, program)
    check_outputs(paths, rig, program, force=force)
    port = open_port(rig.port)
    try:
        with interruptible() as stop:
            for number, path in enumerate(paths):
                told = say if number == 0 else None
                recorder = _Recorder(port, rig, program, stop, progress, told, watch)
                recorder.record(path, force, serial, note, checked=number > 0)
    finally:
        port.close()
    return list(paths)


def capture_over(
    port: Port,
    rig: Rig,
    program: Program,
    path: Path,
    *,
    force: bool = False,
    progress: Progress | None = None,
    serial: str = "",
    note: str = "",
    checked: bool = False,
    watch: Watch | None = None,
) -> Path:
    """As ``capture``, over a port that is open and stays so.

    ``checked``: signs were checked on this motor already, so no pulse goes before the program.
    """
    program = drivable(rig, program)
    check_program(rig, program)
    check_outputs([path], rig, program, force=force)
    with interruptible() as stop:
        _Recorder(port, rig, program, stop, progress, watch=watch).record(
            path, force, serial, note, checked=checked
        )
    return path


class _Recorder:
    """One run into one file."""

    def __init__(
        self,
        port: Port,
        rig: Rig,
        program: Program,
        stop: Stop,
        progress: Progress | None,
        say: Say | None = None,
        watch: Watch | None = None,
    ) -> None:
        self.port, self.rig, self.program = port, rig, program
        self.stop, self.progress, self.say, self.watch = stop, progress, say, watch
        self.measuring = False  # whether the journal holds any of the run proper
        self.recorded: Any = getattr(port, "header", None)  # of a replay: what was, is again

    def record(self, path: Path, force: bool, serial: str, note: str, *, checked: bool) -> None:
        """Measures and saves; raises afterwards what ended the run early."""
        header = self.recorded or run_header(self.rig, self.program, serial, note)
        check_kinds(header, "what is told of this run")  # else its journal could not be read
        if force:
            make_way(path)
        journal = JournalWriter(journal_path(path), header)
        failure: Exception | None = None
        reason = told = ""
        try:
            board = Board(JournaledPort(self.port, journal), int(header.get("first_request", 1)))
            reason = self._measure(board, journal, checked)
            told = board.trip
        except MotoridError as error:
            failure = error
            reason = _end_of(error)
        except Exception as error:  # the caller's own, out of what follows the run's progress
            failure, reason = error, "interrupted"
        except BaseException as error:  # a second Ctrl-C: quit at once
            self._quit(error, journal)
        kept = self._keep(journal, reason, path, force, failure)
        if failure is not None:
            raise _with(failure, _where(kept, path))
        if reason.startswith("fault"):
            fast = kept and reason == f"fault: {name_of(Fault, Fault.OVER_SPEED)}"
            if fast and self.program.held:
                raise RigError(f"{MOVED}{_where(kept, path)}")
            why = why_too_fast(self.rig, store.load(path)) if fast else ""
            text = f"{tripped(reason, told)}{why}{_where(kept, path)}"
            sign = SIGNS.get(reason.removeprefix("fault: "))
            raise RigError(text) if sign is None else seen(sign, text)
        if self.stop.requested:
            raise KeyboardInterrupt(f"interrupted{_where(kept, path) or '; nothing was measured'}")
        if not kept:
            raise LinkError(
                f"{self.port.name}: the board says that the run is over, and not one sample of it "
                "arrived: its firmware is at fault, or the link"
            )

    def _quit(self, error: BaseException, journal: JournalWriter) -> NoReturn:
        with contextlib.suppress(DataError):
            journal.close()
        if not isinstance(error, KeyboardInterrupt):
            raise error
        if not self.measuring:
            journal.discard()
            raise KeyboardInterrupt("interrupted twice; nothing was measured") from None
        raise KeyboardInterrupt(
            f"interrupted twice; `motorid recover {journal.path}` keeps what arrived"
        ) from None

    def _measure(self, board: Board, journal: JournalWriter, checked: bool) -> str:
        """The whole conversation with the board; returns why the run ended."""
        rig = self.rig
        board.identify()
        if rig.calibrated is not None and self.recorded is None:
            serial = rig.board_serial or serial_of(rig.port)
            refuse_other_board(rig.calibrated, board.identity["board"], serial)
        board.make_ready()
        config = self._configure(board, streaming(rig, board))
        refuse_coasts(board, self.program)
        check_inputs(board, rig)
        zero = self._zero(board, journal, config)
        supply_v = check_supply(board, rig)
        self._say_contradictions(board, supply_v if SUPPLY in board.descriptors else None)
        first = check_held if self.program.held else check_signs
        pulse = {} if checked else first(board, rig, config, zero, supply_v, self.stop)
        if self.stop.requested:
            return "interrupted"
        bound = pulse.get("resistance_bound_ohm")
        check_program(rig, self.program, resistance_ohm=bound, supply_v=supply_v)
        period = sample_period(rig, board.identity)
        wire = wire_program(self.program, board.identity, step_ticks(period, board.identity))
        check_burst(rig, wire, board.identity, period)
        config = self._configure_run(board, period)
        board.ask_ticks(clock_check.QUESTIONS)
        load(board, wire)
        journal.mark(
            board.port.now(),
            measure=True,
            wire_steps=wire.origin,
            samples=wire.ticks // period,
            check=pulse,
            **({SUPPLY_BEFORE: supply_v} if SUPPLY in board.descriptors else {}),
        )
        self.measuring = True
        view = LiveView(rig, board, zero, wire, self.progress)
        watched = both(view.consume, self.watch, lambda: run_facts(rig, board, config, zero))
        reason = self._drive(board, wire, config, watched)
        if reason == "completed":
            with contextlib.suppress(MotoridError):  # the run is whole, whatever comes now
                board.ask_ticks(clock_check.QUESTIONS)
        return "interrupted" if self.stop.requested and reason == "stopped" else reason

    def _drive(self, board: Board, wire: WireProgram, config: Fields, watched: Consume) -> str:
        """The run; one whose rotor is to be held ends when it creeps away, too."""
        if not self.program.held:
            return drive(board, wire, config, self.stop, watched)
        travel = TravelWatch(self.rig, self.stop)

        def consume(block: SampleBlock) -> None:
            travel.consume(block)
            watched(block)

        reason = drive(board, wire, config, travel, consume)
        travel.insist()
        return reason

    def _configure(self, board: Board, rig: Rig, **more: int) -> Fields:
        """Limits on the board; that on a rotor which is to be held among them."""
        if self.program.held:
            period = step_ticks(sample_period(rig, board.identity), board.identity)
            more |= board_limit(rig, board.identity, period)
        return configure(board, rig, **more)

    def _configure_run(self, board: Board, period: int) -> Fields:
        """For the program itself: a fast burst's own rate, and the board's sign check.

        The pulses before it go without that check: what they show is said in more words.
        """
        if is_fast(period, board.identity):
            board.describe(Mode.BURST)
        more = signs(self.rig, board.identity, board.descriptors)
        config = self._configure(board, self.rig, **more)
        board.check_same()  # which a configuration that was lost would have shown
        return config

    def _say_contradictions(self, board: Board, read_v: float | None) -> None:
        if self.say is None:
            return
        period = sample_period(self.rig, board.identity)
        known = board.identity, board.descriptors
        for sentence in contradictions(self.rig, self.program, *known, read_v, period):
            self.say(sentence)

    def _zero(self, board: Board, journal: JournalWriter, config: Fields) -> Fields:
        rate_hz = board.identity["clock_hz"] / config["sample_period_ticks"]
        samples = int(min(max(ZERO_S * rate_hz, 16), 4096))
        journal.mark(board.port.now(), zero_samples=samples)
        zero = board.zero(samples)
        check_zero(zero, board.descriptors)
        return zero

    def _keep(
        self,
        journal: JournalWriter,
        reason: str,
        path: Path,
        force: bool,
        failure: Exception | None,
    ) -> int:
        """Samples saved in ``path``; the journal goes once they are safe there, or were none.

        Raises what keeps them out of it, after what ended the run (``failure``), if anything.
        """
        if self.recorded is not None:
            reason = getattr(self.port, "end", None) or ""
        if reason:
            with contextlib.suppress(DataError):  # the disk: close says it
                journal.mark(self.port.now(), end=reason)
        try:
            journal.close()
            kept = keep(journal.path, path, force=force)
        except NoSamplesError:
            journal.discard()
            return 0
        except NoPlaceError as error:
            aside = set_aside(journal.path, RAW)
            said = f"{error}; they are kept as they came in {aside}: report it"
            raise _after(failure, NoPlaceError(said)) from None
        except MotoridError as error:
            raise _after(failure, error) from None
        if kept.unplaced:
            set_aside(journal.path, RAW)
        else:
            journal.discard()
        return kept.samples


def streaming(rig: Rig, board: Board) -> Rig:
    """``rig``, with a stream at the board's best in place of a fast burst.

    Zero and the first pulse last longer than a fast burst is kept.
    """
    if not is_fast(sample_period(rig, board.identity), board.identity):
        return rig
    rate_hz = board.identity["clock_hz"] / board.identity["min_sample_period_ticks"]
    return replace(rig, sampling=replace(rig.sampling, mode="stream", rate_hz=rate_hz))


def configure(board: Board, rig: Rig, **more: int) -> Fields:
    """Limits on the board, read back and compared. Raises RigError or LinkError.

    ``more``: further fields of the command.
    """
    wanted = configuration(rig, board.identity, board.descriptors) | check(board, rig) | more
    board.ask("configure", **wanted)
    config = board.ask("read_config")
    if wrong := differing(wanted, config, board.identity["protocol_minor"]):
        raise LinkError(f"{board.port.name}: the board holds other limits than sent: {wrong}")
    return config


def _end_of(error: MotoridError) -> str:
    """What an error that ended a run says in the capture; nothing where the board has said it."""
    if isinstance(error, BoardResetError):
        return f"reset: {error.cause}"
    return "link lost" if isinstance(error, LinkError) else ""


def _with(failure: Exception, more: str) -> Exception:
    """``failure``, with more to its sentence where it is one of ours."""
    if not isinstance(failure, MotoridError):
        return failure
    said = type(failure)(f"{failure}{more}")
    said.__dict__.update(failure.__dict__)  # what it carries besides its sentence
    return said


def _after(failure: Exception | None, error: MotoridError) -> Exception:
    """One error that says both what ended a run, and what keeps it out of its file."""
    if failure is None:
        return error
    return failure if str(failure) == str(error) else _with(failure, f"; {error}")


def _where(samples: int, path: Path) -> str:
    return f"; {samples} samples are kept in {path}" if samples else ""
