"""What a compiled library says of itself: for which processor, what it offers, what it asks for.

Reads ELF (Linux), PE (Windows) and Mach-O (macOS), each of 64 bits, from the bytes of the file.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass

ELF_MACHINES = {62: "x86_64", 183: "aarch64"}
PE_MACHINES = {0x8664: "x86_64"}
MACHO_MACHINES = {0x01000007: "x86_64", 0x0100000C: "aarch64"}
ELF_DYNSYM = 11
MACHO_SYMTAB, MACHO_DYLIBS = 0x2, (0xC, 0x80000018, 0x8000001F)


@dataclass(frozen=True)
class Library:
    """``kind``: linux, windows or macos. ``asks``: names of functions and data from outside.

    ``versions``: of symbols of the C library (Linux). ``libraries``: those named (Windows, macOS).
    """

    kind: str
    machine: str
    offers: frozenset[str]
    asks: frozenset[str]
    versions: frozenset[str] = frozenset()
    libraries: frozenset[str] = frozenset()


def read(data: bytes) -> Library:
    """The facts of one library.

    Raises:
        ValueError: It is none of the three formats, or it is cut.
    """
    try:
        if data[:5] == b"\x7fELF\x02":
            return _elf(data)
        if data[:2] == b"MZ":
            return _pe(data)
        if data[:4] == b"\xcf\xfa\xed\xfe":
            return _macho(data)
    except (struct.error, KeyError, IndexError, StopIteration) as error:
        raise ValueError(f"a library that is cut or unknown: {error!r}") from None
    raise ValueError("no ELF, PE or Mach-O library of 64 bits")


def _text(data: bytes, at: int) -> str:
    return data[at : data.index(b"\0", at)].decode("ascii", "replace")


def _elf(data: bytes) -> Library:
    (machine,) = struct.unpack_from("<H", data, 18)
    (table,) = struct.unpack_from("<Q", data, 40)
    size, count = struct.unpack_from("<HH", data, 58)
    sections = [struct.unpack_from("<IIQQQQIIQQ", data, table + n * size) for n in range(count)]
    symbols = next(one for one in sections if one[1] == ELF_DYNSYM)
    names = sections[symbols[6]]
    strings = data[names[4] : names[4] + names[5]]
    offers, asks = set(), set()
    for at in range(symbols[4] + 24, symbols[4] + symbols[5], 24):
        name, info, _, section = struct.unpack_from("<IBBH", data, at)
        if info >> 4 == 1:  # global; what is weak may stay undefined
            (offers if section else asks).add(_text(strings, name))
    versions = {part.decode() for part in strings.split(b"\0") if part.startswith(b"GLIBC_")}
    return Library(
        "linux", ELF_MACHINES[machine], frozenset(offers), frozenset(asks), frozenset(versions)
    )


def _pe(data: bytes) -> Library:
    (head,) = struct.unpack_from("<I", data, 0x3C)
    machine, count = struct.unpack_from("<HH", data, head + 4)
    (size,) = struct.unpack_from("<H", data, head + 20)
    first = head + 24 + size
    sections = [struct.unpack_from("<IIII", data, first + 40 * n + 8) for n in range(count)]

    def place(address: int) -> int:
        """Where in the file what is loaded at an address lies."""
        for length, begin, stored, offset in sections:
            if begin <= address < begin + max(length, stored):
                return address - begin + offset
        raise KeyError(address)

    exports, _, imports, _ = struct.unpack_from("<IIII", data, head + 24 + 112)
    names, listed = struct.unpack_from("<I", data, place(exports) + 24), place(exports) + 32
    (table,) = struct.unpack_from("<I", data, listed)
    offers = {
        _text(data, place(struct.unpack_from("<I", data, place(table) + 4 * n)[0]))
        for n in range(names[0])
    }
    asks, libraries = set(), set()
    for at in range(place(imports), len(data), 20):
        wanted, _, _, library, _ = struct.unpack_from("<IIIII", data, at)
        if not library:
            break
        libraries.add(_text(data, place(library)))
        for slot in range(place(wanted), len(data), 8):
            (name,) = struct.unpack_from("<Q", data, slot)
            if not name:
                break
            if not name >> 63:
                asks.add(_text(data, place(name) + 2))
    return Library(
        "windows", PE_MACHINES[machine], frozenset(offers), frozenset(asks),
        libraries=frozenset(libraries),
    )  # fmt: skip


def _macho(data: bytes) -> Library:
    (machine,) = struct.unpack_from("<I", data, 4)
    offers, asks, libraries = set(), set(), set()
    for kind, at in _commands(data):
        if kind == MACHO_SYMTAB:
            table, count, strings, _ = struct.unpack_from("<IIII", data, at + 8)
            for n in range(count):
                name, sort, *_ = struct.unpack_from("<IBBHQ", data, table + 16 * n)
                if sort & 1 and not sort & 0xE0:  # external, and no note for a debugger
                    (offers if sort & 0xE else asks).add(_text(data, strings + name)[1:])
        elif kind in MACHO_DYLIBS:
            libraries.add(_text(data, at + struct.unpack_from("<I", data, at + 8)[0]))
    return Library(
        "macos", MACHO_MACHINES[machine], frozenset(offers), frozenset(asks),
        libraries=frozenset(libraries),
    )  # fmt: skip


def _commands(data: bytes) -> Iterator[tuple[int, int]]:
    """Kind and place of each load command."""
    (count,) = struct.unpack_from("<I", data, 16)
    at = 32
    for _ in range(count):
        kind, size = struct.unpack_from("<II", data, at)
        yield kind, at
        at += size
