"""motorid flash for a Pico: the UF2 file it takes, and the drive that it copies it to."""

from __future__ import annotations

import struct
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from motorid.cli.main import run
from motorid.errors import LinkError, UsageError
from motorid.workflow import flash, flash_drive
from tests.conformance.boards import FIRMWARE, module_of

INFO = "UF2 Bootloader v3.0\nModel: Raspberry Pi RP2\nBoard-ID: {}\n"
IMAGE = b"boot2".ljust(600, b"\1") + b"motorid-pico\0"


def uf2(flash_bytes: bytes) -> bytes:
    """As the firmware's build writes it."""
    made: bytes = module_of(FIRMWARE / "ports" / "rp2040" / "image.py").uf2(flash_bytes)
    return made


@pytest.fixture
def image(tmp_path: Path) -> Path:
    path = tmp_path / "motorid-pico.uf2"
    path.write_bytes(uf2(IMAGE))
    return path


@pytest.fixture
def drive(tmp_path: Path) -> Path:
    """A folder that looks as the boot ROM's drive does."""
    folder = tmp_path / "RPI RP2"
    folder.mkdir()
    (folder / "INFO_UF2.TXT").write_text(INFO.format("RPI-RP2"))
    return folder


def failing(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str]:
    """Exit code, and the sentence on stderr."""
    code = run(["flash", *words])
    *_, said = capsys.readouterr().err.splitlines()
    assert said.startswith("motorid: ")
    return code, said


def test_the_file_is_copied_whole(
    image: Path, drive: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["flash", "--board", "pico", "--hex", str(image), "--drive", str(drive)]) == 0
    assert (drive / image.name).read_bytes() == image.read_bytes()
    assert "copied to" in capsys.readouterr().out


def test_dry_run_writes_nothing(
    image: Path, drive: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ("--board", "pico", "--hex", str(image), "--drive", str(drive), "--dry-run")
    assert run(["flash", *words]) == 0
    assert capsys.readouterr().out == f"cp {image} '{drive / image.name}'\n"
    assert [path.name for path in drive.iterdir()] == ["INFO_UF2.TXT"]


def test_the_only_drive_is_found_among_others(drive: Path, tmp_path: Path) -> None:
    other = tmp_path / "camera"
    other.mkdir()
    absent = tmp_path / "gone"
    assert flash_drive.find_drive(iter((other, drive, absent))) == drive


def test_the_successors_drive_is_another_boards(drive: Path, tmp_path: Path) -> None:
    (drive / "INFO_UF2.TXT").write_text(INFO.format("RP2350"))
    with pytest.raises(LinkError, match="hold its button BOOTSEL"):
        flash_drive.find_drive(iter((drive,)))


def test_of_two_drives_one_must_be_named(drive: Path, tmp_path: Path) -> None:
    second = tmp_path / "second"
    second.mkdir()
    (second / "INFO_UF2.TXT").write_text(INFO.format("RPI-RP2"))
    with pytest.raises(UsageError, match="2 Picos wait"):
        flash_drive.find_drive(iter((drive, second)))


def test_without_a_drive_it_says_which_button_to_hold(
    image: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(flash_drive, "_mounted", lambda: iter(()))
    code, said = failing(capsys, "--board", "pico", "--hex", str(image))
    assert code == 3
    assert "BOOTSEL" in said


def test_a_folder_that_is_no_boot_drive_is_left_alone(
    image: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "photos"
    folder.mkdir()
    words = ("--board", "pico", "--hex", str(image), "--drive", str(folder))
    code, said = failing(capsys, *words)
    assert code == 2
    assert "is not a Pico's boot drive" in said
    assert not list(folder.iterdir())


def test_linux_drives_are_those_of_vfat(tmp_path: Path) -> None:
    table = tmp_path / "mounts"
    table.write_text(
        "/dev/sda1 / ext4 rw 0 0\n/dev/sdb1 /media/me/RPI\\040RP2 vfat rw,nosuid 0 0\n\nbroken\n"
    )
    assert list(flash_drive._linux_mounts(table)) == [Path("/media/me/RPI RP2")]
    assert not list(flash_drive._linux_mounts(tmp_path / "absent"))


def changed(at: int, value: int) -> Callable[[bytes], bytes]:
    """One 32-bit number of the file is another."""

    def change(data: bytes) -> bytes:
        return data[:at] + struct.pack("<I", value) + data[at + 4 :]

    return change


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (changed(0, 0), "block 0 is none"),
        (changed(512 + 508, 0), "block 1 is none"),
        (changed(28, 0xE48BFF59), "another processor"),  # an RP2350's
        (changed(8, 0), "another processor"),  # of no family
        (changed(512 + 12, 0x10000000), "block 1 does not follow"),
        (changed(512 + 20, 0), "block 1 of 3 is missing"),
        (lambda data: data[:1024], "block 0 of 2 is missing"),
        (lambda data: data[:-1], "whole number of blocks"),
        (lambda data: b"", "whole number of blocks"),
        (lambda data: data.replace(b"motorid-pico", b"another-pico"), "is not motorid's firmware"),
    ],
)
def test_the_wrong_file_never_reaches_the_board(
    change: Callable[[bytes], bytes],
    says: str,
    image: Path,
    drive: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    image.write_bytes(change(image.read_bytes()))
    words = ("--board", "pico", "--hex", str(image), "--drive", str(drive))
    code, said = failing(capsys, *words)
    assert code == 4
    assert says in said
    assert not (drive / image.name).exists()


def test_a_file_beyond_the_boards_memory_is_refused(image: Path) -> None:
    with pytest.raises(ValueError, match="more than the board has"):
        flash_drive.read_uf2(uf2(bytes((2 << 20) + 1)))


def test_a_file_that_is_there_reads_back_as_it_was_made() -> None:
    assert flash_drive.read_uf2(uf2(IMAGE))[: len(IMAGE)] == IMAGE


@pytest.mark.skipif(sys.platform == "win32", reason="a folder's rights are other ones there")
def test_a_drive_that_takes_nothing_is_one_sentence(
    image: Path, drive: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (drive / image.name).mkdir()  # what cannot be written for anybody
    words = ("--board", "pico", "--hex", str(image), "--drive", str(drive))
    code, said = failing(capsys, *words)
    assert code == 3
    assert "cannot be written" in said


def test_the_board_is_asked_as_soon_as_its_port_is_there(
    image: Path, drive: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    tries = iter([LinkError("no such port"), LinkError("no such port"), None])

    def who(port: str) -> str:
        if error := next(tries):
            raise error
        return f"{port} answers"

    monkeypatch.setattr(flash_drive, "who_answers", who)
    monkeypatch.setattr(flash_drive, "POLL_S", 0.0)
    words = ("--board", "pico", "--hex", str(image), "--drive", str(drive), "--port", "/dev/x")
    assert run(["flash", *words]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "/dev/x answers"


def test_a_board_that_never_answers_is_one_sentence(
    image: Path, drive: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(flash_drive, "RESTARTS_S", 0.0)
    words = ("--board", "pico", "--hex", str(image), "--drive", str(drive))
    code, said = failing(capsys, *words, "--port", str(drive / "no-port"))
    assert code == 3
    assert "no-port" in said


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--board", "uno"), "--port is missing"),
        (("--board", "mega", "--port", "/dev/x", "--drive", "."), "--drive is for the board pico"),
    ],
)
def test_what_belongs_to_another_board_is_refused(
    words: tuple[str, ...],
    says: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    for name in ("motorid-uno.hex", "motorid-mega.hex"):
        (tmp_path / name).touch()
    monkeypatch.setattr(flash, "FOLDERS", (tmp_path,))
    code, said = failing(capsys, *words)
    assert code == 2
    assert says in said


def test_the_firmware_that_came_along_is_taken(
    image: Path, drive: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(flash, "FOLDERS", (image.parent,))
    assert run(["flash", "--board", "pico", "--drive", str(drive)]) == 0
    assert (drive / image.name).read_bytes() == image.read_bytes()
