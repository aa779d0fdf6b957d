"""motorid station"""

from __future__ import annotations

import contextlib
import os
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from motorid.cli import live
from motorid.cli.options import (
    example,
    port_option,
    product_option,
    rig_option,
    speed_option,
    warned,
)
from motorid.cli.paged import Paged
from motorid.cli.streams import paint
from motorid.cli.values import Kept, Named, Whole
from motorid.errors import EXIT_DONE

if TYPE_CHECKING:
    from motorid.quality.product import Product
    from motorid.report.screen import Screen
    from motorid.storage.place import File
    from motorid.workflow.check import Line
    from motorid.workflow.mqtt.witness import MqttWitness
    from motorid.workflow.opcua.witness import OpcUaWitness

DEFAULT_LISTEN = "127.0.0.1:7410"


@click.command(
    "station",
    cls=Paged,
    common=(
        *("product_name", "rig_name", "port", "output", "listen", "no_listen", "page"),
        *("allow_drive", "certificate", "key", "allow_remote", "token_file", "history"),
        *("name", "operator", "broker", "opcua"),
    ),
    epilog=example(
        "motorid station --product sim-disc --rig sim-line -o shift",
        "motorid station --product m17.toml --rig bench.toml --listen 7500 -o shift",
        "motorid station --product m17.toml --rig bench.toml --page 7412 -o shift",
        "motorid station --product m17.toml --rig bench.toml --station line-1 --mqtt mqtt.toml",
    ),
)
@product_option
@rig_option
@port_option
@speed_option
@click.option(
    "-o",
    "--output",
    type=Kept(file_okay=False, path_type=Path),
    default=Path("inspections"),
    show_default=True,
    help="Folder (or s3://...) that gets a folder for each inspection.",
)
@click.option(
    "--listen",
    default=DEFAULT_LISTEN,
    show_default=True,
    metavar="[HOST:]PORT",
    help="Where a line controller sends its orders.",
)
@click.option("--no-listen", is_flag=True, help="Take no orders but the scanner's.")
@live.operator_options
@click.option("--allow-remote", is_flag=True, help="Let these name more than this computer.")
@click.option(
    "--tokens",
    "token_file",
    type=live.pem_file,
    help="File of tokens and roles; a line controller says one of them first.",
)
@click.option(
    "--queue",
    "depth",
    type=Whole(1, 100),
    default=1,
    show_default=True,
    help="Orders in work at most; above 1 only where a machine changes the motors.",
)
@click.option("--history", help="History that gets the verdicts: a file, or a URL.")
@click.option("--station", "name", default="", help="This station's name in records and history.")
@click.option("--operator", default="", help="Who works here, for records and history.")
@click.option(
    "--mqtt",
    "broker",
    type=Named(exists=True, dir_okay=False, path_type=Path),
    help="Settings file of the MQTT broker that gets state and verdicts.",
)
@click.option(
    "--trusted",
    type=Named(exists=True, dir_okay=False, path_type=Path),
    help="File of trusted keys: refuse limits that none of them signed.",
)
@click.option("--opcua", metavar="[HOST:]PORT", help="Serve the station there by OPC UA.")
def command(
    product_name: str,
    rig_name: str,
    port: str | None,
    speed: str | None,
    output: File,
    listen: str,
    no_listen: bool,
    page: str | None,
    allow_drive: bool,
    certificate: Path | None,
    key: Path | None,
    allow_remote: bool,
    token_file: Path | None,
    depth: int,
    history: str | None,
    name: str,
    operator: str,
    broker: Path | None,
    trusted: Path | None,
    opcua: str | None,
) -> int:
    """Inspect motor after motor: scan a serial number, see PASS, FAIL or INVALID.

    Serial numbers come from a scanner that types, the keyboard, or a line controller over TCP.
    Ctrl-D ends the shift. Captures and results are on disk before a verdict is shown; a station
    that was killed judges what it left unfinished when it starts again.
    """
    from motorid.cli.operator_page import OperatorPage
    from motorid.quality.product import load_product
    from motorid.storage.place import Url
    from motorid.workflow import spool, station_words
    from motorid.workflow.access import Tokens
    from motorid.workflow.check import Line, Who
    from motorid.workflow.orders import Orders
    from motorid.workflow.record import bench
    from motorid.workflow.shift_history import ShiftHistory
    from motorid.workflow.station import Station, reader
    from motorid.workflow.uploads import Uploads

    if page is None and allow_drive:
        raise click.UsageError("--allow-drive is for --page.")
    product = load_product(product_name)
    if trusted is not None:
        _refuse_unsigned(product, product_name, trusted)
    rig = warned(bench(rig_name, port=port, speed=speed))
    address = live.Listen(listen, allow_remote, certificate, key).address()
    if token_file is None and not address.loopback and not no_listen:
        raise click.UsageError(
            f"--listen {listen} goes over a network, so orders need a token: add --tokens FILE "
            "(`motorid token add FILE --role operator --name line` makes one)."
        )
    tokens = Tokens(token_file) if token_file else None
    if tokens is not None:
        tokens.all()  # raises for what is none
    folder, store = spool.first(output), output if isinstance(output, Url) else None
    with Line(rig, product, folder, Who(name, operator)) as line, contextlib.ExitStack() as stack:
        kept = ShiftHistory(history, product, {"station": name}, store) if history else None
        board = OperatorPage(line, name, show) if page else None
        shown = board.show if board else show
        mqtt = _mqtt(broker, name, line) if broker else None
        served = live.Listen(opcua or "", allow_remote, certificate, key, "--opcua", tokens)
        server = _opcua(served, name, product) if opcua else None
        witnesses = [one for one in (board, mqtt, server) if one is not None]
        uploads = Uploads(store) if store else None
        station = Station(line, shown, kept, depth, witnesses, uploads)
        if mqtt:
            stack.enter_context(mqtt.running(station.note))
        if server:
            stack.enter_context(server.running(station))
        station.settle()
        if board and page:
            where = live.Listen(page, allow_remote, certificate, key, "--page", tokens)
            stack.enter_context(board.served(station, where, scans=allow_drive))
        place = address.host, address.port
        orders = None if no_listen else Orders(place, station.take, tokens, address.tls)
        try:
            if orders is not None:
                click.echo(f"listening on {address.host}:{orders.port}", err=True)
            if server:
                click.echo(f"opcua on {server.place.url}", err=True)
            reader(station, _typed(), ends=no_listen or sys.stdin.isatty())
            station.run()
        finally:
            if orders is not None:
                orders.stop()
    click.echo(f"\nshift ended: {station_words.counted(station.counts)}", err=True)
    return EXIT_DONE


def _refuse_unsigned(product: Product, name: str, trusted: Path) -> None:
    from motorid.quality.signed import read_trusted

    if problem := read_trusted(trusted).problem(product.signature, product.digest):
        raise click.UsageError(
            f"the limits of {name} do not count: {problem}. A trusted key signs them by "
            "`motorid product sign`."
        )


def _mqtt(settings: Path, name: str, line: Line) -> MqttWitness:
    from motorid.workflow.mqtt.settings import read_broker
    from motorid.workflow.mqtt.witness import MqttWitness

    return MqttWitness(read_broker(settings), name, line.product.name, line.folder)


def _opcua(listen: live.Listen, name: str, product: Product) -> OpcUaWitness:
    from motorid.workflow.opcua.witness import OpcUaWitness, Place

    address = listen.address()
    if not address.loopback and listen.tokens is None:
        raise click.UsageError(f"--opcua {listen.text} goes over a network: add --tokens FILE.")
    address.bind().close()  # before the address space is built, which takes seconds
    secured = (listen.certificate, listen.key, listen.tokens)
    return OpcUaWitness(Place(address.host, address.port, *secured), name, product)


def _typed() -> Iterator[str]:
    """Lines of the standard input, read without its lock: a thread that waits in it at exit would
    keep the interpreter from closing it.
    """
    rest = b""
    while data := _read():
        *lines, rest = (rest + data).replace(b"\r", b"\n").split(b"\n")
        yield from (line.decode("utf-8", "surrogateescape") for line in lines)
        rest = rest[-4096:]
    yield rest.decode("utf-8", "surrogateescape")


def _read() -> bytes:
    """What was typed; nothing at the end, or where the standard input cannot be read."""
    try:
        return os.read(sys.stdin.fileno(), 4096)
    except OSError:
        return b""


def show(screen: Screen) -> None:
    """The whole terminal, or one line where there is none."""
    from motorid.report.screen import render

    if not sys.stdout.isatty():
        click.echo(" | ".join((screen.word, *screen.lines)))
        return
    width = min(shutil.get_terminal_size().columns, 100)
    colour = "NO_COLOR" not in os.environ
    page = render(screen, width=width, colour=colour, clear=True)
    paint(sys.stdout, f"{page}\n  Serial number: ")
