"""From a rig to a capture file: the only writer of captures from a board."""

from __future__ import annotations

import contextlib
import platform
import random
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from motorid import __version__
from motorid.acquire.assemble import NoSamplesError, assemble
from motorid.acquire.board import Board, Fields
from motorid.acquire.check import check_signs, check_supply, check_zero
from motorid.acquire.drive import Stop, drive, interruptible, load, tripped
from motorid.acquire.journal import journal_path, open_journal
from motorid.acquire.journal_writer import JournaledPort, JournalWriter
from motorid.acquire.leftover import is_journal, make_way, refuse_growing, set_aside, target_of
from motorid.acquire.link import Port
from motorid.acquire.live import Live, LiveView
from motorid.acquire.plan import (
    check_burst,
    configuration,
    differing,
    is_fast,
    sample_period,
    step_ticks,
    wire_program,
)
from motorid.acquire.port import open_port
from motorid.acquire.ports import serial_of
from motorid.acquire.resets import BoardResetError
from motorid.acquire.safety import check_program
from motorid.capture import store
from motorid.capture.model import NOTES, Capture
from motorid.capture.whole import refuse_existing
from motorid.errors import DataError, LinkError, MotoridError, RigError
from motorid.program import Program
from motorid.rig import Rig
from motorid.rig_calibration import citation, refuse_other_board
from motorid.wire.enums import Mode

Progress = Callable[[Live], None]
ZERO_S = 0.2


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
) -> list[Path]:
    """As ``capture``, one run for each path, over one opening of the port."""
    check_program(rig, program)
    for path in paths:
        refuse_existing(path, force)
    port = open_port(rig.port)
    try:
        with interruptible() as stop:
            for number, path in enumerate(paths):
                recorder = _Recorder(port, rig, program, stop, progress)
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
) -> Path:
    """As ``capture``, over a port that is open and stays so.

    ``checked``: signs were checked on this motor already, so no pulse goes before the program.
    """
    check_program(rig, program)
    refuse_existing(path, force)
    with interruptible() as stop:
        _Recorder(port, rig, program, stop, progress).record(
            path, force, serial, note, checked=checked
        )
    return path


def recover(path: Path) -> Path:
    """Builds the capture that a journal holds, beside it; returns the capture's path.

    ``path`` is the journal, perhaps set aside, or the capture that it was meant for. Raises
    DataError when it holds no sample (it is set aside then, so that its name is free), UsageError
    when the capture exists or the journal is still being written.
    """
    journal = path if is_journal(path) else journal_path(path)
    target = target_of(journal)
    refuse_existing(target, force=False)
    refuse_growing(journal)
    try:
        with open_journal(journal) as contents:
            run = assemble(contents)
    except NoSamplesError as error:
        aside = set_aside(journal, "empty")
        raise NoSamplesError(f"{journal}: {error}; it is {aside.name} now") from None
    store.save(run, target)
    if contents.torn:  # keep what a person may still read out of it
        set_aside(journal, "torn")
    else:
        journal.unlink()
    return target


def remarks(capture: Capture) -> list[str]:
    """What a person should know of a capture: what it lacks, and which of its sensors failed."""
    return [said for said in (missing(capture), *capture.provenance.get(NOTES, ())) if said]


def missing(capture: Capture) -> str:
    """What a capture lacks of its run, in a sentence; empty when nothing."""
    parts = []
    if capture.end_reason != "completed":
        parts.append(f"the run ended early ({capture.end_reason})")
        if capture.program is not None and len(capture) > 1:
            parts.append(f"{capture.time_s[-1]:.3f} of {capture.program.duration_s:.3f} s are here")
    lost = sum(gap.samples for gap in capture.gaps)
    if lost:
        plural = "s" if len(capture.gaps) > 1 else ""
        parts.append(f"{lost} samples are missing in {len(capture.gaps)} gap{plural}")
    return "; ".join(parts)


class _Recorder:
    """One run into one file."""

    def __init__(
        self, port: Port, rig: Rig, program: Program, stop: Stop, progress: Progress | None
    ) -> None:
        self.port, self.rig, self.program = port, rig, program
        self.stop, self.progress = stop, progress
        self.measuring = False  # whether the journal holds any of the run proper
        self.recorded: Any = getattr(port, "header", None)  # of a replay: what was, is again

    def record(self, path: Path, force: bool, serial: str, note: str, *, checked: bool) -> None:
        """Measures and saves; raises afterwards what ended the run early."""
        header = self.recorded or _header(self.rig, self.program, serial, note)
        if force:
            make_way(path)
        journal = JournalWriter(journal_path(path), header)
        failure: MotoridError | None = None
        reason = ""
        try:
            board = Board(JournaledPort(self.port, journal), int(header.get("first_request", 1)))
            reason = self._measure(board, journal, checked)
        except MotoridError as error:
            failure = error
            reason = _end_of(error)
        except BaseException as error:  # a second Ctrl-C, or the caller's own: quit at once
            with contextlib.suppress(DataError):
                journal.close()
            if not isinstance(error, KeyboardInterrupt):
                raise
            if not self.measuring:
                journal.discard()
                raise KeyboardInterrupt("interrupted twice; nothing was measured") from None
            raise KeyboardInterrupt(
                f"interrupted twice; `motorid recover {journal.path}` keeps what arrived"
            ) from None
        kept = self._keep(journal, reason, path, force)
        if failure is not None:
            raise type(failure)(f"{failure}{_where(kept, path)}")
        if reason.startswith("fault"):
            raise RigError(f"{tripped(reason)}{_where(kept, path)}")
        if self.stop.requested:
            raise KeyboardInterrupt(f"interrupted{_where(kept, path) or '; nothing was measured'}")

    def _measure(self, board: Board, journal: JournalWriter, checked: bool) -> str:
        """The whole conversation with the board; returns why the run ended."""
        rig = self.rig
        board.identify()
        if rig.calibrated is not None and self.recorded is None:
            serial = rig.board_serial or serial_of(rig.port)
            refuse_other_board(rig.calibrated, board.identity["board"], serial)
        board.make_ready()
        config = configure(board, streaming(rig, board))
        zero = self._zero(board, journal, config)
        supply_v = check_supply(board, rig)
        pulse = {} if checked else check_signs(board, rig, config, zero, supply_v, self.stop)
        if self.stop.requested:
            return "interrupted"
        check_program(
            rig,
            self.program,
            resistance_ohm=pulse.get("resistance_bound_ohm"),
            supply_v=supply_v,
        )
        period = sample_period(rig, board.identity)
        wire = wire_program(self.program, board.identity, step_ticks(period, board.identity))
        check_burst(rig, wire, board.identity, period)
        if is_fast(period, board.identity):
            board.describe(Mode.BURST)
            config = configure(board, rig)
        load(board, wire)
        journal.mark(
            board.port.now(),
            measure=True,
            wire_steps=wire.origin,
            samples=wire.ticks // period,
            check=pulse,
        )
        self.measuring = True
        view = LiveView(rig, board, zero, wire, self.progress)
        reason = drive(board, wire, config, self.stop, view.consume)
        return "interrupted" if self.stop.requested and reason == "stopped" else reason

    def _zero(self, board: Board, journal: JournalWriter, config: Fields) -> Fields:
        rate_hz = board.identity["clock_hz"] / config["sample_period_ticks"]
        samples = int(min(max(ZERO_S * rate_hz, 16), 4096))
        journal.mark(board.port.now(), zero_samples=samples)
        zero = board.zero(samples)
        check_zero(zero, board.descriptors)
        return zero

    def _keep(self, journal: JournalWriter, reason: str, path: Path, force: bool) -> int:
        """Samples saved in ``path``; the journal goes once they are safe there, or were none."""
        if self.recorded is not None:
            reason = getattr(self.port, "end", None) or ""
        if reason:
            with contextlib.suppress(DataError):  # the disk: close says it
                journal.mark(self.port.now(), end=reason)
        journal.close()
        try:
            with open_journal(journal.path) as contents:
                run = assemble(contents)
        except NoSamplesError:
            journal.discard()
            return 0
        try:
            store.save(run, path, force)
        except MotoridError as error:
            raise type(error)(
                f"{error}; the run is in {journal.path}: `motorid recover` builds the capture"
            ) from None
        journal.discard()
        return len(run)


def streaming(rig: Rig, board: Board) -> Rig:
    """``rig``, with a stream at the board's best in place of a fast burst.

    Zero and the first pulse last longer than a fast burst is kept.
    """
    if not is_fast(sample_period(rig, board.identity), board.identity):
        return rig
    rate_hz = board.identity["clock_hz"] / board.identity["min_sample_period_ticks"]
    return replace(rig, sampling=replace(rig.sampling, mode="stream", rate_hz=rate_hz))


def configure(board: Board, rig: Rig) -> Fields:
    """Limits on the board, read back and compared. Raises RigError or LinkError."""
    wanted = configuration(rig, board.identity, board.descriptors)
    board.ask("configure", **wanted)
    config = board.ask("read_config")
    if wrong := differing(wanted, config):
        raise LinkError(f"{board.port.name}: the board holds other limits than sent: {wrong}")
    return config


def _end_of(error: MotoridError) -> str:
    """What an error that ended a run says in the capture; nothing where the board has said it."""
    if isinstance(error, BoardResetError):
        return f"reset: {error.cause}"
    return "link lost" if isinstance(error, LinkError) else ""


def _where(samples: int, path: Path) -> str:
    return f"; {samples} samples are kept in {path}" if samples else ""


def _header(rig: Rig, program: Program, serial: str, note: str) -> dict[str, Any]:
    """What a journal says of the run that follows: all that its bytes do not."""
    file = rig.calibrated
    calibrated = {"calibration_file": citation(rig), "calibration_text": file.text} if file else {}
    return calibrated | {
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
        "motorid": __version__,
        "first_request": random.randrange(1, 0xFFFF),  # noqa: S311 - unlike the last session's
        "port": rig.port,
        "rig_name": rig.name,
        "rig": rig.text,
        "wiring": asdict(rig.wiring) | {"supply_voltage_v": rig.supply_voltage_v or 0.0},
        "voltage_sense": rig.voltage_sense,
        "calibration": {name: asdict(one) for name, one in rig.calibration.items()},
        "clock": {"rate": rig.clock_rate, "uncertainty": rig.clock_uncertainty},
        "board_serial": rig.board_serial or serial_of(rig.port),
        "program": program.to_dict(),
        "ambient_c": rig.ambient_c,
        "ambient_uncertainty_c": rig.ambient_uncertainty_c,
        "serial": serial,
        "note": note,
        "host": {"python": platform.python_version(), "system": platform.platform(terse=True)},
    }
