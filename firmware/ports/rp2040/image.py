"""Makes the file that a Pico's boot drive takes: python image.py IN.bin OUT.uf2 [rp2040|rp2350]

``IN.bin`` is flash from its beginning, as objcopy writes it. The CRC that the chip's boot ROM asks
for is put behind the 252 bytes of the second boot stage: RP2040 data sheet, 2.8.1.3.1. That of an
RP2350 asks for a block of words that start.S has: its data sheet, 5.9. UF2 as microsoft/uf2
describes it.
"""

from __future__ import annotations

import struct
import sys
from pathlib import Path

BOOT2_BYTES = 252
FLASH_AT = 0x10000000
PAGE_BYTES = 256
DATA_BYTES = 476  # of a block, most of them unused
MAGIC = 0x0A324655, 0x9E5D5157, 0x0AB16F30
FAMILIES = {"rp2040": 0xE48BFF56, "rp2350": 0xE48BFF59}  # of the latter, secure Arm
DEFAULT = "rp2040"
HAS_FAMILY = 0x2000
POLYNOMIAL = 0x04C11DB7


def crc32(data: bytes) -> int:
    """The boot ROM's: most significant bit first, begins with all ones, nothing inverted."""
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= byte << 24
        for _ in range(8):
            crc = (crc << 1 ^ (POLYNOMIAL if crc & 0x80000000 else 0)) & 0xFFFFFFFF
    return crc


def sealed(flash: bytes) -> bytes:
    """Flash with the CRC of its second boot stage. Raises ValueError."""
    if any(flash[BOOT2_BYTES : BOOT2_BYTES + 4]):
        raise ValueError("the second boot stage is longer than 252 bytes")
    return flash[:BOOT2_BYTES] + struct.pack("<I", crc32(flash[:BOOT2_BYTES])) + flash[256:]


def uf2(flash: bytes, chip: str = DEFAULT) -> bytes:
    """One block of 512 bytes for each page of 256."""
    pages = [flash[at : at + PAGE_BYTES] for at in range(0, len(flash), PAGE_BYTES)]
    blocks = []
    for number, page in enumerate(pages):
        head = struct.pack(
            "<8I",
            *MAGIC[:2],
            HAS_FAMILY,
            FLASH_AT + number * PAGE_BYTES,
            PAGE_BYTES,
            number,
            len(pages),
            FAMILIES[chip],
        )
        blocks.append(head + page.ljust(DATA_BYTES, b"\0") + struct.pack("<I", MAGIC[2]))
    return b"".join(blocks)


def main() -> int:
    source, target = map(Path, sys.argv[1:3])
    chip = sys.argv[3] if len(sys.argv) > 3 else DEFAULT
    flash = source.read_bytes()
    target.write_bytes(uf2(sealed(flash) if chip == DEFAULT else flash, chip))
    return 0


if __name__ == "__main__":
    sys.exit(main())
