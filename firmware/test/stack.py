"""The deepest stack of an AVR firmware, by its calls, held against the RAM that its data leave.

    python3 stack.py ELF RAM_BYTES

Reads the linked file's disassembly, so that what link-time optimisation made of the sources is what
counts: each function's pushes and frame, and whom it calls, jumps or falls to. Interrupts are
stacked as they can nest: the window's on the main loop, once more on itself where it took too long
(which it sees and leaves), and one of those that let nobody in on top. Pushes of one function
count together though not every path makes them all, so this is a bound. Ends with an error where
it cannot tell: recursion, or a call by pointer.
"""

from __future__ import annotations

import re
import subprocess
import sys
from bisect import bisect_right
from dataclasses import dataclass, field
from functools import cache

WINDOW = "__vector_window"  # the interrupt that lets others in
SMALL_RETURN, LARGE_RETURN, LARGE_RAM = 2, 3, 8192  # more than 128 kB of flash: three bytes
FUNCTION = re.compile(r"^([0-9a-f]+) <(\S+)>:$")
LINE = re.compile(r"^\s+[0-9a-f]+:\t[0-9a-f ]+\t(\S+)(?:\t(.*))?$")
TARGET = re.compile(r"0x([0-9a-f]+)\s*<")
FRAME = {"sbiw": re.compile(r"r28, 0x([0-9a-fA-F]+)"), "subi": re.compile(r"r28, 0x([0-9a-fA-F]+)")}
HIGH = re.compile(r"r29, 0x([0-9a-fA-F]+)")
JUMPS = {"rjmp", "jmp"}
ELSEWHERE = {"ret", "reti", *JUMPS}
POINTERS = {"icall", "eicall", "ijmp", "eijmp"}
# A shared prologue pushes all that there is and jumps back, with a frame of r26: 0 here.
LIBRARY = {"__prologue_saves__", "__tablejump2__"}
FLOAT = "__fp_"  # library functions, of which parts serve one another, once


@dataclass
class Function:
    """What one symbol of the text takes, and where it leads."""

    own: int = 0
    calls: set[str] = field(default_factory=set)
    jumps: set[str] = field(default_factory=set)
    framing: bool = False  # between reading the stack pointer into r28 and writing it back
    ends: bool = False  # its last instruction leads elsewhere: it does not fall into the next


def output(*command: str) -> list[str]:
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    return done.stdout.splitlines()


def static_bytes(elf: str) -> int:
    """RAM that data take."""
    rows = (row.split() for row in output("avr-size", "-A", elf) if row.startswith("."))
    return sum(int(row[1]) for row in rows if row[0] in (".data", ".bss", ".noinit"))


class Program:
    """Every function, from avr-objdump; an address belongs to the last one that begins before."""

    def __init__(self, elf: str) -> None:
        self.functions: dict[str, Function] = {}
        lines = output("avr-objdump", "-d", elf)
        starts = [(int(m[1], 16), m[2]) for line in lines if (m := FUNCTION.match(line))]
        self._starts, self._names = [a for a, _ in starts], [n for _, n in starts]
        name, here = "", Function(ends=True)
        for line in lines:
            if match := FUNCTION.match(line):
                if not here.ends:
                    here.jumps.add(match[2])
                name, here = match[2], self.functions.setdefault(match[2], Function())
            elif match := LINE.match(line):
                self._take(name, here, match[1], match[2] or "")

    def _at(self, address: int) -> tuple[str, bool]:
        """Whose it is, and whether it is its first."""
        place = bisect_right(self._starts, address) - 1
        return self._names[place], self._starts[place] == address

    def _take(self, name: str, here: Function, operation: str, operands: str) -> None:
        here.ends = operation in ELSEWHERE
        match = TARGET.search(operands)
        if operation == "push":
            here.own += 1
        elif operation in POINTERS and name not in LIBRARY:
            raise SystemExit(f"{name}: {operation} leads where this cannot see")
        elif operation in ("call", "rcall") and match:
            target, first = self._at(int(match[1], 16))
            if target == name and not first:  # the next instruction, to make room, or a part of it
                here.own += LARGE_RETURN
            else:
                here.calls.add(target)
        elif (operation.startswith("br") or operation in JUMPS) and match:
            here.jumps |= {self._at(int(match[1], 16))[0]} - {name}
        elif operation == "in" and operands.startswith("r28, 0x3d"):
            here.framing = True
        elif operation == "out" and operands.startswith("0x3d, r28"):
            here.framing = False
        elif here.framing and operation in FRAME and (match := FRAME[operation].match(operands)):
            here.own += int(match[1], 16)
        elif here.framing and operation == "sbci" and (match := HIGH.match(operands)):
            here.own += int(match[1], 16) << 8


class Depths:
    """Most stack below a function's return address."""

    def __init__(self, functions: dict[str, Function], back: int) -> None:
        self._functions, self._back = functions, back
        self._above: list[str] = []
        self.of = cache(self._of)

    def _of(self, name: str, without: str = "") -> int:
        f, above = self._functions[name], self._above
        if name in above and not name.startswith(FLOAT):
            raise SystemExit(f"{name} calls itself: {' -> '.join(above)}")
        if name in above:
            return f.own
        above.append(name)
        calls = [self._back + self.of(called, without) for called in sorted(f.calls)]
        jumps = [self.of(j, without) for j in sorted(f.jumps - {without}) if j not in above]
        above.pop()
        return f.own + max([0, *calls, *jumps])


def main() -> None:
    elf, ram = sys.argv[1], int(sys.argv[2])
    functions = Program(elf).functions
    back = LARGE_RETURN if ram >= LARGE_RAM else SMALL_RETURN
    depths = Depths(functions, back)
    vectors = [name for name in functions if re.fullmatch(r"__vector_\d+", name)]
    parts = {
        "main loop": back + depths.of("main"),
        "window's interrupt": back + depths.of(WINDOW),
        # which sees that it is, cuts the bridge and leaves
        "the same again, too late": 2 * back + functions[WINDOW].own,
        "any other interrupt": max(back + depths.of(name, WINDOW) for name in vectors),
    }
    worst, left = sum(parts.values()), ram - static_bytes(elf)
    told = ", ".join(f"{name} {value}" for name, value in parts.items())
    print(f"stack: at most {worst} of {left} bytes ({told})")
    if worst > left:
        raise SystemExit("the stack may reach the data")


if __name__ == "__main__":
    main()
