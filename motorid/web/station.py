"""The operator's page: the word, the next step, the run as it goes on; with leave, scans."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from motorid.errors import UsageError
from motorid.web.guard import App
from motorid.web.hub import Hub
from motorid.web.pages import app_of

START = "station.html"
LONGEST = 200  # characters of a serial number


class Scanner:
    """One page whose serial numbers go to ``scanned``, as those of a scanner do."""

    def __init__(self, scanned: Callable[[str], None]) -> None:
        self.scanned = scanned

    def hear(self, asked: dict[str, Any]) -> None:
        """See ``pages.Talker``. Raises UsageError for what is no serial number."""
        if asked.get("ask") != "scan":
            return
        serial = asked.get("serial")
        if not isinstance(serial, str) or not serial.strip() or len(serial) > LONGEST:
            raise UsageError("scan a serial number, or type it and press Enter")
        self.scanned(serial.strip())

    def gone(self) -> None:
        """See ``pages.Talker``. A run goes on, as it does when a scanner is unplugged."""


def station_app(hub: Hub, scanned: Callable[[str], None] | None = None) -> App:
    """The operator's page of ``hub``. Without ``scanned`` it only watches."""
    return app_of(hub, START, None if scanned is None else lambda: Scanner(scanned))
