"""motorid dashboard"""

from __future__ import annotations

import contextlib
import time
from pathlib import Path
from typing import TYPE_CHECKING

import click

from motorid.cli import live
from motorid.cli.options import example, moved_option
from motorid.cli.values import Between
from motorid.errors import EXIT_DONE

if TYPE_CHECKING:
    from motorid.storage.place import Place

POLL_S = 0.2


@click.command(
    "dashboard",
    epilog=example(
        "motorid dashboard line.db",
        "motorid dashboard line.db --captures shift --listen 7413",
        "motorid dashboard postgresql://db/line --listen 10.0.0.5:7413 --allow-remote "
        "--certificate cert.pem --key key.pem --tokens tokens.json",
    ),
)
@click.argument("where", metavar="HISTORY")
@moved_option
@click.option(
    "--tokens",
    "token_file",
    type=live.pem_file,
    help="File of tokens and roles: the page is at each one's address too.",
)
@click.option("--seconds", type=Between(min=0), help="End by itself after so long.")
@live.page_options
def command(
    where: str,
    folders: tuple[Place, ...],
    token_file: Path | None,
    seconds: float | None,
    listen: str,
    allow_remote: bool,
    certificate: Path | None,
    key: Path | None,
) -> int:
    """Show a line's history on a page: yield, reasons, charts, stations, and each result.

    The page only reads. Its address holds the filters, so that a view can be kept as a bookmark.
    Ctrl-C ends it.
    """
    from motorid.acquire.interrupt import interruptible
    from motorid.quality.history import open_history
    from motorid.web.dashboard import Dashboard, dashboard_app
    from motorid.web.server import Server
    from motorid.workflow.access import Tokens

    tokens = Tokens(token_file) if token_file else None
    if tokens is not None:
        tokens.all()  # raises for what is none
    address = live.Listen(listen, allow_remote, certificate, key, tokens=tokens).address()
    with contextlib.ExitStack() as stack:
        history = stack.enter_context(open_history(where, create=False))
        board = Dashboard(history, folders)
        server = stack.enter_context(Server(lambda: dashboard_app(board), address))
        stop = stack.enter_context(interruptible())
        click.echo(f"open {server.url}", err=True)
        until = time.monotonic() + seconds if seconds is not None else None
        while not stop.requested and (until is None or time.monotonic() < until):
            time.sleep(POLL_S)
    return EXIT_DONE
