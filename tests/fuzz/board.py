"""Captures from hostile boards, by a seed, and what must hold of each.

Of any board: the host ends within bounds and with a sentence; it asked for an open bridge, or the
run was over by the board's word; every sample that was read is in the capture, or in a journal that
stays; every journal recovers to the file that the capture made, or costs one sentence.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

from motorid.acquire import leftover, record
from motorid.acquire.journal import Kind, open_journal
from motorid.acquire.journal_writer import JournalWriter
from motorid.capture import store
from motorid.capture.model import Capture
from motorid.errors import MotoridError
from motorid.wire.codec import BadPayload, Command, Event, Reply, SampleBlock, decode
from motorid.wire.enums import Channel, State, Status
from motorid.wire.framing import Decoder, Frame
from tests.acquire.rigs import sim_rig
from tests.fuzz.hostile_habits import Hostility
from tests.fuzz.sentence import check_sentence

MEMORY = Path("/dev/shm")  # Linux: files that cost no disk
LONGEST_S = 600.0  # of the port's clock
MOST_READS = 200_000
RATE_HZ = 2000.0
PERIOD = 8000  # ticks of the board, at this rate


@dataclass
class Case:
    """What came of one board."""

    error: BaseException | None
    capture: Capture | None
    copy: Path  # of the journal as it was when it was closed
    left: list[Path]  # journals that stay


def run_case(seed: int, folder: Path) -> str:
    """One capture from one hostile board; what came of it in a word. Raises AssertionError."""
    hostile = Hostility(seed)
    path = folder / "run.h5"
    with copied(folder / "copy") as copy:
        error = captured(hostile, path)
    left = [one for one in folder.iterdir() if leftover.is_journal(one)]
    capture = store.load(path) if path.exists() else None
    case = Case(error, capture, copy, left)
    check_end(hostile, case)
    check_kept(case)
    check_recovery(case, folder)
    if isinstance(error, KeyboardInterrupt):
        return "interrupted"
    kept = "kept" if capture is not None else "raw" if left else "nothing"
    return f"exit {getattr(error, 'exit_code', 0)}, {kept}"


def captured(hostile: Hostility, path: Path) -> BaseException | None:
    """Captures; the error that came of it, which must be one for people."""
    rig = sim_rig()
    rig = replace(rig, sampling=replace(rig.sampling, rate_hz=RATE_HZ))
    port = hostile.port
    act = port.before_read

    def bounded() -> None:
        assert port.now() < LONGEST_S, "the capture does not end"
        assert port.reads < MOST_READS, "the capture reads on and on"
        act()

    port.before_read = bounded
    try:
        with mock.patch.object(record, "open_port", return_value=port):
            record.capture(rig, rig.program, path)
    except (MotoridError, KeyboardInterrupt) as error:
        return error
    assert path.exists(), "success without a file"
    return None


@contextmanager
def copied(target: Path) -> Iterator[Path]:
    """Keeps a copy of the journal as it is once it is closed."""
    close = JournalWriter.close

    def close_and_copy(self: JournalWriter) -> None:
        close(self)
        target.mkdir(exist_ok=True)
        shutil.copyfile(self.path, target / "run.h5.journal")

    with mock.patch.object(JournalWriter, "close", close_and_copy):
        yield target / "run.h5.journal"


def check_end(hostile: Hostility, case: Case) -> None:
    """A sentence, and a bridge that was asked to open."""
    if case.error is not None and str(case.error):
        check_sentence(str(case.error), hostile.port.read_bytes)
        assert "\n" not in str(case.error)
    if case.copy.exists() and not hostile.port.gone:
        assert stopped(case.copy), f"no stop was sent after the last start: {case.error}"


def stopped(journal: Path) -> bool:
    """Whether what was started last was asked to stop, or was over by the board's word."""
    over = True
    for message, _ in messages(journal):
        match message:
            case Command(name="start"):
                over = False
            case Command(name="stop") | Event(name="done" | "hello"):
                over = True
            case Reply(name="read_status", status=Status.OK):
                over = over or message.fields["state"] != State.RUNNING
    return over


def messages(journal: Path) -> Iterator[tuple[Any, bool]]:
    """What the host sent and read, in order, and whether the run proper had begun."""
    decoders, measuring = {Kind.SENT: Decoder(), Kind.RECEIVED: Decoder()}, False
    with open_journal(journal) as contents:
        for one in contents:
            if one.kind is Kind.MARK:
                measuring = measuring or "measure" in one.json
            for frame in decoders[one.kind].feed(one.data) if one.kind in decoders else ():
                try:
                    yield decode(frame.payload if isinstance(frame, Frame) else b""), measuring
                except BadPayload:
                    continue


def check_kept(case: Case) -> None:
    """Every sample that was read in the run is in the file, or the journal stays."""
    if case.left or not case.copy.exists():
        return
    rows = rows_of(case.capture) if case.capture is not None else {}
    for message, measuring in messages(case.copy):
        if not measuring or not isinstance(message, SampleBlock):
            continue
        for number, row in enumerate(message.samples.tolist()):
            tick = (message.first_tick + number * PERIOD) % 2**32
            assert rows.get(tick) == tuple(row), "a sample was read, and is nowhere"


def rows_of(capture: Capture) -> dict[int, tuple[int, ...]]:
    """Raw readings in the order of the wire, by tick modulo 2^32."""
    names = sorted(capture.channels, key=lambda name: Channel[name.upper()])
    columns = [np.asarray(capture.channels[name].raw, dtype=np.int64) for name in names]
    low = (np.stack(columns, axis=1) + (1 << 15)) % (1 << 16) - (1 << 15)
    return {
        tick % 2**32: tuple(row)
        for tick, row in zip(capture.ticks.tolist(), low.tolist(), strict=True)
    }


def check_recovery(case: Case, folder: Path) -> None:
    """The journal gives the same file again, or a sentence; and then it stays."""
    if not case.copy.exists():
        return
    target = case.copy.with_name("run.h5")
    refusal = ""
    with mock.patch.object(leftover, "STILL_GROWING_S", 0.0):
        try:
            record.recover(case.copy)
        except MotoridError as error:
            refusal = str(error)
    if refusal:
        check_sentence(refusal, 1000)
        assert case.capture is None, f"captured, and not recovered: {refusal}"
        assert any(map(leftover.is_journal, case.copy.parent.iterdir())), "a journal is gone"
    elif case.capture is not None:
        assert target.read_bytes() == (folder / "run.h5").read_bytes()


@contextmanager
def in_memory() -> Iterator[Path]:
    """A folder that costs no disk, where there is such a thing."""
    with tempfile.TemporaryDirectory(dir=MEMORY if MEMORY.is_dir() else None) as folder:
        yield Path(folder)


def fuzz(seconds: float, cases: int, seed: int) -> int:
    """Runs case after case; 1 where one breaks a promise. Prints what became of them."""
    seen: Counter[str] = Counter()
    broken = 0
    until = time.monotonic() + seconds
    for number in range(seed, seed + cases if cases >= 0 else sys.maxsize):
        if cases < 0 and time.monotonic() > until:
            break
        with in_memory() as folder:
            try:
                seen[run_case(number, folder)] += 1
            except Exception as error:
                broken += 1
                print(f"case {number} ({Hostility(number)}): {error!r}", file=sys.stderr)
    print(f"Done {sum(seen.values())} runs: {dict(sorted(seen.items()))}", file=sys.stderr)
    return 1 if broken else 0
