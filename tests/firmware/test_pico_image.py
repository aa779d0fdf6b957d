"""The file that a Pico's boot drive takes: its second boot stage and its blocks."""

from __future__ import annotations

import json
import shutil
import struct
import subprocess
import zlib
from pathlib import Path

import pytest

from tests.conformance.boards import FIRMWARE, built_in_place, module_of

PORT = FIRMWARE / "ports" / "rp2040"
EMULATOR = FIRMWARE / "emulator" / "pico"
FLASH_AT, RAM_AT, RAM_END = 0x10000000, 0x20000000, 0x20042000
BOOT2_BYTES = 252
REVERSED = bytes(int(f"{n:08b}"[::-1], 2) for n in range(256))
#: Decodes UF2 by npm's uf2, which is another's.
READER = """
import fs from 'node:fs';
import { decodeBlock, familyMap } from 'uf2';
const file = fs.readFileSync(process.argv[1]);
const blocks = [];
for (let at = 0; at < file.length; at += 512) {
  const block = decodeBlock(file.subarray(at, at + 512));
  const { blockNumber, totalBlocks, flashAddress, boardFamily } = block;
  const family = familyMap.get(boardFamily) ?? boardFamily;
  const payload = Buffer.from(block.payload).toString('hex');
  blocks.push([blockNumber, totalBlocks, flashAddress, family, payload]);
}
console.log(JSON.stringify(blocks));
"""


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the firmware, built."""
    if not shutil.which("make") or not shutil.which("arm-none-eabi-gcc"):
        pytest.skip("no C compiler arm-none-eabi-gcc: the Pico's firmware is not built")
    return built_in_place("pico", "pico", folder=tmp_path_factory.mktemp("built")) / "pico"


def flash_of(built: Path) -> bytes:
    """As the linker made it, without the CRC."""
    out = built / "flash.bin"
    elf = built / "motorid-pico.elf"
    subprocess.run(["arm-none-eabi-objcopy", "-O", "binary", elf, out], check=True)
    return out.read_bytes()


def crc_by_zlib(data: bytes) -> int:
    """The boot ROM's CRC by another program: zlib's takes each byte the other way round."""
    value = zlib.crc32(data.translate(REVERSED)) ^ 0xFFFFFFFF
    return int(f"{value:032b}"[::-1], 2)


def blocks_of(path: Path) -> list[tuple[int, int, int, str | int, str]]:
    """Number, of how many, address, family and payload of each block, as npm's uf2 reads them."""
    if not shutil.which("node") or not (EMULATOR / "node_modules" / "uf2").is_dir():
        pytest.skip("no emulated pico: npm's uf2 comes with its emulator")
    words = ["node", "--input-type=module", "-e", READER, str(path)]
    said = subprocess.run(words, capture_output=True, text=True, check=True, cwd=EMULATOR)
    found: list[tuple[int, int, int, str | int, str]] = json.loads(said.stdout)
    return found


@pytest.mark.slow
def test_another_program_reads_the_image(built: Path) -> None:
    blocks = blocks_of(built / "motorid-pico.uf2")
    flash = flash_of(built)
    read = b"".join(bytes.fromhex(payload) for *_, payload in blocks)
    assert [block[0] for block in blocks] == list(range(len(blocks)))
    assert {block[1] for block in blocks} == {len(blocks)}
    assert [block[2] for block in blocks] == [FLASH_AT + 256 * n for n in range(len(blocks))]
    assert {block[3] for block in blocks} == {"Raspberry Pi RP2040"}
    assert read[:BOOT2_BYTES] == flash[:BOOT2_BYTES]
    assert read[256 : len(flash)] == flash[256:]
    assert struct.unpack_from("<I", read, BOOT2_BYTES)[0] == crc_by_zlib(flash[:BOOT2_BYTES])


@pytest.mark.slow
def test_the_vectors_lead_into_flash_and_the_stack_ends_in_ram(built: Path) -> None:
    flash = flash_of(built)
    stack, start = struct.unpack_from("<2I", flash, 256)
    assert start & 1, "Thumb code"
    assert FLASH_AT + 256 < start < FLASH_AT + len(flash)
    # below everything else, so that an overflow leaves RAM
    symbols = subprocess.run(
        ["arm-none-eabi-nm", str(built / "motorid-pico.elf")],
        capture_output=True,
        text=True,
        check=True,
    ).stdout.splitlines()
    places = {name: int(at, 16) for at, _, name in (line.split() for line in symbols)}
    assert stack == places["stack_top"] == places["image_begin"]
    assert RAM_AT < stack < places["bss_end"] <= RAM_END
    assert places["vectors"] % 256 == 0


@pytest.mark.study
def test_two_builds_are_the_same_to_the_byte(built: Path, tmp_path: Path) -> None:
    """In tests/flash/test_hex.py a release's builds show it for each board."""
    subprocess.run(["make", "-s", "-C", str(PORT), f"OUT={tmp_path}"], check=True)
    name = "motorid-pico.uf2"
    assert (tmp_path / name).read_bytes() == (built / name).read_bytes()


def test_a_second_stage_that_is_too_long_is_refused() -> None:
    image = module_of(PORT / "image.py")
    with pytest.raises(ValueError, match="252 bytes"):
        image.sealed(b"\1" * 300)


def test_the_last_page_is_sent_whole() -> None:
    image = module_of(PORT / "image.py")
    assert len(image.uf2(b"\0" * 257)) == 2 * 512
