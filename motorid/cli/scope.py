"""motorid scope"""

from __future__ import annotations

import contextlib
import time
from pathlib import Path

import click

from motorid.cli import live
from motorid.cli.options import example, port_option, rig_option, speed_option, warned
from motorid.cli.values import Between
from motorid.errors import EXIT_DONE


@click.command(
    "scope",
    epilog=example(
        "motorid scope --rig sim",
        "motorid scope --rig bench.toml --allow-drive",
        "motorid scope --rig bench.toml --live=terminal",
    ),
)
@rig_option
@port_option
@speed_option
@click.option(
    "--live",
    "where",
    type=click.Choice([live.PAGE, live.TERMINAL]),
    default=live.PAGE,
    show_default=True,
    help="Show it on a page for a browser, or in this terminal.",
)
@click.option(
    "--allow-drive",
    is_flag=True,
    help="Let the page drive the motor: each press one program within the rig's limits.",
)
@click.option("--seconds", type=Between(min=0), help="End by itself after so long.")
@live.page_options
def command(
    rig_name: str,
    port: str | None,
    speed: str | None,
    where: str,
    allow_drive: bool,
    seconds: float | None,
    listen: str,
    allow_remote: bool,
    certificate: Path | None,
    key: Path | None,
) -> int:
    """Watch current, voltage, speed and position of a rig as they come, without a capture.

    The bridge stays open, so the motor turns only by hand. With --allow-drive the page has buttons.
    Each press runs the rig's program or a pulse once, after the checks of a capture. A page that
    falls silent stops it. Ctrl-C ends the scope.
    """
    from motorid.acquire.controls import Controls
    from motorid.acquire.interrupt import interruptible
    from motorid.acquire.port import open_port
    from motorid.acquire.scope import Scope
    from motorid.workflow.record import bench

    if allow_drive and where != live.PAGE:
        raise click.UsageError("--allow-drive is for the page, and --live=terminal has none.")
    rig = warned(bench(rig_name, port=port, speed=speed))
    address = live.Listen(listen, allow_remote, certificate, key)
    controls = Controls()
    with contextlib.ExitStack() as stack:
        stop = stack.enter_context(interruptible())  # first: a Ctrl-C while a port opens counts
        shown = (
            live.page(rig, address, controls if allow_drive else None, command="scope")
            if where == live.PAGE
            else live.terminal()
        )
        view = stack.enter_context(shown)
        link = stack.enter_context(contextlib.closing(open_port(rig.port)))
        scope = Scope(link, rig, view.watch, controls, view.say)
        until = time.monotonic() + seconds if seconds is not None else None
        scope.run(stop, lambda: until is not None and time.monotonic() >= until)
        if stop.requested:
            raise KeyboardInterrupt("the scope has ended, and the bridge is open")
    return EXIT_DONE
