"""Which ports there are and who answers, by a system's list made for it and simulated boards."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from serial.tools import list_ports as system

from motorid.acquire import ports
from motorid.acquire.port import open_port
from motorid.errors import LinkError


def usb(device: str, serial: str | None = "S1", vid: int | None = 0x2341) -> Any:
    return SimpleNamespace(device=device, description=None, vid=vid, pid=0x43, serial_number=serial)


@pytest.fixture
def listed(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Has the system list these ports."""

    def put(*found: Any) -> None:
        monkeypatch.setattr(system, "comports", lambda: list(found))

    return put


def test_ports_are_listed_by_name_with_their_usb_identity(listed: Any) -> None:
    named = SimpleNamespace(
        device="A", description="a line", vid=None, pid=None, serial_number=None
    )
    listed(usb("C", serial=None), usb("B"), named)
    assert ports.list_ports() == (
        ports.PortInfo("A", "a line", ""),
        ports.PortInfo("B", "", "2341:0043 S1"),
        ports.PortInfo("C", "", "2341:0043"),
    )
    assert list(ports.listing()) == ["A  a line", "B  2341:0043 S1", "C  2341:0043"]


def test_probing_says_more_of_each_port(listed: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ports, "details", lambda url: iter((f"{url} answers", "well")))
    listed(usb("B"))
    assert list(ports.listing(probe=True)) == ["B  2341:0043 S1", "  B answers", "  well"]
    listed()
    assert list(ports.listing(probe=True)) == ["no serial ports; sim:// is always there"]


def test_the_only_board_is_the_only_usb_device(listed: Any) -> None:
    line = usb("A", serial=None, vid=None)
    listed(usb("B"), line)
    assert ports.only_port() == "B"
    listed(line)
    with pytest.raises(LinkError, match="port auto: no board is plugged in by USB"):
        ports.only_port()
    listed(usb("C"), line, usb("B"))
    with pytest.raises(LinkError, match=r"2 devices are plugged in.* among B, C$"):
        ports.only_port()


def test_a_board_s_serial_number_is_its_usb_device_s(tmp_path: Path, listed: Any) -> None:
    device, link = tmp_path / "device", tmp_path / "by-id"
    device.write_bytes(b"")
    link.symlink_to(device)
    listed(usb("other", "S0"), usb(str(device), "S7"))
    assert ports.serial_of(str(device)) == "S7"
    assert ports.serial_of(f"{link}?baud=9600") == "S7"
    assert ports.serial_of(f"relay://?seed=2&to={link}") == "S7"
    assert ports.serial_of(str(tmp_path)) == ""
    assert ports.serial_of(f"socket://{device}") == ""
    assert ports.serial_of("relay://?seed=2") == ""
    listed(usb(str(device), None))
    assert ports.serial_of(str(device)) == ""


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Each port that is opened, and a link test that says that it is well."""
    found: list[Any] = []

    def opens(url: str) -> Any:
        found.append(open_port(url))
        return found[-1]

    monkeypatch.setattr(ports, "open_port", opens)
    monkeypatch.setattr(
        ports, "measure_link", lambda port: SimpleNamespace(sentence=lambda: "the link is well")
    )
    return found


def closed(port: Any) -> bool:
    try:
        port.read(1, 0.01)
    except LinkError:
        return True
    return False


WHO = "motorid-sim, firmware 1.0.0, protocol 1."
LACKS = "without voltage_limit, inputs, sign_check, front_end"


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ("", [f"{WHO}3", "the link is well"]),
        ("&minor=2", [f"{WHO}2", LACKS, "the link is well"]),
        ("&front_end=none", [f"{WHO}3", "has no valid facts", "the link is well"]),
        ("&brown_out=2700", [f"{WHO}3", "brown-out detector", "the link is well"]),
    ],
)
def test_all_that_a_board_says_of_itself(options: str, says: list[str], opened: list[Any]) -> None:
    url = f"sim://?speed=max{options}"
    for said in (list(ports.details(url)), _described(url)):
        assert len(said) == len(says)
        assert all(part in line for part, line in zip(says, said, strict=True))
    assert len(opened) == 2
    assert all(map(closed, opened))


def _described(url: str) -> list[str]:
    try:
        found = ports.describe(url)
    except LinkError as error:
        return [str(error)]
    assert found["identity"]["board"] == "motorid-sim"
    assert "current" in found["channels"]
    return list(found["says"])


def test_a_port_on_which_nobody_answers_is_closed(
    opened: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    def silent(board: object) -> None:
        raise LinkError("nobody answers")

    monkeypatch.setattr(ports.Board, "identify", silent)
    assert list(ports.details("sim://?speed=max")) == ["nobody answers"]
    assert _described("sim://?speed=max") == ["nobody answers"]
    assert len(opened) == 2
    assert all(map(closed, opened))


def test_a_port_that_does_not_open_is_one_line(opened: list[Any]) -> None:
    assert list(ports.details("socket://nowhere")) == [
        "port socket://nowhere: write socket://HOST:PORT"
    ]
    assert ports.probe("socket://nowhere") == "port socket://nowhere: write socket://HOST:PORT"


def test_an_identity_closes_its_port(opened: list[Any]) -> None:
    assert ports.identity_of("sim://?speed=max")["board"] == "motorid-sim"
    assert closed(opened[0])
