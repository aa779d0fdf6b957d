"""The operator's page: the word, the next step, the run as it goes on; with leave, scans."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from motorid.errors import UsageError
from motorid.web.guard import App
from motorid.web.hub import Hub
from motorid.web.pages import app_of
from motorid.workflow.access import INSPECT, Caller

START = "station.html"
LONGEST = 200  # characters of a serial number
Scanned = Callable[[str, Caller | None], None]  # a serial number, and who gave it: else operator


class Scanner:
    """One page whose serial numbers go to ``scanned``, as those of a scanner do."""

    def __init__(self, scanned: Scanned, caller: Caller) -> None:
        self.scanned, self.caller = scanned, caller

    def hear(self, asked: dict[str, Any]) -> None:
        """See ``pages.Talker``. Raises UsageError for what is no serial number."""
        if asked.get("ask") != "scan":
            return
        serial = asked.get("serial")
        if not isinstance(serial, str) or not serial.strip() or len(serial) > LONGEST:
            raise UsageError("scan a serial number, or type it and press Enter")
        if not self.caller.may(INSPECT):
            raise UsageError(f"the role {self.caller.role} may not start an inspection")
        self.scanned(serial.strip(), self.caller if self.caller.role else None)

    def gone(self) -> None:
        """See ``pages.Talker``. A run goes on, as it does when a scanner is unplugged."""


def station_app(hub: Hub, scanned: Scanned | None = None) -> App:
    """The operator's page of ``hub``. Without ``scanned`` it only watches."""
    talker = None if scanned is None else lambda caller: Scanner(scanned, caller)
    return app_of(hub, START, talker)
