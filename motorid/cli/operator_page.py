"""The operator's page of motorid station: what the screen shows, on a page beside it."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import click

from motorid.workflow.witness import Witness

if TYPE_CHECKING:
    from motorid.cli.live import Listen
    from motorid.report.screen import Screen
    from motorid.workflow.check import Inspection, Line
    from motorid.workflow.station import Station

READY = "READY"


class OperatorPage(Witness):
    """Shows each screen on ``terminal`` and, while it is served, on a page.

    The page gets the samples of each run from ``line``.
    """

    def __init__(self, line: Line, name: str, terminal: Callable[[Screen], None]) -> None:
        from motorid.acquire.tap import Tap
        from motorid.web.hub import Hub
        from motorid.workflow.shift_board import ShiftBoard

        self.terminal, self.url = terminal, ""
        self.board = ShiftBoard(line.folder, line.product)
        self.station: Station | None = None
        tap = Tap()
        facts = {"product": line.product.title, "rig": line.rig.name, "station": name}
        self.hub = Hub(tap, facts)
        line.watch = tap.begin

    def judged(self, done: Inspection) -> None:
        """See ``Witness``."""
        self.board.judged(done)

    def show(self, screen: Screen) -> None:
        """One screen, in both places; the page's address stands under the first of them."""
        if self.station is not None:
            self.hub.post(**self.board.facts(screen, self.station))
        footer = f"page: {self.url}" if screen.word == READY and self.url else screen.footer
        self.terminal(replace(screen, footer=footer))

    @contextlib.contextmanager
    def served(self, station: Station, listen: Listen, *, scans: bool) -> Iterator[None]:
        """While it lasts, the page is there. ``scans``: it may give serial numbers."""
        from motorid.web.server import Server
        from motorid.web.station import station_app

        self.station = station
        self.hub.post(scans=scans)
        scanned = station.scanned if scans else None
        with Server(lambda: station_app(self.hub, scanned), listen.address()) as server:
            self.url = server.url
            click.echo(f"open {server.url}", err=True)
            yield
