"""What the steps of a calibration share: the rig, the person, and the board that answers."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorid.errors import RigError
from motorid.workflow.calibrate.person import Person

if TYPE_CHECKING:
    from motorid.acquire.record import Progress
    from motorid.acquire.session import Session
    from motorid.rig import Rig

Tables = dict[str, dict[str, Any]]  # of a calibration file, by name


@dataclass(frozen=True)
class Settings:
    """How long and how much. Seconds; ``host_uncertainty`` of this computer's clock, relative."""

    rest_s: float = 20.0
    zeros: int = 12
    hold_s: float = 4.0
    levels_v: tuple[float, ...] = ()
    clock_s: float = 30.0
    clock_pairs: int = 60
    host_uncertainty: float = 1e-5
    turns: float = 10.0
    runs: int = 3
    captures: Path | None = None  # folder that keeps the runs of the disc


@dataclass
class Bench:
    """What the steps share: the rig as it stands, the person, and what was found so far."""

    rig: Rig
    person: Person
    settings: Settings
    progress: Progress | None
    found: Tables
    board: dict[str, str]

    @contextmanager
    def session(self, setup: str) -> Iterator[Session]:
        """The board, its limits in force, with the set-up that a step needs."""
        from motorid.acquire.port import open_port
        from motorid.acquire.session import Session

        rig = self.person.arrange(self.rig, setup)
        port = open_port(rig.port)
        try:
            self.person.meet(port)
            session = Session(port, rig, self.progress)
            self._note_board(session, rig)
            yield session
        finally:
            port.close()

    def _note_board(self, session: Session, rig: Rig) -> None:
        from motorid.acquire.ports import serial_of

        who = session.board.identity
        firmware = ".".join(str(who[f"firmware_{part}"]) for part in ("major", "minor", "patch"))
        serial = rig.board_serial or serial_of(rig.port)
        board = {"name": str(who["board"]), "serial": serial, "firmware": firmware}
        if self.board and self.board != board:
            raise RigError(
                f"another board answers now ({board['name']} {board['serial']}) than at the steps "
                f"before ({self.board['name']} {self.board['serial']}): calibrate one at a time"
            )
        self.board = board


def now() -> datetime:
    """The time that a step's table carries."""
    return datetime.now(UTC).replace(microsecond=0)
