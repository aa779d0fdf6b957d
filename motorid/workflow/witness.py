"""Who sees what a station does: the operator's page, a broker, a server of OPC UA."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from motorid.report.screen import Screen
    from motorid.workflow.check import Inspection


class Witness:
    """Is called from the thread of the board, which waits for it: it may only leave a note."""

    def judged(self, done: Inspection) -> None:
        """An inspection whose records are on disk, before its screen is shown."""

    def shown(self, screen: Screen) -> None:
        """A screen that was drawn."""

    def status(self) -> Mapping[str, Any]:
        """Its part of the station's status; from any thread."""
        return {}
