"""The serial ports of this computer, and who answers on them."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from motorid.acquire.board import Board, Fields
from motorid.acquire.front_end import bare
from motorid.acquire.guards import brown_out, lacking
from motorid.acquire.link_test import measure_link
from motorid.acquire.port import open_port
from motorid.errors import LinkError, MotoridError


@dataclass(frozen=True)
class PortInfo:
    """A serial port as the system describes it; not opened."""

    device: str
    description: str
    hardware: str  # USB identity, or empty


def list_ports() -> tuple[PortInfo, ...]:
    """Serial ports by name. Opens none: opening resets many boards."""
    from serial.tools import list_ports as system

    found = []
    for port in sorted(system.comports(), key=lambda port: str(port.device)):
        usb = f"{port.vid:04x}:{port.pid:04x}" if port.vid is not None else ""
        hardware = " ".join(part for part in (usb, port.serial_number or "") if part)
        found.append(PortInfo(str(port.device), str(port.description or ""), hardware))
    return tuple(found)


def only_port() -> str:
    """The one serial port that a USB device offers, unopened: opening resets many boards.

    Raises LinkError where there is none, or more than one.
    """
    found = list_ports()
    boards = [port.device for port in found if port.hardware]
    if len(boards) == 1:
        return boards[0]
    if not boards:
        raise LinkError(
            "port auto: no board is plugged in by USB; `motorid ports` lists all ports: name one"
        )
    raise LinkError(
        f"port auto: {len(boards)} devices are plugged in, and asking one resets it: name the "
        f"board's among {', '.join(boards)}"
    )


def serial_of(url: str) -> str:
    """The serial number of the board behind a port, without opening it; "" where none is told.

    A USB device tells it to the system; a simulated board has one for each seed of boards.
    """
    kind, _, rest = url.partition("://")
    if kind == "relay":
        inner = rest.partition("to=")[2]
        return serial_of(inner) if inner else ""
    if kind == "sim":
        from motorid.sim.options import parse_url

        return f"sim-{parse_url(url).board_seed}"
    return "" if rest else _usb_serial(url.partition("?")[0])


def _usb_serial(device: str) -> str:
    from serial.tools import list_ports as system

    wanted = os.path.realpath(device)
    for port in system.comports():
        if os.path.realpath(str(port.device)) == wanted:
            return str(port.serial_number or "")
    return ""


def probe(url: str) -> str:
    """Who answers on a port, in a line; or why nobody does. Opens it, which resets many boards."""
    try:
        return who_answers(url)
    except MotoridError as error:
        return str(error)


def who_answers(url: str) -> str:
    """Board, firmware and protocol, in a line. Raises LinkError where nobody does."""
    return who_is(identity_of(url))


def identity_of(url: str) -> Fields:
    """What the board behind a port says of itself. Raises LinkError where nobody does."""
    port = open_port(url)
    try:
        return Board(port).identify()
    finally:
        port.close()


def who_is(who: Fields) -> str:
    """Board, firmware and protocol of an identity, in a line."""
    firmware = ".".join(str(who[f"firmware_{part}"]) for part in ("major", "minor", "patch"))
    protocol = f"{who['protocol_major']}.{who['protocol_minor']}"
    return f"{who['board']}, firmware {firmware}, protocol {protocol}"


def details(url: str) -> Iterator[str]:
    """Who answers, what that board lacks, what its link loses, and what is wrong; a line each."""
    try:
        port = open_port(url)
    except MotoridError as error:
        yield str(error)
        return
    try:
        board = Board(port)
        who = board.identify()
        yield who_is(who)
        if missing := lacking(who):
            yield f"without {', '.join(missing)}"
        if said := brown_out(who):
            yield said
        if said := bare(board):
            yield said
        yield measure_link(port).sentence()
    except MotoridError as error:
        yield str(error)
    finally:
        port.close()


def describe(url: str) -> dict[str, Any]:
    """All that the board behind a port says of itself, and lines for a person.

    Raises LinkError where nobody answers.
    """
    port = open_port(url)
    try:
        board = Board(port)
        who = board.identify()
        said = [who_is(who), *(line for line in (brown_out(who), bare(board)) if line)]
        if missing := lacking(who):
            said.append(f"without {', '.join(missing)}")
        said.append(measure_link(port).sentence())
        return {"identity": who, "channels": board.descriptors, "says": said}
    finally:
        port.close()


def listing(*, probe: bool = False) -> Iterator[str]:
    """One line a port; with ``probe``, a second one that says who answers."""
    found = list_ports()
    if not found:
        yield "no serial ports; sim:// is always there"
    for port in found:
        yield "  ".join(part for part in (port.device, port.description, port.hardware) if part)
        if probe:
            for line in details(port.device):
                yield f"  {line}"
