"""Writes what a board says after a crash into docs/faults.md: ``python -m tests.emulated.crashes``.

Every cell is a firmware that is crashed here and now, behind the bootloader that the column names.
``--check`` writes nothing, and exits with 1 when the page says otherwise.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from motorid.wire.enums import Fault, ResetCause, State
from tests.conformance.boards import MCUSR, opened
from tests.conformance.client import Client
from tests.emulated.bootloaders import NAMES, hex_file

PAGE = Path(__file__).resolve().parents[2] / "docs" / "faults.md"
BEGIN, END = "<!-- crashes: python -m tests.emulated.crashes -->", "<!-- end of crashes -->"
MOTOR = "dunkermotoren-gr42"
BOOTS_WITHIN_S = 3.0
LEFT_IN_R2 = (0x00, 0x08, 0xF7, 0xFF)
COLUMNS = (("uno", False), ("uno", True), ("mega", True))
HEAD = "| what happens | when | no bootloader | " + " | ".join(NAMES.values()) + " |"


@dataclass(frozen=True)
class Crash:
    """What goes wrong, as the emulator's ``set`` has it."""

    what: str
    name: str
    value: float
    left_in_r2: tuple[int, ...] = (0x08,)


CRASHES = (
    Crash("the firmware hangs, interrupts off", "hang", 1, LEFT_IN_R2),
    Crash("the main loop hangs", "stall", 1),
    Crash("the firmware strays to its first instruction", "wander", 1),
    Crash("reset pin, or the port is opened", "reset", MCUSR[ResetCause.EXTERNAL]),
    Crash("brown-out", "reset", MCUSR[ResetCause.BROWN_OUT]),
    Crash("power away and back", "power", 1, (0x08, 0xFF)),
)


class Board:
    """A board behind its bootloader, or without one."""

    def __init__(self, name: str, boot: Path | None, stack: ExitStack) -> None:
        options = {"boot": str(boot)} if boot else {}
        emulated: Any = stack.enter_context(opened(name, motor=MOTOR, **options))
        self.emulator = emulated.port.board
        self.client = Client(emulated.port)
        self.wait_for_hello()
        self.client.bring_up()

    def wait_for_hello(self) -> None:
        """Let the bootloader end. Raises TimeoutError."""
        client = self.client
        until = client.port.now() + BOOTS_WITHIN_S
        while not any(message.name == "hello" for message in client.told):
            if client.port.now() > until:
                raise TimeoutError("the board did not start again")
            client.wait(5e-3)
        client.told.clear()

    def drive(self) -> None:
        """Begin a run, up to the closed bridge."""
        client = self.client
        client.start(client.coast(4), client.drive(40_000), host_silence_ms=5000)
        client.wait(client.seconds(20))
        assert self.emulator.facts()["enabled"]

    def crash(self, crash: Crash, running: bool, left_in_r2: int) -> tuple[ResetCause, bool]:
        """The cause that the board then tells, and whether it is latched."""
        client = self.client
        if client.state is State.FAULTED:
            client.get("clear_fault")
        if running:
            self.drive()
        client.told.clear()
        self.emulator.set(crash.name, crash.value)
        self.emulator.set("r2", left_in_r2)
        self.wait_for_hello()
        assert not self.emulator.facts()["enabled"]
        identity = client.get("identify", host_major=1, host_minor=3)
        status = client.get("read_status")
        latched = status["state"] == State.FAULTED
        assert status["fault"] == (Fault.WATCHDOG if latched else Fault.NONE)
        assert status["state"] in (State.FAULTED, State.IDLE)
        return ResetCause(identity["reset_cause"]), latched


def cell(board: Board, crash: Crash, running: bool) -> str:
    """One cell; whatever r2 held, it must be the same."""
    told = {board.crash(crash, running, r2) for r2 in crash.left_in_r2}
    assert len(told) == 1, f"{crash.what}: r2 decides: {told}"
    (cause, latched) = told.pop()
    return f"{cause.name.lower()}, latched" if latched else cause.name.lower()


WHEN = {True: "in a run", False: "at rest"}


def rows(whens: Sequence[bool] = (True, False)) -> Iterable[str]:
    """The table's rows, of crashes in a run, at rest, or both."""
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        boards = [
            Board(name, hex_file(name, Path(folder)) if booted else None, stack)
            for name, booted in COLUMNS
        ]
        for crash in CRASHES:
            for running in whens:
                cells = [cell(board, crash, running) for board in boards]
                yield f"| {' | '.join([crash.what, WHEN[running], *cells])} |"


def table_head() -> list[str]:
    """The table's first two lines."""
    return [HEAD, "|---|---|---|---|---|"]


def table() -> str:
    """The page's section between its marks."""
    return "\n".join(["", *table_head(), *rows(), ""])


def told() -> str:
    """The same as the page has it now."""
    return PAGE.read_text(encoding="utf-8").partition(BEGIN)[2].partition(END)[0].strip("\n")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true")
    made = table().strip("\n")
    if parser.parse_args().check:
        return int(made != told())
    page = PAGE.read_text(encoding="utf-8")
    before, _, rest = page.partition(BEGIN)
    PAGE.write_text(f"{before}{BEGIN}\n\n{made}\n\n{END}{rest.partition(END)[2]}", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
