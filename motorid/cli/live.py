"""--live: a run shown while it goes on, on a page or in the terminal, for several commands."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from motorid.cli.streams import prompt
from motorid.cli.values import Named

if TYPE_CHECKING:
    from motorid.acquire.controls import Controls
    from motorid.acquire.tap import Watch
    from motorid.rig import Rig
    from motorid.web.address import Address
    from motorid.web.hub import Hub
    from motorid.workflow.access import Tokens

Command = TypeVar("Command", bound=Callable[..., Any])
PAGE, TERMINAL = "page", "terminal"
LAST_S = 1.0  # for pages to take the end of a run


capture_option = click.option(
    "--live",
    "where",
    is_flag=False,
    flag_value=PAGE,
    type=click.Choice([PAGE, TERMINAL]),
    help="Show the run as it goes on: --live on a page for a browser, --live=terminal here.",
)


def operator_options(command: Command) -> Command:
    """--page, --allow-drive, --certificate and --key: the operator's page of a station."""
    for option in (
        click.option("--key", type=pem_file, help="The certificate's key, a PEM file."),
        click.option(
            "--certificate", type=pem_file, help="Encrypt page, orders and OPC UA, with this."
        ),
        click.option("--allow-drive", is_flag=True, help="Let the page scan serial numbers."),
        click.option(
            "--page",
            metavar="[HOST:]PORT",
            help="Show the operator's screen on a page there, for a browser.",
        ),
    ):
        command = option(command)
    return command


@dataclass(frozen=True)
class Listen:
    """Where the page is to be served, as the options say. ``option``: which of them names it."""

    text: str
    remote: bool
    certificate: Path | None
    key: Path | None
    option: str = "--listen"
    tokens: Tokens | None = None

    def address(self) -> Address:
        """Raises UsageError where it may not be served there."""
        from motorid.web.address import parse_listen

        return parse_listen(
            self.text,
            remote=self.remote,
            certificate=self.certificate,
            key=self.key,
            option=self.option,
            tokens=self.tokens,
        )


pem_file = Named(exists=True, dir_okay=False, path_type=Path)


def page_options(command: Command) -> Command:
    """--listen, --allow-remote, --certificate and --key: where a page is served."""
    for option in (
        click.option("--key", type=pem_file, help="The certificate's key, a PEM file."),
        click.option(
            "--certificate", type=pem_file, help="Serve the page by TLS, with this PEM file."
        ),
        click.option(
            "--allow-remote",
            is_flag=True,
            help="Let --listen name more than this computer; needs --certificate and --key.",
        ),
        click.option(
            "--listen",
            default="127.0.0.1:7411",
            show_default=True,
            metavar="[HOST:]PORT",
            help="Where the page is served; 0: any free port.",
        ),
    ):
        command = option(command)
    return command


class View:
    """What a run gives its samples to, and what it says of itself."""

    def __init__(self, watch: Watch, post: Callable[..., None]) -> None:
        self.watch, self._post = watch, post
        self._said = 0

    def say(self, state: str, text: str) -> None:
        """Shows a state and a sentence above the curves."""
        self._said += 1
        self._post(state=state, text=text, said=self._said)


@contextlib.contextmanager
def page(
    rig: Rig, listen: Listen, controls: Controls | None = None, **facts: Any
) -> Iterator[View]:
    """A page on its address, which is said on stderr. ``controls``: it may drive."""
    from motorid.acquire.safety import check_program
    from motorid.acquire.tap import Tap
    from motorid.web.hub import Hub
    from motorid.web.live import Desk, live_app
    from motorid.web.server import Server

    address = listen.address()
    desk, drive = None, None
    if controls is not None:
        silence_s = rig.limits.host_silence_s
        desk = Desk(controls, rig.program, silence_s, lambda program: check_program(rig, program))
        drive = {"silence_s": silence_s, "program_s": rig.program.duration_s}
    tap = Tap()
    hub = Hub(tap, {"rig": rig.name, "drive": drive, **facts})
    with Server(lambda: live_app(hub, desk), address) as server:
        click.echo(f"open {server.url}", err=True)
        try:
            yield View(tap.begin, hub.post)
        finally:
            _settle(hub)


def _settle(hub: Hub) -> None:
    """Gives the pages a moment to take what is left for them."""
    until = time.monotonic() + LAST_S
    while not hub.settled and time.monotonic() < until:
        time.sleep(0.02)


@contextlib.contextmanager
def terminal() -> Iterator[View]:
    """Curves in the terminal, drawn by a thread that the run does not wait for."""
    from motorid.acquire.tap import Tap
    from motorid.cli.live_screen import LiveScreen

    tap = Tap()
    with LiveScreen(tap, sys.stderr) as screen:
        yield View(tap.begin, screen.post)


@contextlib.contextmanager
def capture_view(where: str | None, rig: Rig, listen: Listen, serial: str) -> Iterator[View | None]:
    """What ``capture --live`` shows its runs on; None without that option.

    At a terminal the run waits for a person who has opened the page.
    """
    if where is None:
        yield None
        return
    if where == TERMINAL:
        with terminal() as view:
            yield view
        return
    with page(rig, listen, command="capture", serial=serial) as view:
        if sys.stdin.isatty():
            view.say("waiting", "the run begins when Enter is pressed in the terminal")
            prompt("press Enter to begin", err=True, default="", show_default=False)
        view.say("measuring", "")
        try:
            yield view
        except BaseException as error:
            view.say("over", str(error) or "interrupted")
            raise
        view.say("over", "the run is over, and its file is written")
