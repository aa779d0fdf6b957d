"""The Pico's bytes in flash, which outlast a loss of power in any command to the chip."""

from __future__ import annotations

import ctypes
import random
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from tests.conformance.boards import FIRMWARE

BYTES = 134  # firmware/core/port.h, FRONT_END_MEMORY
SECTOR_WORDS = 1024
BLANK, DARK, NEVER = 0xFFFFFFFF, -2, -1


class Journal:
    """journal.c over flash that the test holds."""

    def __init__(self, library: Path) -> None:
        code: Any = ctypes.CDLL(str(library))
        code.journal_write.restype = ctypes.c_bool
        self._code = code
        self.words = (ctypes.c_uint32 * (2 * SECTOR_WORDS)).in_dll(code, "fake_words")
        self._left = ctypes.c_int.in_dll(code, "fake_left")
        self._noise = ctypes.c_uint32.in_dll(code, "fake_noise")
        self._slow = ctypes.c_int.in_dll(code, "fake_slow")
        self._commands = ctypes.c_int.in_dll(code, "fake_commands")
        self._twice = ctypes.c_int.in_dll(code, "fake_twice")
        self.fill(BLANK)
        self._slow.value = self._commands.value = self._twice.value = 0
        self.power_up()

    def fill(self, word: int) -> None:
        """All of flash holds ``word``."""
        for n in range(len(self.words)):
            self.words[n] = word

    def power_up(self) -> None:
        """The board starts."""
        self._left.value = NEVER
        self._code.journal_begin()

    def cut_after(self, commands: int, seed: int) -> None:
        """Power goes in the command after so many."""
        self._left.value, self._noise.value = commands, seed

    @property
    def is_dark(self) -> bool:
        return bool(self._left.value == DARK)

    @property
    def commands(self) -> int:
        """Given to the chip."""
        return int(self._commands.value)

    @property
    def twice(self) -> int:
        """Words that were written without an erasure between."""
        return int(self._twice.value)

    def slow(self, times: int) -> None:
        """So often is flash not ready after a command."""
        self._slow.value = times

    def read(self) -> list[int]:
        return [self._code.journal_read(at) for at in range(BYTES)]

    def write(self, at: int, byte: int) -> bool:
        """Asks until the byte is accepted; False where power went."""
        for _ in range(10_000):
            if self._code.journal_write(at, byte):
                return not self.is_dark
            if self.is_dark:
                return False
        raise AssertionError("it never accepts the byte")


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if not shutil.which("gcc"):
        pytest.skip("no C compiler gcc: the journal is not built")
    path = tmp_path_factory.mktemp("journal") / "journal.so"
    port = FIRMWARE / "ports" / "rp2040"
    sources = port / "journal.c", FIRMWARE / "test" / "fake_flash.c"
    words = ["gcc", "-O1", "-shared", "-fPIC", "-Wall", "-Wextra", "-Wconversion", "-Werror"]
    words += ["-DJOURNAL_AT=0u", "-DPORT_CONST=", f"-I{port}", f"-I{FIRMWARE / 'core'}"]
    subprocess.run([*words, "-o", path, *sources], check=True)
    return path


@pytest.fixture
def journal(library: Path) -> Journal:
    return Journal(library)


def writes(count: int, seed: int) -> list[tuple[int, int]]:
    """Places and bytes."""
    rng = random.Random(seed)
    return [(rng.randrange(BYTES), rng.randrange(256)) for _ in range(count)]


def test_there_is_room_for_the_cores_bytes() -> None:
    text = (FIRMWARE / "core" / "wire_gen.h").read_text()
    (size,) = (
        int(line.split()[2].rstrip("u"))
        for line in text.splitlines()
        if line.startswith("#define WIRE_WRITE_FRONT_END_SIZE ")
    )
    assert 2 * (size + 6) == BYTES


def test_blank_flash_reads_as_never_written(journal: Journal) -> None:
    assert journal.read() == [0xFF] * BYTES
    assert journal.commands == 0


@pytest.mark.slow
def test_thousands_of_writes_are_there_after_a_start(journal: Journal) -> None:
    wanted = [0xFF] * BYTES
    for at, byte in writes(5000, seed=1):
        assert journal.write(at, byte)
        wanted[at] = byte
        assert journal.read()[at] == byte
    journal.power_up()
    assert journal.read() == wanted
    assert journal.twice == 0  # a word of flash is written once


def test_what_is_there_already_costs_no_command(journal: Journal) -> None:
    assert journal.write(5, 7)
    before = journal.commands
    assert journal.write(5, 7)
    assert journal.write(6, 0xFF)
    assert journal.commands == before


def test_flash_that_takes_its_time_is_waited_for(journal: Journal) -> None:
    journal.slow(3)
    for at, byte in writes(200, seed=2):
        assert journal.write(at, byte)
    found = journal.read()
    journal.power_up()
    assert journal.read() == found


@pytest.mark.slow
def test_a_loss_of_power_in_any_command_spoils_no_other_byte(library: Path) -> None:
    """All over the first erasure, the records, and the copy from a full sector to the other."""
    told = writes(1200, seed=3)  # more than a sector has records
    cuts = [*range(6), *range(500, 505), *range(1010, 1170)]
    for cut in cuts:
        journal = Journal(library)
        journal.cut_after(cut, seed=cut + 1)
        held = [0xFF] * BYTES
        for at, byte in told:
            if not journal.write(at, byte):
                break
            held[at] = byte
        assert journal.is_dark
        new = held.copy()
        new[at] = byte
        journal.power_up()
        assert journal.read() in (held, new), cut
        assert journal.write(3, 0x42)  # and it goes on
        journal.power_up()
        assert journal.read()[3] == 0x42


def test_power_that_fails_again_and_again_spoils_nothing(journal: Journal) -> None:
    rng = random.Random(4)
    held = [0xFF] * BYTES
    for at, byte in writes(3000, seed=5):
        if rng.random() < 0.2:
            journal.cut_after(rng.randrange(3), seed=rng.randrange(1, 1 << 32))
        if journal.write(at, byte):
            held[at] = byte
        else:
            journal.power_up()
            found = journal.read()
            assert found[:at] + found[at + 1 :] == held[:at] + held[at + 1 :]
            assert found[at] in (held[at], byte)
            held = found


@pytest.mark.parametrize("word", [0, 0x12345678, 0x55555555])
def test_another_programs_data_count_as_damaged(journal: Journal, word: int) -> None:
    journal.fill(word)
    journal.power_up()
    assert journal.read() == [0] * BYTES
    assert journal.write(0, 1)
    journal.power_up()
    assert journal.read() == [1] + [0] * (BYTES - 1)


def test_a_lost_journal_counts_as_damaged(journal: Journal) -> None:
    for at, byte in writes(10, seed=6):
        assert journal.write(at, byte)
    journal.words[0] ^= 1  # the sector's number
    journal.power_up()
    assert journal.read() == [0] * BYTES


def test_a_word_that_is_worn_does_not_read_as_written(journal: Journal) -> None:
    assert journal.write(0, 1)
    assert journal.write(1, 0x0F)
    journal.words[2] |= 0xFF00  # the second record: bits that cannot be cleared any more
    assert journal.write(2, 2)
    assert journal.read()[1] != 0x0F
