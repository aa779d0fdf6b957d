"""A board held open by a script: run after run over one link."""

from __future__ import annotations

import itertools
import shutil
import tempfile
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from motorid.errors import UsageError

if TYPE_CHECKING:
    from motorid.acquire.port import Port
    from motorid.acquire.record import Progress
    from motorid.capture.model import Capture
    from motorid.program import Program
    from motorid.rig import Rig


class Connection:
    """An open link to the board of a rig; leaving the ``with`` block closes it.

    The firmware opens the bridge by itself when the host falls silent, so a script that dies leaves
    no motor running.
    """

    def __init__(self, rig: Rig) -> None:
        from motorid.acquire.port import open_port

        self.rig = rig
        self._port: Port | None = open_port(rig.port)
        self._scratch: Path | None = None
        self._numbers = itertools.count(1)

    def __enter__(self) -> Connection:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Gives the link back and deletes captures that were given no path. May be called twice."""
        if self._port is not None:
            self._port.close()
            self._port = None
        if self._scratch is not None:
            shutil.rmtree(self._scratch, ignore_errors=True)
            self._scratch = None

    def run(
        self,
        program: Program | None = None,
        *,
        path: str | PathLike[str] | None = None,
        serial: str = "",
        note: str = "",
        force: bool = False,
        progress: Progress | None = None,
    ) -> Capture:
        """Drives the motor through ``program`` (the rig's own, if none) and returns the capture.

        It is on disk first: in ``path``, or in a scratch folder that goes with the connection.
        Raises RigError, LinkError, or UsageError where ``path`` exists and ``force`` is not given.
        """
        from motorid.acquire.record import capture_over
        from motorid.capture import store

        if self._port is None:
            raise UsageError("the connection is closed: connect again")
        where = capture_over(
            self._port,
            self.rig,
            program or self.rig.program,
            Path(path) if path is not None else self._next(),
            force=force,
            progress=progress,
            serial=serial,
            note=note,
        )
        return store.load(where)

    def _next(self) -> Path:
        if self._scratch is None:
            self._scratch = Path(tempfile.mkdtemp(prefix="motorid-"))
        return self._scratch / f"run-{next(self._numbers)}.h5"
