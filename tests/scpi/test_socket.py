"""The whole way by pyvisa-py over sockets: text, binary blocks, time-outs, and the command line."""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.acquire.port import open_port
from motorid.acquire.record import capture_all
from motorid.acquire.scpi.dialect import load_dialect, parse
from motorid.acquire.scpi.link import Instrument, number_of, open_visa, written
from motorid.acquire.scpi.supply import truth
from motorid.cli.main import run
from motorid.errors import LinkError, RigError, UsageError
from motorid.toml_file import packaged
from tests.scpi.bench import block
from tests.scpi.rigs import MockLink, mock, rig

Answer = Callable[[str], Any]
PATIENCE_S = 240.0  # for threads of a busy computer


class Server(threading.Thread):
    """One SCPI instrument on a port of this machine: lines in, lines or blocks out."""

    def __init__(self, answer: Answer) -> None:
        super().__init__(daemon=True)
        self.answer, self.open = answer, True
        self.listening = socket.create_server(("127.0.0.1", 0))
        number = self.listening.getsockname()[1]
        self.resource = f"TCPIP0::127.0.0.1::{number}::SOCKET"
        self.start()

    def run(self) -> None:
        while self.open:
            try:
                link, _ = self.listening.accept()
            except OSError:
                return
            with link, link.makefile("rb") as lines:
                for line in lines:
                    found = self.answer(line.decode().strip())
                    if found is not None:
                        data = found if isinstance(found, bytes) else str(found).encode()
                        link.sendall(data + b"\n")

    def close(self) -> None:
        self.open = False
        self.listening.close()


@pytest.fixture
def serve() -> Iterator[Callable[[Answer], str]]:
    servers: list[Server] = []

    def start(answer: Answer) -> str:
        servers.append(Server(answer))
        return servers[-1].resource

    yield start
    for server in servers:
        server.close()


@pytest.mark.slow
def test_a_run_over_sockets_with_binary_blocks(
    serve: Callable[[Answer], str],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """On a clock that passes only where somebody waits: a busy computer is none the slower."""
    bench, clock = mock()
    monkeypatch.setattr("motorid.acquire.scpi.run.Clock", lambda: clock)
    guard = threading.Lock()

    def locked(answer: Answer) -> Answer:
        def one(text: str) -> Any:
            with guard:
                return answer(text)

        return one

    where = {"supply": serve(locked(bench.supply)), "scope_at": serve(locked(bench.scope))}
    rig(tmp_path, rate_hz=2000, levels="[[4]]", patience_s=PATIENCE_S, **where)
    path = tmp_path / "run.h5"
    code = run(["capture", "--rig", str(tmp_path / "rig.toml"), "-o", str(path), "--serial", "M1"])
    said = capsys.readouterr().err
    assert code == 0, said
    assert "no board guards this run" in said
    assert not bench.on
    from motorid.capture import store

    found = store.load(path)
    assert found.period_s == pytest.approx(5e-4)
    assert found.provenance["serial"] == "M1"
    assert np.max(found.channels["terminal_voltage"].values) == pytest.approx(4.0, abs=0.01)


def test_a_block_may_hold_every_byte(serve: Callable[[Answer], str]) -> None:
    """Line feeds among them, on a link where one ends each message."""
    words = np.arange(65536, dtype="<u2")
    link = open_visa("@py", serve({"D?": block(words)}.get), PATIENCE_S, "recorder")
    np.testing.assert_array_equal(Instrument("recorder", link).block("D?", "H"), words)


@pytest.mark.slow
def test_nobody_there_and_nobody_answering(serve: Callable[[Answer], str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        number = taken.getsockname()[1]

    def reach(resource: str) -> str:
        return Instrument("supply", open_visa("@py", resource, 0.2, "supply")).identify()

    with pytest.raises(LinkError, match=r"cannot be opened|does not answer"):
        reach(f"TCPIP0::127.0.0.1::{number}::SOCKET")
    with pytest.raises(LinkError, match=r"does not answer '\*IDN\?' \(tmo\)"):
        reach(serve(lambda text: None))
    with pytest.raises(LinkError, match="cannot be opened"):
        open_visa("@py", "no such thing", 0.2, "supply")


@pytest.mark.slow
@pytest.mark.parametrize("data", [b"#", b"#42", b"#9x", b"plain", b"#2101234"])
def test_a_block_that_is_none_is_an_error_and_no_hang(
    serve: Callable[[Answer], str], data: bytes
) -> None:
    answers: dict[str, Any] = {"D?": data, "SYST:ERR?": "0"}
    link = open_visa("@py", serve(answers.get), 0.2, "recorder")
    with pytest.raises(LinkError):
        Instrument("recorder", link).block("D?", "H")


def test_a_query_that_an_instrument_refuses_is_explained_by_its_queue() -> None:
    queue = ['-113,"Undefined header"', '-410,"Query INTERRUPTED"']
    answers = {"SYST:ERR?": lambda: queue.pop(0) if queue else "+0"}
    link = MockLink(lambda text: answers[text]() if text in answers else None)
    with pytest.raises(LinkError, match='-113,"Undefined header"; -410'):
        Instrument("supply", link).ask("NONSENSE?")


def test_an_error_queue_that_answers_nonsense_ends_it() -> None:
    with pytest.raises(LinkError, match="no error of SCPI"):
        Instrument("supply", MockLink(lambda text: "hello")).errors()


def test_an_error_queue_that_never_empties_ends_it() -> None:
    found = Instrument("supply", MockLink(lambda text: "-350,overflow")).errors()
    assert 1 < len(found) < 100


@pytest.mark.parametrize(
    ("text", "value"),
    [("+1.25000E+00", 1.25), (" 6 ", 6.0), (".5V", 0.5), ("-3.E-2 A", -0.03), ("9.91E37", np.nan)],
)
def test_numbers_as_instruments_write_them(text: str, value: float) -> None:
    assert number_of(text, "it") == pytest.approx(value, nan_ok=True)


@pytest.mark.parametrize("text", ["", "1,5", "one", "0x10", "1 2", "--1", "nan"])
def test_what_is_no_number_is_refused(text: str) -> None:
    with pytest.raises(LinkError, match="which is no number"):
        number_of(text, "it")


def test_numbers_are_written_with_a_point_and_without_an_exponent() -> None:
    said = [written(value) for value in (9.0, -0.25, 1e-5, 123456.789, 0.0)]
    assert said == ["9.0", "-0.25", "0.00001", "123456.789", "0.0"]


@pytest.mark.parametrize(
    ("answer", "meant"),
    [("1", True), ("+0", False), ("ON", True), ('"off"', False), ("1.0", True), ("2 V", None)],
)
def test_yes_and_no_as_supplies_write_them(answer: str, meant: bool | None) -> None:
    assert truth(answer) is meant


@pytest.mark.parametrize("path", sorted(packaged("rigs/instruments").glob("*.toml")), ids=str)
def test_every_packaged_dialect_reads(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    kind = parse(text, str(path)).kind
    assert load_dialect(path.stem, Path(), kind).tables


def test_a_field_that_is_none_is_found_before_a_run() -> None:
    text = packaged("rigs/instruments").joinpath("scpi.toml").read_text(encoding="utf-8")
    with pytest.raises(RigError, match="'volts' is no field; known: value"):
        parse(text.replace("VOLT {value}", "VOLT {volts}"), "mine.toml")


def test_other_commands_say_that_there_is_no_board() -> None:
    with pytest.raises(UsageError, match="instruments are no board"):
        open_port("scpi://instruments.toml")


@pytest.mark.parametrize(
    ("resource", "plain"),
    [
        ("TCPIP0::h::5025::socket", True),
        ("asrl/dev/x::INSTR", True),
        ("USB0::1::2::3::INSTR", False),
    ],
)
def test_a_resource_is_opened_with_its_time_and_its_ends(
    resource: str, plain: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    import pyvisa

    device, asked = SimpleNamespace(), list[str]()

    def manager(backend: str) -> Any:
        asked.append(backend)
        return SimpleNamespace(open_resource=lambda name: (asked.append(name), device)[1])

    monkeypatch.setattr(pyvisa, "ResourceManager", manager)
    open_visa("@py", resource, 2.5, "dmm")
    ends = {"read_termination": "\n"} if plain else {}
    assert vars(device) == {"timeout": 2500.0, "write_termination": "\n", **ends}
    assert asked == ["@py", resource]


@pytest.mark.parametrize(
    ("error", "says"),
    [
        (OSError("no way\nat all"), "no way"),
        (ValueError(), "ValueError"),
        (OSError("x" * 200), "x" * 160),
    ],
)
def test_a_resource_that_does_not_open_says_why(
    error: Exception, says: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    import pyvisa

    def fails(backend: str) -> None:
        raise error

    monkeypatch.setattr(pyvisa, "ResourceManager", fails)
    with pytest.raises(LinkError, match=rf"^the dmm \(R\) cannot be opened \({says}\): check addr"):
        open_visa("@py", "R", 2.5, "dmm")


def test_without_pyvisa_it_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "pyvisa", None)
    one = rig(tmp_path)
    with pytest.raises(UsageError, match=r"pip install 'motorid\[scpi\]'"):
        capture_all(one, one.program, [tmp_path / "run.h5"])
