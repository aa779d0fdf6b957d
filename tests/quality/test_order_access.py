"""Who may order: a token first, TLS beyond this computer."""

from __future__ import annotations

import contextlib
import json
import re
import socket
import ssl
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from motorid.cli.main import run
from motorid.web.address import parse_listen
from motorid.workflow.access import Caller, Tokens
from motorid.workflow.orders import MOST_CLIENTS, Answer, Message, Orders
from tests import certificates

PAGE = Path(__file__).parents[2] / "docs" / "line-controller.md"
NOT_SO = "0123456789abcdef0123"


class Taken:
    """What a station was asked; it answers at once, and once more when told to."""

    def __init__(self) -> None:
        self.orders: list[Message] = []
        self.answers: list[Answer] = []

    def __call__(self, order: Message, answer: Answer, caller: Caller) -> None:
        assert caller == Caller("line (operator) at 127.0.0.1", "operator")
        self.orders.append(order)
        self.answers.append(answer)
        answer({"event": "accepted"})


@pytest.fixture
def taken() -> Taken:
    return Taken()


@pytest.fixture
def tokens(tmp_path: Path) -> Tokens:
    return Tokens(tmp_path / "tokens.json")


@pytest.fixture
def hello(tokens: Tokens) -> dict[str, str]:
    return {"order": "hello", "token": tokens.add("line", "operator")}


@pytest.fixture
def guarded(taken: Taken, tokens: Tokens, hello: dict[str, str]) -> Iterator[Orders]:
    orders = Orders(("127.0.0.1", 0), taken, tokens)
    yield orders
    orders.stop()


@pytest.fixture(scope="module")
def pair(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    return certificates.pair(tmp_path_factory.mktemp("pem"))


@pytest.fixture
def secure(
    taken: Taken, tokens: Tokens, hello: dict[str, str], pair: tuple[Path, Path]
) -> Iterator[Orders]:
    tls = parse_listen("0", certificate=pair[0], key=pair[1]).tls
    orders = Orders(("127.0.0.1", 0), taken, tokens, tls)
    yield orders
    orders.stop()


def heard(port: int, *lines: Any, trusts: Path | None = None) -> list[dict[str, Any]]:
    """All answers to those lines, until the station ends or the client has said all of them."""
    link: socket.socket = socket.create_connection(("127.0.0.1", port), timeout=60)
    if trusts is not None:
        context = ssl.create_default_context(cafile=str(trusts))
        context.check_hostname = False
        link = context.wrap_socket(link)
    found = []
    with contextlib.suppress(ConnectionError), link, link.makefile("rwb") as file:
        for line in lines:
            file.write(json.dumps(line).encode() + b"\n")
            file.flush()
            if not (answer := file.readline()):
                break
            found.append(json.loads(answer))
    return found


INSPECT = {"order": "inspect", "serial": "D1"}


def test_a_token_opens_the_connection(guarded: Orders, taken: Taken, hello: dict[str, str]) -> None:
    assert heard(guarded.port, hello, INSPECT) == [{"event": "hello"}, {"event": "accepted"}]
    assert taken.orders == [INSPECT]


@pytest.mark.parametrize(
    "first",
    [INSPECT, {"order": "hello"}, {"order": "hello", "token": "ä" + NOT_SO[1:]}, [1],
     {"order": "hello", "token": NOT_SO}, {"order": "hello", "token": None}],
)  # fmt: skip
def test_without_it_nothing_is_taken(guarded: Orders, taken: Taken, first: Any) -> None:
    answers = heard(guarded.port, first, INSPECT, INSPECT)
    assert [one["event"] for one in answers] == ["error"]
    assert taken.orders == []


def test_orders_over_tls(
    secure: Orders, taken: Taken, pair: tuple[Path, Path], hello: dict[str, str]
) -> None:
    said = heard(secure.port, hello, *[INSPECT] * 50, trusts=pair[0])
    assert said == [{"event": "hello"}, *[{"event": "accepted"}] * 50]
    assert len(taken.orders) == 50


@pytest.mark.slow
def test_a_verdict_comes_while_the_client_only_listens(
    secure: Orders, taken: Taken, pair: tuple[Path, Path], hello: dict[str, str]
) -> None:
    """The station's reader waits for the next order meanwhile, on the same connection."""
    context = ssl.create_default_context(cafile=str(pair[0]))
    context.check_hostname = False
    plain = socket.create_connection(("127.0.0.1", secure.port), timeout=60)
    with context.wrap_socket(plain) as link, link.makefile("rwb") as file:
        for line in (hello, INSPECT):
            file.write(json.dumps(line).encode() + b"\n")
            file.flush()
            file.readline()
        (answer,) = taken.answers
        for number in range(40):  # more than one record of TLS
            answer({"event": "verdict", "number": number, "why": "x" * 1000})
            assert json.loads(file.readline())["number"] == number


def test_who_speaks_no_tls_is_told_nothing(secure: Orders, taken: Taken) -> None:
    with socket.create_connection(("127.0.0.1", secure.port), timeout=60) as link:
        link.sendall(json.dumps(INSPECT).encode() + b"\n")
        said = b""
        with contextlib.suppress(ConnectionError):
            while more := link.recv(4096):
                said += more
    assert b"{" not in said  # an alert of TLS at most
    assert taken.orders == []


@pytest.mark.parametrize(
    ("more", "why"),
    [
        ([], "can be reached from other computers"),
        (["--allow-remote"], "needs TLS"),
        (["--allow-remote", "CERTIFICATE"], "orders need a token"),
    ],
)
def test_beyond_this_computer_it_takes_both(
    more: list[str],
    why: str,
    pair: tuple[Path, Path],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    both = ["--certificate", str(pair[0]), "--key", str(pair[1])]
    options = [part for one in more for part in (both if one == "CERTIFICATE" else [one])]
    call = ["station", "--product", "sim-disc", "--rig", "sim-line", "--listen", "0.0.0.0:0"]
    assert run([*call, "-o", str(tmp_path), *options]) == 2
    assert why in " ".join(capsys.readouterr().err.split())


class Open:
    """A connection that stays."""

    def __init__(self, port: int) -> None:
        self.link = socket.create_connection(("127.0.0.1", port), timeout=60)
        self.file = self.link.makefile("rwb")

    def ask(self, line: dict[str, Any]) -> dict[str, Any]:
        self.file.write(json.dumps(line).encode() + b"\n")
        self.file.flush()
        return dict(json.loads(self.file.readline()))


@pytest.mark.slow
def test_strangers_take_no_place_from_clients(guarded: Orders, hello: dict[str, str]) -> None:
    clients = [Open(guarded.port) for _ in range(MOST_CLIENTS)]
    assert {one.ask(hello)["event"] for one in clients} == {"hello"}
    strangers = [Open(guarded.port) for _ in range(MOST_CLIENTS + 1)]
    assert strangers[0].file.readline() == b""  # it made way for the last of them
    assert {one.ask({"order": "status"})["event"] for one in clients} == {"accepted"}
    for one in (*strangers, *clients):
        one.link.close()


@pytest.mark.slow
def test_the_example_for_a_controller_runs(tmp_path: Path) -> None:
    """The page's own program, as a reader would copy it, against answers of the page's form."""

    def judged(order: Message, answer: Answer, caller: Caller) -> None:
        tag = {"id": order["id"], "serial": order["serial"]}
        answer({"event": "accepted", "waiting": 0, **tag})
        answer({"event": "verdict", "outcome": "PASS", "ends": True, **tag})

    (program,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.S)
    path = tmp_path / "controller.py"
    path.write_text(program, encoding="utf-8")
    orders = Orders(("127.0.0.1", 0), judged)
    try:
        words = [sys.executable, str(path), str(orders.port), "D000001"]
        done = subprocess.run(words, capture_output=True, text=True)
    finally:
        orders.stop()
    assert (done.returncode, done.stdout) == (0, "D000001 PASS\n"), done.stderr
