"""motorid flash: the command it gives, and what it says when it cannot."""

from __future__ import annotations

import stat
import sys
from pathlib import Path

import pytest

from motorid.cli.main import run
from motorid.wire.spec import load
from motorid.workflow import flash

posix = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo terminals")


def hex_of(data: bytes, at: int = 0) -> str:
    """Intel HEX, as the format's own description has it."""
    lines = []
    for n in range(0, len(data), 16):
        part = data[n : n + 16]
        body = bytes([len(part)]) + (at + n).to_bytes(2, "big") + b"\0" + part
        lines.append(f":{(body + bytes([-sum(body) & 0xFF])).hex().upper()}")
    return "\n".join([*lines, ":00000001FF", ""])


@pytest.fixture
def uno_hex(tmp_path: Path) -> Path:
    path = tmp_path / "motorid-uno.hex"
    path.write_text(hex_of(b"\x0c\x94" * 40 + b"motorid-uno\0"))
    return path


def avrdude(folder: Path, monkeypatch: pytest.MonkeyPatch, body: str) -> Path:
    """Puts a stand-in first on PATH; it notes its arguments and does as told."""
    tool = folder / "bin" / "avrdude"
    tool.parent.mkdir()
    told = folder / "told"
    tool.write_text(
        f"#!{sys.executable}\nimport sys\nopen({str(told)!r}, 'w').write('\\n'.join(sys.argv[1:]))"
        f"\n{body}\n"
    )
    tool.chmod(tool.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("PATH", f"{tool.parent}")
    return told


def failing(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str]:
    """Exit code, and the sentence on stderr."""
    code = run(["flash", *words])
    *_, said = capsys.readouterr().err.splitlines()
    assert said.startswith("motorid: ")
    return code, said


def test_an_example_of_the_format_is_read() -> None:
    """The records that the format's description on Wikipedia shows: 16 bytes each from 0x0100."""
    text = (
        ":10010000214601360121470136007EFE09D2190140\n"
        ":100110002146017E17C20001FF5F16002148011928\n"
        ":00000001FF\n"
    )
    assert flash.read_hex(text).hex().startswith("214601360121470136007efe09d21901")
    assert len(flash.read_hex(text)) == 32


@pytest.mark.parametrize(
    "bad", ["", "hello", ":00000001FE", ":10010000\n", ":0", hex_of(b"x")[:-13]]
)
def test_what_is_no_hex_is_refused(bad: str) -> None:
    with pytest.raises(ValueError):
        flash.read_hex(bad)


@pytest.mark.parametrize(
    ("board", "part", "programmer"),
    [("uno", "atmega328p", "arduino"), ("mega", "atmega2560", "wiring")],
)
def test_dry_run_shows_the_command_and_opens_nothing(
    board: str, part: str, programmer: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "a file.hex"
    path.write_text(hex_of(f"motorid-{board}".encode()))
    words = ("--port", "/dev/none", "--board", board, "--hex", str(path), "--dry-run")
    assert run(["flash", *words]) == 0
    said = capsys.readouterr().out
    assert said == (
        f"avrdude -q -p {part} -c {programmer} -b 115200 -P /dev/none -D -U 'flash:w:{path}:i'\n"
    )


def test_a_nano_takes_the_unos_firmware_at_two_speeds(
    uno_hex: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ("--port", "/dev/x", "--board", "nano", "--hex", str(uno_hex), "--dry-run")
    assert run(["flash", *words]) == 0
    old, new = capsys.readouterr().out.splitlines()
    assert (" -b 57600 " in old, " -b 115200 " in new) == (True, True)
    assert old.replace("57600", "115200") == new
    uno_hex.write_text(hex_of(b"motorid-uno" + bytes(31_000)))
    code, said = failing(capsys, *words)
    assert (code, "more than the board nano has" in said) == (4, True)


@posix
@pytest.mark.slow
@pytest.mark.parametrize("answering", ["57600", "115200"])
def test_a_nanos_other_bootloader_is_tried(
    answering: str, uno_hex: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from tests.load.pty import terminal

    body = f"sys.exit(0 if {answering!r} in sys.argv else 'error: not in sync')"
    with terminal() as port:
        told = avrdude(tmp_path, monkeypatch, body)
        assert run(["flash", "--port", port, "--board", "nano", "--hex", str(uno_hex)]) == 0
    assert answering in told.read_text().split("\n")


def test_without_avrdude_one_sentence(
    uno_hex: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("PATH", str(uno_hex.parent))
    code, said = failing(capsys, "--port", "/dev/x", "--board", "uno", "--hex", str(uno_hex))
    assert code == 3
    assert "avrdude is not installed" in said


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (hex_of(b"motorid-mega"), "is not motorid's firmware for the board uno"),
        (hex_of(b"blink"), "is not motorid's firmware"),
        (hex_of(b"motorid-uno" + bytes(33_000)), "more than the board uno has"),
        ("<html>not found</html>", "not an Intel HEX file"),
        ("Ω", "not an Intel HEX file"),
    ],
)
def test_the_wrong_file_never_reaches_the_board(
    text: str, says: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "some.hex"
    path.write_text(text, encoding="utf-8")
    code, said = failing(capsys, "--port", "/dev/x", "--board", "uno", "--hex", str(path))
    assert code == 4
    assert says in said


@pytest.mark.parametrize("port", ["sim://", "socket://127.0.0.1:9", ""])
def test_firmware_goes_over_a_device(
    port: str, uno_hex: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, said = failing(capsys, "--port", port, "--board", "uno", "--hex", str(uno_hex))
    assert code == 2
    assert "serial device" in said


def test_without_a_file_it_says_where_to_get_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(flash, "FOLDERS", (tmp_path,))
    code, said = failing(capsys, "--port", "/dev/x", "--board", "mega")
    assert code == 2
    assert "make -C firmware hex" in said


@posix
@pytest.mark.slow
def test_a_board_is_flashed_and_answers(
    uno_hex: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """The stand-in also tries to open the port as a capture would, and must be refused."""
    from tests.load.pty import terminal

    body = (
        "import serial\ntry:\n    serial.Serial(sys.argv[9], exclusive=True)\n"
        "except serial.SerialException:\n    sys.exit(0)\nsys.exit('the port is free: error')"
    )
    with terminal() as port:
        told = avrdude(tmp_path, monkeypatch, body)
        assert run(["flash", "--port", port, "--board", "uno", "--hex", str(uno_hex)]) == 0
    assert told.read_text().split("\n") == flash.commands(port, "uno", uno_hex)[0][1:]
    spec = load()
    assert f"protocol {spec.major}.{spec.minor}" in capsys.readouterr().out


@posix
@pytest.mark.slow
def test_a_port_in_use_is_left_alone(
    uno_hex: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    from motorid.acquire.port import open_port
    from tests.load.pty import terminal

    with terminal() as path:
        told = avrdude(tmp_path, monkeypatch, "")
        holder = open_port(path)
        try:
            code, said = failing(capsys, "--port", path, "--board", "uno", "--hex", str(uno_hex))
        finally:
            holder.close()
    assert code == 3
    assert "another program holds this port" in said
    assert not told.exists()


@posix
@pytest.mark.slow
def test_avrdude_that_fails_is_one_sentence(
    uno_hex: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    from tests.load.pty import terminal

    body = "sys.exit('hello\\navrdude: stk500_getsync() error: not in sync\\navrdude done')"
    with terminal() as path:
        avrdude(tmp_path, monkeypatch, body)
        code, said = failing(capsys, "--port", path, "--board", "uno", "--hex", str(uno_hex))
    assert code == 3
    assert "avrdude failed (avrdude: stk500_getsync() error: not in sync)" in said
